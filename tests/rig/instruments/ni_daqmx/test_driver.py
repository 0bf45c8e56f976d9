"""The NI board's driver, against the simulated board over its real wire and against drivers that are not there."""

from __future__ import annotations

import ctypes.util
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from tests.rig.wires.clock import Clock
from tests.rig.wires.serial_wire import Serial

from dampyr.cli import cli
from dampyr.errors import RigFault
from dampyr.rig import Rig, RigSettings
from dampyr.rig.diagnosis import diagnose
from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import InProcess
from dampyr.rig.instruments.ni_daqmx.driver import NiBoard, signed
from dampyr.rig.settings import BoardSettings, Supply
from dampyr.rig.simulation.event_log import EventFile
from dampyr.rig.simulation.simulator import Simulator

nidaqmx = pytest.importorskip("nidaqmx", reason="the extra rig is not installed: pip install dampyr[rig]")
pytest.importorskip("grpc", reason="the extra rig is not installed: pip install dampyr[rig]")

Open = Callable[..., tuple[NiBoard, Clock]]


@pytest.fixture
def connect() -> Iterator[Open]:
    """A driver and the simulated board at the other end of its wire, both in this process."""
    from tests.rig.wires.daqmx_service import start_server

    ends: list[Callable[[], Any]] = []

    def open_board(settings: RigSettings | None = None, real_time: bool = False) -> tuple[NiBoard, Clock]:
        settings = settings or RigSettings()
        clock = Clock(Simulator(settings), EventFile(None), real_time)
        if real_time:
            clock.start()
            ends.append(clock.finished.set)
        server, port = start_server(clock)
        ends.append(lambda: server.stop(0.1).wait())
        board = NiBoard(replace(settings, wires=replace(settings.wires, grpc=f"127.0.0.1:{port}")))
        ends.append(board.close)
        return board, clock

    yield open_board
    for end in reversed(ends):
        end()


def test_the_command_and_the_samples_go_over_the_wire(connect: Open) -> None:
    board, clock = connect()
    board.start(1000.0, np.full(80, 1.0))
    volts, counts = board.read(40)
    assert volts.shape == (1, 40)
    assert counts.shape == (40,)
    assert clock.rig.command == pytest.approx(1.0, abs=1e-3)
    board.queue(np.full(40, 2.0))
    board.read(60)
    assert clock.rig.command == pytest.approx(2.0, abs=1e-3)
    assert board.index_counts().size == 0
    board.write(0.0)
    assert clock.rig.command == 0.0
    board.write(0.5)
    assert clock.rig.command == pytest.approx(0.5, abs=1e-3)
    board.stop()
    board.start(1000.0, np.zeros(80))  # what the static command held is free again


def test_the_buffer_of_the_command_has_places_to_spare(connect: Open) -> None:
    board, _clock = connect()
    board.start(1000.0, np.zeros(200))
    board.queue(np.zeros(800))  # a second of them; with the size of the first write not one would fit
    with pytest.raises(RigFault, match="the command's buffer on the board Dev1 is full"):
        board.queue(np.zeros(1))
    board.read(40)
    board.queue(np.zeros(40))


def test_a_full_buffer_holds_up_nobody_for_longer_than_a_block(connect: Open, monkeypatch: pytest.MonkeyPatch) -> None:
    waits: list[float] = []
    board, _clock = connect(real_time=True)
    space = Clock.space
    monkeypatch.setattr(Clock, "space", lambda self, size, n, wait: (waits.append(wait), space(self, size, n, wait))[1])
    board.start(1000.0, np.zeros(200))
    with pytest.raises(RigFault, match="is full"):
        board.queue(np.zeros(5000))
    assert waits == [board.rig.board.block]


@pytest.mark.parametrize("volts", [-0.1, 5.6, float("nan")])
def test_a_command_that_the_supply_may_not_be_given_is_refused_in_words(connect: Open, volts: float) -> None:
    board, clock = connect()
    words = "outside of the supply's 0 to 5.5 V"
    with pytest.raises(RigFault, match=words):
        board.start(1000.0, np.full(80, volts))
    board.start(1000.0, np.zeros(80))
    with pytest.raises(RigFault, match=words):
        board.queue(np.array([0.0, volts]))
    with pytest.raises(RigFault, match=words):
        board.write(volts)
    board.queue(np.array([5.5]))  # nothing of what was refused has been taken
    board.read(80)
    assert clock.rig.command == 0.0
    board.write(5.5)
    assert clock.rig.command == pytest.approx(5.5, abs=1e-3)


@pytest.mark.parametrize(
    ("supply", "top"), [(Supply(gain=2.0), 2.75), (Supply(gain=0.1), 10.0), (Supply(max_voltage=5.0), 6.25)]
)
def test_the_output_is_set_up_for_no_more_than_the_supply_needs(connect: Open, supply: Supply, top: float) -> None:
    settings = RigSettings(supply=supply)
    assert settings.command_range == (0.0, top)
    board, clock = connect(settings)
    board.start(1000.0, np.zeros(80))
    board.write(top)
    assert clock.rig.command == pytest.approx(top, abs=1e-3)


