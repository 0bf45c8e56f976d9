"""Notes on records: kept, moved, taken away, and none is lost."""

from concurrent.futures import ThreadPoolExecutor

import pytest

pytest.importorskip("fastapi")
from tests.console.record_files import MEASURED

from dampyr.console.record_notes import MAX_LENGTH, move_note, notes, write_note
from dampyr.console.safe_paths import OWN


def test_a_note_is_kept_and_taken_away(client, campaign_folder):
    client.put("/api/records/notes", json={"key": MEASURED, "text": " the table was pushed "})
    assert client.get("/api/records/one", params={"key": MEASURED}).json()["note"] == "the table was pushed"
    client.put("/api/records/notes", json={"key": MEASURED, "text": ""})
    assert client.get("/api/records/one", params={"key": MEASURED}).json()["note"] == ""
    assert client.put("/api/records/notes", json={"key": "data/no.csv", "text": "x"}).status_code == 404


def test_of_thirty_notes_at_once_none_is_lost(client, data):
    for k in range(30):
        (data / f"r{k}.csv").write_text("time [s],displacement [mm],force [N]\n0,0,0\n")
    given = [{"key": f"data/r{k}.csv", "text": str(k)} for k in range(30)]
    with ThreadPoolExecutor(30) as pool:
        answers = list(pool.map(lambda note: client.put("/api/records/notes", json=note), given))
    assert {answer.status_code for answer in answers} == {200}
    written = notes(data)
    assert [written[f"data/r{k}.csv"] for k in range(30)] == [str(k) for k in range(30)]


def test_a_note_is_cut_to_a_page_and_moves_with_its_record(data):
    assert notes(data) == {}
    (data / OWN).mkdir()
    write_note(data, "data/a.h5", f" {'n' * (MAX_LENGTH + 7)}")
    write_note(data, "data/ü.h5", "Dämpfer\nwarm")
    assert notes(data) == {"data/a.h5": "n" * MAX_LENGTH, "data/ü.h5": "Dämpfer\nwarm"}
    move_note(data, "data/ü.h5", "data/b.h5")
    move_note(data, "data/none.h5", "data/c.h5")
    write_note(data, "data/a.h5", " \n")
    assert notes(data) == {"data/b.h5": "Dämpfer\nwarm"}
