"""The coil's resistance, inductance and gain from steps of its voltage."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.rig.measured_coil import RIG

from dampyr.errors import InputError, RigFault
from dampyr.rig import simulated
from dampyr.rig.calibration import calibration_of
from dampyr.rig.coil_calibration import fit_coil, measure_coil


def test_the_coils_heat_is_that_of_the_resistance_that_was_measured() -> None:
    with simulated(RIG) as rig:
        rig.use(replace(calibration_of(RIG), resistance=8.8, resistance_uncertainty=0.1))
        assert rig.warmth.rig.supply.resistance == 8.8


@pytest.mark.parametrize(("resistance", "inductance", "gain"), [(4.4, 0.044, 1.0), (4.0, 0.08, 0.9), (6.0, 0.006, 1.1)])
def test_a_coil_is_identified_from_steps_of_its_voltage(resistance: float, inductance: float, gain: float) -> None:
    true = replace(RIG, supply=replace(RIG.supply, resistance=resistance, inductance=inductance, gain=gain))
    with simulated(RIG, parts=true) as rig:
        coil = measure_coil(rig)
        assert np.ptp(rig.board.simulator.truth.position) < 1e-6  # nothing has moved
        assert rig.board.simulator.truth.voltage[-1] == 0.0
    assert abs(coil.resistance - resistance) < 2.0 * coil.resistance_uncertainty < 0.03 * resistance
    assert abs(coil.inductance - inductance) < 2.0 * coil.inductance_uncertainty < max(0.1 * inductance, 3e-3)
    assert coil.gain is not None
    assert abs(coil.gain - gain) < 2.0 * coil.gain_uncertainty < 0.01 * gain


def test_a_coil_in_closed_form() -> None:
    """One step from rest: i = u/R (1 - exp(-t R/L))."""
    time = np.arange(2000) / 1000.0
    output = np.where((time >= 0.5) & (time < 1.5), 2.0, 0.0)
    rise = 0.5 * (1.0 - np.exp(-np.clip(time - 0.501, 0.0, None) * 4.0 / 0.1))
    fall = np.where(time >= 1.501, np.exp(-np.clip(time - 1.501, 0.0, None) * 4.0 / 0.1), 1.0)
    late = np.concatenate(([0.0], output[:-1]))  # the board's sample sees what was output before it
    coil = fit_coil(RIG, late, late, rise * fall, 20.0)
    assert coil.resistance == pytest.approx(4.0, rel=1e-3)
    assert coil.inductance == pytest.approx(0.1, rel=1e-2)
    warm = fit_coil(RIG, late, late, rise * fall, 45.0)
    assert warm.resistance == pytest.approx(coil.resistance / (1.0 + 0.0039 * 25.0))


def test_a_coil_without_a_shunt_or_without_a_current_is_said_so() -> None:
    with simulated() as rig, pytest.raises(InputError, match=r"wires\.coil_current"):
        measure_coil(rig)
    assert not rig.was_armed
    with (
        simulated(RIG, faults=["open-coil@0s"]) as rig,
        pytest.raises(RigFault, match="the current changed"),
    ):
        measure_coil(rig)
