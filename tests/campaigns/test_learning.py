"""Learning of a drive: the law on plants in closed form, and tries on the simulated rig, judged by what it really did."""

import json
import shutil
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from scipy import signal
from tests.campaigns.quick_rig import QUICK, quick_rig

from dampyr import campaigns, records
from dampyr.campaigns import RunControl, Stopped, learn_drive, perform, plan, read_journal
from dampyr.campaigns.check import largest
from dampyr.campaigns.force_prediction import specimen
from dampyr.campaigns.learned_drives import FOLDER, LearnedDrive, drive_key, load_learned, save_learned
from dampyr.campaigns.learning import (
    CUTOFF,
    LEAD,
    REACHED,
    ROSE,
    SPENT,
    TOLERANCE,
    TRIES,
    Tracking,
    at_set_points,
    best_of,
    ended_because,
    next_set_points,
    tracking,
)
from dampyr.campaigns.planned_tests import WAYS
from dampyr.campaigns.run_control import Progress
from dampyr.campaigns.steps.sine import Sine
from dampyr.cli import cli
from dampyr.errors import DampyrWarning, InputError, RigFault
from dampyr.records.formats import h5
from dampyr.records.record import Label
from dampyr.rig import Drive, Rig, RigSettings

Array = np.ndarray
NAME = "01-sine-8mm-0.84Hz-3.212V"
LEARNS = ["earthquake", "friction", "gas_force", "low_velocity", "quasi_static", "random", "random_voltage", "sine", "sweep",
          "voltage_steps"]  # fmt: skip


def sine(**changes: Any) -> dict[str, Any]:
    step = {
        "kind": "sine", "amplitude": "8 mm", "frequency": "0.84 Hz", "voltage": "3.212 V", "cycles": 2, "rest_before": "0.2 s",
        "learn": True,
    }  # fmt: skip
    return step | changes


def campaign(*steps: dict[str, Any], **header: Any) -> campaigns.Campaign:
    return campaigns.campaign_of({"rest_between": "0.2 s", "check_amplitude": 0, "step": list(steps)} | header)


def learned_in(folder: Path, name: str = NAME) -> dict[str, str]:
    return h5.provenance(folder / f"{name}.h5")


def iterations(folder: Path) -> list[str]:
    return sorted(path.name.removeprefix(f"{NAME}.") for path in (folder / "learning").glob("*.h5"))


def whats(folder: Path) -> list[str]:
    return [event.what for event in read_journal(folder)[1]]


# The law and its figures.


def swung(frequency: float, cycles: int = 12) -> Drive:
    return Sine(0.01, frequency, cycles=cycles, taper=2).drive(RigSettings())


def plant(u: Array, gain: float, delay: float) -> Array:
    time = np.arange(u.size) * 0.01
    return gain * np.interp(time - delay, time, u)


@pytest.mark.parametrize("frequency", [0.5, 1.0, 2.0, 4.0])
@pytest.mark.parametrize(("gain", "delay"), [(0.95, 0.0), (0.9, 0.02), (1.05, 0.01), (0.8, 0.03)])
def test_on_a_linear_plant_the_error_falls_as_its_closed_form_says(frequency: float, gain: float, delay: float) -> None:
    """In the steady cycles e_(k+1) = (1 - Q P e^(j w lead)) e_k, and P = gain e^(-j w delay)."""
    wanted = swung(frequency).displacement
    # 8 of the 12 steady cycles, clear of rest and tapers
    middle = slice(round((2 + 4 / frequency) / 0.01), round((2 + 12 / frequency) / 0.01))
    w = 2 * np.pi * frequency
    b, a = signal.butter(2, 2 * CUTOFF * 0.01)
    filtered = abs(signal.freqz(b, a, [w * 0.01])[1][0]) ** 2
    ratio = abs(1 - filtered * gain * np.exp(1j * w * (LEAD - delay)))
    u, rms = wanted, []
    for _ in range(3):
        x = plant(u, gain, delay)
        rms.append(np.sqrt(np.mean((wanted - x)[middle] ** 2)))
        u = next_set_points(wanted, u, x, 0.01)
    assert rms[0] == pytest.approx(abs(1 - gain * np.exp(-1j * w * delay)) * 0.01 / np.sqrt(2), rel=0.03)
    # interpolation of the delays between set points, and what the ends leak into the middle
    assert rms[1] / rms[0] == pytest.approx(ratio, rel=0.03, abs=0.006)
    assert rms[2] / rms[0] == pytest.approx(ratio**2, rel=0.06, abs=0.006)


