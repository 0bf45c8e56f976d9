"""Faults of the measurement that a test shows by itself: told of a bad one, and not of a good one."""

import sys
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from tests.campaigns.quick_rig import QUICK, SHORT, quick_rig

from dampyr import records
from dampyr.campaigns import campaign_of, perform, planned_hybrid, read_journal
from dampyr.campaigns.marks import (
    MeasuredTest,
    changed_height,
    created_energy,
    drifting_zero,
    flat_force,
    force_at_rail,
    marks_of,
    slow_cell,
    sudden_force,
)
from dampyr.cli import cli
from dampyr.errors import RigFault
from dampyr.identification import fit
from dampyr.records import Record
from dampyr.records.cycle_analysis.cycles import similar_cycles
from dampyr.records.formats import h5
from dampyr.rig import RigSettings, simulated

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
RIG = RigSettings()
SCALE = RIG.load_cell.scale
STEP = 2 * RIG.board.range / 2**RIG.board.bits


def sine(offset: float = 100.0, drift: float = 0.0) -> MeasuredTest:
    """A hysteretic loop after a rest and before one, as a converter reads it, with its noise."""
    t = np.arange(12_000) / 1000.0
    moving = (t > 1.0) & (t < 11.0)
    x = np.where(moving, 0.005 * np.sin(2 * np.pi * (t - 1.0)), 0.0)
    v = np.where(moving, 0.005 * 2 * np.pi * np.cos(2 * np.pi * (t - 1.0)), 0.0)
    force = offset + 80.0 * np.tanh(v / 0.003) + 1000.0 * v + drift * t
    return read_by_board(t, x, force + 0.4 * np.random.default_rng(1).standard_normal(t.size))


def aperiodic(narrow: bool = False) -> MeasuredTest:
    """Sines of many frequencies after a rest and before one, so that no two turns are alike, on a spring and a friction; or,
    ``narrow``, about one frequency, as a building moves in its first mode."""
    t = np.arange(22_000) / 1000.0
    draw = np.random.default_rng(5)
    waves = [np.sin(2 * np.pi * f * (t - 1.0) + draw.uniform(0.0, 6.28)) / f for f in np.arange(0.2, 2.0, 0.1)]
    window = np.sin(np.pi * np.clip((t - 1.0) / 20.0, 0.0, 1.0)) ** 2
    x = 0.002 * window * np.sum(waves, axis=0)
    if narrow:
        middle = 0.003 * np.clip((t - 1.0) / 20.0, 0.0, 1.0) * np.clip((21.0 - t) / 2.0, 0.0, 1.0)
        size = 0.004 * np.clip((t - 1.0) / 2.0, 0.0, 1.0) * np.clip((21.0 - t) / 2.0, 0.0, 1.0)
        x = middle + size * (1.0 + 0.2 * np.sin(2 * np.pi * 0.13 * t)) * np.sin(2 * np.pi * 0.9 * (t - 1.0))
    v = np.gradient(x, t)
    force = 100.0 + 80.0 * np.tanh(v / 0.003) + 1000.0 * v + 2e4 * x
    return read_by_board(t, x, force + 0.4 * draw.standard_normal(t.size))


def read_by_board(t: np.ndarray, x: np.ndarray, force: np.ndarray) -> MeasuredTest:
    volts = np.round(force / SCALE / STEP) * STEP
    return MeasuredTest(t, x, SCALE * volts, volts, 0.0, RIG)


def with_volts(measured: MeasuredTest, volts: np.ndarray) -> MeasuredTest:
    return replace(measured, volts=volts, force=SCALE * volts)


def test_a_good_test_has_no_mark() -> None:
    good = sine()
    assert marks_of(lambda _: good, good.time.size) == []


@pytest.mark.parametrize(
    ("volts", "lasts"),
    [
        *((volts, lasts) for volts in (5.0, 1.0, 0.0) for lasts in (0.05, 0.4, 3.0)),
        (0.0, 12.0),
        *(pytest.param(volts, 12.0, marks=pytest.mark.prove) for volts in (5.0, 1.0)),
    ],
)
def test_a_force_that_stands_while_the_table_moves_spoils_its_test(volts: float, lasts: float) -> None:
    measured = sine()
    stands = (measured.time >= (0.0 if lasts == 12.0 else 3.1)) & (measured.time < 3.1 + lasts)
    broken = with_volts(measured, np.where(stands, volts, measured.volts))
    (mark,) = flat_force(broken)
    assert mark.spoils
    assert f"the force stands at {SCALE * volts:.4g} N for" in mark.text
    assert "look at the load cell's wire and amplifier" in mark.text


