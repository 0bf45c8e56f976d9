"""Server of the simulated rig, a process of its own: ``python -m dampyr.rig.simulation.server --rig rig.toml --seed 0``.

It prints one line of JSON when it is ready, ``{"serial": "socket://127.0.0.1:PORT", "grpc": "127.0.0.1:PORT"}``: the Uno's
serial wire for pyserial, and NI-DAQmx's gRPC device server for nidaqmx. Both listen on the loopback only. Needs the extra
``rig``.
"""

from __future__ import annotations

import argparse
import json
import socket
import sys
from collections.abc import Sequence
from pathlib import Path
from threading import Thread

from dampyr.errors import DampyrError
from dampyr.models import Damper
from dampyr.rig.gc_control import freeze_objects
from dampyr.rig.priority import raise_priority
from dampyr.rig.settings import RigSettings, load_settings
from dampyr.rig.simulation.clock import Clock, EventLog
from dampyr.rig.simulation.faults import FaultSpec
from dampyr.rig.simulation.simulator import Simulator
from dampyr.rig.specimen import specimen_of


class Serial:
    """The Uno's serial wire as a TCP port for one client at a time; others are refused."""

    def __init__(self, clock: Clock) -> None:
        self.clock, self.busy = clock, False
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self.listener.getsockname()[1]
        Thread(target=self._accept, name="serial", daemon=True).start()

    def _accept(self) -> None:
        while True:
            client, _ = self.listener.accept()
            if self.busy:
                client.close()
                continue
            self.busy = True
            self.clock.client_connected()
            Thread(target=self._serve, args=(client,), name="client", daemon=True).start()

    def _serve(self, client: socket.socket) -> None:
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            while data := client.recv(4096):
                with self.clock.locked() as rig:
                    reply = rig.serial(data)
                client.sendall(reply)
        except OSError:
            pass  # a killed client resets the connection: it has disconnected, as below
        finally:
            self.busy = False
            self.clock.client_disconnected()
            client.close()


def parse_options(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="python -m dampyr.rig.simulation.server", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("--rig", metavar="FILE", help="the rig's settings; without it, the original rig's")
    parser.add_argument("--seed", type=int, default=0, help="of noise and lost bytes")
    parser.add_argument("--real-time", action="store_true", help="the rig follows the wall clock, not its host")
    parser.add_argument("--fault", action="append", default=[], metavar="KIND@TIME [for TIME]", help="may be repeated")
    parser.add_argument("--black-box", metavar="FILE", help="a line of JSON per event")
    parser.add_argument(
        "--once", action="store_true", help="end when the last client has disconnected and the table is at rest"
    )
    return parser.parse_args(arguments)


def build_clock(parsed: argparse.Namespace) -> Clock:
    """The rig of the command line."""
    settings = load_settings(parsed.rig) if parsed.rig else RigSettings()
    faults = [FaultSpec.parse(text) for text in parsed.fault]
    specimen = specimen_of(settings, Path(parsed.rig).parent if parsed.rig else None)
    event_log = EventLog(parsed.black_box)
    _warm_up(settings, specimen)
    rig = Simulator(settings, parsed.seed, faults, specimen, on_event=event_log)
    return Clock(rig, event_log, parsed.real_time, parsed.once)


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
    from dampyr.rig.simulation.daqmx_service import serve

    server, port = serve(clock)
    serial = Serial(clock)
    freeze_objects()
    clock.start()
    print(json.dumps({"serial": f"socket://127.0.0.1:{serial.port}", "grpc": f"127.0.0.1:{port}"}), flush=True)
    try:
        clock.finished.wait()
    except KeyboardInterrupt:
        clock.log("interrupted")
    server.stop(0.2).wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())
