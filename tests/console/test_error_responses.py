"""Errors as a page gets them: a sentence, and nothing of the inside."""

import json

import pytest

pytest.importorskip("fastapi")

from fastapi.testclient import TestClient

from dampyr.console import app
from dampyr.console.error_responses import MAX_SENTENCE, answer, without_places

HERE = "http://127.0.0.1:8077"


def test_a_fault_tells_nothing_of_the_inside(data, monkeypatch, caplog):
    from dampyr.console import cards

    def broken(*_):
        raise RuntimeError("secret /etc/passwd")

    monkeypatch.setattr(cards.safe_paths, "files", broken)
    with TestClient(app(data), base_url=HERE, raise_server_exceptions=False) as client:
        answer = client.get("/api/cards")
    assert answer.status_code == 500
    assert answer.json() == {"detail": "something went wrong inside dampyr; see the console's own output"}


@pytest.mark.parametrize(
    ("sentence", "shown"),
    [
        ("{data}/uploads/a.h5: no force", "uploads/a.h5: no force"),
        ("nothing in {data}, as it is empty", "nothing in the data folder, as it is empty"),
        ("'/home/lab/secret/b.csv', line 3", "'b.csv', line 3"),
        ("C:\\lab\\c.mat: too short", "c.mat: too short"),
        ("12 mm/s is above 1/2 of it", "12 mm/s is above 1/2 of it"),
    ],
)
def test_a_sentence_names_no_folder_of_the_machine(data, sentence, shown):
    assert without_places(sentence.format(data=data), data) == shown


def test_a_long_message_is_cut_to_what_a_person_reads():
    body = json.loads(answer(400, "much\n  more " * 10_000).body)
    assert len(body["detail"]) == MAX_SENTENCE
    assert body["detail"].startswith("much more much more")
    assert body["detail"].endswith(" …")


def test_the_first_thing_that_is_wrong_is_named_with_its_place(client):
    answered = client.post("/api/identify/jobs", json={"records": ["a"], "bandwidth": -1, "starts": 0})
    assert answered.status_code == 422
    assert answered.json()["detail"].startswith("bandwidth: ")