def test_the_driver_itself_refuses_what_gets_past_the_check(connect: Open, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(NiBoard, "_check", lambda self, volts: None)
    board, _clock = connect()
    board.start(1000.0, np.zeros(80))
    for call in (lambda: board.queue(np.full(40, 6.0)), lambda: board.write(-1.0)):
        with pytest.raises(RigFault, match="too large or too small"):
            call()


def test_pulses_on_the_encoders_lines_are_filtered(connect: Open) -> None:
    from tests.rig.wires import daqmx_service

    seen: list[daqmx_service.Board] = []
    made = daqmx_service.Board.__init__

    def remember(self: Any, clock: Clock) -> None:
        made(self, clock)
        seen.append(self)

    daqmx_service.Board.__init__ = remember  # type: ignore[method-assign]
    try:
        for width in (6.425e-6, 125e-9, 0.0):
            board, _ = connect(RigSettings(board=BoardSettings(encoder_filter=width)))
            board.start(1000.0, np.zeros(80))
            filters = {name: task.filters for name, task in seen[-1].tasks.items()}
            each = {"width": pytest.approx(width), "enable": 1.0}
            lines = {"a": each, "b": each} if width else {}
            assert filters["counter"] == lines
            assert filters["index"] == (lines | {"z": each} if width else {})
            assert seen[-1].tasks["index"].lines == {"a": "pfi8", "b": "pfi10", "z": "pfi9" if width else "pfi4"}
    finally:
        daqmx_service.Board.__init__ = made  # type: ignore[method-assign]


def test_a_filter_that_the_board_does_not_have_is_refused_before_anything_starts(connect: Open) -> None:
    board, clock = connect(RigSettings(board=BoardSettings(encoder_filter=1e-6)))
    with pytest.raises(RigFault, match="minimum pulse width"):
        board.start(1000.0, np.zeros(80))
    assert not clock.rig.sampling


def test_counts_below_zero_and_at_both_wraps() -> None:
    ticks = np.array([0, 1, 2**32 - 1, 2**32 - 2, 2**31 - 1, 2**31], np.uint32)
    assert signed(ticks).tolist() == [0, 1, -1, -2, 2**31 - 1, -(2**31)]


def test_counts_go_below_zero_over_the_wire(connect: Open) -> None:
    board, clock = connect()
    board.start(1000.0, np.zeros(200))
    board.read(40)
    from dampyr.rig.simulation import plant

    clock.rig.counters[plant.N_NI] -= 3
    _, counts = board.read(40)
    assert counts[-1] == -3


def test_only_a_board_that_the_driver_calls_real_measures(connect: Open, monkeypatch: pytest.MonkeyPatch) -> None:
    board, clock = connect()
    assert board.origin() == "simulated"  # NI-DAQmx says so of its device, by IS_SIMULATED
    rig = Rig(board.rig, Uno(InProcess(clock.rig.serial)), board, threaded=False)
    assert rig.origin.kind == "simulated"
    monkeypatch.setattr("nidaqmx.system.Device.is_simulated", property(lambda device: False))
    monkeypatch.setattr("nidaqmx.system.Device.serial_num", property(lambda device: 0x01B00000))
    assert board.origin() == "measured"
    real = Rig(board.rig, Uno(InProcess(clock.rig.serial)), board, threaded=False)
    assert real.origin.kind == "measured"
    assert replace(real, simulated=True).origin.kind == "simulated"  # whatever the driver says of a simulated rig


def test_a_driver_that_does_not_say_it_measures_nothing(connect: Open) -> None:
    class Own:
        """A board of another laboratory."""

        def identity(self) -> str:
            return "OUR-BOARD 7"

    clock = connect()[1]
    rig = Rig(RigSettings(), Uno(InProcess(clock.rig.serial)), Own(), threaded=False)  # type: ignore[arg-type]
    assert rig.origin.kind == "not stated"


def test_listening_is_no_error_where_the_output_runs_out(connect: Open) -> None:
    board, clock = connect()
    rig = Rig(board.rig, Uno(InProcess(clock.rig.serial)), board, threaded=False)
    for _ in range(2):
        rig.listen(0.1)
    board.start(1000.0, np.zeros(10))
    board.read(50)
    with pytest.raises(
        RigFault, match=r"has run out \(error -200290\): the host was held up"
    ):  # but it is one where the command is to go on
        board.queue(np.zeros(10))
    board.stop()
    board.write(0.0)
    assert clock.rig.command == 0.0


def test_the_coil_is_cut_by_an_abort_and_one_write(connect: Open, monkeypatch: pytest.MonkeyPatch) -> None:
    from nidaqmx._grpc_interpreter import GrpcStubInterpreter

    calls: list[str] = []
    invoke = GrpcStubInterpreter._invoke

    def record(self: Any, func: Any, request: Any, metadata: Any = None) -> Any:
        calls.append(type(request).__name__.removesuffix("Request"))
        return invoke(self, func, request, metadata)

    board, clock = connect()
    board.start(1000.0, np.full(200, 3.0))
    board.read(40)
    monkeypatch.setattr(GrpcStubInterpreter, "_invoke", record)
    board.write(0.0)
    assert calls[:2] == ["TaskControl", "WriteAnalogScalarF64"]
    assert clock.rig.command == 0.0
    board.read(40)
    assert clock.rig.command == 0.0


def test_a_timed_command_that_cannot_be_aborted_is_closed(connect: Open, monkeypatch: pytest.MonkeyPatch) -> None:
    board, clock = connect()
    board.start(1000.0, np.full(200, 3.0))
    board.read(40)

    def refuse(self: Any, action: Any) -> None:
        raise nidaqmx.DaqError("no", -200088)

    monkeypatch.setattr(nidaqmx.Task, "control", refuse)
    board.write(0.0)
    assert clock.rig.command == 0.0


def test_all_tasks_are_closed_although_one_fails(connect: Open, monkeypatch: pytest.MonkeyPatch) -> None:
    board, _clock = connect()
    board.start(1000.0, np.zeros(80))
    close = nidaqmx.Task.close

    def fail(task: Any) -> None:
        first = task is board_inputs
        close(task)
        if first:
            raise nidaqmx.DaqError("it is stuck", -50150)

    board_inputs = board._tasks["inputs"]
    with monkeypatch.context() as patch:
        patch.setattr(nidaqmx.Task, "close", fail)
        with pytest.raises(RigFault, match="it is stuck"):
            board.stop()
    assert not board._tasks
    board.start(1000.0, np.zeros(80))


def without_wires() -> NiBoard:
    return NiBoard(RigSettings())


def each_call(board: NiBoard) -> list[Callable[[], object]]:
    """What touches the driver first."""
    return [board.identity, lambda: board.start(1000.0, np.zeros(80)), lambda: board.write(0.0)]


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (nidaqmx.errors.DaqNotFoundError("Could not find"), "is not installed on this machine; install it from ni.com"),
        (nidaqmx.errors.DaqNotSupportedError("darwin"), "does not run on this system"),
        (nidaqmx.errors.DaqFunctionNotSupportedError("upgrade it"), "upgrade it"),
        (FileNotFoundError("libnidaqmx.so.1"), "cannot be loaded .*libnidaqmx.so.1.*; install it again"),
        (OSError("wrong ELF class"), "cannot be loaded"),
    ],
)
def test_without_the_driver_there_is_a_sentence(error: Exception, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    from nidaqmx._lib import DaqLibImporter

    def fail(self: object) -> None:
        raise error

    monkeypatch.setattr(DaqLibImporter, "_import_lib", fail)
    for call in each_call(without_wires()):
        with pytest.raises(RigFault, match=words):
            call()


@pytest.mark.parametrize("grpc_server", ["", "127.0.0.1:1"])
@pytest.mark.parametrize("package", ["nidaqmx", "grpc"])
def test_without_the_package_there_is_a_sentence(
    package: str, grpc_server: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    settings = RigSettings(wires=replace(RigSettings().wires, grpc=grpc_server))
    if package == "grpc" and not grpc_server:
        NiBoard(settings)  # it is needed for the wire only
    else:
        with pytest.raises(RigFault, match=r'pip install "dampyr\[rig\]"'):
            NiBoard(settings)


def test_a_server_that_is_not_there_is_a_sentence() -> None:
    settings = RigSettings(wires=replace(RigSettings().wires, grpc="127.0.0.1:1"))
    board = NiBoard(settings)
    for call in each_call(board):
        with pytest.raises(RigFault, match="Failed to connect to server"):
            call()
    board.close()


@pytest.mark.skipif(bool(ctypes.util.find_library("nidaqmx")), reason="this machine has NI-DAQmx")
def test_doctor_and_run_without_the_driver_say_so(tmp_path: Path) -> None:
    clock = Clock(Simulator(RigSettings()), EventFile(None), real_time=True)
    clock.start()
    path = tmp_path / "rig.toml"
    path.write_text(f'[wires]\nserial = "socket://127.0.0.1:{Serial(clock).port}"\n')  # the Uno answers
    words = "install it from ni.com/downloads"
    findings = {each.what: each for each in diagnose(path)}
    assert words in str(findings["board"].repair)
    assert "protocol 3" in findings["Uno"].observed
    step = 'kind = "sine"\namplitude = "4 mm"\nfrequency = "1 Hz"\nvoltage = "0 V"\ncycles = 2\n'
    (tmp_path / "one.toml").write_text(f'name = "one"\noperator = "me"\n[[step]]\n{step}')
    command = ["run", str(tmp_path / "one.toml"), "--rig", str(path), "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(cli, command, catch_exceptions=False)
    assert result.exit_code == 2  # nothing has moved
    assert words in result.stderr
    clock.finished.set()
