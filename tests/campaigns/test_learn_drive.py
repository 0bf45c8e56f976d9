"""A drive learned on the simulated rig, judged by what the rig really did; tries that are killed, stopped and gone on with."""

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.campaigns.learned_sine import NAME, campaign, sine
from tests.campaigns.quick_rig import QUICK, quick_rig

from dampyr import records
from dampyr.campaigns import RunControl, Stopped, learn_drive, perform, read_journal
from dampyr.campaigns.check import largest
from dampyr.campaigns.force_prediction import specimen
from dampyr.campaigns.learned_drives import FOLDER
from dampyr.campaigns.learning import (
    REACHED,
    ROSE,
    SPENT,
    TOLERANCE,
    at_set_points,
    next_set_points,
    tracking,
)
from dampyr.campaigns.planned_tests import WAYS
from dampyr.campaigns.run_control import Progress
from dampyr.campaigns.steps.sine import Sine
from dampyr.errors import DampyrWarning, RigFault
from dampyr.records.formats import h5
from dampyr.rig import Rig, RigSettings
from dampyr.rig.acquisition import AHEAD
from dampyr.rig.simulation.faults import FaultSpec

Array = np.ndarray


def learned_in(folder: Path, name: str = NAME) -> dict[str, str]:
    return h5.provenance(folder / f"{name}.h5")


def iterations(folder: Path) -> list[str]:
    return sorted(path.name.removeprefix(f"{NAME}.") for path in (folder / "learning").glob("*.h5"))


def whats(folder: Path) -> list[str]:
    return [event.what for event in read_journal(folder)[1]]


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
    ("voltage", "cycles"),
    [
        ("0 V", 5),
        *(pytest.param(v, 12, marks=pytest.mark.prove) for v in ("0.8712 V", "2.5 V")),
        *(pytest.param(v, 12, marks=pytest.mark.by_hand) for v in ("0 V", "1.98 V", "3.212 V")),
    ],
)
def test_sines_from_zero_to_the_highest_voltage_are_within_two_per_cent(
    voltage: str, cycles: int, tmp_path: Path
) -> None:
    held_to_truth(voltage, tmp_path, cycles)


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
    begun = ["armed", "homed", "begun", "clocks compared"]
    assert whats(folder) == [*begun, "learning", "learning", "learned", "complete", "complete"]
    [entry], events = read_journal(folder)
    assert next(e.detail for e in events if e.what == "learning").startswith("try 1 of 5: 5.")
    assert "off its wanted path, with a learned drive" in entry.reason
    phases = list(dict.fromkeys(phase for phase, _ in reports if "learning" in phase or phase == "testing"))
    assert phases[0] == "learning, try 1 of 5"
    assert phases[1].startswith("learning, try 2 of 5, 5.")
    assert phases[2] == "testing"
    left = np.array([seconds for _, seconds in reports])
    lead = AHEAD * QUICK.board.block  # in which a drive waits for its begin
    assert left[-1] == pytest.approx(WAYS - lead, abs=2.5 * QUICK.board.block)
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
    assert float(about["learning_error"]) == pytest.approx(errors[0], rel=0.1)


@pytest.mark.prove
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
    opened = quick_rig()
    simulator = opened.board.simulator

    def stall(progress: Progress) -> None:
        if progress.phase.startswith("learning, try 1") and progress.fraction > 0.5 and not simulator.faults:
            simulator.faults = (FaultSpec("stalled-motor", simulator.time),)

    with pytest.raises(RigFault, match="is the motor blocked"):
        perform(campaign(sine()), opened, tmp_path, stall)
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
    assert about["learning_started_from"].startswith(f"the drive learned at {before['time']}, with ")
    assert float(about["learning_error_before"]) < 0.015
    points = np.loadtxt(tmp_path / "second" / about["learning_drive"], delimiter=",", skiprows=1)[:, 2]
    np.testing.assert_allclose(points, before["set_points_m"], atol=1e-9)
    saved.write_text(saved.read_text()[:1000])
    with pytest.warns(DampyrWarning, match="holds no learned drive .*broken now, and learning begins anew"):
        perform(campaign(sine()), opened, tmp_path / "third")
    assert learned_in(tmp_path / "third")["learning_tries"] == "2"
    assert sorted(path.suffix for path in (bench.parent / FOLDER).iterdir()) == [".broken", ".json"]


def with_actuator(settings: RigSettings, **actuator: float) -> RigSettings:
    return replace(settings, actuator=replace(settings.actuator, **actuator))


def test_a_folder_that_takes_no_learned_drive_is_a_warning_and_the_test_is_recorded(
    bench: Path, tmp_path: Path
) -> None:
    (bench.parent / FOLDER).write_text("in the way")
    with pytest.warns(DampyrWarning, match="the learned drive was not saved"):
        perform(campaign(sine(voltage="0 V", cycles=1)), quick_rig(settings=bench), tmp_path / "out")
    assert read_journal(tmp_path / "out")[0][0].state == "complete"
    assert "learned drive not saved" in whats(tmp_path / "out")


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
