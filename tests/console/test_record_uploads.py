"""Uploads of records: their columns, what cannot come in, and what is changed afterwards."""

import io
import pickle
import struct
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import scipy.io

pytest.importorskip("fastapi")
from fastapi.testclient import TestClient
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.console.record_files import BARE, CSV, ROWS, everything, listed, unfolding, upload
from tests.endurance import count

from dampyr import records
from dampyr.console import app, record_uploads
from dampyr.console.limits import READING
from dampyr.options import options_of

KEY = "data/uploads/a.h5"


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


def preview(client, name, content, **said):
    return client.put(f"/api/records/preview/{name}", content=content, params=said).json()


def test_the_columns_of_a_file_are_shown_before_it_is_uploaded(client, data):
    shown = preview(client, "a.csv", CSV[:2000], part=True)
    assert [(c["name"], c["unit"], c["channel"]) for c in shown["columns"]] == [
        ("time", "s", "time"), ("displacement", "mm", "displacement"), ("force", "N", "force")
    ]  # fmt: skip
    assert shown["columns"][0]["values"] == [0.0, 0.01, 0.02, 0.03, 0.04, 0.05]
    assert shown["channels"]["displacement"] == "m"
    assert (shown["every"], shown["rows"], len(shown["columns"][1]["drawn"])) == (1, shown["rows"], shown["rows"])
    whole = preview(client, "a.csv", CSV + BARE * 3)
    assert (whole["rows"], whole["every"]) == (2400, 3)
    assert whole["columns"][1]["drawn"] == pytest.approx([x for _, x, _ in ROWS * 4][::3], abs=1e-5)
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
        option.name
        for option in options_of(records.ReadOptions)
        if option.name not in ("units", "columns", "factors", "offsets", "cut")
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


def test_an_upload_comes_back_as_it_was(client, data):
    answer = upload(client, "run 1.csv", CSV, voltage=1.98)
    assert (answer.status_code, answer.json()) == (201, {"key": "data/uploads/run 1.h5", "notices": []})
    (one,) = client.get("/api/records/list").json()
    assert one["about"]["input_value"] == 1.98
    assert one["about"]["measured"]["frequency_hz"] == pytest.approx(100 / 12 / 2 / np.pi, rel=1e-3)
    assert everything(data) == ["uploads/run 1.h5"]


def test_a_second_upload_of_the_same_name_replaces_nothing(client):
    assert upload(client, "a.csv", CSV).status_code == 201
    again = upload(client, "a.csv", CSV)
    assert (again.status_code, again.json()["detail"][:26]) == (409, "there is a record 'a' alre")


def test_what_the_file_does_not_say_is_asked_for_in_a_sentence(client, data):
    text = CSV.replace(" [mm]", "").replace("force", "cell")
    refused = upload(client, "a.csv", text, unit="displacement=mm")
    assert refused.status_code == 400
    assert "force" in refused.json()["detail"]
    assert str(data) not in refused.text
    assert upload(client, "a.csv", text, unit=["displacement=mm"], column=["force=cell"]).status_code == 201


def test_an_upload_is_read_with_every_option_of_the_reader(client):
    bare = "".join(f"{8 * np.sin(k / 12):.5f},{-300 * np.cos(k / 12):.4f}\n" for k in range(600))
    said = {"column": ["displacement=0", "force=1"], "unit": ["displacement=mm", "force=N"], "dt": "10 ms", "header": 0}
    said |= {"force_sign": -1, "measurement_session": "day 1", "specimen": "no. 7"}
    answer = upload(client, "bare.csv", bare, **said)
    assert answer.status_code == 201, answer.text
    (one,) = client.get("/api/records/list").json()
    about = one["about"]
    assert (about["measurement_session"], about["specimen"], about["duration_s"]) == (
        "day 1",
        "no. 7",
        pytest.approx(5.99),
    )
    assert about["measured"]["energy_per_cycle"] > 0
    assert not about["notes"]
    refused = upload(client, "again.csv", bare, **(said | {"dt": "10 mm"}))
    assert (refused.status_code, "'mm' does not measure what 's' measures" in refused.text) == (422, True)
    matrix = io.BytesIO()
    scipy.io.savemat(matrix, {"run": np.fromstring(bare.replace("\n", ","), sep=",").reshape(-1, 2)})
    said = {name: value for name, value in said.items() if name != "header"} | {"variable": "run"}
    assert upload(client, "run.mat", matrix.getvalue(), **said).status_code == 201