def test_a_force_that_leaps_to_where_it_stands_spoils_a_rest_too() -> None:
    measured = sine()
    stands = (measured.time >= 0.3) & (measured.time < 0.6)
    (mark,) = flat_force(with_volts(measured, np.where(stands, 1.0, measured.volts)))
    assert "the force stands at 613 N for 0.299 s, from 0.3 s over 0 mm" in mark.text


def test_a_force_may_stand_where_the_table_does_and_where_it_slides() -> None:
    t = np.arange(8000) / 1000.0
    rest = read_by_board(t, np.zeros(t.size), np.full(t.size, 120.0))
    slide = read_by_board(t, 0.002 * t, np.full(t.size, 120.0))
    assert not [*flat_force(rest), *flat_force(slide)]


def test_a_clean_amplifier_is_not_taken_for_a_broken_one() -> None:
    """Without noise the force stands for a moment at its extremes, and slides evenly, but changes at each reversal."""
    t = np.arange(12_000) / 1000.0
    x = 0.005 * (2 / np.pi) * np.arcsin(np.sin(2 * np.pi * 0.25 * t))
    assert not list(flat_force(read_by_board(t, x, 100.0 + 60.0 * np.sign(np.gradient(x)))))


def test_a_force_may_stand_at_a_slow_reversal_and_leap_after_it() -> None:
    """A motor with friction comes to the reversal slowly, stands there, and leaves fast: all at 200 samples/s."""
    rig = replace(RIG, board=replace(RIG.board, rate=200.0, velocity_bandwidth=20.0))
    counts = [
        -2,
        -1,
        -1,
        0,
        0,
        0,
        1,
        1,
        1,
        2,
        2,
        *[3] * 7,
        2,
        1,
        -1,
        -3,
        -6,
        -10,
        -13,
        -17,
        -21,
        -25,
        -29,
        -33,
        -38,
        -43,
    ]
    begins = [*range(-400, -60, 12), *range(-60, -2, 4)]
    x = rig.encoder.count * np.array([*begins, *counts, *range(-50, -400, -8)], dtype=float)
    t = np.arange(x.size) / 200.0
    turn = len(begins) + 17
    force = np.where(
        np.arange(x.size) <= turn, 210.0, 210.0 - 430.0 * (1.0 - np.exp(-np.maximum(0.0, x[turn] - x) / 4e-5))
    )
    volts = np.round(force / SCALE / STEP) * STEP
    good = MeasuredTest(t, x, SCALE * volts, volts, 0.0, rig)
    assert not list(flat_force(good))
    # the same leap while the table slides on is the amplifier's
    slides = replace(good, displacement=rig.encoder.count * 5.0 * np.arange(x.size))
    assert len(list(flat_force(slides))) == 1


@pytest.mark.parametrize("drift", [50.0, 5.0, 3.0, -3.0])
def test_a_zero_that_drifts_is_marked(drift: float) -> None:
    (mark,) = drifting_zero(sine(drift=drift))
    assert not mark.spoils
    assert "the force's zero drifts" in mark.text
    assert "look at the load cell" in mark.text


def test_a_rest_that_holds_some_hysteresis_is_no_drift() -> None:
    measured = sine()
    after = np.where(measured.time > 11.0, measured.force + 20.0, measured.force)
    assert not list(drifting_zero(replace(measured, force=after)))


def test_a_force_at_the_rail_is_marked() -> None:
    measured = sine()
    volts = measured.volts.copy()
    volts[5000:5003] = 9.99
    (mark,) = force_at_rail(with_volts(measured, volts))
    assert "at the converter's rail, 9.95 V or more, in 3 samples, first at 5 s" in mark.text


@pytest.mark.parametrize("share", [0.2, 0.6, 0.9])
@pytest.mark.parametrize("motion", ["sine", "random"])
def test_an_amplifier_that_saturates_spoils_its_test(share: float, motion: str) -> None:
    """Flat tops below the converter's rail, which end at each turn; the clip comes after all noise."""
    measured = sine() if motion == "sine" else aperiodic()
    level = share * float(np.abs(measured.volts).max())
    assert not list(flat_force(measured))
    (mark,) = flat_force(with_volts(measured, np.clip(measured.volts, -level, level)))
    assert mark.spoils
    assert "amplifier" in mark.text


