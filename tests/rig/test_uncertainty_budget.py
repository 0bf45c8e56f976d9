"""Stated uncertainty against the simulator's ground truth, of rigs whose constants are not known exactly."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from dampyr import records
from dampyr.campaigns import campaign_of, perform
from dampyr.errors import RigFault
from dampyr.models.numerics.differentiation import differentiate
from dampyr.records import Record
from dampyr.rig import Rig, RigSettings, simulated
from dampyr.rig.calibration import Calibration
from dampyr.rig.load_cell_calibration import Calibrating
from dampyr.rig.simulation import plant
from dampyr.rig.simulation.faults import FaultSpec
from dampyr.rig.simulation.simulator import Simulator
from dampyr.rig.uncertainty_budget import Evidence, budget

BELIEVED = replace(RigSettings(), wires=replace(RigSettings().wires, coil_voltage="ai2", coil_current="ai3"))
TRUE = replace(
    BELIEVED,
    supply=replace(BELIEVED.supply, resistance=4.0, gain=0.9),
    load_cell=replace(BELIEVED.load_cell, bandwidth=100.0, scale=618.0, zero=0.005),
)
NINE = {
    "rest_between": "0.5 s",
    "step": [
        {"kind": "sine", "amplitude": a, "frequency": f, "cycles": 4, "voltage": ["0 V", "0.9 V", "1.98 V"]}
        for a, f in (("8 mm", "1 Hz"), ("4 mm", "2 Hz"), ("2 mm", "3 Hz"))
    ],
}


def errors(record: Record, simulator: Simulator, begin: float, resistance: float) -> dict[str, float]:
    """RMS errors over all but the ends of a record; ``resistance`` [ohm] is what the voltage in it stands for."""
    truth, rate = simulator.truth, simulator.settings.board.rate
    time = record.time + begin + 1.0 / rate
    quantities = {"displacement": truth.position, "force": truth.force, "velocity": truth.speed}
    off = {}
    for name, values in quantities.items():
        off[name] = getattr(record, name) - np.interp(time, truth.time, values)
    coil = np.interp(time, truth.time, truth.current) * resistance
    off["voltage"] = np.broadcast_to(record.voltage, record.n) - coil
    return {name: float(np.sqrt(np.mean(values[300:-300] ** 2))) for name, values in off.items()}


def nine(opened: Rig, folder: Path) -> list[tuple[Record, dict[str, float]]]:
    """Nine records, each with its true errors; the force's clock is that of the displacement as recorded."""
    simulator: Simulator = opened.board.simulator  # type: ignore[attr-defined]
    begins: list[float] = []
    start = simulator.start

    def noted(rate: float) -> None:
        begins.append(simulator.time)
        start(rate)

    simulator.start = noted  # type: ignore[method-assign]
    perform(campaign_of(NINE), opened, folder)
    delay, resistance = opened.settings.force_delay, opened.settings.supply.resistance
    some = records.read_campaign(folder)
    return [(record, errors(record, simulator, begins[-1] - delay, resistance)) for record in some]


@pytest.mark.prove
def test_wrong_constants_are_covered_by_the_uncertainty_of_a_rig_that_was_not_calibrated(tmp_path: Path) -> None:
    with simulated(replace(BELIEVED, wires=RigSettings().wires), parts=TRUE) as opened:
        for record, off in nine(opened, tmp_path):
            for name, error in off.items():
                assert error < 3.0 * record.uncertainty[name].standard + 1e-4, (record.name, name)


@pytest.mark.prove
def test_wrong_constants_are_found_by_calibration(tmp_path: Path) -> None:
    """Gain, resistance, scale, zero and bandwidth; then the uncertainty is small, and the records are within it."""
    with simulated(BELIEVED, parts=TRUE) as opened:
        calibrated = calibrate(opened)
        assert calibrated.resistance == pytest.approx(4.0, rel=0.01)
        assert calibrated.gain == pytest.approx(0.9, rel=0.005)
        assert calibrated.inductance == pytest.approx(0.044, rel=0.02)
        assert calibrated.bandwidth == pytest.approx(100.0, rel=0.02)
        assert calibrated.scale == pytest.approx(618.0, rel=0.01)
        ratios: dict[str, list[float]] = {}
        for record, off in nine(opened, tmp_path):
            assert record.marks == ()
            for name, error in off.items():
                stated = record.uncertainty[name].standard
                assert error < 3.0 * stated, (record.name, name, error, stated)
                if error > 1e-9:
                    ratios.setdefault(name, []).append(stated / error)
        assert max(np.median(ratios[name]) for name in ("displacement", "force", "velocity")) <= 3.0


