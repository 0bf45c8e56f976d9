"""Declared moving averages: undone, or noted in the record with the reason; in files, folders and dampyr's own format."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.errors import DampyrWarning, FileError, InputError
from dampyr.records import MovingAverage, Record, read, read_campaign, with_smoothing, write
from dampyr.records.conditioning.moving_average import averaged, reach_of
from dampyr.records.conditioning.smoothing import comparable

DT = 0.004


def raw(seconds=12.0, rest=0.0, noise=2e-6, seed=0, frequency=1.1, **fields):
    """A sine against friction and a dashpot."""
    t = DT * np.arange(round(seconds / DT))
    rng = np.random.default_rng(seed)
    run = np.maximum(t - rest, 0.0)
    x = 0.01 * np.minimum(run, 1.0) * np.sin(2 * np.pi * frequency * run)
    v = np.gradient(x, t)
    force = 60.0 + 900.0 * v + 200.0 * np.tanh(v / 0.01) + rng.normal(0.0, 1.0, t.size)
    return Record(t, x + rng.normal(0.0, noise, t.size), force, velocity=v, voltage=1.0, **fields)


def smooth(record, samples, trailing=False, channels=("displacement", "velocity", "force"), decimals=None):
    reach = reach_of(samples, trailing)
    changed = {c: averaged(getattr(record, c), *reach) for c in channels}
    if decimals is not None:
        changed = {c: np.round(values, decimals[c]) for c, values in changed.items()}
    return record.replace(note="smoothed", **changed)


@pytest.mark.parametrize(
    ("declared", "samples", "trailing"),
    [("0.1 periods", 23, False), (23 * DT, 23, False), ("23 samples, trailing", 23, True), ("0.1 periods", 24, False)],
)
def test_all_channels_are_undone_and_the_history_says_how(declared, samples, trailing):
    """A tenth of the period is 22.7 samples: which of 22, 23 and 24 it was, the noise tells."""
    truth = raw()
    record = with_smoothing(smooth(truth, samples, trailing), declared)
    assert record.smoothed is None
    alignment = "trailing" if trailing else "centred"
    for channel, spread in (("displacement", 1e-6), ("velocity", 1e-5), ("force", 1.0)):
        assert np.std(getattr(record, channel) - getattr(truth, channel)) < spread
        [note] = [one for one in record.history if one.startswith(channel)]
        assert (
            f"moving average of {samples} samples ({samples * DT:.4g} s, {alignment}) undone, start values from" in note
        )
        assert "are multiplied by up to" in note
    assert record.provenance["smoothing"].startswith("moving average of")


def test_a_force_that_rounding_has_spoilt_is_put_on_the_model():
    truth = raw()
    record = with_smoothing(smooth(truth, 23, decimals={"displacement": 12, "velocity": 12, "force": 0}), "23 samples")
    assert record.smoothed == MovingAverage(23 * DT, "centred", ("force",))
    assert np.std(record.displacement - truth.displacement) < 1e-6
    assert "not undone, since the smoothed values hold an error of their own" in record.history[-1]
    assert "export more digits" in record.history[-1]
    assert comparable(record) == slice(11, record.n - 11)
    assert comparable(truth) == slice(0, truth.n)


def test_a_velocity_that_stays_smoothed_under_a_raw_displacement_is_left_out():
    record = smooth(raw(), 23, decimals={"displacement": 12, "velocity": 2, "force": 6})
    record = with_smoothing(record, "23 samples")
    assert record.velocity is None
    assert record.smoothed is None
    assert record.history[-1].startswith("velocity: left out")


def test_what_is_declared_as_not_undone_stays():
    smoothed = smooth(raw(), 23)
    record = with_smoothing(smoothed, "23 samples, not undone, force")
    np.testing.assert_array_equal(record.force, smoothed.force)
    assert record.smoothed == MovingAverage(23 * DT, "centred", ("force",))
    assert record.history[-1].endswith("not undone, declared so")


def against_friction(x, noise):
    force = 1e5 * np.gradient(x) + 30 * np.sign(np.gradient(x)) + np.random.default_rng(4).normal(0.0, noise, x.size)
    return Record(DT * np.arange(x.size), x, force, voltage=0.0)


def test_broad_motion_needs_a_rest_for_its_force():
    """Without one the force's part at 1/T is lost: it is compared through the average; the displacement is still undone."""
    rng = np.random.default_rng(2)
    x = 1e-3 * np.cumsum(np.convolve(rng.standard_normal(2599), np.hanning(100), "valid")) / 20
    truth = against_friction(x, 0.2)
    record = with_smoothing(smooth(truth, 40, channels=("displacement", "force")), 40 * DT)
    assert record.smoothed == MovingAverage(40 * DT, "centred", ("force",))
    assert "which the average has removed for good; a record that begins with two windows of rest" in record.history[-1]
    truth = against_friction(np.r_[np.full(600, x[0]), x], 0.2)
    record = with_smoothing(smooth(truth, 40, channels=("displacement", "force")), 40 * DT)
    assert record.smoothed is None
    assert np.std(record.force - truth.force) < 0.2
    assert all("start values from rest at the start" in note for note in record.history[-2:])


