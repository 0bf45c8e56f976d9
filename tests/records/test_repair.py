"""Repairs of samples: told, kept with what was there before, and undone to the last bit."""

import pickle
import re

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

import dampyr as dp
from dampyr.cli import cli
from dampyr.errors import FileError, InputError
from dampyr.records import Record, read, repair, undo_repairs, with_lowpass, write
from dampyr.records.record import CHANNELS

KINDS = "false samples, gaps, force drift, position drift"


def same(one: Record, other: Record) -> bool:
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in CHANNELS if name != "temperature")


def without(record: Record, *missing: int) -> Record:
    keep = np.setdiff1d(np.arange(record.n), missing)
    parts = {name: values[keep] for name in CHANNELS if isinstance(values := getattr(record, name), np.ndarray)}
    return record.replace(note="samples lost", **parts)


def test_false_samples_are_replaced_told_and_given_back(make_sine):
    clean = make_sine(no_input=True)
    at = [400, 401, 733, 1200]  # two beside one another
    force = np.array(clean.force)
    force[at] += [3000.0, -2500.0, 4000.0, -3000.0]
    wrong = clean.replace(note="spikes", force=force)
    repaired = repair(wrong, "false samples")
    slope = 3000.0 * 0.010 * (2 * np.pi * 0.9) ** 2  # N/s at most, of which a line loses 1/8 of (2 dt)^2 curvature
    assert np.flatnonzero(repaired.force != wrong.force).tolist() == at
    assert np.abs(repaired.force - clean.force).max() < 0.01 * slope * 3 * 0.01
    [note] = [finding for finding in repaired.findings if "replaced" in finding.words]
    assert note.severity == "note"
    assert note.words == "4 false samples of the force replaced, linearly between their neighbours"
    assert not any("it seems" in finding.words for finding in repaired.findings)
    assert any("--repair false-samples" in finding.words for finding in wrong.findings)
    undone = undo_repairs(repaired)
    assert same(undone, wrong)
    assert not undone.repairs
    assert undone.history[-1] == f"undone: {note.words}"


def test_where_nothing_is_wrong_the_samples_stay_and_the_history_says_so(make_sine):
    clean = make_sine(no_input=True)
    looked = repair(clean, "false-samples, gaps")
    assert same(looked, clean)
    assert looked.history[-2:] == ("false samples: nothing to repair was found", "gaps: nothing to repair was found")


def test_short_gaps_are_filled_and_long_ones_are_refused(make_sine):
    clean = make_sine(no_input=True)
    holed = without(clean, 500, 801, 802, 803, 1100, 1101)
    repaired = repair(holed, "gaps")
    assert repaired.time == pytest.approx(clean.time, abs=1e-12)
    assert np.abs(repaired.displacement - clean.displacement).max() < 2e-5  # of 20 mm: the encoder's steps are 5 um
    # the force is a cosine of 170 N: a cubic over four intervals of 10 ms, at an extreme where a monotone one is flat
    assert np.abs(repaired.force - clean.force).max() < 0.01 * 170.0
    assert [finding.words for finding in repaired.findings if "put into" in finding.words] == [
        "6 samples put into 3 gaps, the longest of 0.04 s, on a monotone cubic through the samples about it"
    ]
    assert same(undo_repairs(repaired), holed)
    assert same(undo_repairs(repaired.until(9.0)), holed.until(9.0))  # those that were cut away stay away
    with pytest.raises(
        InputError, match=r"the gap of 0.31 s at 4.99 s is too long to be filled, at most 0.0555 s here"
    ):
        repair(without(clean, *range(500, 530)), "gaps")


def test_stamps_that_jitter_are_no_gaps(make_sine):
    clean = make_sine(no_input=True)
    time = clean.time + np.where(np.arange(clean.n) % 3 == 0, 0.006, 0.0)
    with pytest.raises(InputError, match=r"the time stamps jitter.*dt=0\.01"):
        repair(clean.replace(note="jitter", time=time), "gaps")


@pytest.mark.parametrize("slope", [3.0, -8.0])
def test_a_drifting_zero_of_the_force_is_taken_off(make_sine, slope):
    clean = make_sine(no_input=True)
    drifted = clean.replace(note="drift", force=clean.force + slope * clean.time)
    repaired = repair(drifted, "force drift")
    assert np.abs(repaired.force - clean.force).max() < 0.02 * abs(slope) * clean.duration
    assert float(re.search(r"zero, (-?[\d.]+) N/s", repaired.history[-1])[1]) == pytest.approx(slope, rel=0.01)
    assert same(undo_repairs(repaired), drifted)


