"""Records as pages show them: what is told of a record, its lines, and what it is saved as."""

import numpy as np
import pytest

pytest.importorskip("fastapi")
from tests.console.record_files import CSV, MEASURED, listed, made

from dampyr import records
from dampyr.console import record_answers
from dampyr.console.page_words import in_page_words
from dampyr.records.checks.channel_uncertainty import ChannelUncertainty
from dampyr.to_json import plain


def as_shown(about):
    """What the command tells of a record, with its findings as the page's notes."""
    return about | {"notes": [in_page_words(finding["words"]) for finding in about.pop("findings")]}


def test_a_record_is_told_as_the_command_tells_it(client, campaign_folder):
    (record,) = records.read_campaign(campaign_folder, role="validation")
    about = client.get("/api/records/one", params={"key": "labcontrol/ensaio.vali.1.mat"}).json()["about"]
    assert about == as_shown(plain(records.describe(record)))


@pytest.mark.prove
def test_the_list_tells_what_the_command_tells(client, campaign_folder):
    reply = client.get("/api/records/list", params={"source": "labcontrol"}).json()
    own = {record.name: plain(records.describe(record)) for record in records.read_campaign(campaign_folder, role=None)}
    for about in own.values():
        about["notes"] = [in_page_words(finding["words"]) for finding in about.pop("findings")]
    assert {one["about"]["name"]: one["about"] for one in reply} == own
    keys = [one["key"] for one in reply]
    assert keys.index("labcontrol/ensaio.A.10.mat") - keys.index(MEASURED) == 9


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
    got = client.get("/api/records/curves", params={"key": MEASURED}).json()
    record = records.read(campaign_folder / "ensaio.A.1.mat")
    assert max(got["force"]["y"]) == pytest.approx(record.force.max(), rel=1e-5)
    assert min(got["force_displacement"]["x"]) == pytest.approx(record.displacement.min(), rel=1e-5)


@pytest.mark.parametrize("format", ["csv", "mat", "h5"])
def test_an_export_is_read_back(client, campaign_folder, tmp_path, format):
    answer = client.get("/api/records/export", params={"key": MEASURED, "format": format})
    (tmp_path / f"a.{format}").write_bytes(answer.content)
    back, own = records.read(tmp_path / f"a.{format}", voltage=3.212), records.read(campaign_folder / "ensaio.A.1.mat")
    np.testing.assert_allclose(back.force, own.force, rtol=1e-12)
    np.testing.assert_allclose(back.velocity, own.velocity, rtol=1e-12, atol=1e-15)


def test_a_figure_is_exported(client, campaign_folder):
    answer = client.get("/api/records/export", params={"key": MEASURED, "format": "png"})
    assert answer.content.startswith(b"\x89PNG")


def test_a_record_of_millions_of_samples_is_measured_on_its_first_part(monkeypatch):
    monkeypatch.setattr(record_answers, "MAX_MEASURED", 400)
    about = record_answers.description(made())
    assert (about["quality"]["samples"], about["duration_s"]) == (600, 5.99)
    assert about["notes"][0] == "measured on its first 3.99 s of 5.99 s: it has 600 samples"
    assert about["measured"]["cycles"] < 6


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