@pytest.mark.parametrize("noise", [0.2, 0.4, 2.0])
@pytest.mark.parametrize("knee", [1e-4, 1e-3])
def test_a_flat_topped_friction_loop_is_no_saturated_amplifier(noise: float, knee: float) -> None:
    """Constant over the stroke to a step of the converter, in a slow test and in a fast one."""
    measured = sine()
    for speed in (1.0, 0.1):
        v = speed * np.gradient(measured.displacement, measured.time)
        draw = np.random.default_rng(3).standard_normal(measured.time.size)
        force = 100.0 + 80.0 * np.tanh(v / knee) + noise * draw
        assert not list(flat_force(read_by_board(measured.time, measured.displacement, force)))


def test_what_lies_between_two_turns_of_an_earthquake_is_no_cycle() -> None:
    """The mean force over it holds stiffness and hysteresis: it wanders as the motion does."""
    measured = aperiodic(narrow=True)
    record = Record(measured.time, measured.displacement, measured.force)
    assert similar_cycles(record)
    assert not list(drifting_zero(measured))
    assert not list(created_energy(measured))
    drifting = read_by_board(measured.time, measured.displacement, measured.force + 20.0 * measured.time)
    (mark,) = drifting_zero(drifting)  # by the rests before and after
    assert "at rest before the motion" in mark.text
    (mark,) = created_energy(with_volts(measured, -measured.volts))
    assert mark.spoils


def test_a_table_that_follows_a_building_never_stands() -> None:
    """Its set points change by a part of a count, which the encoder does not show, and the force by all of the friction."""
    measured = sine()
    leapt = np.where((measured.time > 0.5) & (measured.time < 0.51), measured.force - 45.0, measured.force)
    nudged = read_by_board(measured.time, measured.displacement, leapt)
    assert len(list(sudden_force(nudged))) == 1
    assert not list(sudden_force(replace(nudged, closed_loop=True)))
    slides = np.where(measured.time > 3.5, measured.force + 100.0, measured.force)
    broken = read_by_board(measured.time, measured.displacement, slides)
    assert len(list(sudden_force(replace(broken, closed_loop=True)))) == 1


@pytest.mark.parametrize("speed", [0.7, 3.0])
def test_a_table_that_creeps_and_sticks_for_some_milliseconds_has_no_sudden_force(speed: float) -> None:
    """The motor's dead band stops it within a count, and the force of a damper follows its speed."""
    t = np.arange(8000) / 1000.0
    v = np.where((t > 4.0) & (t < 4.004), 0.0, -1e-3 * speed)
    x = np.cumsum(v) * 1e-3
    read = 5e-6 * (np.floor(x / 5e-6) + 0.5)
    force = 100.0 + 60.0 * np.tanh(v / 5e-4) + 0.4 * np.random.default_rng(3).standard_normal(t.size)
    sticks = read_by_board(t, read, force)
    assert np.abs(np.diff(sticks.force)).max() > 30.0
    assert not list(sudden_force(sticks))


