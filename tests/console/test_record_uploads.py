"""Records as files: odd names, interrupted ones, uploads with their columns, and what is changed afterwards."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from urllib.parse import quote

import numpy as np
import pytest

pytest.importorskip("fastapi")

from dampyr import records
from dampyr.console import record_answers
from dampyr.console.record_sources import unique_names
from dampyr.options import options_of

ROWS = [(k / 100, 8 * np.sin(k / 12), 300 * np.cos(k / 12) + 20) for k in range(600)]
CSV = "time [s],displacement [mm],force [N]\n" + "".join(f"{t},{x:.5f},{f:.4f}\n" for t, x, f in ROWS)
BARE = "".join(f"{t},{x:.5f},{f:.4f}\n" for t, x, f in ROWS)
KEY = "data/uploads/a.h5"


def upload(client, name, content=CSV, **said):
    kind = {"content-type": "application/octet-stream"}
    return client.put(f"/api/records/uploads/{quote(name)}", content=content, params=said, headers=kind)


def listed(client):
    return client.get("/api/records/list", params={"source": "data"}).json()


def made(name="a", **more):
    t, x, f = np.array(ROWS).T
    return records.Record(t, 1e-3 * x, f, voltage=1.0, name=name, **more)


@pytest.mark.parametrize(
    "name",
    ["0,25 A.csv", "#3.csv", "O'Neil.csv", "run [2].csv", "50 % & more.csv", "_first.csv", "n" * 120 + ".csv", "ü.csv"],
)
def test_a_file_with_an_odd_name_is_listed_and_read(client, data, name):
    (data / name).write_text(CSV)
    (one,) = listed(client)
    assert (one["key"], one["problem"]) == (f"data/{name}", "")
    for what in ("one", "curves", "cycles"):
        assert client.get(f"/api/records/{what}", params={"key": one["key"]}).status_code == 200


def test_what_cannot_be_used_is_listed_with_the_reason(client, data, tmp_path):
    (data / "what?.csv").write_text(CSV)
    (tmp_path / "outside.csv").write_text(CSV)
    (data / "link.csv").symlink_to(tmp_path / "outside.csv")
    said = {one["key"]: one["problem"] for one in listed(client)}
    assert "rename it" in said["data/what?.csv"]
    assert "links are not followed" in said["data/link.csv"]


def test_interrupted_and_repeated_tests_are_marked(client, data):
    folder = data / "runs" / "day"
    folder.mkdir(parents=True)
    for name, attempt, complete in (("a", 1, "no"), ("a-try2", 2, "yes"), ("b", 1, "yes"), ("b-try2", 2, "yes")):
        about = {"test": name[0], "try": str(attempt)} | ({"complete": "no"} if complete == "no" else {})
        records.write(made(name[0], provenance=about), folder / f"{name}.h5")
    marks = {one["key"].rpartition("/")[2]: one["left_out"] for one in listed(client)}
    assert marks == {
        "a.h5": "interrupted: its recording was not completed", "a-try2.h5": "",
        "b.h5": "done again: try 2 of this test is the last", "b-try2.h5": "",
    }  # fmt: skip
    tries = [record.provenance["try"] for record in records.read_campaign(folder)]
    assert tries == ["2", "2"]  # what the command takes


@pytest.mark.prove
def test_records_of_two_runs_with_the_same_names_are_fitted_together(client, data, finished):
    keys = []
    for run in ("monday", "tuesday"):
        folder = data / "runs" / run
        folder.mkdir(parents=True)
        records.write(made("01-sine"), folder / "01-sine.h5")
        keys.append(f"data/runs/{run}/01-sine.h5")
    job = finished(client.post("/api/identify/jobs", json={"records": keys, "model": "bingham"}).json()["id"])
    assert job["state"] == "done", job["reason"]
    assert job["result"]["records"] == ["01-sine (monday)", "01-sine (tuesday)"]


def test_names_that_repeat_are_told_apart_by_as_little_as_is_needed():
    keys = ["data/x/a.h5", "data/y/a.h5", "data/y/b.h5"]
    assert unique_names(["a", "a", "b"], keys) == ["a (x)", "a (y)", "b"]
    assert unique_names(["a", "a"], ["data/x/a.h5", "data/x/a-try2.h5"]) == ["a (a.h5)", "a (a-try2.h5)"]
    assert unique_names(["a", "a"], ["data/x/1/a.h5", "data/y/1/a.h5"]) == ["a (data/x/1/a.h5)", "a (data/y/1/a.h5)"]


def test_an_odd_name_is_stored_as_a_safe_one_and_said_so(client):
    answer = upload(client, "Prüfstand 3, Dämpfer ü.csv")
    assert answer.status_code == 201
    assert answer.json()["key"] == "data/uploads/Prüfstand 3_ Dämpfer ü.h5"
    assert "is stored as 'Prüfstand 3_ Dämpfer ü'" in answer.json()["notices"][0]
    assert "has no suffix of a record; it must end in" in upload(client, "a.exe").json()["detail"]


def test_latin_1_is_read_and_said_so(client):
    text = "Zeit [s];Weg [mm];Kraft für Dämpfer [N]\n" + BARE.replace(",", ";").replace(".", ",")
    said = {"column": ["time=0", "displacement=1", "force=2"]}
    answer = upload(client, "alt.csv", text.encode("latin-1"), **said)
    assert answer.status_code == 201, answer.text
    assert answer.json()["notices"] == ["read as Latin-1 (Windows-1252) text, as it is not UTF-8"]
    about = client.get("/api/records/one", params={"key": "data/uploads/alt.h5"}).json()["about"]
    assert about["measured"]["peak_to_peak_m"] == pytest.approx(0.016, rel=1e-2)


def test_a_file_of_a_million_columns_is_answered_in_a_line(client, data):
    answer = upload(client, "wide.csv", "1," * 1_000_000 + "1\n")
    assert answer.status_code == 400
    assert answer.json()["detail"].startswith("wide.csv: line 1 has more than 1000 columns")
    many = ",".join(f"c{k}" for k in range(900)) + "\n" + ("1," * 899 + "1\n") * 20
    answer = upload(client, "many.csv", many)
    assert answer.status_code == 400
    assert len(answer.json()["detail"]) <= 600


def test_of_thirty_notes_at_once_none_is_lost(client, data):
    (data / "a.csv").write_text(CSV)
    for k in range(30):
        (data / f"r{k}.csv").write_text(CSV)
    given = [{"key": f"data/r{k}.csv", "text": str(k)} for k in range(30)]
    with ThreadPoolExecutor(30) as pool:
        answers = list(pool.map(lambda note: client.put("/api/records/notes", json=note), given))
    assert {answer.status_code for answer in answers} == {200}
    notes = {one["key"]: one["note"] for one in listed(client)}
    assert [notes[f"data/r{k}.csv"] for k in range(30)] == [str(k) for k in range(30)]


def preview(client, name, content, **said):
    return client.put(f"/api/records/preview/{name}", content=content, params=said).json()


def test_the_columns_of_a_file_are_shown_before_it_is_uploaded(client, data):
    shown = preview(client, "a.csv", CSV[:2000], part=True)
    assert [(c["name"], c["unit"], c["channel"]) for c in shown["columns"]] == [
        ("time", "s", "time"), ("displacement", "mm", "displacement"), ("force", "N", "force")
    ]  # fmt: skip
    assert shown["columns"][0]["values"] == [0.0, 0.01, 0.02, 0.03, 0.04, 0.05]
    assert shown["channels"]["displacement"] == "m"
    assert list(data.glob("*/*.h5")) == []


def test_a_file_without_names_is_read_with_the_columns_that_were_chosen(client):
    shown = preview(client, "bare.csv", BARE)
    assert [(c["name"], c["channel"]) for c in shown["columns"]] == [("", "")] * 3
    said = {
        "column": ["time=0", "displacement=1", "force=2"],
        "unit": ["time=s", "displacement=mm", "force=N"],
        "force_sign": -1, "voltage": 0.5,
    }  # fmt: skip
    assert upload(client, "bare.csv", BARE, **said).status_code == 201
    about = client.get("/api/records/one", params={"key": "data/uploads/bare.h5"}).json()["about"]
    assert about["input_value"] == 0.5
    assert "force turned, as its sign was declared" in about["history"]
    assert preview(client, "no.csv", "words\n")["problem"].startswith("no.csv: has no line of numbers")


def test_what_the_form_of_uploads_offers_is_taken(client):
    offered = [option["name"] for option in client.get("/api/records/uploads/options").json()]
    assert offered == [
        option.name for option in options_of(records.ReadOptions) if option.name not in ("units", "columns", "cut")
    ]
    untimed = "x [mm],f [N]\n" + "".join(f"{x:.5f},{f:.4f}\n" for _, x, f in ROWS)
    said = {"dt": 0.01, "column": ["displacement=x", "force=f"], "smoothed": "3 samples, not undone", "lowpass": "20"}
    answer = upload(client, "untimed.csv", untimed, **said)
    assert answer.status_code == 201, answer.text
    history = client.get("/api/records/one", params={"key": answer.json()["key"]}).json()["about"]["history"]
    assert any("time from the sampling interval, 0.01 s" in step for step in history)
    assert any("low-pass" in step for step in history)
    for wrong, code in (({"dt": -1}, 422), ({"smoothed": "a tenth"}, 400), ({"force_sign": 2}, 400)):
        assert upload(client, "wrong.csv", untimed, **wrong).status_code == code


def test_a_record_is_described_anew_and_the_file_as_it_came_is_untouched(client, data):
    upload(client, "a.csv")
    before = (data / "uploads" / "a.h5").read_bytes()
    given = {"key": KEY, "specimen": "no. 7", "operator": "Jo", "voltage": 1.98, "temperature": 23.0}
    assert client.post("/api/records/edit", json=given).status_code == 200
    about = client.get("/api/records/one", params={"key": KEY}).json()["about"]
    assert (about["specimen"], about["input_value"], about["provenance"]["operator"]) == ("no. 7", 1.98, "Jo")
    assert about["provenance"]["edited"].endswith("specimen, operator, voltage, temperature")
    assert (
        about["history"][-1]
        == "edited in the console: specimen = no. 7, operator = Jo, voltage = 1.98, temperature = 23.0"
    )
    client.post("/api/records/edit", json={"key": KEY, "specimen": "no. 8"})
    assert (data / ".console" / "originals" / "a.h5").read_bytes() == before
    assert [one["key"] for one in listed(client)] == [KEY]
    assert client.post("/api/records/edit", json={"key": KEY}).status_code == 400
    assert client.post("/api/records/edit", json={"key": "data/a.h5", "specimen": "x"}).status_code == 400


def test_a_record_is_renamed_with_its_note_and_deleted_with_its_original(client, data):
    upload(client, "a.csv")
    upload(client, "b.csv")
    client.put("/api/records/notes", json={"key": KEY, "text": "loose"})
    client.post("/api/records/edit", json={"key": KEY, "specimen": "x"})
    assert client.post("/api/records/rename", json={"key": KEY, "name": "b"}).status_code == 409
    assert client.post("/api/records/rename", json={"key": KEY, "name": "../c"}).status_code == 400
    key = client.post("/api/records/rename", json={"key": KEY, "name": "c 1"}).json()["key"]
    assert key == "data/uploads/c 1.h5"
    assert {one["key"]: one["note"] for one in listed(client)} == {key: "loose", "data/uploads/b.h5": ""}
    assert client.delete("/api/records/uploads/c 1.h5").status_code == 204
    assert sorted(path.name for path in data.rglob("*.h5")) == ["b.h5"]


def test_a_record_of_millions_of_samples_is_measured_on_its_first_part(monkeypatch):
    monkeypatch.setattr(record_answers, "MAX_MEASURED", 400)
    about = record_answers.description(made())
    assert (about["quality"]["samples"], about["duration_s"]) == (600, 5.99)
    assert about["notes"][0] == "measured on its first 3.99 s of 5.99 s: it has 600 samples"
    assert about["measured"]["cycles"] < 6


@pytest.mark.prove
def test_forty_megabytes_of_text_are_read_within_a_gigabyte(tmp_path):
    path = tmp_path / "big.csv"
    path.write_text("time [s],displacement [mm],force [N]\n")
    with path.open("a") as file:
        for k in range(3_200_000 // 600):
            file.writelines(f"{t + 6 * k:.2f},{x:.2f},{f:.1f}\n" for t, x, f in ROWS)
    # ru_maxrss would begin at the memory of the process that starts this one
    code = "import sys\nfrom dampyr import records\nn = records.read(sys.argv[1]).n\n"
    code += "used = next(line for line in open('/proc/self/status') if line.startswith('VmHWM'))\n"
    code += "print(n, int(used.split()[1]) // 1024)"
    done = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True)
    samples, memory = map(int, done.stdout.split())
    assert samples == 3_200_000 // 600 * 600
    assert memory < 1000


def test_motions_and_structures_are_no_broken_records(client, data):
    """In their folders they are not listed; a motion elsewhere says what it is, below what can be read."""
    motion = "time [s],acceleration [m/s^2]\n" + "".join(f"{k / 100},{np.sin(k / 9):.4f}\n" for k in range(300))
    for folder in ("motions", "structures"):
        (data / folder).mkdir()
        (data / folder / "a.csv").write_text(motion)
    (data / "a motion.csv").write_text(motion)
    (data / "b broken.csv").write_text("time [s],force [N]\n0,1\n")
    (data / "c record.csv").write_text(CSV)
    entries = listed(client)
    assert [one["key"] for one in entries] == ["data/c record.csv", "data/a motion.csv", "data/b broken.csv"]
    assert (
        "a ground motion of 2.99 s and not a record of a damper; put it into the folder motions"
        in entries[1]["problem"]
    )
    assert "ground motion" not in entries[2]["problem"]
