"""The estimate of the damper's temperature beside a reading: the guard takes the hotter."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.rig.warm_damper import HOT, SETTINGS

from dampyr import records
from dampyr.campaigns import perform, read_journal
from dampyr.errors import RigFault
from dampyr.rig import Rig, RigSettings, simulated
from dampyr.rig.firmware.protocol import Fault, State, Status
from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import InProcess
from dampyr.rig.instruments.ni_daqmx.simulated import InProcessBoard
from dampyr.rig.interlock import Samples
from dampyr.rig.simulation.simulator import Simulator
from dampyr.rig.thermal_model import PARTED, Warmth

WITH_THERMOCOUPLE = replace(
    RigSettings(),
    wires=replace(RigSettings().wires, temperature="ai1"),
    specimen=replace(RigSettings().specimen, heat_capacity=10.0, cooling=0.1),
    limits=replace(RigSettings().limits, temperature=31.0),
)


def test_a_stuck_thermocouple_does_not_switch_the_guard_off(tmp_path: Path) -> None:
    (tmp_path / "hot.toml").write_text(HOT)
    rig = simulated(WITH_THERMOCOUPLE, faults=["thermocouple-stuck@0s"])
    with pytest.raises(RigFault, match=r"estimated temperature 31.*the thermocouple reads 20 degC, .* has not moved"):
        perform(tmp_path / "hot.toml", rig, tmp_path / "out")
    assert rig.board.simulator.truth.temperature.max() < 32.0
    assert rig.warmth.temperature == pytest.approx(31.0, abs=0.5)  # by which the voltage is raised and what is saved
    assert "the thermocouple reads 20 degC" in read_journal(tmp_path / "out")[0][0].reason


def test_a_thermocouple_that_parts_from_the_estimate_is_marked_and_a_good_one_is_not(tmp_path: Path) -> None:
    (tmp_path / "hot.toml").write_text(HOT.replace("repeats = 2", "").replace("cycles = 20", "cycles = 12"))
    settings = replace(WITH_THERMOCOUPLE, limits=RigSettings().limits)
    for faults, words in (([], ""), (["thermocouple-stuck@0s"], "the reading has not moved while")):
        rig = simulated(settings, faults=faults)
        out = perform(tmp_path / "hot.toml", rig, tmp_path / f"out{len(faults)}").folder
        record = records.read(next(out.glob("*.h5")))
        true = rig.board.simulator.truth.temperature[-1]
        assert true > 20.0 + PARTED
        assert [words in mark for mark in record.marks] == ([True] if words else [])
        assert rig.warmth.temperature == pytest.approx(true, abs=1.0)
        assert record.temperature is not None
        error = np.abs(np.asarray(record.temperature)[-1] - true)
        assert error < 3.0 * record.uncertainty["temperature"].standard


def test_the_estimate_stays_beside_a_reading_and_the_guard_takes_the_hotter() -> None:
    """By hand: 20 J/K and no cooling, so that 200 J are the 10 K after which a reading that stands is dead."""
    settings = replace(WITH_THERMOCOUPLE, specimen=replace(WITH_THERMOCOUPLE.specimen, heat_capacity=20.0, cooling=0.0))
    warmth = Warmth(settings, 20.0)
    status = Status(0, State.ARMED, Fault(0), 0, 0, 0, True, True, False, 0, 0, 0)

    def heat(kelvin: float, reading: float) -> None:
        """A second in which the coil takes what warms the damper by ``kelvin``."""
        volts = math.sqrt(kelvin * 20.0 * settings.supply.resistance)
        zeros, n = np.zeros(1000), 1000
        warmth.take(
            Samples(0, zeros, zeros, zeros, np.full(n, reading), zeros[None], zeros.astype(int), zeros + volts, status)
        )

    heat(0.0, 24.0)
    assert (warmth.estimate, warmth.temperature) == (24.0, 24.0)  # a damper that is warm already
    heat(9.0, 24.5)
    assert (warmth.temperature, warmth.hottest, warmth.doubt) == (24.5, pytest.approx(33.0), "")
    heat(1.5, 24.5)  # 10.5 K in all: 210 J, and the reading stands within its uncertainty of 1 K
    assert warmth.dead
    assert warmth.temperature == warmth.hottest == pytest.approx(34.5)
    assert "has not moved while 0.21 kJ went in" in warmth.doubt
    heat(0.0, 33.0)  # it was loose, and is not any more
    assert (warmth.temperature, warmth.doubt) == (33.0, "")
    heat(0.0, 60.0)  # heat from elsewhere
    assert (warmth.temperature, warmth.hottest) == (60.0, 60.0)
    assert "26 K apart, 10 K at most" in warmth.doubt
    warmth.temperature = 30.0
    assert (warmth.estimate, warmth.hottest, warmth.doubt) == (30.0, 30.0, "")


def test_an_estimate_cools_while_nothing_is_read() -> None:
    """A damper that cooled with nobody reading has no thermocouple that parted from it."""
    settings = replace(SETTINGS, limits=RigSettings().limits)
    now = [0.0]
    simulator = Simulator(settings)
    rig = Rig(
        settings, Uno(InProcess(simulator.serial)), InProcessBoard(simulator), threaded=False,
        clock=lambda: now[0],
    )  # fmt: skip
    with rig.armed():
        rig.warmth.estimate = 40.0
    now[0] = 20.0  # s, with 20 J/K and 1 W/K a time constant
    with rig.armed():
        assert rig.warmth.estimate == pytest.approx(20.0 + 20.0 / math.e, abs=0.5)
