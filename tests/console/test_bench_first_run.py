"""From an empty data folder to a run with its certificate, in one walk through a browser with a look at all on the way."""

import json
import re
from functools import partial

import pytest
from tests.console.printed_pages import page_texts
from tests.console.test_bench_page import LAGGING

pytest.importorskip("fastapi")

MAX_CLICKS = 6  # from an empty page to a table that moves
COUNT = """() => {
    globalThis.clicks = 0;
    addEventListener("click", (event) => { if (event.isTrusted && event.detail) clicks += 1; }, { capture: true });
}"""


DRAWN = """async () => {
    const { strip } = await import("/static/lib/strip.js");
    const coloured = async (value) => {
        const host = document.createElement("div");
        Object.assign(host.style, { position: "fixed", top: "0", width: "600px" });
        document.body.append(host);
        const y = { words: "force", unit: "N", least: 1 };
        const made = strip(host, { label: "of a test", y, limits: [{ value, words: "" }] });
        made.set({ now: 1, span: 1, lines: [{ time: [0, 1], low: [-50, 80], high: [-50, 80] }] });
        await new Promise((resolve) => setTimeout(resolve, 300));
        const canvas = host.querySelector("canvas");
        const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        const away = (k) => Math.abs(data[k] - 163) + Math.abs(data[k + 1] - 71) + data[k + 2]; // from a limit's #a34700
        let count = 0;
        for (let k = 0; k < data.length; k += 4) count += away(k) < 30;
        made.clear();
        host.remove();
        return count;
    };
    return [await coloured(100), await coloured(-60), await coloured(150)];
}"""


@pytest.fixture
def address(data, serving, request):
    """A console over an empty folder, whose simulated rig keeps up with the wall clock where the machine can."""
    serve = serving if request.config.getoption("--endure") else partial(serving, program=("-c", LAGGING))
    with serve(data) as url:
        yield url


def until_testing(page):
    """Wait until a test is under way."""
    page.wait_for_function("() => document.querySelector('#run')?.textContent.includes('testing')")


def rings(page):
    """The state of each safety layer as the page shows it, and its words."""
    layers = page.locator(".rings li").all()
    return [(each.get_attribute("class") or "", each.inner_text().replace("\n", " ")) for each in layers]


@pytest.mark.endure
def test_from_an_empty_folder_to_a_certificate(address, new_page, data, tmp_path, accessible):
    page = new_page(address, viewport={"width": 1440, "height": 900})
    page.evaluate(COUNT)
    page.get_by_role("navigation").get_by_role("link", name="Bench", exact=True).click()
    page.locator("#example").click()
    page.locator("#connect:enabled").click()
    page.locator("#start:enabled").wait_for()
    assert all(kind == "" and "not watching" in words for kind, words in rings(page)), rings(
        page
    )  # none of them is green
    assert "once armed it stops beyond 4500 N" in rings(page)[1][1]
    page.locator("#start").click()
    page.locator("#start-now:enabled").click()
    until_testing(page)
    assert page.evaluate("clicks") <= MAX_CLICKS - 1
    assert [kind for kind, _ in rings(page)] == ["good", "good", "good"]
    next_test = page.locator("#run dt", has_text="next").locator("xpath=following-sibling::dd[1]")
    next_test.get_by_text("02-sine-8mm-1Hz-1.98V").wait_for()
    assert re.search(r"sine 8 mm at 1 Hz, 1\.98 V; up to .* mm, .* mm/s, 1\.98 V; \d+ s", next_test.inner_text())

    # a tab that was duplicated has a copy of the first one's storage, and is another page
    with page.context.expect_page() as opened:
        page.evaluate("() => { window.open(location.href); }")
    opened.value.get_by_text("page 1 holds control; this page only watches").wait_for()
    opened.value.reload()
    opened.value.get_by_text("page 1 holds control; this page only watches").wait_for()
    page.get_by_text("This page holds control").wait_for()
    opened.value.close()

    near, below, far = page.evaluate(DRAWN)  # data from -50 to 80: a limit is drawn that is not far beyond them
    assert (near > 200, below > 200, far) == (True, True, 0)

    page.locator("#who").fill("A. Operator")
    page.locator("#who").press("Tab")
    page.locator("#span").select_option("60")
    accessible(page)
    page.locator("#stop").click()
    page.get_by_text("the campaign was stopped by its operator; Continue goes on with it").first.wait_for()
    [run] = (data / "runs").iterdir()
    page.get_by_role("button", name=f"Remove {run.name}").click()
    removal = page.get_by_text(
        re.compile(r"Its folder is deleted with (what|\d complete)")
    )  # later, where the machine is busy
    removal.wait_for()
    page.get_by_role("button", name="Cancel").last.click()
    assert run.is_dir()
    page.locator("#start:enabled").click()
    page.locator("#continue-it").click()
    page.get_by_text(re.compile(r"\d of 3 tests are recorded there; the others are run")).wait_for()
    (tmp_path / "hurry").touch()
    page.locator("#start-now:enabled").click()
    page.wait_for_function("() => document.querySelector('#run').textContent.includes('3 of 3 complete')")
    with page.expect_download() as saved:
        page.locator("#report").click()
    assert saved.value.suggested_filename == f"{run.name}-cycles.html"
    report = saved.value.path().read_text("utf-8")
    assert "SIMULATED" in report
    assert "01-sine-8mm-1Hz-0V" in report

    lines = [json.loads(line) for line in (data / "bench" / "bench-events.jsonl").read_text().splitlines()]
    said = [f"{line['who']}: {line['what']}" for line in lines]
    named = [each for each in said if each.startswith("A. Operator, page 1: ")]
    assert [each.partition(": ")[2] for each in named] == ["stops the campaign", f"starts quick into {run.name}"]
    assert "page 1 from 127.0.0.1: connects the original rig, simulated" in said

    assert page.locator("#span").input_value() == "60"
    paper = page_texts(page.pdf(format="A4"))
    assert all("timewhowhat" in text for text in paper[1:]), paper  # the head of the log on each of its sheets
    assert not any("Abort" in text or "Campaigns" in text for text in paper)
    page.emulate_media(media="print")
    for canvas in page.locator(".strip canvas").all():  # as wide over high as it was drawn
        box, drawn = canvas.bounding_box(), canvas.evaluate("one => one.width / one.height")
        assert box["width"] / box["height"] == pytest.approx(drawn, rel=0.02)
