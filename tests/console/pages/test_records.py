"""The Records page: what its endpoints tell, what comes in and what cannot."""

import io
import pickle
import struct
import tempfile
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io

pytest.importorskip("fastapi")
from fastapi.testclient import TestClient
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.console.memory import resident
from tests.endurance import count
from tests.records.test_self_contained import PLANTS, planted

from dampyr import records
from dampyr.console import app, record_uploads
from dampyr.console.limits import READING
from dampyr.console.page_words import in_page_words
from dampyr.records.checks.channel_uncertainty import ChannelUncertainty
from dampyr.to_json import plain

KEY = "labcontrol/ensaio.A.1.mat"
CSV = "time [s],displacement [mm],force [N]\n" + "".join(
    f"{k / 100},{8 * np.sin(k / 12):.5f},{300 * np.cos(k / 12) + 20:.4f}\n" for k in range(600)
)


def upload(client, name, content, **said):
    return client.put(f"/api/records/uploads/{name}", content=content, params=said)


def everything(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def test_the_list_tells_what_the_command_tells(client, campaign_folder):
    reply = client.get("/api/records/list", params={"source": "labcontrol"}).json()
    own = {record.name: plain(records.describe(record)) for record in records.read_campaign(campaign_folder, role=None)}
    for about in own.values():
        about["notes"] = [in_page_words(finding["words"]) for finding in about.pop("findings")]
    assert {one["about"]["name"]: one["about"] for one in reply} == own
    keys = [one["key"] for one in reply]
    assert keys.index("labcontrol/ensaio.A.10.mat") - keys.index(KEY) == 9


def test_marks_and_uncertainty_of_a_record_are_shown(client, data):
    t = np.arange(600) / 100.0
    mark, stated = "the force's zero moved by +16 N", {"force": ChannelUncertainty({"zero": 5.0, "noise": 0.4})}
    x = 8e-3 * np.sin(t / 0.12)
    marked = records.Record(t, x, 300.0 * np.cos(t / 0.12), voltage=1.0, marks=(mark,), uncertainty=stated)
    (data / "uploads").mkdir()
    records.write(marked, data / "uploads" / "one.h5")
    (one,) = client.get("/api/records/list").json()
    assert mark in one["about"]["notes"]
    assert one["about"]["uncertainty"]["force"]["parts"] == {"zero": 5.0, "noise": 0.4}


def test_curves_keep_the_peaks(client, campaign_folder):
    got = client.get("/api/records/curves", params={"key": KEY}).json()
    record = records.read(campaign_folder / "ensaio.A.1.mat")
    assert max(got["force"]["y"]) == pytest.approx(record.force.max(), rel=1e-5)
    assert min(got["force_displacement"]["x"]) == pytest.approx(record.displacement.min(), rel=1e-5)


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


def _bomb():
    """An .h5 file of a few kB that unfolds to 24 GB."""
    with tempfile.TemporaryDirectory() as folder, h5py.File(Path(folder, "a.h5"), "w") as file:
        file.attrs.update({"format": "dampyr record", "schema": 1, "complete": np.uint8(1), "name": "a", "role": "fit"})
        file.attrs.update({"test": "a", "try": 1})
        for channel, unit in (("time", "s"), ("displacement", "m"), ("force", "N")):
            made = file.create_dataset(
                f"calibrated/{channel}", shape=(10**9,), dtype="f8", chunks=(10**7,), compression="gzip"
            )
            made.attrs["unit"] = unit
        file.flush()
        return Path(folder, "a.h5").read_bytes()


NO_KEYS = ["data/../x.csv", "labcontrol/../SOURCES.md", "data//etc/passwd", "nowhere/a.mat", "data/x.csv", "x"]

HOSTILE = {
    "empty.csv": b"",
    "pickle.mat": pickle.dumps(print),
    "objects.mat": _v5(Ts=0.01, dist=np.array([[{"a": 1}]], dtype=object), forc=np.zeros(20), x_F=np.zeros((20, 3))),
    "cut.mat": _v5(Ts=0.01, dist=np.zeros(2000), forc=np.zeros(2000), x_F=np.zeros((2000, 3)))[:700],
    "header.mat": b"MATLAB 5.0 MAT-file".ljust(124)
    + struct.pack("<HH", 0x0100, 0x4D49)
    + struct.pack("<II", 15, 2**31 - 8),
    "noise.h5": b"\x89HDF\r\n\x1a\n" + bytes(range(256)) * 4,
    "unfolds.h5": _bomb(),
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
    "name", ["..%2f..%2fa.csv", "%2e%2e.csv", ".a.csv", "a.exe", "a.csv%00", "a", "a%5cb.csv", "-a.csv", "a.pkl"]
)
def test_a_name_that_is_none_is_refused(client, data, name):
    assert upload(client, name, CSV).status_code in (400, 404)
    assert everything(data) == []


def test_files_that_point_out_of_themselves_show_nothing(client, data, tmp_path):
    """Neither uploaded nor put into the data folder by hand."""
    answers = []
    for number, plant in enumerate(PLANTS.values()):
        (folder := tmp_path / "sent" / str(number)).mkdir(parents=True)
        path = planted(folder / f"test {number}.h5", plant)
        refused = upload(client, path.name, path.read_bytes())
        assert refused.status_code == 400
        answers.append(refused)
    assert everything(data) == []
    for path in (tmp_path / "sent").glob("*/test *.h5"):
        (data / path.name).write_bytes(path.read_bytes())
        answers += [
            client.get(f"/api/records/{each}", params={"key": f"data/{path.name}", "format": "csv"})
            for each in ("one", "curves", "cycles", "export")
        ]
    listed = client.get("/api/records/list")
    assert sum("copy it with h5repack" in one["problem"] for one in listed.json()) == len(PLANTS)
    for answer in (listed, *answers):
        assert not any(secret in answer.text for secret in ("777.25", "778.25", "password"))
        assert "copy it with h5repack" in answer.text


def test_one_file_that_unfolds_does_not_hide_the_others(client, data):
    """Each is read where memory is bounded, and what cannot be is said in its place."""
    for name, content in (("a.csv", CSV.encode()), ("b.h5", HOSTILE["unfolds.h5"]), ("c.csv", CSV.encode())):
        (data / name).write_bytes(content)
    before = resident()
    listed = client.get("/api/records/list").json()
    assert [(one["key"], bool(one["problem"])) for one in listed] == [
        ("data/a.csv", False), ("data/c.csv", False), ("data/b.h5", True)
    ]  # fmt: skip
    assert "memory" in listed[2]["problem"]
    assert resident() - before < 30


def test_uploads_stop_at_the_quota(data):
    with TestClient(app(data, quota=20_000), base_url="http://localhost") as client:
        refused = upload(client, "a.csv", CSV * 4)
    assert (refused.status_code, everything(data)) == (413, [])


def test_an_upload_that_unfolds_to_more_than_may_be_written_is_told(client, data, monkeypatch):
    monkeypatch.setattr(record_uploads, "READING", replace(READING, written=10_000))
    refused = upload(client, "a.csv", CSV)
    assert (refused.status_code, "more than may be written" in refused.text) == (400, True)
    assert everything(data) == []


@pytest.mark.parametrize("key", [*NO_KEYS, "data/.console/notes.json"])
@pytest.mark.parametrize("path", ["one", "curves", "cycles", "export"])
def test_a_key_never_leads_out(client, campaign_folder, key, path):
    answer = client.get(f"/api/records/{path}", params={"key": key, "format": "csv"})
    assert answer.status_code in (400, 404, 422)
    assert "/" not in answer.json()["detail"].replace(key, "").replace(key.partition("/")[2], "").replace("by /", "")


def test_a_note_is_kept_and_taken_away(client, campaign_folder):
    client.put("/api/records/notes", json={"key": KEY, "text": " the table was pushed "})
    assert client.get("/api/records/one", params={"key": KEY}).json()["note"] == "the table was pushed"
    client.put("/api/records/notes", json={"key": KEY, "text": ""})
    assert client.get("/api/records/one", params={"key": KEY}).json()["note"] == ""
    assert client.put("/api/records/notes", json={"key": "data/no.csv", "text": "x"}).status_code == 404


@pytest.mark.parametrize("format", ["csv", "mat", "h5"])
def test_an_export_is_read_back(client, campaign_folder, tmp_path, format):
    answer = client.get("/api/records/export", params={"key": KEY, "format": format})
    (tmp_path / f"a.{format}").write_bytes(answer.content)
    back, own = records.read(tmp_path / f"a.{format}", voltage=3.212), records.read(campaign_folder / "ensaio.A.1.mat")
    np.testing.assert_allclose(back.force, own.force, rtol=1e-12)
    np.testing.assert_allclose(back.velocity, own.velocity, rtol=1e-12, atol=1e-15)


def test_a_figure_is_exported(client, campaign_folder):
    answer = client.get("/api/records/export", params={"key": KEY, "format": "png"})
    assert answer.content.startswith(b"\x89PNG")


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
