"""NI-DAQmx gRPC service of the simulated board: the calls that the drivers make, and a clear refusal of all others.

The tasks of one board: analogue inputs and a linear encoder on one sample clock, and an analogue output written point by
point. The messages are those of `nidaqmx[grpc]`; errors travel as its client expects them, with NI-DAQmx's own numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import grpc
import numpy as np
from nidaqmx._stubs import nidaqmx_pb2 as pb
from nidaqmx._stubs import nidaqmx_pb2_grpc as service
from numpy.typing import NDArray

from dampyr.rig.simulation.board_signals import TIMEOUT, BoardError
from dampyr.rig.simulation.clock import Clock
from dampyr.rig.simulation.daqmx_identity import NO_CHANNEL, DaqTask, Identity
from dampyr.rig.simulation.timed_command import TimedCommand

# NI-DAQmx's numbers of these settings
DO_NOT_REGENERATE = 10158
X4, METERS, TICKS = 10092, 10219, 10304  # as above
ALL = -1  # samples: all that are buffered
UNSUPPORTED = -200077


class Board(Identity):
    """The simulated PCI-6221 of a :class:`~dampyr.rig.simulation.clock.Clock`."""

    # tasks

    def CreateTask(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context):
            self.task_count += 1
            name = request.session_name or f"_unnamedTask<{self.task_count}>"
            self.tasks[name] = DaqTask()
        return pb.CreateTaskResponse(task=_session(name), new_session_initialized=True)

    def CreateAIVoltageChan(self, request: Any, context: Any) -> Any:
        allowed = list(self.settings.inputs.values())
        self._add(request.task, "ai", request.physical_channel, allowed, context)
        return pb.CreateAIVoltageChanResponse()

    def CreateAOVoltageChan(self, request: Any, context: Any) -> Any:
        self._add(request.task, "ao", request.physical_channel, [self.settings.wires.command], context)
        self.tasks[request.task.name].max_voltage = min(request.max_val, self.settings.board.range)
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
        return pb.CreateCILinEncoderChanResponse()

    def _add(self, session: Any, kind: str, channel: str, allowed: list[str], context: Any) -> None:
        with self.grpc_errors(context, session.name) as task:
            board = self.settings.wires.board
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
            task.latched = task.kind == "ci" and bool(wires.index) and request.source.lower() == mark
        return pb.CfgSampClkTimingResponse()

    def SetChanAttributeString(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            lines = {
                pb.CHANNEL_ATTRIBUTE_CI_ENCODER_A_INPUT_TERM: "pfi8",
                pb.CHANNEL_ATTRIBUTE_CI_ENCODER_B_INPUT_TERM: "pfi10",
            }
            wired = f"/{self.settings.wires.board}/{lines.get(request.attribute_raw)}".lower()
            if task.kind != "ci" or request.value.lower() != wired:
                raise NotImplementedError("the simulated encoder's lines are A on PFI8 and B on PFI10; ask for these")
        return pb.SetChanAttributeStringResponse()

    def StartTask(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            self._start(task)
        return pb.StartTaskResponse()

    def _start(self, task: DaqTask) -> None:
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

    def _stop(self, task: DaqTask) -> None:
        task.running = False
        task.rows.clear()
        if task.kind == "ai" and self.clock.rig.sampling:
            self.clock.rig.stop()
            self.clock.log("sampling ended")
        if task.kind == "ao" and task.rate:
            self.clock.rig.timed = None

    def ClearTask(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            if task.running:
                self._stop(task)
            del self.tasks[request.task.name]
        return pb.ClearTaskResponse()

    def TaskControl(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            if request.action_raw == pb.TASK_CONTROL_ACTION_TASK_ABORT and task.running:
                self._stop(task)
        return pb.TaskControlResponse()

    def IsTaskDone(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
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
                raise NotImplementedError(f"a task of {task.kind or 'no'} channels cannot be read by this call")
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
        clocked = request.task.name in self.tasks and self.tasks[request.task.name].rate
        (self._queue if clocked else self._write)(request, context)
        return pb.WriteAnalogF64Response(samps_per_chan_written=request.num_samps_per_chan)

    def SetWriteAttributeInt32(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name):
            requested = (request.attribute_raw, request.value_raw)
            if requested != (pb.WRITE_ATTRIBUTE_REGEN_MODE, DO_NOT_REGENERATE):
                raise NotImplementedError(
                    "the simulated output does not regenerate its samples; set DO_NOT_ALLOW_REGENERATION"
                )
        return pb.SetWriteAttributeInt32Response()

    def _queue(self, request: Any, context: Any) -> None:
        """Samples for a clocked output: stored until it starts, then appended to its buffer."""
        with self.grpc_errors(context, request.task.name) as task:
            volts = self._check_volts(task, request.write_array)
            self.clock.rig.queue(volts) if task.running else task.rows.append(volts)

    def _write(self, request: Any, context: Any, values: Any = None) -> None:
        with self.grpc_errors(context, request.task.name) as task:
            self.clock.rig.write(float(self._check_volts(task, request.write_array if values is None else values)[-1]))

    @staticmethod
    def _check_volts(task: DaqTask, values: Any) -> NDArray[np.float64]:
        if task.kind != "ao":
            raise NotImplementedError(f"a task of {task.kind or 'no'} channels is not written")
        volts = np.array(list(values), float)
        if np.abs(volts).max(initial=0.0) > task.max_voltage:
            raise BoardError(UNSUPPORTED)
        return volts


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


def serve(clock: Clock) -> tuple[grpc.Server, int]:
    """Serve the board on the loopback: the running server and its port."""
    from concurrent.futures import ThreadPoolExecutor

    server = grpc.server(ThreadPoolExecutor(2), interceptors=(RefuseUnsupported(clock),))
    service.add_NiDAQmxServicer_to_server(Board(clock), server)
    port = server.add_insecure_port("127.0.0.1:0")
    server.start()
    return server, port
