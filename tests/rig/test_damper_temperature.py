"""The damper is as warm for the next host as the last one left it, less what it has cooled."""

import math
import sys
import threading
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from tests.rig.warm_damper import HOT, SETTINGS

from dampyr.campaigns import perform, read_journal
from dampyr.errors import DampyrWarning, FileError, InputError, RigFault
from dampyr.rig import Drive, Rig, RigSettings, simulated
from dampyr.rig.damper_temperature import NAME, SavedTemperature, load_temperature, save_temperature
from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import InProcess
from dampyr.rig.instruments.ni_daqmx.simulated import InProcessBoard
from dampyr.rig.simulation.simulator import Simulator


def host(simulator: Simulator, folder: Path | None) -> Rig:
    """A new host of a rig that stays."""
    uno, board = Uno(InProcess(simulator.serial)), InProcessBoard(simulator)
    return Rig(SETTINGS, uno, board, threaded=False, folder=folder, clocked_by_reads=True, clock=lambda: simulator.time)


@pytest.mark.parametrize("with_rig_file", [True, False])
def test_a_damper_that_is_too_warm_is_not_taken_for_cold_by_the_next_host(tmp_path: Path, with_rig_file: bool) -> None:
    """By the file beside the rig's settings, or, in a further run of a campaign, by its journal."""
    (tmp_path / "hot.toml").write_text(HOT)
    simulator = Simulator(SETTINGS)
    folder = tmp_path if with_rig_file else None
    with pytest.raises(RigFault, match="estimated temperature 26"):
        perform(tmp_path / "hot.toml", host(simulator, folder), tmp_path / "out")
    for k in range(3):
        out = tmp_path / (f"out{k}" if with_rig_file else "out")
        with pytest.raises(
            (RigFault, InputError), match=r"estimated temperature 26|is at 26 degC as estimated.*let it cool"
        ):
            perform(tmp_path / "hot.toml", host(simulator, folder), out)
    assert simulator.truth.temperature.max() < 27.0


def test_a_damper_that_has_to_cool_is_told_before_anything_moves(tmp_path: Path) -> None:
    (tmp_path / "hot.toml").write_text(HOT)
    save_temperature(tmp_path, 30.0)
    simulator = Simulator(SETTINGS)
    with pytest.raises(InputError, match=r"is at 30 degC as estimated, and limits\.temperature = 26 degC; let it cool"):
        perform(tmp_path / "hot.toml", host(simulator, tmp_path), tmp_path / "out")
    assert simulator.time < 0.1  # it was asked who it is, and not read


def test_it_cools_by_the_thermal_model() -> None:
    now = datetime(2026, 11, 23, 12, tzinfo=UTC)
    saved = SavedTemperature(60.0, now)
    rig = RigSettings()
    tau = rig.specimen.heat_capacity / rig.specimen.cooling
    for seconds in (0.0, 100.0, 1e6):
        expected = 20.0 + 40.0 * math.exp(-seconds / tau)
        assert saved.cooled(rig, now + timedelta(seconds=seconds)) == pytest.approx(expected)
    assert saved.cooled(rig, now - timedelta(days=2)) == 60.0  # a clock that was set back


def test_a_jump_of_the_days_clock_cools_nothing() -> None:
    """NTP sets a wrong clock right, somebody sets it wrong: the machine's own time goes on evenly, in suspension too."""
    now, rig = datetime(2026, 11, 23, 12, tzinfo=UTC), RigSettings()
    saved = SavedTemperature(60.0, now, "start-1 1000.0")
    tau = rig.specimen.heat_capacity / rig.specimen.cooling
    for jump in (-86400.0, 0.0, 3600.0, 86400.0):
        later = now + timedelta(seconds=jump)
        assert saved.cooled(rig, later, "start-1 1100.0") == pytest.approx(20.0 + 40.0 * math.exp(-100.0 / tau))
    assert saved.cooled(rig, now + timedelta(days=1), "start-2 50.0") == pytest.approx(20.0)  # it was started anew
    assert SavedTemperature.parse("60", now.isoformat()).uptime == ""  # of dampyr up to 0.3.0


def test_each_arming_saves_it(tmp_path: Path) -> None:
    rig = host(Simulator(SETTINGS), tmp_path)
    with rig.armed() as table:
        rig.warmth.temperature = 24.0
        table.rest(0.1)
    saved = load_temperature(tmp_path)
    assert saved is not None
    assert saved.temperature == pytest.approx(24.0, abs=0.1)
    assert host(Simulator(SETTINGS), tmp_path).warmth.temperature == pytest.approx(24.0, abs=0.2)
    assert "delete this file where another damper is mounted" in (tmp_path / NAME).read_text()


@pytest.mark.prove
def test_a_killed_host_leaves_what_was_saved_while_it_ran(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules["dampyr.campaigns.performing"], "SAVE_EVERY", 0.0)
    (tmp_path / "hot.toml").write_text(HOT)
    saved: list[float] = []

    def show(_: object) -> None:
        for each in threading.enumerate():  # simulated time does not wait for a disk
            if each.name == "temperature":
                each.join()
        if (tmp_path / NAME).is_file():
            warm = load_temperature(tmp_path)
            assert warm is not None
            saved.append(warm.temperature)

    with pytest.raises(RigFault):
        perform(tmp_path / "hot.toml", host(Simulator(SETTINGS), tmp_path), tmp_path / "out", show)
    assert saved[-1] - saved[0] > 4.0
    assert len(read_journal(tmp_path / "out")[0]) == 2


@pytest.mark.parametrize("text", ["", 'temperature_degC = "warm"\ntime = "now"', "temperature_degC = 30.0\ntime = 3"])
def test_a_file_that_says_none_is_told(tmp_path: Path, text: str) -> None:
    (tmp_path / NAME).write_text(text)
    with pytest.raises(FileError, match=r"temperature\.toml: says no temperature_degC and time"):
        load_temperature(tmp_path)


def test_a_disk_that_takes_no_temperature_is_a_warning(tmp_path: Path) -> None:
    rig = host(Simulator(SETTINGS), tmp_path / "nowhere")
    with pytest.warns(DampyrWarning, match="the damper's temperature was not saved: .*cannot be written"), rig.armed():
        pass


def test_a_temperature_that_is_measured_is_that_of_the_coil() -> None:
    """The command rises with it, also where the damper is warmer than its own work has made it."""
    base = RigSettings()
    settings = replace(base, wires=replace(base.wires, temperature="ai1"))
    rig = simulated(settings, faults=["hot-specimen=40@0s"])
    simulator = rig.board.simulator
    with rig.armed() as table:
        table.home()
        table.go(0.0)
        assert table.temperature == pytest.approx(simulator.truth.temperature[-1], abs=0.1)
        for _ in table.play(Drive(0.01, np.zeros(100), np.full(100, 1.5))):
            pass
    truth = simulator.truth
    cold = truth.voltage / (1.0 + 0.0039 * (truth.temperature - 20.0))
    assert cold[truth.voltage > 0.0] == pytest.approx(1.5, abs=2e-3)
