"""A rig whose Uno has a clock of its own, at the end of a line that is slow and uneven: what is paired, and what is a fault."""

from dataclasses import replace

import numpy as np
import pytest
from tests.rig.drives import made, sine

from dampyr.errors import InputError, RigFault
from dampyr.rig import Drive, RigSettings, session
from dampyr.rig.drive import DutyReversals
from dampyr.rig.session import ArmedRig

MANY = [pytest.param(ppm, marks=pytest.mark.prove) for ppm in (0.0, 500.0, -500.0, 2000.0, -2000.0, -5000.0)]


def clocked(ppm: float, **line: float) -> RigSettings:
    settings = RigSettings()
    return replace(settings, uno=replace(settings.uno, clock_ppm=ppm, **line))


def recorded(table: ArmedRig, drive: Drive) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rows = [(b.time[part], b.displacement[part], b.voltage[part]) for b, part in table.play(drive)]
    t, x, u = (np.concatenate(row) for row in zip(*rows, strict=True))
    return t - t[0], x, u


@pytest.mark.parametrize("ppm", [5000.0, *MANY])
def test_the_motion_has_the_frequency_of_the_drive_on_the_boards_clock(ppm: float) -> None:
    rig, simulator = made(settings=clocked(ppm))
    drive = sine(0.006, 1.0, 20.0)
    drive = replace(
        drive, displacement=np.r_[np.zeros(50), drive.displacement], voltage=np.r_[np.zeros(50), drive.voltage]
    )
    with rig.armed() as table:
        table.home()
        table.compare_clocks()
        table.go(0.0)
        t, x, _ = recorded(table, drive)
        ratio = table.loop.clock_ratio
        drifted = simulator.constants.clock_warming * (1.0 - np.exp(-simulator.time / simulator.constants.warming_time))
    assert ratio.known
    assert abs(ratio.value - 1.0 / (1.0 + 1e-6 * (ppm + drifted))) < 4.0 * ratio.uncertainty
    inside = (t > 2.5) & (t < 18.5)
    assert abs(frequency(t[inside], x[inside], 1.0) - 1.0) < 100e-6  # 0.5 % without the ratio
    wanted = np.interp(t, drive.time, drive.displacement)
    assert np.abs(x - wanted).max() < 4e-4  # 20 s of 0.5 % are 100 ms, 3.8 mm


def frequency(t: np.ndarray, x: np.ndarray, near: float) -> float:
    """Hz of a sine, by least squares."""
    from scipy.optimize import least_squares

    def off(p: np.ndarray) -> np.ndarray:
        return np.asarray(p[0] + p[1] * np.sin(2 * np.pi * p[3] * t) + p[2] * np.cos(2 * np.pi * p[3] * t) - x)

    return float(least_squares(off, [0.0, x.max(), 0.0, near], x_scale=[1e-3, 1e-3, 1e-3, 1e-3]).x[3])


def test_steps_of_the_voltage_stay_with_the_motion() -> None:
    """A step at each passage through the middle; after 15 s an Uno that is 0.5 % slow would be 75 ms behind."""
    rig, _ = made(settings=clocked(5000.0))
    drive = sine(0.006, 1.0, 15.0)
    drive = replace(drive, voltage=np.where(np.floor(drive.time) % 2 == 0, 0.2, 0.4))
    with rig.armed() as table:
        table.home()
        table.compare_clocks()
        table.go(0.0)
        t, x, u = recorded(table, drive)
    steps = np.flatnonzero(np.abs(np.diff(u)) > 0.1)
    middle = [t[np.argmin(np.abs(x[k - 200 : k + 200])) + k - 200] - t[k] for k in steps[2:-2]]
    assert np.abs(middle).max() < 0.020


def test_reversals_of_the_duty_last_as_long_as_the_board_says() -> None:
    rig, simulator = made(settings=clocked(5000.0))
    with rig.armed() as table:
        table.home()
        table.compare_clocks()
        table.go(0.0)
        n = 1200
        list(table.play(Drive(0.01, np.zeros(n), np.zeros(n), reversals=DutyReversals(0.4, 2.0, 0.0, 5))))
    duty, time = simulator.truth.duty, simulator.truth.time
    part = time > time[-1] - 11.0
    begun = time[part][1:][(duty[part][1:] > 0) & (duty[part][:-1] <= 0)]
    assert np.diff(begun)[:2] == pytest.approx(4.0, abs=0.003)  # 20 ms more without the ratio


def test_a_drive_without_a_rest_begins_with_its_voltage() -> None:
    """The Uno begins to follow before it, at rest, so that the uneven line does not count."""
    begun = []
    for seed in (1, 2, 3, 4):
        rig, simulator = made(settings=clocked(1500.0))
        simulator.line_rng = np.random.default_rng(seed)
        with rig.armed() as table:
            table.home()
            table.go(0.0)
            t, x, _ = recorded(table, Drive(0.01, 0.010 * np.linspace(0.0, 1.0, 51) ** 2, np.ones(51)))
        begun.append(float(t[np.argmax(x > 0.002)]))
    assert np.ptp(begun) < 0.012  # up to 48 ms of three requests otherwise


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("uno-clock=30000@0s", r"% slow against the board's"),
        ("uno-clock=-5000@8s", r"has changed by \+0\.[45]\d* % within"),
    ],
)
def test_a_clock_that_is_wrong_or_jumps_stops_the_rig(fault: str, words: str) -> None:
    rig, simulator = made(fault)
    with pytest.raises(RigFault, match=words), rig.armed() as table:
        table.rest(60.0)
    assert not simulator.twin.enabled
    assert simulator.time < 16.0


def test_what_waits_for_the_clocks_says_so_where_they_stay_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session, "COMPARING", 2)
    rig, _ = made()
    words = r"known to \d+ ppm after 2 s, and a drive that is learned or computed needs 50 ppm"
    with pytest.raises(RigFault, match=words), rig.armed() as table:
        table.compare_clocks()


def test_a_line_whose_latency_has_no_range_is_refused() -> None:
    with pytest.raises(InputError, match=r"uno\.longest_latency = 1 ms is less than uno\.shortest_latency = 5 ms"):
        clocked(0.0, shortest_latency=0.005, longest_latency=0.001)