def _v5(**variables):
    page = io.BytesIO()
    scipy.io.savemat(page, variables)
    return page.getvalue()


HOSTILE = {
    "empty.csv": b"",
    "pickle.mat": pickle.dumps(print),
    "objects.mat": _v5(Ts=0.01, dist=np.array([[{"a": 1}]], dtype=object), forc=np.zeros(20), x_F=np.zeros((20, 3))),
    "cut.mat": _v5(Ts=0.01, dist=np.zeros(2000), forc=np.zeros(2000), x_F=np.zeros((2000, 3)))[:700],
    "header.mat": b"MATLAB 5.0 MAT-file".ljust(124)
    + struct.pack("<HH", 0x0100, 0x4D49)
    + struct.pack("<II", 15, 2**31 - 8),
    "noise.h5": b"\x89HDF\r\n\x1a\n" + bytes(range(256)) * 4,
    "unfolds.h5": unfolding(),
    "binary.csv": bytes(range(256)) * 20,
    "words.txt": b"nothing but words\n" * 50,
    "one-line.csv": b"1," * 300_000,
    "nan.csv": CSV.replace("20.0", "nan").encode() + b"7,nan,inf\n",
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_file_is_a_sentence_and_leaves_nothing(client, data, name):
    refused = upload(client, name, HOSTILE[name])
    assert refused.status_code == 400
    assert set(refused.json()) == {"detail"}
    assert "Traceback" not in refused.text
    assert str(data) not in refused.text
    assert "incoming" not in refused.text
    assert everything(data) == []


@pytest.mark.parametrize(
    "name",
    ["..%2f..%2fa.csv", "%2e%2e.csv", ".a.csv", "a.exe", "a.csv%00", "a", "a%5cb.csv", "-a.csv", "a.pkl", "con.csv"],
)
def test_a_name_that_is_none_is_refused(client, data, name):
    assert upload(client, name, CSV).status_code in (400, 404)
    assert everything(data) == []


def test_uploads_stop_at_the_quota(data):
    with TestClient(app(data, quota=20_000), base_url="http://localhost") as client:
        refused = upload(client, "a.csv", CSV * 4)
    assert (refused.status_code, everything(data)) == (413, [])


def test_an_upload_that_unfolds_to_more_than_may_be_written_is_told(client, data, monkeypatch):
    monkeypatch.setattr(record_uploads, "READING", replace(READING, written=10_000))
    refused = upload(client, "a.csv", CSV)
    assert (refused.status_code, "more than may be written" in refused.text) == (400, True)
    assert everything(data) == []


@pytest.mark.prove
@settings(max_examples=6, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(content=st.binary(min_size=1, max_size=300), suffix=st.sampled_from(["csv", "txt", "mat", "h5"]))
def test_no_bytes_make_it_stumble(client, data, content, suffix):
    assert upload(client, f"a.{suffix}", content).status_code == 400
    assert everything(data) == []


@pytest.mark.prove
@pytest.mark.endure
@settings(max_examples=count(300), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=st.integers(0, 20_000), value=st.integers(0, 255), suffix=st.sampled_from(["csv", "mat", "h5"]))
def test_no_changed_byte_of_a_good_file_makes_it_stumble(client, data, tmp_path, place, value, suffix):
    good = tmp_path / f"good.{suffix}"
    if not good.exists():
        (tmp_path / "start.csv").write_text(CSV)
        records.write(records.with_velocity(records.read(tmp_path / "start.csv")), good)
    content = bytearray(good.read_bytes())
    content[place % len(content)] = value
    answer = upload(client, good.name, bytes(content))
    assert answer.status_code in (201, 400)
    client.delete("/api/records/uploads/good.h5")
    assert set(everything(data)) <= {".console/notes.json"}  # what was taken and deleted has left its notes behind