@pytest.mark.parametrize("closed_loop", [True, False])
def test_a_table_whose_speed_changes_within_milliseconds_has_no_sudden_force(closed_loop: bool) -> None:
    """As a building's set points change it, which follow the force."""
    t = np.arange(8000) / 1000.0
    v = np.where((t // 0.01) % 2 == 0, -6e-3, -1e-3)
    force = 100.0 + 60.0 * np.tanh(v / 3e-3)
    read = 5e-6 * (np.floor(np.cumsum(v) * 1e-3 / 5e-6) + 0.5)
    creeps = replace(read_by_board(t, read, force), closed_loop=closed_loop)
    assert np.abs(np.diff(creeps.force)).max() > 30.0
    assert not list(sudden_force(creeps))


@pytest.mark.prove
@pytest.mark.parametrize(
    "step",
    [
        'kind = "sine"\namplitude = "8 mm"\nfrequency = "0.84 Hz"\ncycles = 5',
        pytest.param('kind = "sine"\namplitude = "8 mm"\nfrequency = "0.4 Hz"\ncycles = 3', marks=pytest.mark.by_hand),
        pytest.param(
            'kind = "random"\namplitude = "8 mm"\nduration = "10 s"\nlow = "0.2 Hz"', marks=pytest.mark.by_hand
        ),
    ],
    ids=["sine", "slow", "random"],
)
def test_each_run_with_a_saturated_amplifier_is_marked_and_no_healthy_one(tmp_path: Path, step: str) -> None:
    path = tmp_path / "one.toml"
    for voltage, level in ((0.0, 0), (0.87, 0), (1.98, 0), (3.2, 0), (1.98, 100), (1.98, 250), (1.98, 500)):
        path.write_text(f'check_amplitude = "0 mm"\n[[step]]\n{step}\nvoltage = "{voltage} V"\n', "utf-8")
        rig = quick_rig(*([f"cell-clip={level}@0s"] if level else []))
        out = tmp_path / f"{voltage}-{level}"
        if level:
            with pytest.raises(RigFault, match="the test is spoiled: the force stands at"):
                perform(path, rig, out)
            assert np.abs(rig.board.simulator.truth.force).max() > level
        else:
            (record,) = perform(path, rig, out)
            assert record.marks == ()


@pytest.mark.prove
@pytest.mark.parametrize(
    ("voltage", "duration"),
    [
        (0.0, 10.0),
        (0.8712, 20.0),
        *(pytest.param(*case, marks=pytest.mark.by_hand) for case in ((0.5, 10.0), (0.8712, 10.0), (1.5, 20.0))),
    ],
)
def test_a_healthy_hybrid_test_has_no_mark(tmp_path: Path, voltage: float, duration: float) -> None:
    """The documented command, and other voltages."""
    plan = planned_hybrid({"kind": "hybrid", "voltage": voltage, "duration": duration})
    (record,) = perform(plan, simulated(), tmp_path / "out")
    assert record.marks == ()


@pytest.mark.prove
@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("drifting-cell=10@12s", "the force's zero moved by"),
        ("shunted-cell=100@14.5s", "the force's zero moved by"),
        ("cell-clip=200@0s", "the test is spoiled: the force stands at"),
    ],
)
def test_a_fault_in_a_hybrid_test_is_marked(tmp_path: Path, fault: str, words: str) -> None:
    plan = planned_hybrid({"kind": "hybrid", "voltage": 0.8712, "duration": 5.0})
    try:
        perform(plan, simulated(faults=[fault]), tmp_path / "out")
    except RigFault as problem:
        said = str(problem)
    else:
        said = "; ".join(records.read_campaign(tmp_path / "out")[0].marks)
    assert words in said


def test_a_test_without_samples_has_no_marks() -> None:
    empty = np.empty(0)
    assert marks_of(lambda _: MeasuredTest(empty, empty, empty, empty, 0.0, RIG), 0) == []


def test_a_long_test_is_looked_at_in_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """A force that stands is one of a piece, and a drift one of the whole, of which every k-th sample is looked at."""
    monkeypatch.setattr(sys.modules["dampyr.campaigns.marks"], "PIECE", 2500)
    drifting = sine(drift=20.0)
    volts = drifting.volts.copy()
    volts[8000:9000] = volts[8000]
    spoiled, read = with_volts(drifting, volts), []

    def some(rows: slice) -> MeasuredTest:
        read.append(rows)
        names = ("time", "displacement", "force", "volts")
        return MeasuredTest(*(getattr(spoiled, name)[rows] for name in names), 0.0, RIG)

    flat, drift = marks_of(some, spoiled.time.size)
    assert flat.spoils
    assert "the force stands at" in flat.text
    assert "the force's zero drifts" in drift.text
    assert all(len(range(*rows.indices(spoiled.time.size))) <= 2500 for rows in read)


@pytest.fixture
def short(tmp_path: Path) -> Callable[..., Path]:
    def make(voltage: str = '["0 V", "1 V"]') -> Path:
        path = tmp_path / "short.toml"
        path.write_text(SHORT.format(voltage=voltage))
        return path

    return make


@pytest.mark.parametrize("volts", [5.0, pytest.param(0.0, marks=pytest.mark.prove)])
def test_a_broken_cell_ends_the_campaign_and_its_test_is_not_complete(
    short: Callable[..., Path], tmp_path: Path, volts: float
) -> None:
    rig = quick_rig(f"broken-cell={volts}@28s")
    with pytest.raises(RigFault, match="the test is spoiled: the force stands at"):
        perform(short(), rig, tmp_path / "out")
    assert not rig.board.simulator.twin.enabled
    first, second = read_journal(tmp_path / "out")[0]
    assert (first.state, second.state) == ("complete", "failed")
    assert "the force stands at" in second.reason
    record = records.read(tmp_path / "out" / f"{second.name}.h5")
    assert not h5.state(tmp_path / "out" / f"{second.name}.h5").complete
    assert record.provenance["exit_status"] == "failed"
    assert record.marks[0].startswith("the force stands at")
    assert len(records.read_campaign(tmp_path / "out")) == 1


