"""The NI board: force, temperature and position on one sample clock, and the command voltage out on the same clock.

What NI documents of the calls that are made here, and what it does not, is in docs/reference/ni-daqmx.md.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import RigFault, install_line
from dampyr.origin import OriginKind
from dampyr.rig.instruments.contract import Array, Counts
from dampyr.rig.instruments.ni_daqmx.boards import Lack, lacks_of
from dampyr.rig.settings import RigSettings

T = TypeVar("T")
BUFFER = 10.0  # s of samples that the board holds for a late host
LATCHES = 1000  # passes of the index that the board holds
ENCODER_LINES = {
    "ctr0": ("PFI8", "PFI10"),
    "ctr1": ("PFI3", "PFI11"),
}  # A and B of an M Series board's counters by default
PATIENCE = 2.0  # s beyond a block's own duration until a read fails
OUTPUT_BUFFER = 1.0  # s of the command that the board can hold: many times what is queued ahead
ROUNDING = 1e-6  # of the command's range: a command at its end is not refused for its last digit
UNDERFLOW, NOT_YET_WRITTEN, NO_SPACE = -200290, -200292, -200293  # NI-DAQmx's numbers of these errors
NO_DRIVER = (
    "NI-DAQmx, National Instruments' driver, is not installed on this machine; install it from ni.com/downloads and start "
    "again, or name another machine's NI gRPC device server in wires.grpc"
)


class NiBoard:
    """A board of National Instruments, of this machine or behind a gRPC device server."""

    def __init__(self, rig: RigSettings) -> None:
        self.rig, self._tasks = rig, {}  # type: RigSettings, dict[str, Any]
        self._channel: Any = None
        self._nidaqmx, grpc = _imported(bool(rig.wires.grpc))
        if rig.wires.grpc:
            self._channel = grpc.insecure_channel(rig.wires.grpc)

    def start(self, rate: float, ahead: Array) -> None:
        """Set up the tasks on the analogue inputs' clock, and start them."""
        self.stop()
        self._call(self._start, rate, ahead)

    def read(self, n: int) -> tuple[Array, Counts]:
        """The next n samples of both tasks."""
        volts, ticks = np.empty((len(self.rig.inputs), n)), np.empty(n, np.uint32)
        wait = PATIENCE + n / self.rig.board.rate
        self._call(self._analog.read_many_sample, volts, n, wait)
        self._call(self._counter.read_many_sample_uint32, ticks, n, wait)
        return volts, signed(ticks)

    def index_counts(self) -> Counts:
        """What the index has latched."""
        return self._call(self._latched)

    def queue(self, volts: Array) -> None:
        """Append to the command's buffer; it waits for a block at most where the buffer is full."""
        self._check(volts)
        self._call(self._writer.write_many_sample, np.ascontiguousarray(volts), self.rig.board.block)

    def write(self, volts: float) -> None:
        """End the timed command and set a static one."""
        self._check(np.array([volts]))
        self._call(self._write_now, float(volts))

    def shunt(self, on: bool) -> None:
        """Switch the relay that puts a shunt across the load cell's bridge, at the line of wires.shunt; on demand, so that
        what is being sampled goes on.
        """
        self._call(self._switch, on)

    def stop(self) -> None:
        """End all tasks; each is tried, and the first failure is raised."""
        failed: list[RigFault] = []
        for name in list(self._tasks):
            try:
                self._call(self._close, name)
            except RigFault as problem:
                failed.append(problem)
        if failed:
            raise failed[0]

    def close(self) -> None:
        """End all tasks and the channel."""
        try:
            self.stop()
        finally:
            if self._channel is not None:
                self._channel.close()

    def identity(self) -> str:
        """Product and serial number, as the driver gives them."""
        return self._call(self._identity)

    def type_and_lacks(self) -> tuple[str, list[Lack]]:
        """The product's type, and what NI-DAQmx says that it does not have of what the rig asks of it."""
        return self._call(lambda: ((device := self._device()).product_type, list(lacks_of(device, self.rig))))

    def origin(self) -> OriginKind:
        """Whether NI-DAQmx says that its samples are of a real board."""
        return self._call(self._origin)

    # all that follows is called through `_call`

    def _start(self, rate: float, ahead: Array) -> None:
        from nidaqmx.constants import AcquisitionType, TerminalConfiguration
        from nidaqmx.stream_readers import AnalogMultiChannelReader, CounterReader

        wires, span = self.rig.wires, self.rig.board.range
        clock = {"sample_mode": AcquisitionType.CONTINUOUS, "samps_per_chan": int(BUFFER * rate)}
        shared = clock | {"source": f"/{wires.board}/ai/SampleClock"}
        inputs, counter = self._task("inputs"), self._task("counter")
        output = self._task("output") if len(ahead) else None
        for name in self.rig.inputs.values():
            inputs.ai_channels.add_ai_voltage_chan(
                f"{wires.board}/{name}", terminal_config=TerminalConfiguration.DIFF, min_val=-span, max_val=span
            )
        self._filter(self._add_encoder(counter, wires.position), "ab")
        inputs.timing.cfg_samp_clk_timing(rate, **clock)
        counter.timing.cfg_samp_clk_timing(rate, **shared)
        if output is not None:
            self._add_output(output)
            self._time_output(output, rate, shared, ahead)
            self._prepare_static_output()
        if wires.index:
            self._latch_index(rate)
        self._analog, self._counter = AnalogMultiChannelReader(inputs.in_stream), CounterReader(counter.in_stream)
        self._analog.verify_array_shape = self._counter.verify_array_shape = False
        for task in (counter, output, inputs):  # whose clock it is comes last
            if task is not None:
                task.start()

    def _add_encoder(self, task: Any, counter: str) -> Any:
        from nidaqmx.constants import EncoderType, LengthUnits

        return task.ci_channels.add_ci_lin_encoder_chan(
            f"{self.rig.wires.board}/{counter}",
            decoding_type=EncoderType.X_4,
            units=LengthUnits.TICKS,
            dist_per_pulse=4 * self.rig.encoder.count,
        )

    def _filter(self, channel: Any, lines: str) -> None:
        """Have the counter ignore pulses of the encoder's ``lines`` that are shorter than the filter."""
        width = self.rig.board.encoder_filter
        for line in lines if width else "":
            setattr(channel, f"ci_encoder_{line}_input_dig_fltr_min_pulse_width", width)
            setattr(channel, f"ci_encoder_{line}_input_dig_fltr_enable", True)

    def _latch_index(self, rate: float) -> None:
        """Start the counter that counts the same lines as that of the position, and is sampled at each rising edge of Z."""
        from nidaqmx.constants import AcquisitionType
        from nidaqmx.stream_readers import CounterReader

        wires = self.rig.wires
        counter, _, mark = wires.index.partition("/")
        task = self._task("index")
        channel = self._add_encoder(task, counter)
        for name, line in zip("ab", ENCODER_LINES.get(wires.position.lower(), ()), strict=False):
            setattr(channel, f"ci_encoder_{name}_input_term", f"/{wires.board}/{line}")
        if self.rig.board.encoder_filter:  # a filter belongs to a terminal: that of Z filters what samples this counter
            channel.ci_encoder_z_input_term = f"/{wires.board}/{mark}"
        self._filter(channel, "abz")
        clock = {"sample_mode": AcquisitionType.CONTINUOUS, "samps_per_chan": LATCHES}
        task.timing.cfg_samp_clk_timing(rate, source=f"/{wires.board}/{mark}", **clock)
        self._latch = CounterReader(task.in_stream)
        self._latch.verify_array_shape = False
        task.start()

    def _latched(self) -> Counts:
        task = self._tasks.get("index")
        n = 0 if task is None else int(task.in_stream.avail_samp_per_chan)
        ticks = np.empty(n, np.uint32)
        if n:
            self._latch.read_many_sample_uint32(ticks, n, PATIENCE)
        return signed(ticks)

    def _add_output(self, task: Any) -> None:
        low, high = self.rig.command_range
        task.ao_channels.add_ao_voltage_chan(
            f"{self.rig.wires.board}/{self.rig.wires.command}", min_val=low, max_val=self._with_rounding(high)
        )

    def _time_output(self, output: Any, rate: float, shared: dict[str, Any], ahead: Array) -> None:
        from nidaqmx.constants import RegenerationMode
        from nidaqmx.stream_writers import AnalogSingleChannelWriter

        output.timing.cfg_samp_clk_timing(rate, **shared)
        output.out_stream.regen_mode = RegenerationMode.DONT_ALLOW_REGENERATION
        # else it has the size of the first write, and the next one waits for a place in it
        output.out_stream.output_buf_size = max(round(OUTPUT_BUFFER * rate), len(ahead) + self.rig.block_samples)
        self._writer = AnalogSingleChannelWriter(output.out_stream, auto_start=False)
        self._writer.verify_array_shape = False  # a question to the server per call
        self._check(ahead)
        self._writer.write_many_sample(np.ascontiguousarray(ahead), self.rig.board.block)

    def _prepare_static_output(self) -> Any:
        """A task that sets the output at once, made and verified before it is needed: only that takes no output."""
        from nidaqmx.constants import TaskMode

        task = self._task("static")
        self._add_output(task)
        task.control(TaskMode.TASK_VERIFY)
        return task

    def _switch(self, on: bool) -> None:
        from nidaqmx.constants import LineGrouping

        self._close("shunt")
        task = self._task("shunt")
        lines = f"{self.rig.wires.board}/{self.rig.wires.shunt}"
        task.do_channels.add_do_chan(lines, line_grouping=LineGrouping.CHAN_PER_LINE)
        task.write(on, auto_start=True)

    def _write_now(self, volts: float) -> None:
        """Abort the timed command, which frees the output, and write through the task that is ready for it."""
        from nidaqmx.constants import TaskMode
        from nidaqmx.stream_writers import AnalogSingleChannelWriter

        timed = self._tasks.get("output")
        if timed is not None:
            try:
                timed.control(TaskMode.TASK_ABORT)
            except self._nidaqmx.errors.Error:
                self._close("output")  # the slow way
        static = self._tasks.get("static") or self._prepare_static_output()
        AnalogSingleChannelWriter(static.out_stream, auto_start=True).write_one_sample(volts, PATIENCE)
        self._close("output")

    def _identity(self) -> str:
        device = self._device()
        return f"{device.product_type} {device.serial_num:08X}"

    def _origin(self) -> OriginKind:
        return "simulated" if self._device().is_simulated else "measured"

    def _device(self) -> Any:
        from nidaqmx.system import Device

        return Device(self.rig.wires.board, grpc_options=self._options())

    def _options(self) -> Any:
        if self._channel is None:
            return None
        from nidaqmx import GrpcSessionOptions

        return GrpcSessionOptions(self._channel, "")

    def _task(self, name: str) -> Any:
        self._tasks[name] = self._nidaqmx.Task(name, grpc_options=self._options())
        return self._tasks[name]

    def _close(self, name: str) -> None:
        task = self._tasks.pop(name, None)
        if task is None:
            return
        try:
            task.close()
        except self._nidaqmx.errors.DaqError as problem:
            if problem.error_code != UNDERFLOW:  # an output that has run out has done its work
                raise

    def _check(self, volts: Array) -> None:
        """Refuse a command outside of what the supply may be given, before the driver has a part of it."""
        low, high = self.rig.command_range
        high = self._with_rounding(high)
        if not (volts.min(initial=low) >= low and volts.max(initial=low) <= high):
            outside = volts[~((volts >= low) & (volts <= high))][0]
            raise RigFault(
                f"a command of {outside:.4g} V is outside of the supply's {low:g} to {high:.4g} V "
                "(1.25 * supply.max_voltage / supply.gain)",
                "interlock",
            )

    def _with_rounding(self, high: float) -> float:
        return min(self.rig.board.range, high * (1.0 + ROUNDING))

    def _call(self, call: Callable[..., T], *args: Any, **named: Any) -> T:
        """What ``call`` gives; the driver's complaints as a :class:`RigFault` in one sentence."""
        errors, board = self._nidaqmx.errors, self.rig.wires.board
        try:
            return call(*args, **named)
        except errors.DaqNotFoundError as problem:
            raise RigFault(NO_DRIVER) from problem
        except errors.DaqNotSupportedError as problem:
            raise RigFault(
                "NI-DAQmx does not run on this system, only on Windows and Linux; name the NI gRPC device server of a machine "
                "with the driver in wires.grpc"
            ) from problem
        except errors.Error as problem:
            code = getattr(problem, "error_code", 0)
            if code in (NOT_YET_WRITTEN, NO_SPACE):
                raise RigFault(
                    f"the command's buffer on the board {board} is full and nothing leaves it: has its sample clock stopped?"
                ) from problem
            if code == UNDERFLOW:
                raise RigFault(
                    f"the command on the board {board} has run out (error {code}): the host was held up for longer than it "
                    "runs ahead; end what else keeps the machine busy"
                ) from problem
            message = " ".join(str(problem).split())
            raise RigFault(f"the board {board} gives an error: {message}") from problem
        except OSError as problem:  # the driver's shared library is there and cannot be loaded
            raise RigFault(
                f"NI-DAQmx cannot be loaded ({problem}); install it again from ni.com/downloads"
            ) from problem


def connect(rig: RigSettings) -> NiBoard:
    """The board that ``rig`` names."""
    return NiBoard(rig)


def signed(ticks: NDArray[np.uint32]) -> Counts:
    """The counts of a counter of 32 bits, which goes from 0 to 2**32 - 1 where it counts down."""
    return ticks.astype(np.int32).astype(np.int64)


def _imported(remote: bool) -> tuple[Any, Any]:
    """The driver's package, and that of its remote calls where these are needed."""
    try:
        import nidaqmx
        import nidaqmx.errors

        if not remote:
            return nidaqmx, None
        import grpc
    except ImportError as problem:
        raise RigFault(f"the NI board needs nidaqmx; install it: {install_line('rig')}") from problem
    return nidaqmx, grpc
