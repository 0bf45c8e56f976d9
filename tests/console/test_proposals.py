"""The next tests, proposed on the Campaigns page as the command proposes them."""

import re

import pytest

pytest.importorskip("fastapi")

from dampyr import campaigns, planning
from dampyr.studies import published_damper

QUICK = {"tests": 1, "seconds": 4.0, "voltages": [0.0, 1.98], "kinds": ["sine"]}


def done_with(client, finished, **request):
    job = client.post("/api/campaigns/proposals", json=QUICK | request)
    assert job.status_code == 202, job.text
    return finished(job.json()["id"])


@pytest.mark.usefixtures("light")
def test_a_request_waits_as_it_was_sent(client):
    answer = client.post(
        "/api/campaigns/proposals", json=QUICK | {"damper": "raminelli_2020", "targets": {"dahl.rho": 0.2}}
    )
    assert answer.status_code == 202, answer.text
    job = client.get(f"/api/jobs/{answer.json()['id']}").json()
    assert (job["kind"], job["title"]) == ("propose", "tests from raminelli_2020")
    sent = {name: job["request"][name] for name in (*QUICK, "damper", "targets")}
    assert sent == QUICK | {"damper": "raminelli_2020", "targets": {"dahl.rho": 0.2}}


@pytest.mark.prove  # in a process; tests/console/jobs/test_propose.py does the same work in this one
def test_a_proposal_from_a_damper_is_that_of_the_library(client, finished):
    job = done_with(client, finished, damper="raminelli_2020", targets={"dahl.rho": 0.2})
    assert job["state"] == "done", job["reason"]
    ours = planning.propose(published_damper("raminelli_2020"), **QUICK, targets={"dahl.rho": 0.2})
    assert job["result"]["text"] == ours.text
    assert job["result"]["notice"] == ours.origin.notice
    for words in ("--card raminelli_2020", "--target dahl.rho=20%", "--at 1.98", "--kind sine", "--seconds 4"):
        assert words in job["result"]["command"]


@pytest.mark.parametrize(
    ("request_body", "words"),
    [
        ({"goal": "peak"}, "the goal peak needs the damper's voltage in the earthquake; enter it"),
        ({"goal": "speed"}, "goal = 'speed' is not known; choose from parameters, peak"),
        ({"damper": "no_such"}, "'no_such' is neither a card nor a published damper"),
        ({"rig": "no_such"}, "rig = 'no_such' is not known"),
        ({"records": ["data/none.h5"]}, "no such file"),
        ({"tests": 0}, "greater than or equal to 1"),
        ({"peak_target": 0.02}, "needs the goal peak"),
    ],
)
def test_a_wrong_request_is_a_sentence(client, request_body, words):
    answer = client.post("/api/campaigns/proposals", json=request_body)
    assert answer.status_code in (400, 404, 422)
    assert words in answer.json()["detail"]


def test_tests_are_proposed_on_the_page_and_their_text_is_planned(address, new_page, accessible, data):
    page = new_page(f"{address}#/campaigns")
    page.locator("#verdict").wait_for()
    page.get_by_text("Propose tests").click()
    page.get_by_label("Tests", exact=True).fill("2")
    page.get_by_label("Seconds, s", exact=True).fill("4")
    page.get_by_label("Voltages, V", exact=True).fill("0; 1,98")
    for kind in ("voltage_steps", "sweep", "random"):
        page.get_by_role("group", name="Kinds").get_by_label(kind, exact=True).uncheck()
    accessible(page)
    page.get_by_role("button", name="Propose", exact=True).click()
    page.get_by_text("The proposed tests are in the text").wait_for(timeout=120_000)
    page.get_by_text("The rig can run all 2 tests").wait_for()
    assert "# Planned by dampyr" in page.locator("#source").input_value()
    page.locator("#file").fill("proposed")
    page.locator("#save").click()
    page.get_by_text(re.compile("Saved: proposed")).wait_for()
    assert len(campaigns.plan(data / "campaigns" / "proposed.toml").tests) == 2