@pytest.mark.usefixtures("no_trials")
def test_a_drifting_cell_is_marked_and_told_where_its_records_are_used(drifted: Path) -> None:
    folder = drifted
    recorded = records.read_campaign(folder)
    assert all(record.marks and "the force's zero drifts" in record.marks[0] for record in recorded)
    assert all("the force's zero drifts" in test.reason for test in read_journal(folder)[0])
    listed = CliRunner().invoke(cli, ["records", str(folder)])
    assert listed.stdout.count("the force's zero drifts") == 2
    assert records.describe(recorded[0])["marks"] == recorded[0].marks
    [drifts] = [one for one in fit(recorded, "dahl").findings if "zero drifts" in str(one)]
    assert (drifts.severity, set(drifts.about)) == ("doubt", {record.name for record in recorded})
    said = CliRunner().invoke(cli, ["identify", str(folder), "--model", "dahl"])
    assert said.stdout.count("the force's zero drifts") == 1
    piece = records.cut(recorded[0], "4 s")[0]
    assert piece.marks == recorded[0].marks


SHORTER = {  # of the steps of the example: each in the least time that shows it
    "warm_up": {"cycles": 3},
    "rest": {"duration": "1 s"},
    "gas_force": {"places": 3},
    "low_velocity": {"speeds": ["2 mm/s"], "voltage": "1.98 V"},
    "sine": {"amplitude": "5 mm", "repeats": 1},
    "sweep": {"duration": "10 s"},
    "random": {"duration": "10 s"},
    "voltage_steps": {"hold": "1 s"},
    "random_voltage": {"cycles": 3},
}


@pytest.mark.prove
def test_no_kind_of_step_is_marked_where_nothing_is_wrong(tmp_path: Path) -> None:
    document = tomllib.loads((EXAMPLES / "every_kind.toml").read_text("utf-8"))
    steps = [step | SHORTER.get(step["kind"], {}) for step in document["step"]]
    short = campaign_of(document | {"rest_between": "0.5 s", "step": steps})
    folder = perform(short, simulated(), tmp_path / "out").folder
    assert {record.name: record.marks for record in records.read_campaign(folder) if record.marks} == {}


@pytest.mark.parametrize("at", [0.5, 1.6, 3.52, 6.02, 11.5])
@pytest.mark.parametrize("size", [-40.0, 300.0])
def test_a_force_that_leaps_while_the_table_slides_or_stands_is_marked(at: float, size: float) -> None:
    """Such as at the end of a drift that has come and gone, or where the cell's wires are swapped in a test."""
    measured = sine()
    leapt = read_by_board(
        measured.time, measured.displacement, measured.force + np.where(measured.time > at, size, 0.0)
    )
    (mark,) = sudden_force(leapt)
    assert not mark.spoils
    assert float(mark.text.split("leaps by ")[1].split()[0]) == pytest.approx(size, abs=8.0)
    assert f"at {at:.4g}" in mark.text


def test_a_force_that_grows_from_one_slow_sample_to_the_next_does_not_leap(tmp_path: Path) -> None:
    """At 200 Hz the spring of the original specimen gives 30 N from a sample to the next."""
    rig = replace(QUICK, board=replace(QUICK.board, rate=200.0, velocity_bandwidth=50.0))
    step = {"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz", "cycles": 4, "voltage": "3.2 V"}
    folder = perform(campaign_of({"step": [step]}), simulated(rig), tmp_path / "out").folder
    (record,) = records.read_campaign(folder)
    assert np.abs(np.diff(record.force)).max() > 50.0
    assert record.marks == ()


