"""The Identify page: the same numbers as the room gives, and a card that can be loaded."""

import pytest

pytest.importorskip("fastapi")

from dampyr import identification, records, structures
from dampyr.ground_motions import el_centro
from dampyr.models import Damper
from dampyr.show.identification.result import error_table, parameter_table, session_table
from dampyr.studies import raminelli_2020

KEYS = [f"labcontrol/ensaio.{name}.mat" for name in ("A.1", "B.3", "vali.1")]


@pytest.fixture
def identified(client, finished, campaign_folder):
    request_body = {"records": KEYS, "model": "dahl + spring"}
    job = finished(client.post("/api/identify/jobs", json=request_body).json()["id"])
    assert job["state"] == "done", job["reason"]
    return job


def test_the_fit_is_that_of_the_room_and_the_card_is_kept(client, identified, data, campaign_folder):
    chosen = [r for r in records.read_campaign(campaign_folder) if r.name in ("ensaio.A.1", "ensaio.B.3")]
    own, output = identification.fit(chosen, "dahl + spring"), identified["result"]
    assert output["records"] == ["ensaio.A.1", "ensaio.B.3", "ensaio.vali.1"]
    assert output["mean_l1"] == pytest.approx(sum(s.l1 for s in own.scores.values()) / 2, rel=1e-6)
    shown, between, errors = (each["rows"] for each in output["parameters"])
    assert [shown, between, errors] == [make(own).rows for make in (parameter_table, session_table, error_table)]
    assert output["settling"] == 2.0
    (held,) = output["held"]
    vali = next(r for r in records.read_campaign(campaign_folder, role="validation"))
    if held["problem"] == "":
        assert held["l1"] == pytest.approx(identification.score(own.damper, vali).l1, rel=1e-6)
    else:
        assert "0.8712" in held["problem"]

    place = f"/api/identify/jobs/{identified['id']}"
    for name in ("../x", "a/b", ".x", ""):
        assert client.post(f"{place}/card", json={"name": name}).status_code in (400, 422)
    assert client.post(f"{place}/card", json={"name": "mine"}).status_code == 201
    assert client.post(f"{place}/card", json={"name": "mine"}).status_code == 409
    assert Damper.load(data / "cards/mine.toml").range == own.damper.range
    assert client.get("/api/cards").json() == ["mine.toml"]
    one = next(r for r in chosen if r.name == "ensaio.A.1")
    lines = client.get(f"{place}/curves", params={"record": "ensaio.A.1"}).json()
    assert max(lines["time"]["measured"]["y"]) == pytest.approx(one.force.max(), rel=1e-5)
    page = client.get(f"{place}/page")
    assert "attachment" in page.headers["content-disposition"]
    assert "<h1>Identified: dahl + spring</h1>" in page.text
    assert client.get("/api/building/choices").json()["dampers"][0]["name"] == "cards/mine.toml"


@pytest.mark.parametrize(
    ("request_body", "words"),
    [
        ({"records": []}, "at least 1 item"),
        ({"records": KEYS[:1], "model": "dahl + nothing"}, "nothing"),
        ({"records": ["labcontrol/none.mat"], "model": "dahl"}, "no such file"),
        ({"records": KEYS[:1], "model": "dahl", "bandwidth": -1}, "greater than 0"),
        ({"records": KEYS[:1], "model": "dahl", "session_prior": 8}, "less than or equal to 1"),
    ],
)
def test_a_wrong_question_is_a_sentence(client, campaign_folder, request_body, words):
    answer = client.post("/api/identify/jobs", json=request_body)
    assert answer.status_code in (400, 404, 422)
    assert words in answer.json()["detail"]


def test_only_validation_records_are_refused(client, finished, campaign_folder):
    job = client.post("/api/identify/jobs", json={"records": KEYS[2:], "model": "dahl"}).json()
    assert "only validation records" in finished(job["id"])["reason"]


def test_the_levels_of_sessions_are_those_that_the_form_states(client, finished, campaign_folder):
    """Each voltage was measured in one session, so that the spread of their levels is what is stated."""
    body = {"records": KEYS[:2], "model": "dahl", "session_prior": 0.05}
    result = finished(client.post("/api/identify/jobs", json=body).json()["id"])["result"]
    assert result["data"]["levels"]["session_sd"] == pytest.approx(0.05)
    assert any("5 % (standard deviation) is assumed between sessions" in words for words in result["warnings_of_fit"])


@pytest.mark.prove
@pytest.mark.by_hand  # tests/stories/test_one_job_three_ways.py asks for one too, and compares all of it
def test_a_leaderboard_of_two(client, finished, campaign_folder):
    keys = [f"labcontrol/ensaio.{name}.mat" for name in ("A.1", "A.4", "A.8", "B.3", "B.8")]
    job = client.post("/api/identify/jobs", json={"records": keys, "models": ["dahl", "bingham"]}).json()
    done = finished(job["id"])
    assert done["state"] == "done", done["reason"]
    board = done["result"]["data"]["leaderboard"]["entries"]
    assert [one["error"] for one in board] == sorted(one["error"] for one in board)
    assert done["result"]["model"] == board[0]["model"]


@pytest.mark.prove
def test_a_response_is_that_of_the_room(client, finished):
    job = client.post("/api/building/responses", json={"damper": {"inputs": [1.98], "laws": ["on_off"]}}).json()
    done = finished(job["id"])
    assert done["state"] == "done", done["reason"]
    bare, damped, ruled = done["result"]["cases"]
    own = structures.respond(structures.two_storey(), el_centro(), {1: raminelli_2020.damper()}, voltage=1.98)
    assert bare["peak_displacement"][0] == pytest.approx(45.534e-3, rel=1e-4)  # chapter 5
    assert damped["peak_displacement"] == pytest.approx(list(own.peak_displacement), rel=1e-9)
    assert ruled["name"].startswith("on_off")
    curves = client.get(f"/api/building/responses/{job['id']}/curves").json()
    assert max(map(abs, curves["cases"]["1.98 V"]["displacement"][0]["y"])) <= own.peak_displacement[0] * (1 + 1e-5)
    assert {len(floor) for case in curves["frames"]["cases"].values() for floor in case} == {
        len(curves["frames"]["time"])
    }


@pytest.mark.prove
def test_an_ensemble_gives_fragility(client, finished):
    request_body = {
        "motions": 6,
        "scales": [0.1 * k for k in range(1, 11)],
        "limits": ["12mm"],
        "damper": {"inputs": [1.98]},
    }
    done = finished(client.post("/api/building/ensembles", json=request_body).json()["id"])
    assert done["state"] == "done", done["reason"]
    result = done["result"]
    assert result["cases"] == 6 * 10 * 2
    medians = {row[0]: row[1] or row[5] for row in result["fragilities"][0]["table"]["rows"]}
    assert list(medians) == ["no damper", "1.98 V"]
    assert medians["1.98 V"] is None or medians["1.98 V"] > medians["no damper"]
