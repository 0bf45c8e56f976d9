"""Long work and unsaved work through reloads, and two browsers at the same work."""

import json
import re
import threading
from collections import Counter

import pytest

pytest.importorskip("fastapi")
from fastapi.testclient import TestClient

from dampyr.console import app
from dampyr.studies import raminelli_2020

DONE = "0123456789abcdef"


def progress(page):
    """The work that the page shows."""
    return page.get_by_role("group", name="Job in progress")


@pytest.mark.prove
def test_a_search_goes_on_through_a_reload_and_another_browser_sees_and_cancels_it(address, new_page, campaign_folder):
    first, second = (new_page(f"{address}#/identify") for _ in range(2))
    for name in ("ensaio.A.1", "ensaio.A.4", "ensaio.A.7", "ensaio.B.3", "ensaio.B.5"):
        first.get_by_label(f"Choose {name}", exact=True).check()
    first.get_by_role("button", name="Find the best model").click()
    progress(first).wait_for()
    first.reload()
    progress(first).get_by_text(re.compile(r"^(?!starting|waiting).* \d+ %")).wait_for(timeout=90_000)  # it goes on
    second.get_by_role("link", name=re.compile("the best model, 5 records")).click()  # it came into the list by itself
    progress(second).get_by_text("%").wait_for()
    second.get_by_role("button", name="Cancel").click()
    for page in (first, second):
        page.get_by_text("Cancelled.").wait_for()
        page.locator(".before").get_by_text("cancelled").wait_for()


@pytest.mark.prove
def test_an_ensemble_goes_on_through_a_reload(address, new_page):
    page = new_page(f"{address}#/building")
    page.get_by_text("Many earthquakes").click()
    page.get_by_label("Inputs").fill("1.98")
    page.get_by_label("Synthetic motions").fill("20")
    page.get_by_role("button", name="Run the ensemble").click()
    progress(page).wait_for()
    page.reload()
    page.get_by_role("heading", name="Fragility").wait_for(timeout=180_000)
    other = new_page(page.url)  # the address is the work
    other.get_by_role("heading", name="Fragility").wait_for()
    table = "() => document.querySelector('.table').innerText"
    assert other.evaluate(table) == page.evaluate(table)


@pytest.mark.prove
def test_a_campaign_that_is_not_saved_comes_back(address, new_page, data):
    page = new_page(f"{address}#/campaigns")
    page.locator("#verdict").wait_for()
    assert page.locator("#restored").is_hidden()
    page.locator("#g-amplitude").fill("3, 5")
    page.locator("#g-note").fill("half typed")
    page.locator("#file").fill("grid")
    page.reload()  # at once: before the plan was made anew
    page.locator("#restored").wait_for()
    assert page.locator("#g-amplitude").input_value() == "3, 5"
    assert page.locator("#g-note").input_value() == "half typed"
    assert page.locator("#file").input_value() == "grid"
    page.get_by_role("cell", name=re.compile("01-sine-3mm")).wait_for()
    page.locator("#save").click()
    page.get_by_text("Saved: grid").wait_for()
    assert '"3 mm", "5 mm"' in (data / "campaigns" / "grid.toml").read_text()
    page.reload()
    page.wait_for_function("""() => document.querySelector("#open")?.value === "grid" """)
    assert page.locator("#restored").is_hidden()

    page.locator("#source").fill('[[step]]\nkind = "rest"\nduration = "2 s"\n')
    page.evaluate("location.assign('#/records')")
    page.get_by_role("heading", level=1, name="Records").wait_for()
    page.evaluate("location.assign('#/campaigns?open=grid')")
    page.locator("#restored").wait_for()
    assert '"rest"' in page.locator("#source").input_value()
    page.locator("#open").select_option("")  # another file: the work on this one stays with it
    page.wait_for_function("""() => document.querySelector("#g-amplitude")?.value === "1; 2; 4" """)
    assert page.locator("#restored").is_hidden()
    page.locator("#open").select_option("grid")
    page.locator("#restored").wait_for()
    page.locator("#discard").click()
    page.wait_for_function("""() => document.querySelector("#g-amplitude")?.value === "3; 5" """)
    page.reload()
    page.locator("#verdict").wait_for()
    assert page.locator("#restored").is_hidden()


