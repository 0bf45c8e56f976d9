"""The NI board: force, temperature and position on one sample clock, and the command voltage out on the same clock."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import RigFault
from dampyr.rig.settings import RigSettings

Array = NDArray[np.float64]
Counts = NDArray[np.int64]
T = TypeVar("T")
BUFFER = 10.0  # s of samples that the board holds for a late host
LATCHES = 1000  # passes of the index that the board holds
ENCODER_LINES = {
    "ctr0": ("PFI8", "PFI10"),
    "ctr1": ("PFI3", "PFI11"),
}  # A and B of an M Series board's counters by default
PATIENCE = 2.0  # s beyond a block's own duration until a read fails


class Board(Protocol):
    """What the acquisition needs of a board."""

    def start(self, rate: float, ahead: Array) -> None:
        """Start sampling at ``rate`` [Hz]; the command begins with the volts in ``ahead``."""

    def read(self, n: int) -> tuple[Array, Counts]:
        """The next n samples: volts (channels, n), in the order of the rig's ``inputs``, and counts (n,); waits for them."""

    def index_counts(self) -> Counts:
        """The counts (k,) at which the encoder's index was passed since the last call, hardware-latched."""

    def queue(self, volts: Array) -> None:
        """Append to the command, a sample of it per sample read."""

    def write(self, volts: float) -> None:
        """Set the command now; what was queued is dropped, and nothing is queued before the next start."""

    def stop(self) -> None:
        """Stop sampling; the command stays as it is."""

    def close(self) -> None:
        """Close the board."""

    def identity(self) -> str:
        """Product and serial number."""