def test_a_plant_of_the_wrong_sign_makes_the_error_rise_and_that_ends_it() -> None:
    wanted = swung(1.0)
    u, tries = wanted.displacement, []
    while not (reason := ended_because(tries)):
        x = plant(u, -0.5, 0.0)
        tries.append(tracking(wanted, x))
        u = next_set_points(wanted.displacement, u, x, 0.01)
    assert (reason, len(tries), best_of(tries)) == (ROSE, 2, 0)


def test_the_drive_begins_and_ends_where_the_table_rests() -> None:
    wanted = swung(1.0).displacement
    u = next_set_points(wanted, wanted, wanted - 0.001, 0.01)  # a table that stands off everywhere
    assert (u[0], u[-1]) == (wanted[0], wanted[-1])
    assert np.abs(np.diff(u - wanted)).max() < 5e-5
    np.testing.assert_allclose((u - wanted)[100:-100], 0.001, rtol=1e-6)


@pytest.mark.parametrize("period", [0.001, 0.01, 0.05])
def test_what_is_too_fast_for_the_table_is_left_alone(period: float) -> None:
    time = np.arange(round(6.0 / period)) * period
    fast = 1e-4 * np.sin(2 * np.pi * min(40.0, 0.49 / period) * time)
    u = next_set_points(np.zeros(time.size), np.zeros(time.size), fast, period)
    assert np.abs(u[time.size // 3 : -time.size // 3]).max() < 0.05 * 1e-4


def test_the_error_is_the_greatest_distance_over_half_of_the_peak_to_peak() -> None:
    wanted = Drive(0.01, [0.0, 0.0, 0.004, -0.006, 0.0], np.zeros(5))
    figures = tracking(wanted, np.array([0.0, 0.0, 0.0035, -0.006, 0.0]))
    assert figures.error == pytest.approx(0.0005 / 0.005)
    assert figures.rms == pytest.approx(0.1 / np.sqrt(5))
    with pytest.raises(InputError, match="does not change"):
        tracking(Drive(0.01, np.zeros(5), np.zeros(5)), np.zeros(5))


def test_samples_begin_with_the_first_set_point_that_is_recorded() -> None:
    drive = Drive(0.01, np.arange(6.0), np.zeros(6), record_from=2)
    time = 7.0 + np.arange(31) * 0.001
    np.testing.assert_allclose(at_set_points(drive, time, 2.0 + (time - 7.0) / 0.01), [2.0, 2.0, 2.0, 3.0, 4.0, 5.0])
    with pytest.raises(InputError, match="record the whole drive"):
        at_set_points(drive, time[:15], time[:15])


@pytest.mark.parametrize(
    ("errors", "reason"),
    [
        ([], ""), ([0.05], ""), ([0.02], REACHED), ([0.05, 0.01], REACHED), ([0.05, 0.051], ROSE), ([0.05, 0.04], ""),
        ([0.09, 0.08, 0.07, 0.06], ""), ([0.09, 0.08, 0.07, 0.06, 0.05], SPENT), ([0.09, 0.08, 0.07, 0.06, 0.061], ROSE),
    ],
)  # fmt: skip
def test_learning_ends_within_the_tolerance_on_a_rise_or_after_five_tries(errors: list[float], reason: str) -> None:
    assert ended_because([Tracking(each, 0.4 * each) for each in errors]) == reason


def test_a_rise_is_one_of_the_rms_and_the_best_try_that_of_the_least_error() -> None:
    scattered = [Tracking(0.13, 0.07), Tracking(0.029, 0.011), Tracking(0.03, 0.007)]
    assert ended_because(scattered) == ""
    assert best_of(scattered) == 1


# The campaign file.


def test_a_campaign_without_learning_is_what_it_was() -> None:
    """The digest as the release before wrote it: folders that were begun with it go on."""
    steps = [
        {"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz", "voltage": ["0 V", "1.98 V"], "repeats": 2},
        {"kind": "sweep", "amplitude": "2 mm", "start": "0.3 Hz", "stop": "3 Hz"},
        {"kind": "earthquake", "scale": 0.2},
    ]
    before = campaigns.campaign_of({"step": steps})
    assert before.digest == before.path_digest == "7325b28d1657af01"
    for changed in ({"learn": True}, {"fit_limits": True}):
        now = campaigns.campaign_of({"step": [steps[0], steps[1] | changed, steps[2]]})
        assert now.digest != before.digest
    assert campaigns.campaign_of({"learn": True, "step": steps}).digest != before.digest


@pytest.mark.parametrize("kind", ["rest", "reversals", "warm_up"])
def test_a_kind_that_follows_no_set_points_to_their_end_cannot_learn(kind: str) -> None:
    fields = {
        "rest": {"duration": "1 s"}, "reversals": {"half_period": "0.5 s"},
        "warm_up": {"amplitude": "5 mm", "frequency": "1 Hz"},
    }[kind]  # fmt: skip
    with pytest.raises(
        InputError, match=rf"step 1\.learn = true is not allowed for the kind {kind}.*{', '.join(LEARNS)}"
    ):
        campaign({"kind": kind, **fields, "learn": True})
    [test] = campaign({"kind": kind, **fields}, learn=True).tests
    assert not test.learn


def test_the_header_lets_every_step_learn_but_those_that_say_no() -> None:
    tests = campaign(
        sine(), {**sine(), "learn": False}, {k: v for k, v in sine().items() if k != "learn"}, learn=True
    ).tests
    assert [test.learn for test in tests] == [True, False, True]


def test_a_plan_counts_the_tries_as_at_most_five() -> None:
    without, learning = plan(campaign(sine(learn=False))), plan(campaign(sine()))
    assert learning.duration == pytest.approx((TRIES + 1) * without.duration + TRIES * 0.2)
    assert "its drive is learned first, in at most 5 tries" in learning.tests[0].notes


# On the simulated rig.


def judged_by_truth(rig: Rig, started: float, folder: Path, name: str) -> tuple[float, float, float]:
    """Of a test's last steady cycles: the true table's error of the amplitude, its distortion, and its greatest distance to
    the wanted path over the amplitude."""
    record = records.read(folder / f"{name}.h5")
    step = Sine(**json.loads(record.provenance["step"]))
    drive, truth = step.drive(rig.settings), rig.board.simulator.truth
    since = truth.time - started - record.time[0]
    x = np.interp(drive.time, since, truth.position)
    steady = (drive.time > step.rest_before + 1.0 / step.frequency) & (
        drive.time < step.rest_before + (1 + step.cycles) / step.frequency
    )
    phase = 2 * np.pi * step.frequency * (drive.time[steady] - step.rest_before)
    basis = np.column_stack([f(k * phase) for k in range(1, 11) for f in (np.sin, np.cos)] + [np.ones(phase.size)])
    fitted = np.linalg.lstsq(basis, x[steady], rcond=None)[0][:20].reshape(10, 2)
    amplitudes = np.hypot(*fitted.T)
    distortion = float(np.sqrt(np.sum(amplitudes[1:] ** 2)) / amplitudes[0])
    return float(amplitudes[0] / step.amplitude - 1), distortion, tracking(drive, x).error


def held_to_truth(voltage: str, folder: Path, cycles: int) -> dict[str, str]:
    """Learn a sine of 8 mm at 0.84 Hz, and judge record and truth; what the record says."""
    opened, begins = quick_rig(), []
    simulator = opened.board.simulator
    start = simulator.start

    def started(rate: float) -> None:
        begins.append(simulator.time)
        start(rate)

    simulator.start = started
    tests = campaign(sine(voltage=voltage, cycles=cycles))
    perform(tests, opened, folder)
    [name] = [test.name for test in tests.tests]
    record = records.read(folder / f"{name}.h5")
    assert float(record.provenance["learning_error"]) <= TOLERANCE
    assert abs(records.amplitude_error(record)) < 0.02
    assert records.total_harmonic_distortion(record) < 0.05
    amplitude, distortion, error = judged_by_truth(opened, begins[-1], folder, name)
    assert abs(amplitude) < 0.02
    assert distortion < 0.05
    # the encoder is read 1 ms late: 0.042 mm at 42 mm/s, and so is what the host takes for the begin
    assert error < TOLERANCE + 0.006
    return record.provenance


def test_at_the_highest_voltage_the_learned_sine_is_within_two_per_cent(tmp_path: Path) -> None:
    about = held_to_truth("3.212 V", tmp_path, 3)
    assert float(about["learning_error_before"]) > 0.04
    assert (about["learning_tries"], about["learning_ended"]) == ("2", REACHED)


@pytest.mark.parametrize(
    "voltage", ["0 V", *(pytest.param(v, marks=pytest.mark.prove) for v in ("0.8712 V", "1.98 V", "2.5 V", "3.212 V"))]
)
def test_sines_from_zero_to_the_highest_voltage_are_within_two_per_cent(voltage: str, tmp_path: Path) -> None:
    held_to_truth(voltage, tmp_path, 5)


BENCH = """
name = "a bench"
[board]
block = "0.1 s"
[limits]
heartbeat = "0.2 s"
"""


@pytest.fixture
def bench(tmp_path: Path) -> Path:
    path = tmp_path / "bench" / "rig.toml"
    path.parent.mkdir()
    path.write_text(BENCH, encoding="utf-8")
    return path


@dataclass
class LearnedSine:
    """A sine that was learned and recorded on a rig: its folder at the end and in the middle of the second try."""

    bench: Path
    rig: Rig
    folder: Path
    killed: Path
    reports: list[tuple[str, float]] = field(default_factory=list)


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> LearnedSine:
    place = tmp_path_factory.mktemp("learned")
    bench = place / "bench" / "rig.toml"
    bench.parent.mkdir()
    bench.write_text(BENCH, encoding="utf-8")
    sine_learned = LearnedSine(bench, quick_rig(settings=bench), place / "whole", place / "killed")

    def show(progress: Progress) -> None:
        sine_learned.reports.append((progress.phase, progress.time_left))
        if (
            progress.phase.startswith("learning, try 2")
            and progress.fraction > 0.5
            and not sine_learned.killed.exists()
        ):
            shutil.copytree(sine_learned.folder, sine_learned.killed)

    perform(campaign(sine(), operator="me"), sine_learned.rig, sine_learned.folder, show)
    return sine_learned


@pytest.fixture
def killed(learned: LearnedSine, tmp_path: Path) -> Path:
    """The folder as it lies on the disk in the middle of the second try, which is what a kill leaves."""
    return Path(shutil.copytree(learned.killed, tmp_path / "killed"))


def test_every_try_is_a_record_with_its_drive_and_the_test_says_how_it_was_learned(learned: LearnedSine) -> None:
    folder, reports = learned.folder, learned.reports
    assert iterations(folder) == ["iteration1.h5", "iteration2.h5"]
    wanted = Sine(0.008, 0.84, 3.212, cycles=2, rest_before=0.2).drive(RigSettings())
    errors = [float(each) for each in learned_in(folder)["learning_errors"].split(", ")]
    for k, error in enumerate(errors, 1):
        path = folder / "learning" / f"{NAME}.iteration{k}.h5"
        tried, raw = records.read(path), h5.read_raw(path)["position"]
        assert tried.provenance["learning_try"] == f"{k} of 5"
        assert (tried.provenance["learning_of"], tried.provenance["operator"]) == (NAME, "me")
        x = at_set_points(wanted, tried.time, raw.gain * raw.values + raw.offset)
        assert tracking(wanted, x).error == pytest.approx(error, abs=1e-6)
        assert float(tried.provenance["learning_error"]) == pytest.approx(error, abs=1e-6)
        head, *rows = path.with_suffix(".csv").read_text().splitlines()
        assert head == "time [s],wanted [m],commanded [m],voltage [V]"
        table = np.array([row.split(",") for row in rows], dtype=float)
        np.testing.assert_array_equal(table[:, 1], wanted.displacement)
        assert np.array_equal(table[:, 2], wanted.displacement) == (k == 1)
    about = learned_in(folder)
    assert about["learning_drive"] == f"learning/{NAME}.iteration2.csv"
    assert float(about["learning_error_best"]) == min(errors)
    assert about["learning_started_from"] == "the wanted drive"
    assert [record.name for record in records.read_campaign(folder)] == [NAME]  # the tries are no tests
    assert whats(folder) == ["armed", "homed", "begun", "learning", "learning", "learned", "complete", "complete"]
    [entry], events = read_journal(folder)
    assert next(e.detail for e in events if e.what == "learning").startswith("try 1 of 5: 5.")
    assert "off its wanted path, with a learned drive" in entry.reason
    phases = list(dict.fromkeys(phase for phase, _ in reports if "learning" in phase or phase == "testing"))
    assert phases[0] == "learning, try 1 of 5"
    assert phases[1].startswith("learning, try 2 of 5, 5.")
    assert phases[2] == "testing"
    left = np.array([seconds for _, seconds in reports])
    assert left[-1] == pytest.approx(WAYS, abs=2.5 * QUICK.board.block)
    assert np.all(np.diff(left) <= 1e-9)


def with_gain(gain: float) -> Callable[..., Array]:
    def law(wanted: Array, commanded: Array, achieved: Array, period: float) -> Array:
        return commanded + gain * (next_set_points(wanted, commanded, achieved, period) - commanded)

    return law


def test_an_error_that_rises_ends_learning_and_the_best_drive_is_played(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(learn_drive, "next_set_points", with_gain(-1.0))
    folder = perform(campaign(sine(amplitude="4 mm", frequency="2 Hz", cycles=1)), quick_rig(), tmp_path).folder
    about = learned_in(folder, "01-sine-4mm-2Hz-3.212V")
    errors = [float(each) for each in about["learning_errors"].split(", ")]
    assert about["learning_ended"] == ROSE
    assert len(errors) == 2
    assert errors[1] > 1.5 * errors[0]
    assert about["learning_drive"].endswith("iteration1.csv")
    assert float(about["learning_error"]) == pytest.approx(errors[0], rel=0.05)


def test_there_are_five_tries_at_most(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(learn_drive, "next_set_points", with_gain(0.05))
    folder = perform(campaign(sine(amplitude="4 mm", frequency="2 Hz", cycles=1)), quick_rig(), tmp_path).folder
    about = learned_in(folder, "01-sine-4mm-2Hz-3.212V")
    assert (about["learning_tries"], about["learning_ended"]) == ("5", SPENT)
    assert len(list((folder / "learning").glob("*.h5"))) == 5


def test_a_drive_beyond_the_limits_is_not_played(tmp_path: Path) -> None:
    """The largest sine that the check lets pass: what would make up for its lag is too fast."""
    step = Sine(0.004, 4.0, 3.212, cycles=1, rest_before=0.2)
    fastest = largest(step, "frequency", RigSettings(), specimen(RigSettings(), None))
    opened = quick_rig()
    folder = perform(campaign(sine(amplitude="4 mm", frequency=fastest, cycles=1)), opened, tmp_path).folder
    [path] = folder.glob("*.h5")
    about = h5.provenance(path)
    assert about["learning_ended"].startswith("limits: the next drive needs")
    assert (about["learning_tries"], about["exit_status"]) == ("1", "complete")
    assert float(about["learning_error"]) > TOLERANCE


def test_a_run_that_was_killed_in_a_try_goes_on_with_the_tries_that_are_complete(
    learned: LearnedSine, killed: Path, bench: Path
) -> None:
    assert not h5.state(killed / "learning" / f"{NAME}.iteration2.h5").complete
    first = (killed / "learning" / f"{NAME}.iteration1.h5").read_bytes()
    opened = quick_rig(settings=bench)  # whose folder of learned drives is empty
    with opened.armed() as table:  # the next host meets the table elsewhere
        table.home()
        table.go(0.013)
    perform(campaign(sine(), operator="me"), opened, killed)
    assert (killed / "learning" / f"{NAME}.iteration1.h5").read_bytes() == first
    assert iterations(killed) == ["iteration1.h5", "iteration2.h5", "iteration3.h5"]
    about = h5.provenance(killed / f"{NAME}.try2.h5")
    assert (about["learning_tries"], about["learning_ended"]) == ("2", REACHED)
    third = h5.provenance(killed / "learning" / f"{NAME}.iteration3.h5")
    assert third["learning_try"] == "2 of 5"
    points = [
        (folder / "learning" / f"{NAME}.iteration{k}.csv").read_text()
        for folder, k in ((learned.folder, 2), (killed, 3))
    ]
    assert points[0] == points[1]


def test_stop_in_a_try_ends_the_run_in_order_and_a_fault_as_in_any_test(tmp_path: Path) -> None:
    control = RunControl()

    def stop(progress: Progress) -> None:
        if progress.phase.startswith("learning, try 1") and progress.fraction > 0.3:
            control.stop()

    with pytest.raises(Stopped):
        perform(campaign(sine()), quick_rig(), tmp_path, stop, control)
    [entry], _ = read_journal(tmp_path)
    assert (entry.state, entry.reason) == ("stopped", "by the operator")
    assert not list(tmp_path.glob("*.h5"))
    with pytest.raises(RigFault, match="is the motor blocked"):
        perform(campaign(sine()), quick_rig("stalled-motor@7s"), tmp_path)
    [entry], _ = read_journal(tmp_path)
    assert entry.state == "failed"
    states = [h5.state(path).complete for path in (tmp_path / "learning").glob("*.h5")]
    assert states == [False, False]


def test_tries_on_another_rig_do_not_count(killed: Path) -> None:
    slower = quick_rig(settings=with_actuator(QUICK, lag=0.03))
    with pytest.warns(DampyrWarning, match=r"actuator\.lag was"):
        perform(campaign(sine(), operator="me"), slower, killed)
    assert iterations(killed) == [f"iteration{k}.h5" for k in (1, 2, 3, 4)]
    assert h5.provenance(killed / f"{NAME}.try2.h5")["learning_tries"] == "2"
    assert h5.provenance(killed / "learning" / f"{NAME}.iteration3.h5")["learning_try"] == "1 of 5"


def test_the_learned_drive_serves_the_next_campaign(learned: LearnedSine, tmp_path: Path) -> None:
    bench, opened = learned.bench, learned.rig
    [saved] = (bench.parent / FOLDER).iterdir()
    before = json.loads(saved.read_text())
    with opened.armed() as table:  # one rig, used for something else meanwhile, and left in mid-stroke
        table.home()
        table.go(-0.017)
    perform(campaign(sine(), name="the next one"), opened, tmp_path / "second")
    about = learned_in(tmp_path / "second")
    assert (about["learning_tries"], about["learning_ended"]) == ("1", REACHED)
    assert about["learning_started_from"].startswith(f"the drive learned at {before['time']}, with 0.")
    assert float(about["learning_error_before"]) < 0.015
    points = np.loadtxt(tmp_path / "second" / about["learning_drive"], delimiter=",", skiprows=1)[:, 2]
    np.testing.assert_allclose(points, before["set_points_m"], atol=1e-9)
    saved.write_text(saved.read_text()[:1000])
    with pytest.warns(DampyrWarning, match="holds no learned drive .*broken now, and learning begins anew"):
        perform(campaign(sine()), opened, tmp_path / "third")
    assert learned_in(tmp_path / "third")["learning_tries"] == "2"
    assert sorted(path.suffix for path in (bench.parent / FOLDER).iterdir()) == [".broken", ".json"]


def test_a_learned_drive_is_for_one_path_one_rig_and_one_specimen() -> None:
    drive = Sine(0.008, 0.84, 3.212).drive(RigSettings())
    settings = RigSettings()
    slower = with_actuator(settings, free_speed=0.07)
    keys = {
        drive_key(drive, settings, {}),
        drive_key(drive, slower, {}),
        drive_key(drive, settings, {"specimen": "number 2"}),
        drive_key(Sine(0.008, 0.84, 3.0).drive(settings), settings, {}),
        drive_key(Sine(0.008, 0.85, 3.212).drive(settings), settings, {}),
    }
    assert len(keys) == 5
    assert drive_key(Sine(0.008, 0.84, 3.212).drive(settings), RigSettings(), {}) in keys


def with_actuator(settings: RigSettings, **actuator: float) -> RigSettings:
    return replace(settings, actuator=replace(settings.actuator, **actuator))


@pytest.mark.parametrize(
    "change",
    [
        {"set_points_m": [0.0, 1.0]}, {"error": -1.0}, {"format": 99}, {"key": "another"}, {"time": None, "rms": "x"},
        {"set_points_m": None},
    ],
)  # fmt: skip
def test_a_file_that_is_no_learned_drive_is_put_aside(change: dict[str, Any], tmp_path: Path) -> None:
    wanted = swung(1.0)
    learned = LearnedDrive("k", "a sine", wanted.displacement, Tracking(0.01, 0.004), "2026-11-23T00:00:00+00:00")
    path = save_learned(tmp_path / FOLDER, "sine", learned, wanted)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        again = load_learned(tmp_path / FOLDER, "sine", "k", wanted)
    assert again is not None
    np.testing.assert_allclose(again.set_points, wanted.displacement, atol=1e-10)
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.warns(DampyrWarning, match="holds no learned drive"):
        assert load_learned(tmp_path / FOLDER, "sine", "k", wanted) is None
    assert not path.exists()


def test_a_folder_that_takes_no_learned_drive_is_a_warning_and_the_test_is_recorded(
    bench: Path, tmp_path: Path
) -> None:
    (bench.parent / FOLDER).write_text("in the way")
    with pytest.warns(DampyrWarning, match="the learned drive was not saved"):
        perform(campaign(sine(voltage="0 V", cycles=1)), quick_rig(settings=bench), tmp_path / "out")
    assert read_journal(tmp_path / "out")[0][0].state == "complete"
    assert "learned drive not saved" in whats(tmp_path / "out")


# Sweeps and earthquakes within the limits.


def test_a_sweep_is_lowered_to_what_the_rig_can_do_where_it_asks_for_it() -> None:
    sweep = {
        "kind": "sweep",
        "amplitude": "8 mm",
        "start": "0.5 Hz",
        "stop": "3 Hz",
        "duration": "10 s",
        "voltage": "1.98 V",
    }
    refused = plan(campaign(sweep)).tests[0]
    assert "lower the amplitude to" in refused.refusal
    [test] = plan(campaign(sweep | {"fit_limits": True})).tests
    assert not test.refusal
    assert test.fitted.startswith(
        f"amplitude lowered to {1e3 * test.step.amplitude:g} mm instead of 8 mm: at 8 mm it needs"
    )
    assert f"lower the amplitude to {1e3 * test.step.amplitude:g} mm" in refused.refusal


def test_what_was_scaled_is_in_the_record_the_journal_and_what_run_prints(tmp_path: Path) -> None:
    text = """
        name = "fitted"
        rest_between = "0.2 s"
        check_amplitude = 0
        [[step]]
        kind = "sweep"
        amplitude = "8 mm"
        start = "1 Hz"
        stop = "3 Hz"
        duration = "2 s"
        rest_before = "0.2 s"
        fit_limits = true
        [[step]]
        kind = "earthquake"
        motion = "motion.csv"
        rest_before = "0 s"
    """
    t = np.arange(0.0, 2.0, 0.02)  # 2 m/s^2 at 2 Hz: 160 mm/s, twice what the table can do
    shaken = 2.0 * np.sin(0.5 * np.pi * t) ** 2 * np.sin(4 * np.pi * t)
    rows = "".join(f"{at:.2f},{value:.6f}\n" for at, value in zip(t, shaken, strict=True))
    (tmp_path / "motion.csv").write_text(f"time [s],acceleration [m/s^2]\n{rows}")
    (tmp_path / "fitted.toml").write_text(text)
    done = CliRunner().invoke(
        cli,
        ["run", str(tmp_path / "fitted.toml"), "--out", str(tmp_path / "out")],
        env={"COLUMNS": "400"},
    )
    assert done.exit_code == 0
    fitted = campaigns.plan(tmp_path / "fitted.toml").tests
    flat = " ".join(done.stdout.split())
    for test in fitted:
        assert f"{test.name}: {test.fitted}" in flat
        assert h5.provenance(tmp_path / "out" / f"{test.name}.h5")["fitted"] == test.fitted
    assert [event.detail for event in read_journal(tmp_path / "out")[1] if event.what == "fitted"] == [
        test.fitted for test in fitted
    ]
    assert fitted[1].fitted.startswith("scaled to 0.")


@pytest.mark.parametrize(
    "step",
    [
        pytest.param({"kind": "earthquake", "scale": 0.18, "voltage": "1.98 V"}, marks=pytest.mark.prove),
        {"kind": "voltage_steps", "amplitude": "6 mm", "frequency": "1 Hz", "voltages": ["1 V", "3 V"], "hold": "2 s"},
    ],
    ids=["earthquake", "voltage_steps"],
)
def test_other_paths_are_learned_too(step: dict[str, Any], tmp_path: Path) -> None:
    perform(campaign(step | {"learn": True}), quick_rig(), tmp_path)
    [path] = tmp_path.glob("*.h5")
    about = h5.provenance(path)
    assert float(about["learning_error_before"]) > TOLERANCE
    assert float(about["learning_error"]) < TOLERANCE
    assert about["learning_ended"] == REACHED


@pytest.mark.prove
def test_an_earthquake_at_the_largest_scale_stays_within_the_limits(tmp_path: Path) -> None:
    """What the rig can just do leaves nothing to correct with."""
    opened = quick_rig()
    perform(campaign({"kind": "earthquake", "voltage": "1.98 V", "learn": True}), opened, tmp_path)
    [path] = tmp_path.glob("*.h5")
    about = h5.provenance(path)
    assert about["fitted"].startswith("scaled to 0.")
    assert about["learning_ended"].startswith("limits: ")
    truth, limits = opened.board.simulator.truth, opened.settings.limits
    assert np.abs(truth.position).max() < 0.5 * limits.stroke
    assert np.abs(truth.speed).max() < limits.speed


# The figures of a sine.


def test_distortion_and_error_of_the_amplitude_of_a_record() -> None:
    time = np.arange(0, 10.0, 0.001)
    phase = 2 * np.pi * 0.84 * time
    x = 0.0081 * (np.sin(phase) + 0.03 * np.sin(3 * phase + 1) + 0.04 * np.sin(5 * phase))
    record = records.Record(
        time=time, displacement=x, force=np.cos(phase), voltage=0.0, name="a", label=Label(0.016, 0.84)
    )
    assert records.total_harmonic_distortion(record) == pytest.approx(0.05, rel=1e-6)
    assert records.amplitude_error(record) == pytest.approx(0.0125, rel=1e-6)
    with pytest.raises(InputError, match="no label that says its peak to peak"):
        records.amplitude_error(records.Record(time=time, displacement=x, force=np.cos(phase), voltage=0.0, name="a"))