@pytest.mark.parametrize(
    ("change", "declared", "words"),
    [
        (lambda r: r, 0.001, "a window of 0.001 s is 0 samples of 0.004 s; it must be from 2 to 1500"),
        (lambda r: r, "2000 samples", "it must be from 2 to 1500"),
        (lambda r: r.until(0.5), "0.1 periods", "its motion does not repeat itself"),
        (lambda r: r.replace(note="", velocity=None), "23 samples, velocity", "has none of the channels"),
        (lambda r: with_smoothing(r, "23 samples"), "23 samples", "is declared smoothed already"),
        (lambda r: r.replace(note="", time=r.time**1.1), 0.1, "sampling steps differ by more than 1 %"),
    ],
)
def test_what_cannot_be_is_refused_with_the_repair(change, declared, words):
    with pytest.raises(InputError, match=words):
        with_smoothing(change(raw()), declared)


def written(folder, name, record):
    columns = np.column_stack([record.time, 1e3 * record.displacement, record.force])
    np.savetxt(folder / name, columns, fmt="%.9f", header="time [s],displacement [mm],force [N]", delimiter=",")


def test_reading_toml_declares_it_by_pattern_and_a_call_goes_before(tmp_path):
    truth = raw()
    written(tmp_path, "sine.csv", smooth(truth, 23))
    written(tmp_path, "plain.csv", truth)
    said = 'voltage = 1.0\n[smoothed]\n"sine*" = "0.1 periods"\n[lowpass]\n"s*" = "15 f"\n"p*" = 20.0\n'
    (tmp_path / "reading.toml").write_text(said)
    plain, sine = read_campaign(tmp_path)
    assert np.std(sine.force - truth.force) < 1.0
    assert "moving average" not in " ".join(plain.history)
    assert float(sine.provenance["displacement_lowpass_hz"]) == pytest.approx(16.5, rel=1e-3)
    assert plain.history[-1] == "displacement after a low-pass: local cubic, no phase, -3 dB at 20 Hz"
    said_here = read(tmp_path / "sine.csv", smoothed="23 samples, not undone", lowpass=10.0)
    assert said_here.smoothed == MovingAverage(23 * DT, "centred", ("displacement", "force"))
    assert said_here.provenance["displacement_lowpass_hz"] == "10"
    assert [r.smoothed is None for r in read_campaign(tmp_path, smoothed="23 samples, not undone")] == [False, False]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('smoothed = "a tenth"', "smoothed = 'a tenth' is not a valid window"),
        (
            '[smoothed]\n"s*" = 0.1\n"*e" = 0.2',
            "smoothed gives sine.csv both '0.1 s' and '0.2 s'; make the patterns exclusive",
        ),
        ('[smoothed]\n"x*" = 0.1', "'x\\*' matches no file of the folder"),
        ("lowpass = 0", "lowpass = 0 is not a frequency"),
        ('[lowpass]\n"s*" = "fast"', "lowpass = 'fast' is not a frequency"),
    ],
)
def test_a_slip_in_reading_toml_is_told(tmp_path, text, words):
    written(tmp_path, "sine.csv", raw(seconds=4.0))
    (tmp_path / "reading.toml").write_text(f"{text}\n")
    with pytest.raises(FileError, match=words):
        read_campaign(tmp_path)


