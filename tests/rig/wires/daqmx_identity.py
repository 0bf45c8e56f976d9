"""Identity of the simulated board: the attributes of device and tasks, and its errors as gRPC statuses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import grpc
import numpy as np
from nidaqmx._stubs import nidaqmx_pb2 as pb
from nidaqmx._stubs import nidaqmx_pb2_grpc as service
from numpy.typing import NDArray
from tests.rig.wires.clock import Clock

from dampyr.rig.simulation.board_signals import BOARD_MESSAGES, BoardError

PRODUCT, SERIAL = "PCI-6221", 0x01A2B3C4
# NI-DAQmx's numbers of these errors
NO_CHANNEL, NO_TASK, NO_DEVICE = -200170, -200088, -200220
RESERVED, NOT_STARTED, ONE_SAMPLE, NO_SPACE, NOT_YET = -50103, -200846, -200547, -200293, -200292
BEYOND_LIMITS, EMPTY, TOO_SHORT, RUNNING, READ_TYPE = -200561, -200462, -200609, -200557, -200525
FILTER_WIDTH, FILTER_NOT_SET, FILTER_DIFFERS = -200777, -200771, -200775
CI_MEAS_TYPES = 0x2FD4  # what the counters of a device measure, as nidaqmx asks it
CHANNEL_ATTRIBUTES = {
    pb.CHANNEL_ATTRIBUTE_CHAN_TYPE: {"ai": 10100, "ao": 10102, "ci": 10131},
    pb.CHANNEL_ATTRIBUTE_AI_MEAS_TYPE: {"ai": 10322},
    pb.CHANNEL_ATTRIBUTE_CI_MEAS_TYPE: {"ci": 10361},
    pb.CHANNEL_ATTRIBUTE_AO_OUTPUT_TYPE: {"ao": 10322},
}  # NI-DAQmx's numbers for analogue input and output, counter input, voltage and linear encoder
MESSAGES = BOARD_MESSAGES | {
    NO_CHANNEL: "physical channel specified does not exist on this device",
    NO_TASK: "task specified is invalid or does not exist",
    NO_DEVICE: "device identifier is invalid",
    RESERVED: "the specified resource is reserved by another task",
    NOT_STARTED: "write cannot be performed: auto start is false and the task, without a clock, is not running",
    ONE_SAMPLE: "write failed: the buffer's size is configured automatically, and one sample is too few for it",
    NO_SPACE: "some samples can not be written: there is no space in the buffer, and no generation is in progress",
    NOT_YET: "some samples could not be written to the buffer yet, and the timeout has elapsed",
    BEYOND_LIMITS: "attempted writing analogue data that are too large or too small: they leave the channel's limits",
    EMPTY: "generation cannot be started: the output buffer is empty",
    TOO_SHORT: "generation cannot be started: the output buffer is too small",
    RUNNING: "the property cannot be set while the task is running",
    READ_TYPE: "the read does not fit the type of the task's channels",
    FILTER_WIDTH: "the device cannot produce this minimum pulse width of a digital filter",
    FILTER_NOT_SET: "the digital filter is enabled and its minimum pulse width is not configured",
    FILTER_DIFFERS: "the terminal is configured to a different minimum pulse width by another task",
}


@dataclass
class DaqTask:
    """A task: its kind ("ai", "ci" or "ao"), its channels, its clock, and the settings of its channels."""

    kind: str = ""
    channels: list[str] = field(default_factory=list)
    rate: float = 0.0
    running: bool = False
    pulse: float = 1.0
    initial: float = 0.0
    limits: tuple[float, float] = (-10.0, 10.0)
    latched: bool = False  # sampled by the encoder's index, not by the inputs' clock
    buffer: int = 0  # samples of an output; 0: its first write decides
    input_buffer: int = 10000  # samples
    reserved: bool = False
    lines: dict[str, str] = field(default_factory=dict)  # terminals of the encoder's lines
    filters: dict[str, dict[str, float]] = field(default_factory=dict)  # by line: "enable" and "width"
    rows: list[NDArray[Any]] = field(default_factory=list)

    def take(self, n: int) -> NDArray[Any]:
        """The next ``n`` buffered samples (channels, n)."""
        whole = np.concatenate(self.rows, axis=1)
        self.rows = [whole[:, n:]]
        return whole[:, :n]

    @property
    def waiting(self) -> int:
        """The number of buffered samples."""
        return sum(rows.shape[-1] for rows in self.rows)

    @property
    def resources(self) -> set[str]:
        """What no other task may hold: the one converter of the inputs, each counter, each output."""
        return {"ai"} if self.kind == "ai" else {channel.lower() for channel in self.channels}


class Identity(service.NiDAQmxServicer):
    """The calls of the service that neither sample nor write."""

    def __init__(self, clock: Clock) -> None:
        self.clock, self.settings = clock, clock.rig.settings
        self.tasks: dict[str, DaqTask] = {}
        self.task_count = 0

    @contextmanager
    def grpc_errors(
        self, context: grpc.ServicerContext, name: str = "", counted: Sequence[tuple[str, str]] = ()
    ) -> Iterator[DaqTask]:
        """Lock the rig for one call; an error of the board becomes the gRPC status that the client expects."""
        code, words = 0, ""
        try:
            with self.clock.locked():
                if name and name not in self.tasks:
                    raise KeyError(NO_TASK)
                yield self.tasks.get(name, DaqTask())
        except BoardError as problem:
            code = problem.code
        except KeyError as problem:
            code = int(problem.args[0])
        except NotImplementedError as problem:
            words = str(problem)
        if words:
            self.clock.log(f"refused: {words}")
            context.abort(grpc.StatusCode.UNIMPLEMENTED, words)
        if code:
            self.clock.log(f"board error {code}")
            context.set_trailing_metadata((("ni-error", str(code)), *counted))
            context.abort(grpc.StatusCode.UNKNOWN, MESSAGES[code])

    def take_latched(self) -> None:
        """Give the counts at the passes of the index to the tasks that it samples."""
        latched = [task for task in self.tasks.values() if task.running and task.latched]
        passes = self.clock.rig.index_counts() if latched else None
        for task in latched:
            task.rows.append(np.asarray(passes)[None])

    # what it is

    def GetDeviceAttributeString(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context):
            self._check_device(request.device_name)
            names = {
                pb.DEVICE_ATTRIBUTE_AI_PHYSICAL_CHANS: [f"ai{k}" for k in range(16)],
                pb.DEVICE_ATTRIBUTE_AO_PHYSICAL_CHANS: ["ao0", "ao1"],
                pb.DEVICE_ATTRIBUTE_CI_PHYSICAL_CHANS: ["ctr0", "ctr1"],
                pb.DEVICE_ATTRIBUTE_DO_LINES: [],  # it has none
                pb.DEVICE_ATTRIBUTE_TERMINALS: [f"PFI{k}" for k in range(16)],
            }
            named = {key: ", ".join(f"{request.device_name}/{name}" for name in value) for key, value in names.items()}
            texts = named | {pb.DEVICE_ATTRIBUTE_PRODUCT_TYPE: PRODUCT}
            if request.attribute_raw not in texts:
                raise NotImplementedError("the simulated board gives its product, channels and terminals only")
        return pb.GetDeviceAttributeStringResponse(value=texts[request.attribute_raw])

    def GetDeviceAttributeInt32Array(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context):
            self._check_device(request.device_name)
            if request.attribute_raw != CI_MEAS_TYPES:
                raise NotImplementedError("of such lists, the simulated board gives what its counters measure only")
        return pb.GetDeviceAttributeInt32ArrayResponse(value_raw=[10125, 10361])  # edges and linear encoders

    def GetDeviceAttributeDouble(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context):
            self._check_device(request.device_name)
            if request.attribute_raw != pb.DEVICE_ATTRIBUTE_AI_MAX_MULTI_CHAN_RATE:
                raise NotImplementedError("of such numbers, the simulated board gives the rate of its inputs only")
        return pb.GetDeviceAttributeDoubleResponse(value=250e3)

    def GetDeviceAttributeUInt32(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context):
            self._check_device(request.device_name)
            if request.attribute_raw != pb.DEVICE_ATTRIBUTE_SERIAL_NUM:
                raise NotImplementedError("the simulated board gives its product type and serial number only")
        return pb.GetDeviceAttributeUInt32Response(value=SERIAL)

    def GetDeviceAttributeBool(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context):
            self._check_device(request.device_name)
            clocks = (pb.DEVICE_ATTRIBUTE_AO_SAMP_CLK_SUPPORTED, pb.DEVICE_ATTRIBUTE_CI_SAMP_CLK_SUPPORTED)
            if request.attribute_raw not in (pb.DEVICE_ATTRIBUTE_IS_SIMULATED, *clocks):
                raise NotImplementedError(
                    "of the flags, the simulated board gives its clocks, and that it is simulated"
                )
        return pb.GetDeviceAttributeBoolResponse(value=True)

    def _check_device(self, name: str) -> None:
        if name.lower() != self.settings.wires.board.lower():
            raise KeyError(NO_DEVICE)

    def GetSystemInfoAttributeString(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context):
            if request.attribute_raw != pb.SYSTEM_ATTRIBUTE_DEV_NAMES:
                raise NotImplementedError("the simulated system says its devices' names and its version only")
        return pb.GetSystemInfoAttributeStringResponse(value=self.settings.wires.board)

    def GetSystemInfoAttributeUInt32(self, request: Any, context: Any) -> Any:
        versions = {
            pb.SYSTEM_ATTRIBUTE_NIDAQ_MAJOR_VERSION: 24,
            pb.SYSTEM_ATTRIBUTE_NIDAQ_MINOR_VERSION: 0,
            pb.SYSTEM_ATTRIBUTE_NIDAQ_UPDATE_VERSION: 0,
        }
        with self.grpc_errors(context):
            if request.attribute_raw not in versions:
                raise NotImplementedError("the simulated system says its devices' names and its version only")
        return pb.GetSystemInfoAttributeUInt32Response(value=versions[request.attribute_raw])

    def GetTaskAttributeString(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            said = {
                pb.TASK_ATTRIBUTE_NAME: request.task.name,
                pb.TASK_ATTRIBUTE_CHANNELS: ", ".join(task.channels),
                pb.TASK_ATTRIBUTE_DEVICES: self.settings.wires.board,
            }
            if request.attribute_raw not in said:
                raise NotImplementedError("the simulated board says its tasks' names, channels and devices only")
        return pb.GetTaskAttributeStringResponse(value=said[request.attribute_raw])

    def GetTaskAttributeUInt32(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            if request.attribute_raw != pb.TASK_ATTRIBUTE_NUM_CHANS:
                raise NotImplementedError("the simulated board says the number of its tasks' channels only")
        return pb.GetTaskAttributeUInt32Response(value=len(task.channels))

    def GetChanAttributeInt32(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            if request.attribute_raw not in CHANNEL_ATTRIBUTES:
                raise NotImplementedError("the simulated board says only what kind of channel one is")
            value = CHANNEL_ATTRIBUTES[request.attribute_raw][task.kind]
        return pb.GetChanAttributeInt32Response(value_raw=value)

    def GetReadAttributeString(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            if request.attribute_raw != pb.READ_ATTRIBUTE_CHANNELS_TO_READ:
                raise NotImplementedError("of a read the simulated board says its channels and their number only")
        return pb.GetReadAttributeStringResponse(value=", ".join(task.channels))

    def GetReadAttributeUInt32(self, request: Any, context: Any) -> Any:
        with self.grpc_errors(context, request.task.name) as task:
            self.take_latched()
            said = {
                pb.READ_ATTRIBUTE_NUM_CHANS: len(task.channels),
                pb.READ_ATTRIBUTE_AVAIL_SAMP_PER_CHAN: task.waiting + (0 if task.latched else self.clock.rig.waiting),
            }
            if request.attribute_raw not in said:
                raise NotImplementedError("of a read the simulated board says its channels and their number only")
        return pb.GetReadAttributeUInt32Response(value=said[request.attribute_raw])

    def GetErrorString(self, request: Any, context: Any) -> Any:
        return pb.GetErrorStringResponse(error_string=MESSAGES.get(request.error_code, ""))

    def GetExtendedErrorInfo(self, request: Any, context: Any) -> Any:
        return pb.GetExtendedErrorInfoResponse(error_string="")
