"""Process of the simulated rig: start, wires, end."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, replace
from importlib.util import find_spec
from pathlib import Path

import tomli_w

from dampyr.errors import RigFault, install_line
from dampyr.models import Damper
from dampyr.rig.settings import RigSettings
from dampyr.rig.simulation.faults import FaultSpec
from dampyr.rig.simulation.shared_clock import SharedClock

# by what people install: what is imported
NEEDED = {"pyserial": "serial"}
NEEDED_BY_NI = {"nidaqmx[grpc]": "nidaqmx", "grpcio": "grpc"}
PATIENCE = 5.0  # s for a rig without a host to come to rest: the watchdog stops it within 0.2 s, then a second of rest


class Process:
    """A running ``python -m dampyr.rig.simulation.server``; it outlives a killed host until the table is at rest."""

    def __init__(
        self,
        rig: RigSettings,
        specimen: Damper,
        seed: int,
        faults: Sequence[FaultSpec],
        real_time: bool,
        black_box: str | Path | None,
        chip: tuple[str | Path, str | Path] | None = None,
    ) -> None:
        needed = NEEDED | (NEEDED_BY_NI if rig.wires.acquisition == "ni-daqmx" else {})
        if absent := [library for library, module in needed.items() if find_spec(module) is None]:
            raise RigFault(
                f"the simulated rig needs {' and '.join(absent)} for its wires; install the extra: {install_line('rig')}, "
                "or simulate it without them (--in-process, in_process=True)"
            )
        self.clock: SharedClock | None = None
        """By how much it was held back, of one in real time."""
        self._clock_folder = tempfile.mkdtemp(prefix="dampyr-clock-") if real_time else None
        with tempfile.TemporaryDirectory(prefix="dampyr-rig-") as folder:
            specimen.save(Path(folder) / "card.toml")
            settings = replace(rig, specimen=replace(rig.specimen, card="card.toml"))
            path = Path(folder) / "rig.toml"
            path.write_text(tomli_w.dumps(asdict(settings)), "utf-8")
            command = [sys.executable, "-m", "dampyr.rig.simulation.server", "--once", "--seed", str(seed)]
            command += ["--rig", str(path), *(word for fault in faults for word in ("--fault", str(fault)))]
            if self._clock_folder is not None:
                self.clock = SharedClock(Path(self._clock_folder) / "clock")
                command += ["--real-time", "--shared-clock", str(self.clock.path)]
            command += ["--black-box", str(black_box)] if black_box is not None else []
            command += ["--terminal", "--chip", *map(str, chip)] if chip is not None else []
            self._process = subprocess.Popen(
                command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
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
        if self._clock_folder is not None:
            shutil.rmtree(self._clock_folder, ignore_errors=True)
