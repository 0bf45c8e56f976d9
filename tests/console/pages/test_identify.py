"""The Identify page: the same numbers as the room gives, and a card that can be loaded."""

import json

import pytest

pytest.importorskip("fastapi")
from fastapi.testclient import TestClient
from tests.console.conftest import when_ended
from tests.identification.synthetic import sine

from dampyr import identification, records, structures
from dampyr.console import app, job_work
from dampyr.console.identify_schemas import IdentifyRequest
from dampyr.console.jobs import identify
from dampyr.console.safe_paths import OWN
from dampyr.ground_motions import el_centro
from dampyr.models import Damper
from dampyr.show.identification.result import error_table, parameter_table, session_table
from dampyr.show.pages.typography import as_words
from dampyr.studies import raminelli_2020

KEYS = [f"labcontrol/ensaio.{name}.mat" for name in ("A.1", "B.3", "vali.1")]
ASKED = {"model": "dahl", "session_prior": 0.05}
DONE = "0123456789abcdef"


def of_synthetic_tests(data, request):
    """Two short tests and one of validation; the job is done in this process before the console starts, with a bare page."""
    damper = raminelli_2020.damper()
    made = [sine(damper, voltage, f"r{voltage:g}", noise=2.0, seconds=4.0) for voltage in (0.0, 1.98, 0.8712)]
    made[2] = made[2].replace(note="kept for validation", role="validation")
    for record in made:
        records.write(record, data / f"{record.name}.h5")
    asked = IdentifyRequest(records=[f"data/{record.name}.h5" for record in made], **ASKED).model_dump()
    folder = data / OWN / "jobs" / DONE
    folder.mkdir(parents=True)
    (folder / "request.json").write_text(json.dumps({"kind": "identify", "request": asked}))
    (folder / "job.json").write_text(json.dumps({"id": DONE, "kind": "identify", "title": "a fit", "state": "done"}))
    with pytest.MonkeyPatch.context() as patch:
        bare = "<h1>Identified: {}</h1>"
        patch.setattr(identify, "write_page", lambda fit, path: path.write_text(bare.format(fit.problem.composition)))
        assert job_work.run(folder, lambda _: None) == 0
    with TestClient(app(data), base_url="http://localhost") as client:
        yield client, client.get(f"/api/jobs/{DONE}").json(), data, made


def of_the_campaign(data, request):
    """Two tests of the published campaign, and its record of validation; in a process, with its page."""
    folder = request.getfixturevalue("campaign_folder")
    measured = {record.name: record for record in records.read_campaign(folder, role=None)}
    with TestClient(app(data), base_url="http://localhost") as client:
        job = when_ended(client, client.post("/api/identify/jobs", json={"records": KEYS, **ASKED}).json()["id"])
        assert job["state"] == "done", job["reason"]
        yield client, job, data, [measured[f"ensaio.{name}"] for name in ("A.1", "B.3", "vali.1")]


@pytest.fixture(scope="module", params=[of_synthetic_tests, pytest.param(of_the_campaign, marks=pytest.mark.prove)])
def identified(request, tmp_path_factory):
    """A console and its fit, with a spread of sessions that the form states, computed once; and the records."""
    data = tmp_path_factory.mktemp("identified") / "data"
    data.mkdir()
    yield from request.param(data, request)


def test_the_fit_is_that_of_the_room_and_the_card_is_kept(identified):
    client, job, data, (*chosen, vali) = identified
    own, output = identification.fit(chosen, "dahl", session_prior=0.05), job["result"]
    assert output["records"] == [record.name for record in (*chosen, vali)]
    assert output["mean_l1"] == pytest.approx(sum(s.l1 for s in own.scores.values()) / 2, rel=1e-6)
    shown, between, errors = (each["rows"] for each in output["parameters"])
    tables = [make(own).rows for make in (parameter_table, session_table, error_table)]
    assert [shown, between, errors] == [[[as_words(cell) for cell in row] for row in rows] for rows in tables]
    assert shown[0][0] == "dahl k_x"  # as on paper
    assert output["settling"] == 2.0
    (held,) = output["held"]
    if held["problem"] == "":
        assert held["l1"] == pytest.approx(identification.score(own.damper, vali).l1, rel=1e-6)
    else:
        assert "0.8712" in held["problem"]

    place = f"/api/identify/jobs/{job['id']}"
    for name in ("../x", "a/b", ".x", ""):
        assert client.post(f"{place}/card", json={"name": name}).status_code in (400, 422)
    assert client.post(f"{place}/card", json={"name": "mine"}).status_code == 201
    assert client.post(f"{place}/card", json={"name": "mine"}).status_code == 409
    assert Damper.load(data / "cards/mine.toml").range == own.damper.range
    assert client.get("/api/cards").json() == ["mine.toml"]
    one = chosen[0]
    lines = client.get(f"{place}/curves", params={"record": one.name}).json()
    assert max(lines["time"]["measured"]["y"]) == pytest.approx(one.force.max(), rel=1e-5)
    page = client.get(f"{place}/page")
    assert "attachment" in page.headers["content-disposition"]
    assert "<h1>Identified: dahl</h1>" in page.text
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


def test_the_levels_of_sessions_are_those_that_the_form_states(identified):
    """Each voltage was measured in one session, so that the spread of their levels is what is stated."""
    result = identified[1]["result"]
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
    assert ruled["name"].startswith("on-off")
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