@pytest.mark.parametrize("speed", [0.002, 0.03, 0.08])
def test_a_stiff_damper_that_turns_does_not_leap(speed: float) -> None:
    """4 N/um, the stiffest of the original specimen's: at full speed 170 N from a sample to the next."""
    measured, frequency = sine(), speed / (2 * np.pi * 0.005)
    t = measured.time
    x = np.where((t > 1.0) & (t < 11.0), 0.005 * np.sin(2 * np.pi * frequency * (t - 1.0)), 0.0)
    force, dahl = np.zeros(t.size), 0.0
    for k, step in enumerate(np.diff(x, prepend=0.0)):
        dahl = np.sign(step) + (dahl - np.sign(step)) * np.exp(-2e4 * abs(step))  # grows over 50 um to 200 N
        force[k] = 200.0 * dahl
    noise = 0.4 * np.random.default_rng(2).standard_normal(t.size)
    assert not list(sudden_force(read_by_board(t, 5e-6 * np.round(x / 5e-6), force + noise)))


@pytest.mark.parametrize("begin", [0.0, 5.0])
def test_a_force_with_the_wrong_sign_spoils_its_test(begin: float) -> None:
    measured = sine()
    inverted = with_volts(measured, np.where(measured.time >= begin, -measured.volts, measured.volts))
    (mark,) = created_energy(inverted)
    assert mark.spoils
    assert "the force's sign inverted" in mark.text
    assert not list(created_energy(measured))


def test_a_loop_whose_height_changes_from_a_cycle_to_the_next_is_marked() -> None:
    good = sine()
    assert not list(changed_height(good))
    changed = np.where(good.time > 5.6, 0.9, 1.0)
    (mark,) = changed_height(with_volts(good, good.volts * changed))
    assert "from a cycle to the next at" in mark.text
    assert mark in marks_of(lambda _: with_volts(good, good.volts * changed), good.time.size)
    longer = (good.time > 5.0) & (good.time < 6.0)  # and so faster: its force grows with it
    x, force = (np.where(longer, 1.08, 1.0) * good.displacement, np.where(longer, 1.07, 1.0) * (good.force - 100.0))
    assert not list(changed_height(read_by_board(good.time, x, force)))
    assert list(changed_height(read_by_board(good.time, good.displacement, force)))
    slowly = 1.0 - 0.2 * np.clip(good.time - 1.0, 0.0, 10.0) / 10.0
    assert not list(changed_height(with_volts(good, good.volts * slowly)))  # as a damper that warms


def test_a_cell_with_less_noise_than_before_has_grown_slow() -> None:
    good = replace(sine(), noise=0.4 / SCALE)
    assert not list(slow_cell(good))
    quiet = np.where(good.time > 7.0, np.convolve(good.volts, np.ones(15) / 15.0, mode="same"), good.volts)
    slow = with_volts(good, quiet)
    (mark,) = slow_cell(slow)
    assert "has grown slow" in mark.text
    assert not list(slow_cell(replace(slow, noise=np.nan)))
    assert not list(slow_cell(replace(slow, noise=0.5 * STEP)))  # the converter's own noise


@pytest.mark.parametrize(
    ("rate", "step"),
    [
        (10.0, 'kind = "sine"\namplitude = "4 mm"\nfrequency = "2 Hz"\ncycles = 2'),
        (-40.0, 'kind = "rest"\nduration = "3 s"'),
        pytest.param(10.0, 'kind = "rest"\nduration = "3 s"', marks=pytest.mark.prove),
        pytest.param(
            -40.0, 'kind = "sine"\namplitude = "4 mm"\nfrequency = "2 Hz"\ncycles = 2', marks=pytest.mark.prove
        ),
    ],
)
def test_a_drift_in_a_short_test_is_seen_on_the_way_past_the_index(tmp_path: Path, rate: float, step: str) -> None:
    path = tmp_path / "short.toml"
    path.write_text(f'check_amplitude = "0 mm"\n[[step]]\n{step}\nvoltage = "1 V"\n', "utf-8")
    for faults, count in (([], 0), ([f"drifting-cell={rate}@5s"], 1)):
        rig = quick_rig(*faults)
        folder = perform(path, rig, tmp_path / f"out{count}").folder
        (path_of_record,) = folder.glob("*.h5")
        record = records.read(path_of_record)
        assert len([text for text in record.marks if "the force's zero moved by" in text]) == count


@pytest.mark.parametrize("check", [0, 1])
def test_a_cell_whose_wires_are_swapped_ends_the_campaign(tmp_path: Path, check: int) -> None:
    path = tmp_path / "short.toml"
    text = SHORT.format(voltage='"1 V"').replace('"0 mm"', f'"{check} mm"')
    path.write_text(text, "utf-8")
    rig = quick_rig("inverted-cell@0s")
    with pytest.raises(RigFault, match="sign inverted"):
        perform(path, rig, tmp_path / "out")
