"""Jobs: they end well, fail in a sentence, can be cancelled, and outlive neither their console nor a reload of it."""

import os
import time
from multiprocessing.process import BaseProcess

import numpy as np
import pytest

pytest.importorskip("fastapi")
from fastapi.testclient import TestClient
from tests.console.layers import state_of

import dampyr as dp
from dampyr.console import app
from dampyr.console.job_processes import Jobs
from dampyr.errors import InputError, MissingData

SMALL = {"damper": {"inputs": [1.98]}}
LONG = {"motions": 400, "scales": [0.1 * k for k in range(1, 41)], "damper": {"laws": ["skyhook", "on_off"]}}


def ended(jobs, id):
    for _ in range(1200):
        if jobs.job(id).ended is not None and id not in jobs._running:
            return jobs.job(id)
        time.sleep(0.05)
    raise AssertionError(jobs.job(id))


def begun(client, id):
    while client.get(f"/api/jobs/{id}").json()["stage"] in ("", "starting"):
        time.sleep(0.05)


def test_a_wrong_question_is_refused_at_once(client):
    for request_body, words in (
        ({"damper": {"inputs": []}}, "no input"),
        ({"damper": {"laws": ["magic"]}}, "magic"),
        ({"damper": {"name": "nobody_1900", "inputs": [1]}}, "nobody_1900"),
        ({"damper": {"name": "cards/../x.toml", "inputs": [1]}}, "is not a valid file name"),
        ({"building": {"kind": "shear"}, **SMALL}, "masses"),
        ({"motion": {"kind": "file", "file": "none.at2"}, **SMALL}, "no such file"),
        ({"building": {"kind": "published", "name": "ohtori"}, **SMALL}, "choose from ohtori_2004"),
        ({"building": {"kind": "file", "name": "none.toml"}, **SMALL}, "no such file"),
        ({"building": {"kind": "file", "name": "../x.toml"}, **SMALL}, "is not a valid file name"),
    ):
        answer = client.post("/api/building/responses", json=request_body)
        assert answer.status_code in (400, 404)
        assert words in answer.json()["detail"]
    assert client.get("/api/jobs").json() == []


@pytest.mark.prove
def test_a_structure_of_a_file_is_offered_and_simulated(client, finished, data):
    (data / "structures").mkdir()
    text = 'name = "tower"\nmasses = [1e3, 1e3]\nstiffnesses = [1e6, 1e6]\ndamping_ratio = 0.03\n'
    (data / "structures" / "tower.toml").write_text(text)
    offered = client.get("/api/building/choices").json()["structures"]
    assert {"ohtori_2004", "structures/tower.toml"} <= set(offered)
    job = client.post(
        "/api/building/responses", json={"building": {"kind": "file", "name": "tower.toml"}, **SMALL}
    ).json()
    assert "tower.toml" in job["title"]
    result = finished(job["id"])["result"]
    assert result["title"].startswith("tower, ")
    expected = dp.structures.respond(
        dp.structures.load(data / "structures" / "tower.toml"), dp.ground_motions.el_centro()
    )
    np.testing.assert_allclose(result["cases"][0]["peak_displacement"], expected.peak_displacement, rtol=1e-12)


@pytest.mark.prove
def test_a_published_structure_tells_its_truncation(client, finished):
    request = {"building": {"kind": "published", "name": "ohtori_2004"}, "damper": {"inputs": [0.0]}}
    result = finished(client.post("/api/building/responses", json=request).json()["id"])["result"]
    assert "40 coordinates for 291 degrees of freedom; beside all modes" in result["note"]
    assert "beside 21 coordinates, with the dampers" in result["note"]
    assert len(result["floors"]) == 20


def test_what_fails_in_the_job_is_a_sentence(client, finished, data):
    job = client.post("/api/building/responses", json={"damper": {"inputs": [9.0]}}).json()
    done = finished(job["id"])
    assert done["state"] == "failed"
    assert "9 V" in done["reason"]
    assert "Traceback" not in str(done)
    assert str(data) not in str(done)
    assert client.get(f"/api/building/responses/{job['id']}/curves").status_code == 404


def test_a_job_is_cancelled_and_its_processes_are_gone(client, finished):
    job = client.post("/api/building/ensembles", json=LONG).json()
    begun(client, job["id"])
    jobs = state_of(client.app).jobs
    process = jobs._running[job["id"]]
    if hasattr(os, "getpriority"):
        assert os.getpriority(os.PRIO_PROCESS, process.pid) > os.getpriority(os.PRIO_PROCESS, 0)  # a rig goes before
    assert client.post(f"/api/jobs/{job['id']}/cancel").json()["state"] == "cancelled"
    assert process.wait(10) == -9
    assert ended(jobs, job["id"]).state == "cancelled"
    assert client.delete(f"/api/jobs/{job['id']}").status_code == 204
    assert client.get(f"/api/jobs/{job['id']}").status_code == 404


@pytest.mark.usefixtures("light")
def test_jobs_wait_for_one_another_and_the_waiting_can_be_cancelled(data):
    with TestClient(app(data, at_once=1), base_url="http://localhost") as client:
        first, second = (client.post("/api/building/ensembles", json=LONG).json()["id"] for _ in range(2))
        begun(client, first)
        assert client.get(f"/api/jobs/{second}").json()["state"] == "waiting"
        assert client.post(f"/api/jobs/{second}/cancel").json()["state"] == "cancelled"
        assert client.delete(f"/api/jobs/{first}").status_code == 400
        client.post(f"/api/jobs/{first}/cancel")


@pytest.mark.parametrize("work", ["light", pytest.param("computed", marks=pytest.mark.prove)])
def test_a_job_ends_with_its_console_and_is_told_when_it_starts_again(data, request, work):
    if work == "light":
        request.getfixturevalue("light")
    with TestClient(app(data), base_url="http://localhost") as client:
        id = client.post("/api/building/ensembles", json=LONG).json()["id"]
        begun(client, id)
        process = state_of(client.app).jobs._running[id]
    assert process.wait(10) == -9
    with TestClient(app(data), base_url="http://localhost") as client:
        job = client.get(f"/api/jobs/{id}").json()
    assert (job["state"], job["reason"]) == ("failed", "the console was stopped while it ran or waited; run it again")


@pytest.mark.prove
def test_a_result_is_there_after_the_console_was_started_again(client, finished, data):
    id = client.post("/api/building/responses", json=SMALL).json()["id"]
    before = finished(id)
    assert before["state"] == "done", before["reason"]
    with TestClient(app(data), base_url="http://localhost") as later:
        assert later.get(f"/api/jobs/{id}").json() == before


def test_a_job_whose_process_is_not_started_says_so_and_the_next_one_is_done(tmp_path, monkeypatch):
    def no_process(self):
        raise BlockingIOError(11, "Resource temporarily unavailable")

    jobs = Jobs(tmp_path / "jobs", at_once=1)
    monkeypatch.setattr(BaseProcess, "start", no_process)
    monkeypatch.setattr("dampyr.processes.PAUSES", ())
    first, second = (jobs.submit("respond", {}, "").id for _ in range(2))
    for id in (first, second):
        job = ended(jobs, id)
        assert job.state == "failed"
        assert job.reason == ("a process was not started ([Errno 11] Resource temporarily unavailable); try again")
    jobs.close()


def test_a_kind_that_is_none_and_a_job_that_is_not_there(tmp_path):
    jobs = Jobs(tmp_path / "jobs")
    with pytest.raises(InputError, match="kinds of jobs"):
        jobs.submit("os", {}, "")
    with pytest.raises(MissingData, match="no job"):
        jobs.job("../../etc")
    jobs.close()