def both_are_sections(one, other):
    return f'[[files]]\npattern = "sine*"\n{one}\n[[files]]\npattern = ["*2"]\n{other}\n'


def test_a_section_of_files_declares_it_before_what_holds_for_all(tmp_path):
    """Sections merge as all other keys do; a value may be a table of its fields, and the same one in other words agrees."""
    for name in ("plain.csv", "sine1.csv", "sine2.csv"):
        written(tmp_path, name, smooth(raw(), 23))
    said = 'voltage = 1.0\nsmoothed = {samples = 15, undo = false, channels = ["force"]}\nlowpass = 20\n'
    said += both_are_sections(
        'smoothed = {samples = 23, undo = false}\nlowpass = "15 f"', "smoothed = '23 samples, not undone'"
    )
    (tmp_path / "reading.toml").write_text(said)
    plain, first, second = read_campaign(tmp_path)
    assert plain.smoothed == MovingAverage(15 * DT, "centred", ("force",))
    assert plain.provenance["displacement_lowpass_hz"] == "20"
    assert first.smoothed == second.smoothed == MovingAverage(23 * DT, "centred", ("displacement", "force"))
    assert float(second.provenance["displacement_lowpass_hz"]) == pytest.approx(16.5, rel=1e-3)


@pytest.mark.parametrize(
    ("one", "other", "words"),
    [
        (
            'smoothed = "23 samples"',
            'smoothed = "23 samples, trailing"',
            r"'sine\*' and '\*2' give sine2.csv two values of smoothed, '23 samples' and '23 samples, trailing'; make the",
        ),
        ("lowpass = 20", 'lowpass = "15 f"', "give sine2.csv two values of lowpass, 20 and '15 f'; make the patterns"),
        ("smoothed = 0.1", "header = 1\nlowpass = 0", r"\[\[files\]\] 2: lowpass = 0 is not a frequency"),
        (
            "smoothed = {samples = 9, trialing = true}",
            "",
            r"\[\[files\]\] 1: smoothed: 'trialing' is not among seconds",
        ),
        ("[files.smoothed]\n'x*' = 0.1", "", "'x\\*' matches no file of the folder"),
    ],
)
def test_sections_that_contradict_one_another_are_refused(tmp_path, one, other, words):
    for name in ("sine1.csv", "sine2.csv"):
        written(tmp_path, name, raw(seconds=4.0))
    (tmp_path / "reading.toml").write_text("voltage = 1.0\n" + both_are_sections(one, other))
    with pytest.raises(FileError, match=words):
        read_campaign(tmp_path)


def test_a_table_of_a_campaign_passes_it_on(tmp_path):
    written(tmp_path, "a.csv", smooth(raw(), 23))
    head = "file,table,row,voltage_V,peak_to_peak_mm,frequency_Hz,kx_Ns_per_mm,kw_N,rho_per_mm,sha256"
    (tmp_path / "campaign.csv").write_text(f"{head}\na.csv,4.2,1,1.0,20,1.1,,,,\n")
    [record] = read_campaign(tmp_path, smoothed="23 samples, not undone, force", lowpass=20)
    assert record.smoothed == MovingAverage(23 * DT, "centred", ("force",))
    assert record.provenance["displacement_lowpass_hz"] == "20"


def test_the_command_line_declares_it(tmp_path):
    written(tmp_path, "a.csv", smooth(raw(), 23))
    given = ["records", str(tmp_path / "a.csv"), "--smoothed", "23 samples, not undone, force", "--lowpass", "20"]
    done = CliRunner().invoke(cli, [*given, "--force-sign", "-1", "--json"])
    assert done.exit_code == 0, done.stderr
    [shown] = json.loads(done.stdout)["records"]
    assert shown["smoothed"]["channels"] == ["force"]
    assert shown["provenance"]["displacement_lowpass_hz"] == "20"
    assert shown["history"][-3].startswith("force turned")
    wrong = CliRunner().invoke(cli, ["records", str(tmp_path / "a.csv"), "--smoothed", "a tenth"])
    assert wrong.exit_code == 2
    assert "smoothed = 'a tenth' is not a valid window" in wrong.stderr