class NiBoard:
    """A board of National Instruments, of this machine or behind a gRPC device server."""

    def __init__(self, rig: RigSettings) -> None:
        self.rig, self._tasks = rig, {}  # type: RigSettings, dict[str, Any]
        self._channel: Any = None
        self._nidaqmx = _imported()
        if rig.wires.grpc:
            import grpc

            self._channel = grpc.insecure_channel(rig.wires.grpc)

    def start(self, rate: float, ahead: Array) -> None:
        """Set up the three tasks on the analogue inputs' clock, and start them."""
        from nidaqmx.constants import AcquisitionType
        from nidaqmx.stream_readers import AnalogMultiChannelReader, CounterReader

        self.stop()
        clock = {"sample_mode": AcquisitionType.CONTINUOUS, "samps_per_chan": int(BUFFER * rate)}
        shared = clock | {"source": f"/{self.rig.wires.board}/ai/SampleClock"}
        inputs, counter, output = (self._task(name) for name in ("inputs", "counter", "output"))
        self._call(self._wire_up, inputs, counter, output)
        self._call(inputs.timing.cfg_samp_clk_timing, rate, **clock)
        self._call(counter.timing.cfg_samp_clk_timing, rate, **shared)
        self._time_output(output, rate, shared, ahead)
        if self.rig.wires.index:
            self._latch_index(rate)
        self._analog, self._counter = AnalogMultiChannelReader(inputs.in_stream), CounterReader(counter.in_stream)
        self._analog.verify_array_shape = self._counter.verify_array_shape = False
        for task in (counter, output, inputs):  # whose clock it is comes last
            self._call(task.start)

    def _latch_index(self, rate: float) -> None:
        """Start the counter that counts the same lines as that of the position, and is sampled at each rising edge of Z."""
        from nidaqmx.constants import AcquisitionType, EncoderType, LengthUnits
        from nidaqmx.stream_readers import CounterReader

        wires = self.rig.wires
        counter, _, mark = wires.index.partition("/")
        task = self._task("index")
        channel = self._call(
            task.ci_channels.add_ci_lin_encoder_chan,
            f"{wires.board}/{counter}",
            decoding_type=EncoderType.X_4,
            units=LengthUnits.TICKS,
            dist_per_pulse=4 * self.rig.encoder.count,
        )
        for name, line in zip("ab", ENCODER_LINES.get(wires.position.lower(), ()), strict=False):
            self._call(setattr, channel, f"ci_encoder_{name}_input_term", f"/{wires.board}/{line}")
        clock = {"sample_mode": AcquisitionType.CONTINUOUS, "samps_per_chan": LATCHES}
        self._call(task.timing.cfg_samp_clk_timing, rate, source=f"/{wires.board}/{mark}", **clock)
        self._latch = CounterReader(task.in_stream)
        self._latch.verify_array_shape = False
        self._call(task.start)

    def _time_output(self, output: Any, rate: float, shared: dict[str, Any], ahead: Array) -> None:
        from nidaqmx.constants import RegenerationMode
        from nidaqmx.stream_writers import AnalogSingleChannelWriter

        self._call(output.timing.cfg_samp_clk_timing, rate, **shared)
        output.out_stream.regen_mode = RegenerationMode.DONT_ALLOW_REGENERATION
        self._writer = AnalogSingleChannelWriter(output.out_stream, auto_start=False)
        self._writer.verify_array_shape = False  # a question to the server per call
        self._call(self._writer.write_many_sample, np.ascontiguousarray(ahead))

    def _wire_up(self, inputs: Any, counter: Any, output: Any) -> None:
        from nidaqmx.constants import EncoderType, LengthUnits, TerminalConfiguration

        wires, span = self.rig.wires, self.rig.board.range
        for name in self.rig.inputs.values():
            inputs.ai_channels.add_ai_voltage_chan(
                f"{wires.board}/{name}", terminal_config=TerminalConfiguration.DIFF, min_val=-span, max_val=span
            )
        counter.ci_channels.add_ci_lin_encoder_chan(
            f"{wires.board}/{wires.position}",
            decoding_type=EncoderType.X_4,
            units=LengthUnits.TICKS,
            dist_per_pulse=4 * self.rig.encoder.count,
        )
        output.ao_channels.add_ao_voltage_chan(f"{wires.board}/{wires.command}", min_val=-span, max_val=span)

    def read(self, n: int) -> tuple[Array, Counts]:
        """The next n samples of both tasks."""
        volts, ticks = np.empty((len(self.rig.inputs), n)), np.empty(n, np.uint32)
        wait = PATIENCE + n / self.rig.board.rate
        self._call(self._analog.read_many_sample, volts, n, wait)
        self._call(self._counter.read_many_sample_uint32, ticks, n, wait)
        return volts, ticks.astype(np.int32).astype(np.int64)  # the counter wraps below 0

    def index_counts(self) -> Counts:
        """What the index has latched."""
        task = self._tasks.get("index")
        n = 0 if task is None else int(self._call(lambda: task.in_stream.avail_samp_per_chan))
        ticks = np.empty(n, np.uint32)
        if n:
            self._call(self._latch.read_many_sample_uint32, ticks, n, PATIENCE)
        return ticks.astype(np.int32).astype(np.int64)

    def queue(self, volts: Array) -> None:
        """Append to the command's buffer."""
        self._call(self._writer.write_many_sample, np.ascontiguousarray(volts))

    def write(self, volts: float) -> None:
        """End the timed command and set a static one."""
        self._close("output")
        with_one = self._task("output")
        span, wires = self.rig.board.range, self.rig.wires
        self._call(with_one.ao_channels.add_ao_voltage_chan, f"{wires.board}/{wires.command}", "", -span, span)
        self._call(with_one.write, float(volts), auto_start=True)
        self._close("output")  # the board holds the last value

    def stop(self) -> None:
        """End all tasks."""
        for name in list(self._tasks):
            self._close(name)

    def close(self) -> None:
        """End all tasks and the channel."""
        self.stop()
        if self._channel is not None:
            self._channel.close()

    def identity(self) -> str:
        """Product and serial number, as the driver gives them."""
        from nidaqmx.system import Device

        device = Device(self.rig.wires.board, grpc_options=self._options())
        return f"{self._call(lambda: device.product_type)} {self._call(lambda: device.serial_num):08X}"

    def _options(self) -> Any:
        if self._channel is None:
            return None
        from nidaqmx import GrpcSessionOptions

        return GrpcSessionOptions(self._channel, "")

    def _task(self, name: str) -> Any:
        self._tasks[name] = self._call(self._nidaqmx.Task, name, grpc_options=self._options())
        return self._tasks[name]

    def _close(self, name: str) -> None:
        task = self._tasks.pop(name, None)
        if task is not None:
            self._call(task.close)

    def _call(self, call: Callable[..., T], *args: Any, **named: Any) -> T:
        """What ``call`` gives; the driver's complaints as a :class:`RigFault` in one sentence."""
        try:
            return call(*args, **named)
        except self._nidaqmx.errors.Error as problem:
            message = " ".join(str(problem).split())
            raise RigFault(f"the board {self.rig.wires.board} gives an error: {message}") from problem


def _imported() -> Any:
    try:
        import nidaqmx
        import nidaqmx.errors
    except ImportError as problem:
        raise RigFault("the NI board needs nidaqmx; install it: pip install 'dampyr[rig]'") from problem
    return nidaqmx
