"""Instruments of another laboratory: those of docs/how-to/add-an-instrument.md, and folders that are none."""

from __future__ import annotations

import json
import socket
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from tests.rig.instruments.laboratory import agree, records_of, rig_file

from dampyr.cli import cli
from dampyr.errors import FileError, InputError, RigFault
from dampyr.records import Record, read_campaign
from dampyr.rig import RigSettings, load_settings, simulated
from dampyr.rig.diagnosis import diagnose
from dampyr.rig.instruments import catalogue
from dampyr.rig.settings_file import write_settings
from dampyr.rig.simulation.simulator import Simulator


def test_the_page_shows_files_that_are_there(laboratory: Path) -> None:
    rig = load_settings(laboratory / "rig.toml")
    assert (rig.wires.acquisition, rig.wires.supply) == ("./our_board", "./bench_supply")
    assert load_settings(write_settings(rig, laboratory / "written.toml")) == rig
    with simulated(laboratory / "rig.toml") as opened:
        assert "OUR-BOARD 7, supply simulated BENCH 30V" in opened.identity
        assert "up to 90 ms late" in opened.identity


def test_an_acquisition_of_ones_own_gives_the_record_of_the_usual_one(laboratory: Path, usual: list[Record]) -> None:
    path = rig_file(laboratory, acquisition="./our_board")
    ours = records_of(simulated(path), laboratory / "out")
    agree(ours, usual)
    for own, other in zip(ours, usual, strict=True):  # the same calls: to the last bit
        np.testing.assert_array_equal(own.force, other.force)


def test_the_driver_of_ones_own_over_its_wire(laboratory: Path) -> None:
    """The page's driver speaks to its simulated end over TCP, and gives what it gives without a wire."""
    rig = replace(RigSettings(), wires=replace(RigSettings().wires, acquisition=str(laboratory / "our_board")))
    end, driver = (catalogue.part(rig, "acquisition", name) for name in ("simulated", "driver"))
    simulators = [Simulator(RigSettings(), 1) for _ in range(2)]
    listener = socket.create_server(("127.0.0.1", 0))

    def serve() -> None:
        client, _ = listener.accept()
        with client, client.makefile("rw", encoding="utf-8") as lines:
            for line in lines:
                request = json.loads(line)
                try:
                    reply = end.answer(simulators[0], request.pop("do"), **request)
                except InputError as problem:
                    reply = {"error": str(problem)}
                lines.write(json.dumps(reply) + "\n")
                lines.flush()

    threading.Thread(target=serve, daemon=True).start()
    address = f"127.0.0.1:{listener.getsockname()[1]}"
    there = driver.connect(replace(rig, wires=replace(rig.wires, acquisition_address=address)))
    here = end.in_process(simulators[1])
    with pytest.raises(RigFault, match=r"our board gives an error: .*no sampled task runs"):
        there.read(10)
    seen = []
    for board in (there, here):
        board.start(1000.0, [1.0] * 100)
        board.queue([2.0] * 50)
        seen.append(board.read(40))
        board.write(0.5)
        assert board.identity() == "simulated OUR-BOARD 7"
        assert board.index_counts().size == 0
        board.stop()
    for ours, theirs in zip(*seen, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    assert simulators[0].command == simulators[1].command == pytest.approx(0.5, abs=1e-3)
    there.close()
    listener.close()


def test_the_supply_of_ones_own_without_a_wire_says_what_it_is(laboratory: Path) -> None:
    with simulated(laboratory / "rig.toml") as rig:
        volts, counts = rig.listen(0.2)
        assert (volts.shape, counts.shape) == ((1, 200), (200,))
        assert rig.identity.startswith("simulated OUR-BOARD 7, supply simulated BENCH 30V (no sample clock")


def test_dampyr_run_takes_it(laboratory: Path) -> None:
    path = rig_file(laboratory, acquisition="./our_board")
    (laboratory / "one.toml").write_text(
        'name = "one"\noperator = "me"\n[[step]]\nkind = "sine"\namplitude = "5 mm"\nfrequency = "1 Hz"\ncycles = 2\n'
        'voltage = "0 V"\n'
    )
    command = [
        "run",
        str(laboratory / "one.toml"),
        "--rig",
        str(path),
        "--out",
        str(laboratory / "out"),
    ]
    result = CliRunner().invoke(cli, command, catch_exceptions=False)
    assert result.exit_code == 0, result.stderr
    [record] = read_campaign(laboratory / "out")
    assert record.provenance["board"].startswith("simulated OUR-BOARD 7")


DRIVE = """
from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import InProcess, open_wire

class OurDrive(Uno):
    jogs = 0

    def jog(self, speed, time_ms):
        self.jogs += 1
        super().jog(speed, time_ms)

def connect(rig):
    return OurDrive(open_wire(rig.wires.serial, rig.wires.baud))

def in_process(simulator):
    return OurDrive(InProcess(simulator.serial))
"""


def test_a_drive_of_ones_own(tmp_path: Path) -> None:
    (tmp_path / "our_drive").mkdir()
    (tmp_path / "our_drive" / "driver.py").write_text(DRIVE)
    (tmp_path / "our_drive" / "simulated.py").write_text("from .driver import in_process\n")
    with simulated(rig_file(tmp_path, drive="./our_drive")) as rig:
        assert "drive's firmware" in rig.identity
        with rig.armed() as table:
            table.home()
            table.jog(0.001)
            assert rig.uno.jogs == 1  # type: ignore[attr-defined]
            table.go(0.002)
            assert table.position == pytest.approx(0.002, abs=5e-4)


@pytest.mark.prove  # in real time
def test_the_process_that_reads_opens_own_instruments(laboratory: Path) -> None:
    with simulated(laboratory / "rig.toml", real_time=True) as rig:
        volts, counts = rig.listen(0.2)
        assert volts.shape == (1, 200)
        assert "OUR-BOARD 7" in rig.identity
        with rig.armed() as table:
            table.home(here=True)
            assert rig.command_delay == pytest.approx(0.09)
        assert counts.shape == (200,)


@pytest.mark.prove  # a process is started, which imports dampyr
def test_in_real_time_it_is_the_same_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"wires.acquisition = 'ni-daqm' is not known"):
        simulated(rig_file(tmp_path, acquisition="ni-daqm"), real_time=True)


def test_what_was_opened_is_closed_where_another_fails(tmp_path: Path) -> None:
    from dampyr.rig.instruments.connection import assembled

    closed: list[str] = []

    class Closing:
        def close(self) -> None:
            closed.append("closed")

    with pytest.raises(FileError, match=r"no hello\(\)"):
        assembled(RigSettings(), {"drive": Closing, "acquisition": Closing})
    assert closed == ["closed"]


def test_doctor_lists_the_instruments(laboratory: Path) -> None:
    findings = {each.what: each for each in diagnose(laboratory / "rig.toml")}
    assert findings["acquisition"].observed == "./our_board"
    assert findings["drive"].observed == "arduino-uno"
    assert findings["supply"].observed == "./bench_supply"
    assert "OUR-BOARD 7" in findings["board"].observed
    usual = {each.what: each for each in diagnose(None)}
    assert usual["supply"].observed == "an output of the acquisition"
