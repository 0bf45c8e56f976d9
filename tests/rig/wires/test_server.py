"""The simulated rig as a process, driven by the real clients: pyserial and nidaqmx."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.rig.simulation.driver import PROMPT, Host, sine
from tests.rig.wires import clock, daqmx_service, serial_wire, server

from dampyr.rig import RigSettings
from dampyr.rig.firmware.protocol import Reader, Request, State
from dampyr.rig.settings_file import write_settings

grpc = pytest.importorskip("grpc", reason="the extra rig is not installed: pip install dampyr[rig]")
nidaqmx = pytest.importorskip("nidaqmx", reason="the extra rig is not installed: pip install dampyr[rig]")
serial = pytest.importorskip("serial", reason="the extra rig is not installed: pip install dampyr[rig]")
Start = Callable[..., "Served"]


class Served:
    """A rig behind its wires, in threads of this process or in one of its own, and its clients."""

    def __init__(self, box: Path, *options: str, process: bool = False) -> None:
        self.box, self.tasks, self.channel, self.wire = box, [], None, None
        if not process:
            self.clock = server.build_clock(server.parse_options(["--black-box", str(box), *options]))
            self.where = serial_wire.serve(self.clock) | daqmx_service.serve(self.clock)
            self.clock.start()
            return
        self.clock = None
        command = [sys.executable, "-m", "tests.rig.wires.server", "--black-box", str(box), *options]
        path = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])}
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=path)
        assert self.process.stdout is not None
        self.where = json.loads(self.process.stdout.readline())

    def host(self) -> Host:
        """A host on the serial wire."""
        self.wire = serial.serial_for_url(self.where["serial"], baudrate=250000, timeout=5)

        def ask(data: bytes) -> bytes:
            self.wire.write(data)
            said, reader = b"", Reader()
            while not reader.feed(said):
                some = self.wire.read(max(1, self.wire.in_waiting))
                assert some, "no reply"
                said, reader = said + some, Reader()
            return said

        return Host(ask)

    def task(self) -> Any:
        """A task of nidaqmx on the gRPC wire."""
        if self.channel is None:
            self.channel = grpc.insecure_channel(self.where["grpc"])
        self.tasks.append(nidaqmx.Task(grpc_options=nidaqmx.GrpcSessionOptions(self.channel, "")))
        return self.tasks[-1]

    def sampled(self, rate: float = 1000.0) -> tuple[Any, Any]:
        """The analogue input and the encoder on one clock, not started."""
        from nidaqmx.constants import AcquisitionType, EncoderType, LengthUnits, TerminalConfiguration

        force, place = self.task(), self.task()
        force.ai_channels.add_ai_voltage_chan(
            "Dev1/ai0", terminal_config=TerminalConfiguration.DIFF, min_val=-10, max_val=10
        )
        place.ci_channels.add_ci_lin_encoder_chan(
            "Dev1/ctr0",
            decoding_type=EncoderType.X_4,
            units=LengthUnits.METERS,
            dist_per_pulse=20e-6,
            initial_pos=0.001,
        )
        clock = {"sample_mode": AcquisitionType.CONTINUOUS, "samps_per_chan": 10000}
        force.timing.cfg_samp_clk_timing(rate, **clock)
        place.timing.cfg_samp_clk_timing(rate, source="/Dev1/ai/SampleClock", **clock)
        return force, place

    def command(self) -> Any:
        """The analogue output."""
        output = self.task()
        output.ao_channels.add_ao_voltage_chan("Dev1/ao0", min_val=-10, max_val=10)
        return output

    @property
    def events(self) -> list[tuple[float, str]]:
        """The black box."""
        lines = map(json.loads, self.box.read_text("utf-8").splitlines())
        return [(line["time"], line["event"]) for line in lines]

    def leave(self) -> None:
        """Close what is open."""
        for task in self.tasks:
            with suppress(nidaqmx.errors.RpcError):  # where the process has ended
                task.close()
        self.tasks = []
        for end in (self.wire, self.channel):
            if end is not None:
                end.close()
        self.wire = self.channel = None

    def end(self) -> None:
        self.leave()
        if self.clock is not None:
            self.clock.finished.set()
            self.clock.thread.join()
            for end in self.clock.on_end:
                end()
            return
        self.process.terminate()
        self.process.wait(20)
        assert self.process.stdout is not None
        self.process.stdout.close()


@pytest.fixture
def serve(tmp_path: Path) -> Iterator[Start]:
    made: list[Served] = []

    def start(*options: str, process: bool = False) -> Served:
        made.append(Served(tmp_path / f"box{len(made)}.jsonl", *options, process=process))
        return made[-1]

    yield start
    for each in made:
        each.end()


def when(rig: Served, event: str, after: float = 0.0) -> float:
    """When something happened, waiting for it."""
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline:
        times = [t for t, words in rig.events if words == event and t >= after]
        if times:
            return times[0]
        time.sleep(0.02)
    raise AssertionError(f"no {event!r} in {rig.events}")


def moving(rig: Served, host: Host, blocks: int) -> tuple[np.ndarray, np.ndarray]:
    """Follow a sine, sampled in blocks of 40 ms through the stream readers."""
    from nidaqmx.stream_readers import AnalogMultiChannelReader, CounterReader

    force, place = rig.sampled()
    host.arm()
    rig.command().write(0.8712, auto_start=True)
    points = sine(0.008, 1.0, 20, 0.01)
    host.feed(points)
    host.done(Request.FOLLOW, 10, len(points))
    place.start()
    force.start()
    volts, metres = np.empty((1, 40 * blocks)), np.empty(40 * blocks)
    reads, counts = AnalogMultiChannelReader(force.in_stream), CounterReader(place.in_stream)
    for k in range(blocks):
        some, others = np.empty((1, 40)), np.empty(40)
        assert reads.read_many_sample(some, 40, 2.0) == 40
        assert counts.read_many_sample_double(others, 40, 2.0) == 40
        volts[:, 40 * k : 40 * k + 40], metres[40 * k : 40 * k + 40] = some, others
        host.feed(points)
    return volts[0], metres


def test_the_real_clients_see_what_the_simulator_in_process_gives(serve: Start, tmp_path: Path) -> None:
    from tests.rig.simulation.driver import rig as in_process

    write_settings(RigSettings(uno=PROMPT), tmp_path / "rig.toml")
    served = serve("--seed", "1", "--rig", str(tmp_path / "rig.toml"))
    host = served.host()
    volts, metres = moving(served, host, 50)
    assert host.beat.state == State.FOLLOWING
    made, other = in_process()
    made.advance_to(0.001)
    other.arm()
    made.write(0.8712)
    points = sine(0.008, 1.0, 20, 0.01)
    other.feed(points)
    other.done(Request.FOLLOW, 10, len(points))
    made.start(1000.0)
    expected, counts = [], []
    for _ in range(50):
        v, c = made.read(40)
        expected.append(v[0])
        counts.append(c)
        other.feed(points)
    np.testing.assert_array_equal(volts, np.concatenate(expected))
    np.testing.assert_allclose(metres, 0.001 + 5e-6 * np.concatenate(counts), atol=1e-12)
    assert np.ptp(metres) > 0.014


def test_the_device_says_what_it_is_and_refuses_the_rest_clearly(serve: Start) -> None:
    served = serve()
    task = served.task()
    system = nidaqmx.system.System.remote(nidaqmx.GrpcSessionOptions(served.channel, ""))
    (device,) = system.devices
    assert (device.name, device.product_type, device.is_simulated) == ("Dev1", "PCI-6221", True)
    assert device.serial_num > 0
    with pytest.raises(nidaqmx.DaqError) as problem:
        task.ai_channels.add_ai_voltage_chan("Dev1/ai7")
    assert problem.value.error_code == -200170
    task.ao_channels.add_ao_voltage_chan("Dev1/ao0", min_val=-5, max_val=5)
    with pytest.raises(nidaqmx.DaqError, match="leave the channel's limits") as problem:
        task.write(5.1, auto_start=True)
    assert problem.value.error_code == -200561
    from nidaqmx._stubs import nidaqmx_pb2, nidaqmx_pb2_grpc

    with pytest.raises(grpc.RpcError) as refusal:
        nidaqmx_pb2_grpc.NiDAQmxStub(served.channel).SelfTestDevice(
            nidaqmx_pb2.SelfTestDeviceRequest(device_name="Dev1")
        )
    assert refusal.value.code() == grpc.StatusCode.UNIMPLEMENTED
    assert refusal.value.details() == "the simulated board does not answer SelfTestDevice"


def test_a_single_value_and_a_counter_in_ticks_without_a_clock(serve: Start) -> None:
    served = serve()
    host = served.host()
    force = served.task()
    force.ai_channels.add_ai_voltage_chan("Dev1/ai0")
    assert force.read() * 613.0 == pytest.approx(134.0, abs=3.0)
    host.arm()
    host.done(Request.JOG, -2000, 300)
    for _ in range(25):
        host.wait()
    from nidaqmx.constants import LengthUnits

    place = served.task()
    place.ci_channels.add_ci_lin_encoder_chan("Dev1/ctr0", units=LengthUnits.TICKS)
    assert place.read() == pytest.approx(host.beat.position, abs=1)


def test_errors_of_the_board_arrive_as_nidaqmx_errors(serve: Start) -> None:
    served = serve("--fault", "board-timeout@0.2s for 100ms", "--fault", "board-overrun@0.5s")
    force, place = served.sampled()
    place.start()
    with pytest.raises(nidaqmx.DaqError) as early:
        place.read(10)
    assert early.value.error_code == -200284  # nobody clocks the counter yet
    force.start()
    seen = []
    for _ in range(20):
        try:
            force.read(40)
        except nidaqmx.DaqError as problem:
            seen.append(problem.error_code)
    assert seen[0] == -200284
    assert -200279 in seen


@pytest.mark.prove
def test_when_the_client_leaves_the_rig_runs_on_alone_and_ends(serve: Start) -> None:
    served = serve("--once", process=True)
    host = served.host()
    moving(served, host, 20)
    served.wire.close()
    served.wire = None
    left = when(served, "serial closed")
    assert when(served, "firmware fault HEARTBEAT") - left < 0.2
    assert when(served, "enable low") - left < 0.2
    assert when(served, "at rest", left) - left < 0.3
    assert when(served, "coil dead", left) - left < 0.3
    assert served.process.wait(30) == 0
    assert served.events[-1][1] == "ends"


def test_a_killed_client_leaves_a_dead_coil_and_a_table_at_rest(serve: Start, tmp_path: Path) -> None:
    served = serve()
    code = (
        "import sys, time\n"
        "from pathlib import Path\n"
        "from tests.rig.wires.test_server import Served, moving\n"
        "rig = Served.__new__(Served)\n"
        "import json\n"
        "rig.where, rig.tasks, rig.channel = json.loads(sys.argv[1]), [], None\n"
        "moving(rig, rig.host(), 20)\n"
        "print('moving', flush=True)\n"
        "time.sleep(60)\n"
    )
    root = Path(__file__).resolve().parents[3]
    client = subprocess.Popen(
        [sys.executable, "-c", code, json.dumps(served.where)],
        cwd=root,
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(root), str(root / "src")])},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert client.stdout is not None
    assert client.stdout.readline() == "moving\n"
    client.send_signal(signal.SIGKILL if sys.platform != "win32" else signal.SIGTERM)
    client.wait()
    client.stdout.close()
    left = when(served, "serial closed")
    assert when(served, "at rest", left - 0.6) - left < 0.3
    assert when(served, "coil dead", left - 0.6) - left < 0.3
    assert served.host().beat.state == State.FAULT  # the next host is let in, and is told


def test_silence_and_the_watchdog_acts(serve: Start, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clock, "SILENCE", 0.3)
    served = serve()
    host = served.host()
    host.arm()
    when(served, "silence: runs on alone")
    when(served, "firmware fault HEARTBEAT")
    assert host.beat.state == State.FAULT


def test_a_second_client_is_turned_away(serve: Start) -> None:
    served = serve()
    host = served.host()
    other = socket.create_connection(("127.0.0.1", int(served.where["serial"].rpartition(":")[2])))
    assert other.recv(10) == b""
    other.close()
    assert host.ask(Request.HELLO, 3).values[0] == 3


@pytest.mark.by_hand
def test_in_real_time_the_walls_clock_moves_it(serve: Start) -> None:
    served = serve("--real-time", process=True)
    host = served.host()
    host.ask(Request.HELLO, 3)
    before, start = host.beat.time, time.monotonic()
    time.sleep(0.5)
    after, end = host.beat.time, time.monotonic()
    assert after - before == pytest.approx((end - start) * 1e3, abs=150)
    force, _ = served.sampled()
    force.start()
    start = time.monotonic()
    assert len(force.read(300, timeout=10.0)) == 300
    assert time.monotonic() - start > 0.25
    with pytest.raises(nidaqmx.DaqError):
        force.read(1000, timeout=0.05)


@pytest.mark.parametrize(
    ("options", "words"),
    [(["--fault", "stuck-encodr@1s"], "did you mean"), (["--rig", "nowhere.toml"], "there is no such file")],
)
def test_a_wrong_command_line_is_a_sentence(options: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert server.main(options) == 2
    assert words in capsys.readouterr().err


def test_the_rigs_card_lies_beside_its_settings(tmp_path: Path) -> None:
    from dampyr.models import Damper

    Damper("dahl", {"dahl.kx": 1e3, "dahl.kw": 100.0, "dahl.rho": 1e3}).save(tmp_path / "mine.toml")
    (tmp_path / "rig.toml").write_text('[specimen]\ncard = "mine.toml"\n')
    clock = server.build_clock(server.parse_options(["--rig", str(tmp_path / "rig.toml")]))
    assert clock.rig.specimen.composition.names == ("dahl",)