def calibrate(opened: Rig) -> Calibration:
    """Zero and load without the damper, whose force is taken off the cell here; the shunt's step; the coil."""
    simulator: Simulator = opened.board.simulator  # type: ignore[attr-defined]
    steps, mounted = Calibrating(opened), -float(simulator.plant[plant.Y_FORCE])

    def shunt(force: float, seconds: float = 1e6) -> FaultSpec:
        return FaultSpec("shunted-cell", simulator.time, seconds, mounted + force)

    simulator.faults = (shunt(0.0),)
    simulator.run_unattended(0.1)
    steps.zero()
    simulator.faults = (shunt(500.0),)
    simulator.run_unattended(0.1)
    steps.loaded("500 N")
    simulator.faults = (shunt(0.0, 1.1), replace(shunt(500.0), at=simulator.time + 1.1))
    simulator.run_unattended(0.1)
    steps.amplifier(4.0)
    simulator.faults = (shunt(-mounted),)  # none
    steps.coil()
    opened.use(steps.calibration)
    return steps.calibration


def test_a_supply_that_comes_late_is_in_the_uncertainty_of_a_voltage_that_changes() -> None:
    """Late by any part of 40 ms."""
    rig, t = RigSettings(), np.arange(8000) / 1000.0
    voltage, generator = 2.0 * (np.floor(2.0 * t) % 2.0), np.random.default_rng(0)
    pieces = [(t, 0.0 * t, 0.0 * t, voltage)]
    late = budget(rig, Evidence(command_delay=0.04), 8.0, pieces)["voltage"]["delay of the supply"]
    each = [voltage - np.roll(voltage, n) for n in generator.integers(0, 41, 200)]
    assert late == pytest.approx(np.sqrt(np.mean(np.square(each))), rel=0.1)
    assert "delay of the supply" not in budget(rig, Evidence(), 8.0, pieces)["voltage"]
    read = budget(BELIEVED, Evidence(command_delay=0.04), 8.0, pieces)["voltage"]
    assert "delay of the supply" not in read  # what was read is not late
    steady = budget(rig, Evidence(command_delay=0.04), 8.0, [(t, 0.0 * t, 0.0 * t, 2.0)])["voltage"]
    assert steady["delay of the supply"] == 0.0


def test_a_test_that_was_stopped_states_the_warmth_of_its_coil(tmp_path: Path) -> None:
    step = {"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz", "cycles": 20, "voltage": "1.98 V"}
    with simulated(faults=["board-overrun@20s"]) as opened:
        opened.warmth.temperature = 40.0
        with pytest.raises(RigFault):
            perform(campaign_of({"step": [step]}), opened, tmp_path)
    (path,) = tmp_path.glob("*.h5")
    record = records.read(path)
    assert record.provenance["complete"] == "no"
    assert record.uncertainty["voltage"].parts["warmth of the coil"] > 0.03


@pytest.mark.parametrize("speed", [0.4, 3.7, 5.02, 9.9, 10.3, 15.2, 17.4, 40.1, 59.9])
def test_the_noise_of_counting_is_that_of_an_even_motion_whatever_its_speed(speed: float) -> None:
    """At 10.3 mm/s 5 um and 1 kHz beat at 60 Hz, within the bandwidth: all of a count's noise is in the velocity."""
    rig = RigSettings()
    t = np.arange(20_000) / rig.board.rate
    x = 1e-3 * speed * t
    read = rig.encoder.count * (np.floor(x / rig.encoder.count) + 0.5)
    error = differentiate(t, read, rig.board.velocity_bandwidth) - 1e-3 * speed
    true = float(np.sqrt(np.mean(error[200:-200] ** 2)))
    stated = budget(rig, Evidence(), 20.0, [(t, read, 0.0 * t, 0.0)])["velocity"]["resolution of the encoder"]
    assert true < 1.02 * stated < max(1.1 * true, 0.18e-3)


def test_a_rest_does_not_lower_the_noise_of_what_moves() -> None:
    rig = RigSettings()
    t = np.arange(20_000) / rig.board.rate
    x = 0.0103 * np.minimum(t, 2.0)
    read = rig.encoder.count * np.floor(x / rig.encoder.count)
    stated = budget(rig, Evidence(), 20.0, [(t, read, 0.0 * t, 0.0)])["velocity"]["resolution of the encoder"]
    assert stated > 0.3e-3
