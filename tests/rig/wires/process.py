"""A simulated rig behind the wires of a real one, in a process that outlives its host."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from tests.rig.wires import serial_wire
from tests.rig.wires.clock import Clock

from dampyr.errors import RigFault
from dampyr.rig import Rig, RigSettings, load_settings
from dampyr.rig.connecting import _calibrated
from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import open_wire
from dampyr.rig.instruments.ni_daqmx.driver import NiBoard
from dampyr.rig.settings_file import write_settings
from dampyr.rig.simulation.event_log import EventFile
from dampyr.rig.simulation.simulator import Simulator, parse_faults
from dampyr.rig.specimen import specimen_of

ROOT = Path(__file__).resolve().parents[3]
PATIENCE = 5.0  # s for a rig without a host to come to rest: the watchdog stops it within 0.2 s, then a second of rest


class Process:
    """A running ``python -m tests.rig.wires.server``; it outlives a killed host until the table is at rest."""

    def __init__(
        self,
        rig: RigSettings,
        folder: Path | None = None,
        seed: int = 0,
        faults: Sequence[str] = (),
        real_time: bool = False,
        black_box: str | Path | None = None,
        chip: tuple[str | Path, str | Path] | None = None,
    ) -> None:
        with tempfile.TemporaryDirectory(prefix="dampyr-rig-") as made:
            specimen_of(rig, folder).save(Path(made) / "card.toml")
            settings = replace(rig, specimen=replace(rig.specimen, card="card.toml"))
            path = write_settings(settings, Path(made) / "rig.toml")
            command = [
                sys.executable,
                "-m",
                "tests.rig.wires.server",
                "--once",
                "--seed",
                str(seed),
                "--rig",
                str(path),
            ]
            command += [word for fault in faults for word in ("--fault", str(fault))]
            command += ["--real-time"] if real_time else []
            command += ["--black-box", str(black_box)] if black_box is not None else []
            command += ["--terminal", "--chip", *map(str, chip)] if chip is not None else []
            self._process = subprocess.Popen(
                command,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                start_new_session=True,
                env=os.environ | {"PYTHONPATH": str(ROOT)},
            )
            assert self._process.stdout is not None
            line = self._process.stdout.readline()
        if not line:
            assert self._process.stderr is not None
            output = self._process.stderr.read().strip().splitlines()
            self.close()
            raise RigFault(f"the simulated rig did not start: {output[-1] if output else 'it printed nothing'}")
        self.wires: dict[str, str] = json.loads(line)
        """The settings of ``[wires]`` that lead to it."""

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._process.pid

    def close(self) -> None:
        """Wait until the rig has come to rest and its process has ended."""
        try:
            self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.terminate()
            self._process.wait()
        for stream in (self._process.stdout, self._process.stderr):
            if stream is not None:
                stream.close()


class ThreadServer:
    """The same wires, served by threads of this process: no interpreter is started."""

    def __init__(self, rig: RigSettings, folder: Path | None = None, seed: int = 0, faults: Sequence[str] = ()) -> None:
        from tests.rig.wires import daqmx_service

        self._clock = Clock(Simulator(rig, seed, parse_faults(faults), specimen_of(rig, folder)), EventFile(None))
        self.wires: dict[str, str] = serial_wire.serve(self._clock) | daqmx_service.serve(self._clock)
        """The settings of ``[wires]`` that lead to it."""
        self._clock.start()

    def close(self) -> None:
        """End the server."""
        self._clock.finished.set()
        self._clock.thread.join()
        for end in self._clock.on_end:
            end()


def open_wired(wired: RigSettings) -> tuple[Uno, NiBoard]:
    """The drivers at the wires of a simulated rig, which may answer late."""
    return Uno(open_wire(wired.wires.serial, wired.wires.baud), wait=0.25, tries=20), NiBoard(wired)


def over_wires(
    settings: RigSettings | str | Path | None = None,
    seed: int = 0,
    faults: Sequence[str] = (),
    black_box: str | Path | None = None,
    parts: RigSettings | None = None,
    chip: tuple[str | Path, str | Path] | None = None,
) -> Rig:
    """A rig in lockstep behind its wires: its time passes while it is read, or by itself where nobody does.

    It is in a process of its own. The arguments are those of `dampyr.rig.simulated`.
    """
    rig, true, folder = _settings_of(settings, parts)
    return _connected(rig, folder, Process(true, folder, seed, faults, black_box=black_box, chip=chip))


def over_wires_here(
    settings: RigSettings | str | Path | None = None,
    seed: int = 0,
    faults: Sequence[str] = (),
    parts: RigSettings | None = None,
) -> Rig:
    """The same, with the other end of the wires in threads of this process."""
    rig, true, folder = _settings_of(settings, parts)
    return _connected(rig, folder, ThreadServer(true, folder, seed, faults))


def _settings_of(
    settings: RigSettings | str | Path | None, parts: RigSettings | None
) -> tuple[RigSettings, RigSettings, Path | None]:
    """What the rig's host takes it for, what it really is, and the folder of its file."""
    path = None if settings is None or isinstance(settings, RigSettings) else Path(settings)
    rig = load_settings(path) if path is not None else settings or RigSettings()
    assert isinstance(rig, RigSettings)
    folder = None if path is None else path.parent
    true = rig if parts is None else replace(parts, wires=rig.wires, board=rig.board, limits=rig.limits)
    return rig, true, folder


def _connected(rig: RigSettings, folder: Path | None, process: Process | ThreadServer) -> Rig:
    """A host of the rig at the other end of the wires."""
    try:
        wired = replace(rig, wires=replace(rig.wires, **process.wires))
        uno, board = open_wired(_calibrated(wired, folder))
        return Rig(
            rig,
            uno,
            board,
            threaded=False,
            folder=folder,
            on_close=[process.close],
            damper_persists=False,
            simulated=True,
        )
    except BaseException:
        process.close()
        raise