@pytest.mark.filterwarnings("ignore:.*integrated from the velocity")
@pytest.mark.parametrize("undone", [True, False])
def test_a_velocity_alone_is_undone_before_it_is_integrated(tmp_path, undone):
    """What is averaged is the velocity of the file; its displacement follows it."""
    t = DT * np.arange(3000)
    noise = np.random.default_rng(5)
    v = 0.05 * np.cos(2 * np.pi * 1.1 * t) + noise.normal(0.0, 1e-4, t.size)
    truth = Record(t, np.zeros(t.size), 900.0 * v + noise.normal(0.0, 1.0, t.size), velocity=v)
    made = smooth(truth, 23, channels=("velocity", "force"))
    head = "time [s],velocity [m/s],force [N]"
    columns = np.column_stack([made.time, made.velocity, made.force])
    np.savetxt(tmp_path / "a.csv", columns, fmt="%.12g", header=head, delimiter=",", comments="")
    record = read(tmp_path / "a.csv", voltage=1.0, smoothed="23 samples" + ", not undone" * (not undone))
    steps = 0.5 * (record.velocity[1:] + record.velocity[:-1]) * np.diff(t)
    np.testing.assert_allclose(np.diff(record.displacement), steps, atol=1e-7)
    if undone:
        assert record.smoothed is None
        assert np.std(record.velocity - v) < 5e-5
        expected = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * DT)])
        assert np.std(record.displacement - expected) < 2e-5  # the drift is judged to a few um/s
        assert record.history[-1] == "displacement: integrated again from the raw velocity"
    else:
        assert record.smoothed == MovingAverage(23 * DT, "centred", ("displacement", "velocity", "force"))
        assert record.history[-1] == "displacement: smoothed as the velocity that it is the integral of"


def test_dampyrs_own_file_holds_what_is_not_undone(tmp_path):
    record = with_smoothing(smooth(raw(), 23), "23 samples, not undone, force")
    again = read(write(record, tmp_path / "a.h5"))
    assert again.smoothed == record.smoothed
    np.testing.assert_array_equal(again.force, record.force)
    for name in ("a.csv", "a.mat"):
        with pytest.raises(FileError, match=r"cannot say that the record is smoothed; write .h5"):
            write(record, tmp_path / name)
    assert read(write(raw(), tmp_path / "b.h5")).smoothed is None


def test_a_multiple_that_one_record_cannot_carry_leaves_that_one_off_and_not_the_folder(tmp_path):
    """15 times 5 Hz is more than 200 samples per second carry; a random motion has no frequency to take a multiple of."""
    t = 0.005 * np.arange(1200)
    for name, x in (
        ("slow", 0.01 * np.sin(2 * np.pi * 1.0 * t)),
        ("fast", 0.01 * np.sin(2 * np.pi * 5.0 * t)),
        ("random", np.cumsum(np.random.default_rng(2).normal(0.0, 2e-4, t.size))),
    ):
        written(tmp_path, f"{name}.csv", Record(t, x, 1e3 * x, voltage=1.0))
    with pytest.warns(DampyrWarning, match="low-pass of 15 f left off") as caught:
        read_back = {each.name: each for each in read_campaign(tmp_path, voltage=1.0, lowpass="15 f")}
    assert {str(each.message).partition(":")[0] for each in caught} == {"fast", "random"}
    assert float(read_back["slow"].provenance["displacement_lowpass_hz"]) == pytest.approx(15.0, rel=1e-2)
    for name, why in (("fast", "75 Hz"), ("random", "does not repeat itself")):
        assert "displacement_lowpass_hz" not in read_back[name].provenance
        assert "low-pass of 15 f left off" in read_back[name].history[-1]
        assert why in read_back[name].history[-1]
    with pytest.raises(
        InputError, match="fast: lowpass"
    ):  # what is said of a file in Hz is a mistake where it cannot be
        read(tmp_path / "fast.csv", voltage=1.0, lowpass=95.0)