def test_a_repaired_record_gives_the_numbers_of_the_whole_one():
    t = 0.002 * np.arange(2001)
    damper = dp.models.Damper("dahl", {"kx": 1200.0, "kw": 200.0, "rho": 2000.0})
    x, v = 0.01 * np.sin(2 * np.pi * t), 0.02 * np.pi * np.cos(2 * np.pi * t)
    whole = Record(t, x, damper.force(t, x, velocity=v), no_input=True)
    force = np.array(whole.force)
    force[[200, 700, 1500]] += 3000.0
    bad = without(whole.replace(note="spikes", force=force), 400, 401, 950)
    whole_values, repaired_values, misled_values = (
        [fitted.damper.all_laws[f"dahl.{name}"].coefficients[0] for name in ("kx", "kw", "rho")]
        for fitted in (dp.fit(whole, "dahl"), dp.fit(repair(bad, "false samples, gaps"), "dahl"), dp.fit(bad, "dahl"))
    )
    assert repaired_values == pytest.approx(whole_values, rel=2e-3)
    assert misled_values != pytest.approx(whole_values, rel=0.01)


def test_files_keep_what_was_there_before(make_sine, tmp_path):
    wrong = without(make_sine(no_input=True, drift=4e-4), 500, 900)
    force = np.array(wrong.force)
    force[[300, 701]] += 2500.0
    wrong = wrong.replace(note="spikes", force=force)
    repaired = pickle.loads(pickle.dumps(repair(wrong, KINDS)))
    assert [step.kind for step in repaired.repairs] == ["false samples", "gaps", "force drift", "position drift"]
    assert any(finding.severity == "doubt" and "did feel it" in finding.words for finding in repaired.findings)
    path = write(repaired, tmp_path / "test.h5")
    assert same(read(path), repaired)
    assert [finding.words for finding in read(path).findings] == [finding.words for finding in repaired.findings]
    undone = read(path, repair="none")
    assert same(undone, wrong)
    assert same(undo_repairs(read(path), "position drift"), undo_repairs(repaired, "position drift"))
    with h5py.File(path, "r+") as file:
        file["repairs/0"][1, 0] += 1.0
    with pytest.raises(FileError, match=r"/repairs/0 is not what was written"):
        read(path)


def test_what_was_changed_after_a_repair_is_not_undone(make_sine):
    wrong = make_sine(no_input=True, drift=4e-4)
    filtered = with_lowpass(repair(wrong, "position drift"), 10.0)
    with pytest.raises(InputError, match=r"the displacement was changed after the repair of position drift"):
        undo_repairs(filtered)


@pytest.mark.parametrize("text", ["spikes", "", "gaps,", 3, "none, gaps"])
def test_a_repair_that_is_none_is_refused(make_sine, text):
    with pytest.raises(InputError, match=r"repair = .* choose from false samples, gaps, force drift, position drift"):
        repair(make_sine(no_input=True), text)


def test_rows_with_an_empty_cell_are_gaps_where_it_is_declared(make_sine, tmp_path):
    clean = make_sine(no_input=True)
    lines = [f"{t:.3f},{x:.9f},{f:.6f}" for t, x, f in zip(clean.time, clean.displacement, clean.force, strict=True)]
    lines[500], lines[700] = "5.000,,120.0", "7.000,0.0,"
    (tmp_path / "test.csv").write_text("time (s),displacement (m),force (N)\n" + "\n".join(lines) + "\n")
    with pytest.raises(
        FileError, match=r"line 502: the cell of the displacement is empty; .*--repair gaps or repair='gaps'"
    ):
        read(tmp_path / "test.csv", no_input=True)
    record = read(tmp_path / "test.csv", no_input=True, repair="gaps")
    assert record.n == clean.n
    assert np.abs(record.displacement - clean.displacement).max() < 2e-5
    assert "2 rows with an empty cell left out" in record.history
    # the same without a column of the time, whose interval counts the rows that are left out
    text = "\n".join(line.split(",", 1)[1] for line in ["t,displacement (m),force (N)", *lines])
    (tmp_path / "untimed.csv").write_text(text + "\n")
    untimed = read(tmp_path / "untimed.csv", no_input=True, repair="gaps", dt=0.01)
    assert untimed.time == pytest.approx(clean.time, abs=1e-12)
    assert untimed.force == pytest.approx(record.force, abs=1e-9)


def test_the_command_line_repairs_and_a_folder_says_it_once(make_sine, tmp_path):
    wrong = make_sine(no_input=True)
    force = np.array(wrong.force)
    force[300] += 2500.0
    write(wrong.replace(note="spike", force=force), tmp_path / "test.csv")
    told, mended = (
        CliRunner().invoke(cli, ["records", str(tmp_path), "--no-input", *more], catch_exceptions=False).stdout
        for more in ([], ["--repair", "false-samples"])
    )
    assert "--repair false-samples" in told
    assert "1 false sample of the force replaced" in mended
    (tmp_path / "reading.toml").write_text('repair = "false samples"\nno_input = true\n')
    [record] = dp.records.read_campaign(tmp_path)
    assert record.repairs[0].kind == "false samples"
    refused = CliRunner().invoke(cli, ["records", str(tmp_path), "--repair", "all"])
    assert refused.exit_code == 2
    assert "choose from false samples, gaps" in refused.output