@pytest.mark.parametrize(
    ("name", "late"),
    [("records", "records/list"), ("campaigns", "campaigns/files"), ("building", "building/responses")],
)
def test_an_answer_that_comes_after_one_has_left_changes_nothing(address, new_page, data, name, late):
    page = new_page(f"{address}#/{name}")
    waiting = []
    page.route(f"**/api/{late}*", lambda route: waiting.append(route), times=1)
    page.reload()
    if name == "building":
        page.get_by_role("button", name="Simulate").click()
    while not waiting:
        page.wait_for_timeout(20)
    page.get_by_role("link", name="Bench", exact=True).click()  # it has no address of its own
    page.locator("#note").wait_for(state="attached")
    with page.expect_event("requestfinished", lambda request: request == waiting[0].request):
        waiting[0].continue_()
    page.wait_for_timeout(300)  # what the answer sets off
    assert page.url.endswith("#/bench")


def test_what_is_typed_is_what_is_saved(address, new_page, data):
    page = new_page(f"{address}#/campaigns")
    page.locator("#g-amplitude").fill("3, 5")
    page.locator("#file").fill("grid")
    page.locator("#save").click()  # at once: before the text was made anew
    page.get_by_text("Saved: grid").wait_for()
    assert '"3 mm", "5 mm"' in (data / "campaigns" / "grid.toml").read_text()
    page.locator("#g-cycles").fill("0")
    page.locator("#save").click()  # nothing is written for entries that are wrong
    page.get_by_text("cycles must be a whole number").wait_for()
    assert '"3 mm", "5 mm"' in (data / "campaigns" / "grid.toml").read_text()


@pytest.mark.prove
def test_two_pages_on_one_campaign_do_not_overwrite_each_other(address, new_page, data):
    (data / "campaigns").mkdir()
    file = data / "campaigns" / "grid.toml"
    file.write_text('[[step]]\nkind = "sine"\namplitude = "4 mm"\nfrequency = "1 Hz"\n')
    first, second = (new_page(f"{address}#/campaigns?open=grid", refused=409) for _ in range(2))
    for page, value in ((first, "2"), (second, "6")):
        page.wait_for_function("""() => document.querySelector("#g-amplitude")?.value === "4" """)
        page.locator("#g-amplitude").fill(value)
        page.get_by_role("cell", name=re.compile(f"01-sine-{value}mm")).wait_for()
    first.locator("#save").click()
    first.get_by_text("Saved: grid").wait_for()
    second.locator("#save").click()
    second.get_by_text("'grid' holds another campaign by now").wait_for()
    assert '"2 mm"' in file.read_text()
    second.locator("#file").fill("grid 2")
    second.locator("#save").click()
    second.get_by_text("Saved: grid 2").wait_for()
    assert '"6 mm"' in (data / "campaigns" / "grid 2.toml").read_text()
    first.locator("#open").select_option("")
    first.locator("#file").fill("grid")
    first.locator("#save").click()  # a new one by the name of one that is there
    first.get_by_text("'grid' holds another campaign by now").wait_for()


def all_at_once(work, count=8):
    """What ``work`` returns when that many ask at the same moment."""
    gate, results = threading.Barrier(count), []

    def one(k):
        gate.wait()
        results.append(work(k))

    threads = [threading.Thread(target=one, args=(k,)) for k in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return Counter(results)


@pytest.fixture
def with_a_fit(data):
    """A console that knows a fit from before, with its card."""
    place = data / ".console" / "jobs" / DONE
    place.mkdir(parents=True)
    (place / "job.json").write_text(json.dumps({"id": DONE, "kind": "identify", "title": "a fit", "state": "done"}))
    (place / "request.json").write_text(json.dumps({"kind": "identify", "request": {}}))
    (place / "result.json").write_text("{}")
    raminelli_2020.damper().save(place / "card.toml")
    with TestClient(app(data), base_url="http://localhost") as test_client:
        yield test_client


def test_of_many_who_keep_a_card_by_one_name_one_does(with_a_fit, data):
    ask = f"/api/identify/jobs/{DONE}/card"
    for turn in range(5):

        def keep(_, name=f"card {turn}"):
            return with_a_fit.post(ask, json={"name": name}).status_code

        assert all_at_once(keep) == {201: 1, 409: 7}
    assert len(list((data / "cards").iterdir())) == 5


@pytest.mark.prove
def test_of_many_who_save_a_new_campaign_by_one_name_one_does(client, data):
    def text(k):
        return f'name = "{k}"\n[[step]]\nkind = "rest"\nduration = "{k + 1} s"\n'

    def ask(k):
        return client.put("/api/campaigns/files/one", json={"text": text(k), "replaces": ""}).status_code

    assert all_at_once(ask) == {200: 1, 409: 7}
    saved = (data / "campaigns" / "one.toml").read_text()
    assert saved in [text(k) for k in range(8)]
    answer = client.put("/api/campaigns/files/one", json={"text": text(9), "replaces": saved})
    assert answer.status_code == 200
    assert (
        client.put("/api/campaigns/files/one", json={"text": text(3)}).status_code == 200
    )  # replaces whatever is there
