"""The simulated rig against the records of the original one: both lie in the same bands (FACTS 1 and 6)."""

from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import Record, read_campaign
from dampyr.rig.drive import DutyReversals
from dampyr.rig.settings import RigSettings
from dampyr.rig.simulation.twin_validation import Characteristics, characteristics, open_loop

VOLTAGES = (0.0, 0.8712, 1.98, 3.212)
TOPS = (248, 165)
SLOPE = {0.0: 2.2e-3, 0.8712: 4.2e-3, 1.98: 2.2e-3, 3.212: 2.2e-3}  # s for each step of the duty


def drive(voltage: float, top: int) -> DutyReversals:
    """What the original rig ran at a voltage."""
    return DutyReversals(duty=top / 255, half_period=top * SLOPE[voltage], pause=0.05)


@pytest.fixture(scope="module")
def simulated() -> dict[tuple[float, int], Characteristics]:
    return {(v, top): characteristics(open_loop(RigSettings(), drive(v, top), v)) for v in VOLTAGES for top in TOPS}


def within_bands(measured: Characteristics) -> None:
    """What holds for every record of the original rig, and for every simulated one."""
    assert 0.026 < measured.peak_speed < 0.076
    assert 0.02 < measured.third < 0.09
    assert measured.others < 0.025
    assert 0.8 < measured.period < 2.3
    assert measured.displacement_step == pytest.approx(5e-6, rel=1e-6)
    assert measured.force_step == pytest.approx(0.187, abs=1e-3)
    assert 75.0 < measured.mean_force < 155.0
    assert abs(measured.drift) < 0.7e-3


@pytest.mark.prove
@pytest.mark.parametrize("voltage", VOLTAGES)
def test_simulated_records_lie_in_the_bands(
    simulated: dict[tuple[float, int], Characteristics], voltage: float
) -> None:
    for top in TOPS:
        within_bands(simulated[voltage, top])


def test_measured_records_lie_in_the_bands(campaign_folder: Path) -> None:
    for record in read_campaign(campaign_folder):
        if record.role == "fit":
            within_bands(characteristics(record))


def nearest(records: list[Record], voltage: float, period: float) -> Characteristics:
    """The measured record at a voltage whose period is nearest."""
    candidates = [characteristics(r) for r in records if abs(float(np.mean(r.voltage)) - voltage) < 0.01]
    return min(candidates, key=lambda each: abs(each.period - period))


def test_each_resembles_the_record_of_the_same_drive(
    campaign_folder: Path, simulated: dict[tuple[float, int], Characteristics]
) -> None:
    records = [r for r in read_campaign(campaign_folder) if r.role == "fit" and r.voltage is not None]
    for (voltage, _), ours in simulated.items():
        theirs = nearest(records, voltage, ours.period)
        assert ours.period == pytest.approx(theirs.period, rel=0.02)
        assert ours.peak_speed == pytest.approx(theirs.peak_speed, rel=0.25)
        assert ours.stroke == pytest.approx(theirs.stroke, rel=0.25)
        assert ours.force_span == pytest.approx(theirs.force_span, rel=0.25)


def test_amplitude_falls_with_voltage(simulated: dict[tuple[float, int], Characteristics]) -> None:
    for top in TOPS:
        strokes = [simulated[v, top].stroke for v in (0.0, 1.98, 3.212)]  # at 0.8712 V the ramp was slower
        assert strokes == sorted(strokes, reverse=True)


def test_what_is_measured_of_a_made_up_record_is_what_was_made() -> None:
    t = np.arange(0, 15, 0.01)
    w = 2 * np.pi * 0.9
    x = np.where(t < 1, 0.0, 0.01 * np.sin(w * (t - 1)) + 0.0005 * np.sin(3 * w * (t - 1)) + 2e-4 * (t - 1))
    force = np.round((120 + 300 * np.cos(w * t)) / 0.5) * 0.5
    measured = characteristics(Record(t, np.round(x / 1e-5) * 1e-5, force))
    assert measured.period == pytest.approx(1 / 0.9, rel=2e-3)
    assert measured.stroke == pytest.approx(0.02, rel=5e-3)
    assert measured.third == pytest.approx(0.05, abs=1e-3)
    assert measured.others < 0.003
    assert measured.drift == pytest.approx(2e-4, rel=0.1)
    assert (measured.force_step, measured.displacement_step) == (pytest.approx(0.5), pytest.approx(1e-5))
    assert measured.mean_force == pytest.approx(120, abs=2.0)


def test_a_record_of_two_cycles_is_too_short() -> None:
    t = np.arange(0, 3.2, 0.01)
    with pytest.raises(InputError, match="at least 3"):
        characteristics(Record(t, 0.01 * np.sin(2 * np.pi * t), np.cos(t)))


def test_a_drive_beyond_the_limits_is_refused() -> None:
    with pytest.raises(InputError, match="refuses REVERSE"):
        open_loop(RigSettings(), DutyReversals(duty=0.001, half_period=0.5), 0.0)
