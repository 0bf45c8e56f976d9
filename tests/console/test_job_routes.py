"""Jobs over HTTP: their states, and what they are called."""

import time

import pytest

pytest.importorskip("fastapi")


@pytest.mark.usefixtures("light")
def test_the_titles_of_responses_say_what_is_computed(client):
    for inputs, laws in (([1.98], []), ([0.5, 1.0], ["on_off"])):
        client.post("/api/building/responses", json={"damper": {"inputs": inputs, "laws": laws}})
    titles = [job["title"] for job in client.get("/api/jobs").json()]
    assert [title.rpartition(", ")[2] for title in titles] == ["0.5 1 on-off", "1.98"]


@pytest.mark.usefixtures("light")
def test_a_job_is_read_cancelled_and_removed(client):
    made = client.post("/api/building/responses", json={"damper": {"inputs": [1.98]}}).json()
    place = f"/api/jobs/{made['id']}"
    read = client.get(place).json()
    assert (read["kind"], read["result"], read["request"]["damper"]["inputs"]) == ("respond", None, [1.98])
    assert client.delete(place).status_code == 400  # it has not ended
    assert client.post(f"{place}/cancel").json()["state"] == "cancelled"
    for _ in range(400):
        if client.delete(place).status_code == 204:  # as soon as its process has ended
            break
        time.sleep(0.01)
    assert client.get(place).status_code == 404
    assert client.get("/api/jobs").json() == []


@pytest.mark.parametrize("id", ["0123456789abcde", "0123456789ABCDEF", "0123456789abcdef0"])
def test_what_is_no_identifier_of_a_job_is_refused(client, id):
    assert client.get(f"/api/jobs/{id}").status_code == 422
