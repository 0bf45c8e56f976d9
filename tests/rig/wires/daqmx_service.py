"""NI-DAQmx gRPC service of the simulated board: the calls that the drivers make, and a clear refusal of all others.

The tasks of one board: analogue inputs and a linear encoder on one sample clock, and an analogue output on that clock or
written point by point. The messages are those of `nidaqmx[grpc]`; errors travel as its client expects them, with NI-DAQmx's
own numbers. It is as strict as NI documents the driver to be, see docs/reference/ni-daqmx.md: reserved resources, limits and
buffer of the output, digital filters.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import grpc
import numpy as np
from nidaqmx._stubs import nidaqmx_pb2 as pb
from nidaqmx._stubs import nidaqmx_pb2_grpc as service
from numpy.typing import NDArray
from tests.rig.wires.clock import Clock
from tests.rig.wires.daqmx_identity import (
    BEYOND_LIMITS,
    EMPTY,
    FILTER_DIFFERS,
    FILTER_NOT_SET,
    FILTER_WIDTH,
    NO_CHANNEL,
    NO_SPACE,
    NOT_STARTED,
    NOT_YET,
    ONE_SAMPLE,
    READ_TYPE,
    RESERVED,
    RUNNING,
    TOO_SHORT,
    DaqTask,
    Identity,
)

from dampyr.rig.simulation.board_signals import OVERRUN, RANGE, TIMEOUT, UNDERFLOW, BoardError
from dampyr.rig.simulation.timed_command import TimedCommand

# NI-DAQmx's numbers of these settings
DO_NOT_REGENERATE = 10158
X4, METERS, TICKS = 10092, 10219, 10304  # as above
ALL = -1  # samples: all that are buffered
FILTER_WIDTHS = (125e-9, 6.425e-6, 2.55e-3)  # s, of an M Series board
INPUT_BUFFERS = ((100.0, 1000), (10e3, 10000), (1e6, 100000))  # up to a rate: samples that are buffered at least
ENCODER_INPUTS = {
    pb.CHANNEL_ATTRIBUTE_CI_ENCODER_A_INPUT_TERM: "a",
    pb.CHANNEL_ATTRIBUTE_CI_ENCODER_B_INPUT_TERM: "b",
    pb.CHANNEL_ATTRIBUTE_CI_ENCODER_Z_INPUT_TERM: "z",
}
FILTER_ENABLED = {
    pb.CHANNEL_ATTRIBUTE_CI_ENCODER_A_INPUT_DIG_FLTR_ENABLE: "a",
    pb.CHANNEL_ATTRIBUTE_CI_ENCODER_B_INPUT_DIG_FLTR_ENABLE: "b",
    pb.CHANNEL_ATTRIBUTE_CI_ENCODER_Z_INPUT_DIG_FLTR_ENABLE: "z",
}
FILTER_LENGTHS = {
    pb.CHANNEL_ATTRIBUTE_CI_ENCODER_A_INPUT_DIG_FLTR_MIN_PULSE_WIDTH: "a",
    pb.CHANNEL_ATTRIBUTE_CI_ENCODER_B_INPUT_DIG_FLTR_MIN_PULSE_WIDTH: "b",
    pb.CHANNEL_ATTRIBUTE_CI_ENCODER_Z_INPUT_DIG_FLTR_MIN_PULSE_WIDTH: "z",
}
DEFAULT_LINES = {"ctr0": ("pfi8", "pfi10", "pfi9"), "ctr1": ("pfi3", "pfi11", "pfi4")}  # A, B, Z of an M Series board


class Board(Identity):
    """The simulated PCI-6221 of a :class:`~tests.rig.wires.clock.Clock`."""

    # tasks

    def CreateTask(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context):
            self.task_count += 1
            name = request.session_name or f"_unnamedTask<{self.task_count}>"
            self.tasks[name] = DaqTask()
        return pb.CreateTaskResponse(task=_session(name), new_session_initialized=True)

    def CreateAIVoltageChan(self, request: Any, context: Any) -> Any:
        allowed = list(self.settings.inputs.values())
        self._add(request.task, "ai", request.physical_channel, allowed, context, (request.min_val, request.max_val))
        return pb.CreateAIVoltageChanResponse()

    def CreateAOVoltageChan(self, request: Any, context: Any) -> Any:
        limits = request.min_val, request.max_val
        self._add(request.task, "ao", request.physical_channel, [self.settings.wires.command], context, limits)
        return pb.CreateAOVoltageChanResponse()

    def CreateCILinEncoderChan(self, request: Any, context: Any) -> Any:
        counters = [self.settings.wires.position, self.settings.wires.index.partition("/")[0]]
        self._add(request.task, "ci", request.counter, counters, context)
        with self.grpc_errors(context, request.task.name) as task:
            if request.decoding_type_raw != X4 or request.units_raw not in (METERS, TICKS) or request.zidx_enable:
                raise NotImplementedError(
                    "the simulated counter decodes X4, in metres or ticks, without the index; ask for these"
                )
            task.pulse = 0.25 * request.dist_per_pulse if request.units_raw == METERS else 1.0
            task.initial = request.initial_pos
            lines = DEFAULT_LINES.get(request.counter.rpartition("/")[2].lower(), ("", "", ""))
            task.lines = dict(zip("abz", lines, strict=True))
        return pb.CreateCILinEncoderChanResponse()

    def _add(
        self,
        session: Any,
        kind: str,
        channel: str,
        allowed: list[str],
        context: Any,
        limits: tuple[float, float] = (-10.0, 10.0),
    ) -> None:
        with self.grpc_errors(context, session.name) as task:
            board, span = self.settings.wires.board, self.settings.board.range
            if not -span <= limits[0] < limits[1] <= span:
                raise BoardError(RANGE)
            task.limits = limits
            for name in channel.replace(" ", "").split(","):
                if name.lower() not in [f"{board}/{each}".lower() for each in allowed if each]:
                    raise KeyError(NO_CHANNEL)
                if task.kind not in ("", kind):
                    raise NotImplementedError(f"a task of {task.kind} channels takes no {kind} channel; make another")
                task.kind = kind
                task.channels.append(name)

    def CfgSampClkTiming(self, request: Any, context: Any) -> Any:
        wires = self.settings.wires
        mark = f"/{wires.board}/{wires.index.partition('/')[2]}".lower()
        with self.grpc_errors(context, request.task.name) as task:
            task.rate = request.rate
            at_least = next((size for rate, size in INPUT_BUFFERS if request.rate <= rate), 1000000)
            task.input_buffer = max(request.samps_per_chan, at_least)
            task.latched = task.kind == "ci" and bool(wires.index) and request.source.lower() == mark
        return pb.CfgSampClkTimingResponse()

    def SetChanAttributeString(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            line = ENCODER_INPUTS.get(request.attribute_raw)
            terminal = request.value.lower().rpartition("/")[2]
            wired = dict(zip("abz", DEFAULT_LINES["ctr0"], strict=True))
            if task.kind != "ci" or line is None or wired[line] != terminal:
                raise NotImplementedError(
                    "the simulated encoder's lines are A on PFI8, B on PFI10 and Z on PFI9; ask for these"
                )
            self._not_running(task)
            task.lines[line] = terminal
        return pb.SetChanAttributeStringResponse()

    def SetChanAttributeBool(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            self._filter(task, FILTER_ENABLED.get(request.attribute_raw))["enable"] = float(request.value)
        return pb.SetChanAttributeBoolResponse()

    def SetChanAttributeDouble(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            setting = self._filter(task, FILTER_LENGTHS.get(request.attribute_raw))
            if not any(abs(request.value - width) <= 1e-3 * width for width in FILTER_WIDTHS):
                raise BoardError(FILTER_WIDTH)
            setting["width"] = request.value
        return pb.SetChanAttributeDoubleResponse()

    def _filter(self, task: DaqTask, line: str | None) -> dict[str, float]:
        """The filter of one of the encoder's lines."""
        if task.kind != "ci" or line is None:
            raise NotImplementedError("the simulated board filters the encoder's lines only")
        self._not_running(task)
        return task.filters.setdefault(line, {})

    @staticmethod
    def _not_running(task: DaqTask) -> None:
        if task.running:
            raise BoardError(RUNNING)

    def SetBufferAttributeUInt32(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            if request.attribute_raw != pb.BUFFER_ATTRIBUTE_OUTPUT_BUF_SIZE or task.kind != "ao" or request.value < 2:
                raise NotImplementedError("of buffers, only that of a clocked output can be set, to 2 samples or more")
            self._not_running(task)
            task.buffer = request.value
        return pb.SetBufferAttributeUInt32Response()

    def StartTask(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            self._start(task)
        return pb.StartTaskResponse()

    def _reserve(self, task: DaqTask) -> None:
        """Take the task's resources; what another one holds cannot be taken."""
        others = [other for other in self.tasks.values() if other is not task and other.reserved]
        if any(task.resources & other.resources for other in others):
            raise BoardError(RESERVED)
        for line, setting in task.filters.items():
            if setting.get("enable") and "width" not in setting:
                raise BoardError(FILTER_NOT_SET)
            for other in others:
                for its_line, its_setting in other.filters.items():
                    if other.lines.get(its_line) == task.lines.get(line) and its_setting != setting:
                        raise BoardError(FILTER_DIFFERS)
        task.reserved = True

    def _start(self, task: DaqTask) -> None:
        if task.running:
            return
        if task.kind == "ao" and task.rate and not task.rows:
            raise BoardError(EMPTY)
        if task.kind == "ao" and task.rate and task.waiting < 2:
            raise BoardError(TOO_SHORT)
        self._reserve(task)
        task.running = True
        if task.kind == "ai" and not self.clock.rig.sampling:
            self.clock.rig.start(task.rate or self.settings.board.rate)
            self.clock.log("sampling")
        if task.kind == "ao" and task.rate:
            self.clock.rig.timed = TimedCommand(self.clock.rig.time, task.rate, np.concatenate([[], *task.rows]))

    def StopTask(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            self._stop(task)
        return pb.StopTaskResponse()

    def _stop(self, task: DaqTask, quietly: bool = False) -> None:
        """End a task; an output that has run out says so, unless it is aborted."""
        late = self._has_run_out(task)
        task.running = task.reserved = False
        task.rows.clear()
        if task.kind == "ai" and self.clock.rig.sampling:
            self.clock.rig.stop()
            self.clock.log("sampling ended")
        if task.kind == "ao" and task.rate:
            self.clock.rig.timed = None
        if late and not quietly:
            raise BoardError(UNDERFLOW)

    def _has_run_out(self, task: DaqTask) -> bool:
        """Whether a clocked output has no more values to generate."""
        rig = self.clock.rig
        return task.kind == "ao" and task.running and rig.timed is not None and rig.timed.empty(rig.time)

    def ClearTask(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            del self.tasks[request.task.name]
            if task.running:
                self._stop(task)
        return pb.ClearTaskResponse()

    def TaskControl(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            if request.action_raw == pb.TASK_CONTROL_ACTION_TASK_ABORT:
                if task.running:
                    self._stop(task, quietly=True)
                task.reserved = False
                task.rows.clear()
            elif request.action_raw != pb.TASK_CONTROL_ACTION_TASK_VERIFY:
                raise NotImplementedError(
                    "of a task's states the simulated board knows verify and abort; ask for these"
                )
        return pb.TaskControlResponse()

    def IsTaskDone(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            if self._has_run_out(task):
                raise BoardError(UNDERFLOW)
            done = not task.running
        return pb.IsTaskDoneResponse(is_task_done=done)

    # samples

    def ReadAnalogF64(self, request: Any, context: Any) -> Any:
        rows = self._read(request, context, "ai")
        ordered = rows if request.fill_mode_raw == pb.GROUP_BY_GROUP_BY_CHANNEL else rows.T
        return pb.ReadAnalogF64Response(samps_per_chan_read=rows.shape[1], read_array=ordered.ravel().tolist())

    def ReadCounterF64(self, request: Any, context: Any) -> Any:
        rows = self._read(request, context, "ci")
        return pb.ReadCounterF64Response(samps_per_chan_read=rows.shape[1], read_array=rows.ravel().tolist())

    def ReadCounterF64Ex(self, request: Any, context: Any) -> Any:
        rows = self._read(request, context, "ci")
        return pb.ReadCounterF64ExResponse(samps_per_chan_read=rows.shape[1], read_array=rows.ravel().tolist())

    def ReadAnalogScalarF64(self, request: Any, context: Any) -> Any:
        rows = self._read(_Single(request.task, request.timeout), context, "ai")
        return pb.ReadAnalogScalarF64Response(value=rows[0, 0])

    def ReadCounterScalarF64(self, request: Any, context: Any) -> Any:
        rows = self._read(_Single(request.task, request.timeout), context, "ci")
        return pb.ReadCounterScalarF64Response(value=rows[0, 0])

    def ReadCounterU32(self, request: Any, context: Any) -> Any:
        rows = self._read(request, context, "ci").astype(np.int64) & 0xFFFFFFFF
        return pb.ReadCounterU32Response(samps_per_chan_read=rows.shape[1], read_array=rows.ravel().tolist())

    def ReadCounterU32Ex(self, request: Any, context: Any) -> Any:
        rows = self._read(request, context, "ci").astype(np.int64) & 0xFFFFFFFF
        return pb.ReadCounterU32ExResponse(samps_per_chan_read=rows.shape[1], read_array=rows.ravel().tolist())

    def _read(self, request: Any, context: Any, kind: str) -> NDArray[Any]:
        samples = np.empty((0, 0))
        with self.grpc_errors(context, request.task.name, [("ni-samps-per-chan-read", "0")]) as task:
            if task.kind != kind:
                raise BoardError(READ_TYPE)
            samples = (
                self._read_clocked(task, request)
                if task.rate
                else self._read_unclocked(task, request.num_samps_per_chan)
            )
            if kind == "ci":
                samples = task.initial + task.pulse * samples
        self.clock.sleep_deferred()
        return samples

    def _read_clocked(self, task: DaqTask, request: Any) -> NDArray[Any]:
        """Samples on the sample clock, or those that the index has latched."""
        if task.latched:
            return self._read_latched(task, request.num_samps_per_chan)
        if not task.running and task.kind == "ai":
            self._start(task)
        if not (task.running and self.clock.rig.sampling):
            raise BoardError(TIMEOUT)
        wanted = request.num_samps_per_chan
        if task.waiting + self.clock.rig.waiting > task.input_buffer:
            raise BoardError(OVERRUN)
        missing = self.clock.rig.waiting if wanted == ALL else wanted - task.waiting
        if missing > 0:
            self._distribute(self.clock.read(missing, request.timeout))
        return task.take(task.waiting if wanted == ALL else wanted) if task.rows else np.empty((1, 0))

    def _read_latched(self, task: DaqTask, wanted: int) -> NDArray[Any]:
        """Counts at passes of the index; a simulated host does not wait for one."""
        self.take_latched()
        if wanted != ALL and task.waiting < wanted:
            raise BoardError(TIMEOUT)
        return task.take(task.waiting if wanted == ALL else wanted) if task.rows else np.empty((1, 0))

    def _read_unclocked(self, task: DaqTask, wanted: int) -> NDArray[Any]:
        """Samples on demand, of a task without a clock."""
        self._reserve(task)
        readings = [self.clock.rig.read_now() for _ in range(max(1, wanted))]
        if task.kind == "ci":
            return np.array([[counts for _, counts in readings]])
        return np.stack([volts[self._channel_rows(task)] for volts, _ in readings], axis=1)

    def _channel_rows(self, task: DaqTask) -> list[int]:
        """The rows of the rig's analogue inputs that are a task's channels."""
        inputs = list(self.settings.inputs.values())
        return [inputs.index(channel.rpartition("/")[2]) for channel in task.channels]

    def _distribute(self, samples: tuple[NDArray[np.float64], NDArray[np.int64]]) -> None:
        """Append samples to every running task: inputs and counter share one clock."""
        volts, counts = samples
        for task in self.tasks.values():
            if task.running and task.kind == "ai":
                task.rows.append(volts[self._channel_rows(task)])
            if task.running and task.kind == "ci" and not task.latched:
                task.rows.append(counts[None])

    def WriteAnalogScalarF64(self, request: Any, context: Any) -> Any:
        self._write(request, context, [request.value])
        return pb.WriteAnalogScalarF64Response()

    def WriteAnalogF64(self, request: Any, context: Any) -> Any:
        self._write(request, context, request.write_array)
        return pb.WriteAnalogF64Response(samps_per_chan_written=request.num_samps_per_chan)

    def SetWriteAttributeInt32(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name):
            requested = (request.attribute_raw, request.value_raw)
            if requested != (pb.WRITE_ATTRIBUTE_REGEN_MODE, DO_NOT_REGENERATE):
                raise NotImplementedError(
                    "the simulated output does not regenerate its samples; set DO_NOT_ALLOW_REGENERATION"
                )
        return pb.SetWriteAttributeInt32Response()

    def _write(self, request: Any, context: Any, values: Any) -> None:
        """Volts for an output: at once without a clock, else into its buffer."""
        volts = np.array(list(values), float)
        counted = [("ni-samps-per-chan-written", "0")]
        with self.grpc_errors(context, request.task.name, counted) as task:
            if task.kind != "ao":
                raise NotImplementedError(f"a task of {task.kind or 'no'} channels is not written")
            if not (
                volts.min(initial=task.limits[0]) >= task.limits[0]
                and volts.max(initial=task.limits[0]) <= task.limits[1]
            ):
                raise BoardError(BEYOND_LIMITS)
            if task.rate:
                number = self._queue(task, volts, request.timeout)
                counted[0] = (counted[0][0], str(number))
                if request.auto_start:
                    self._start(task)
                if number < volts.size:
                    raise BoardError(NOT_YET if task.running else NO_SPACE)
            else:
                if not (request.auto_start or task.running):
                    raise BoardError(NOT_STARTED)
                self._start(task)
                self.clock.rig.write(float(volts[-1]))

    def _queue(self, task: DaqTask, volts: NDArray[np.float64], timeout: float) -> int:
        """Samples for a clocked output: stored until it starts, then appended to its buffer; how many it has taken."""
        if not task.buffer and not task.rows and volts.size < 2:
            raise BoardError(ONE_SAMPLE)
        task.buffer = task.buffer or volts.size
        self._reserve(task)
        if not task.running:
            fitting = volts[: task.buffer - task.waiting]
            task.rows.append(fitting)
            return fitting.size
        if self._has_run_out(task) or self.clock.rig.timed is None:
            raise BoardError(UNDERFLOW)
        fitting = volts[: self.clock.space(task.buffer, volts.size, timeout)]
        self.clock.rig.queue(fitting)
        return fitting.size


def _session(name: str) -> Any:
    from session_pb2 import Session

    return Session(name=name)


class _Single(NamedTuple):
    """A request of one sample."""

    task: Any
    timeout: float
    num_samps_per_chan: int = 1


class RefuseUnsupported(grpc.ServerInterceptor):
    """Refuse the calls that `Board` does not answer with a sentence."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock

    def intercept_service(self, continuation: Callable[..., Any], details: Any) -> Any:
        name = details.method.rpartition("/")[2]
        if any(name in vars(cls) for cls in (Board, Identity)):
            return continuation(details)

        def refuse(request: Any, context: grpc.ServicerContext) -> None:
            self.clock.log(f"refused {name}")
            context.abort(grpc.StatusCode.UNIMPLEMENTED, f"the simulated board does not answer {name}")

        return grpc.unary_unary_rpc_method_handler(refuse)


def serve(clock: Clock) -> dict[str, str]:
    """Serve NI-DAQmx's gRPC interface on the loopback; the wire to it."""
    server, port = start_server(clock)
    clock.on_end.append(lambda: server.stop(0.2).wait())
    return {"grpc": f"127.0.0.1:{port}"}


def start_server(clock: Clock) -> tuple[grpc.Server, int]:
    """Serve the board on the loopback: the running server and its port."""
    from concurrent.futures import ThreadPoolExecutor

    server = grpc.server(ThreadPoolExecutor(2), interceptors=(RefuseUnsupported(clock),))
    service.add_NiDAQmxServicer_to_server(Board(clock), server)
    port = server.add_insecure_port("127.0.0.1:0")
    server.start()
    return server, port
