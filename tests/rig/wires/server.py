"""Server of the simulated rig behind the wires of a real one: ``python -m tests.rig.wires.server --rig rig.toml --seed 0``.

It prints one line of JSON when it is ready, the settings of ``[wires]`` that lead to it, such as
``{"serial": "socket://127.0.0.1:PORT", "grpc": "127.0.0.1:PORT"}``: the Uno's serial wire for pyserial and NI-DAQmx's gRPC
device server for nidaqmx. Both listen on the loopback only. It outlives a host that is killed.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from tests.rig.wires import daqmx_service, serial_wire
from tests.rig.wires.clock import Clock

from dampyr.errors import DampyrError
from dampyr.models import Damper
from dampyr.rig.gc_control import freeze_objects
from dampyr.rig.priority import raise_priority
from dampyr.rig.settings import RigSettings, load_settings
from dampyr.rig.simulation.event_log import EventFile
from dampyr.rig.simulation.faults import FaultSpec
from dampyr.rig.simulation.simulator import Simulator
from dampyr.rig.specimen import specimen_of


def parse_options(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.rig.wires.server", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("--rig", metavar="FILE", help="the rig's settings; without it, the original rig's")
    parser.add_argument("--seed", type=int, default=0, help="of noise and lost bytes")
    parser.add_argument("--real-time", action="store_true", help="the rig follows the wall clock, not its host")
    parser.add_argument("--fault", action="append", default=[], metavar="KIND@TIME [for TIME]", help="may be repeated")
    parser.add_argument("--terminal", action="store_true", help="the serial wire is a pseudo-terminal")
    parser.add_argument(
        "--chip",
        nargs=2,
        metavar=("PROGRAM", "ELF"),
        help="the firmware's binary, and the program that runs it in simavr, in place of the firmware's model",
    )
    parser.add_argument("--black-box", metavar="FILE", help="a line of JSON per event")
    parser.add_argument(
        "--once", action="store_true", help="end when the last client has disconnected and the table is at rest"
    )
    return parser.parse_args(arguments)


def build_clock(parsed: argparse.Namespace) -> Clock:
    """The rig of the command line."""
    folder = Path(parsed.rig).parent if parsed.rig else None
    settings = load_settings(parsed.rig) if parsed.rig else RigSettings()
    faults = [FaultSpec.parse(text) for text in parsed.fault]
    specimen = specimen_of(settings, folder)
    event_log = EventFile(parsed.black_box)
    _warm_up(settings, specimen)
    rig = Simulator(settings, parsed.seed, faults, specimen, on_event=event_log, chip=parsed.chip)
    return Clock(rig, event_log, parsed.real_time, parsed.once, parsed.terminal)


def _warm_up(settings: RigSettings, specimen: Damper) -> None:
    """Compile and import what the first samples need: a waiting host gives up after 80 ms."""
    other = Simulator(settings, 0, (), specimen)
    other.start(settings.board.rate)
    other.advance_to(0.05)


def main(arguments: Sequence[str] | None = None) -> int:
    """Serve until interrupted, or as ``--once`` says; 2 with a sentence where the command line is wrong."""
    parsed = parse_options(arguments)
    try:
        clock = build_clock(parsed)
    except DampyrError as problem:
        print(problem, file=sys.stderr)
        return 2
    if parsed.real_time:
        raise_priority()  # it stands for hardware, which waits for nobody; before its threads, which inherit it
    try:
        wires = serial_wire.serve(clock) | daqmx_service.serve(clock)
    except DampyrError as problem:
        print(problem, file=sys.stderr)
        return 2
    freeze_objects()
    clock.start()
    print(json.dumps(wires), flush=True)
    try:
        clock.finished.wait()
    except KeyboardInterrupt:
        clock.log("interrupted")
    for end in clock.on_end:
        end()
    return 0


if __name__ == "__main__":
    sys.exit(main())
