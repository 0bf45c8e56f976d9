"""The simulated board refuses what NI documents its driver to refuse, with NI's numbers (docs/reference/ni-daqmx.md)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from tests.rig.wires.clock import Clock

from dampyr.rig import RigSettings
from dampyr.rig.simulation.event_log import EventFile
from dampyr.rig.simulation.simulator import Simulator

grpc = pytest.importorskip("grpc", reason="the extra rig is not installed: pip install dampyr[rig]")
nidaqmx = pytest.importorskip("nidaqmx", reason="the extra rig is not installed: pip install dampyr[rig]")


class Wired:
    """Tasks at the simulated board."""

    def __init__(self) -> None:
        from tests.rig.wires.daqmx_service import start_server

        self.clock = Clock(Simulator(RigSettings()), EventFile(None))
        self.server, port = start_server(self.clock)
        self.channel, self.tasks = grpc.insecure_channel(f"127.0.0.1:{port}"), []

    def task(self) -> Any:
        self.tasks.append(nidaqmx.Task(grpc_options=nidaqmx.GrpcSessionOptions(self.channel, "")))
        return self.tasks[-1]

    def output(self, low: float = 0.0, high: float = 5.0) -> Any:
        task = self.task()
        task.ao_channels.add_ao_voltage_chan("Dev1/ao0", min_val=low, max_val=high)
        return task

    def clocked(self, buffer: int = 0) -> Any:
        from nidaqmx.constants import AcquisitionType, RegenerationMode

        task = self.output()
        task.timing.cfg_samp_clk_timing(1000.0, sample_mode=AcquisitionType.CONTINUOUS, samps_per_chan=100)
        task.out_stream.regen_mode = RegenerationMode.DONT_ALLOW_REGENERATION
        if buffer:
            task.out_stream.output_buf_size = buffer
        return task

    def inputs(self, samples: int = 10000) -> Any:
        from nidaqmx.constants import AcquisitionType

        task = self.task()
        task.ai_channels.add_ai_voltage_chan("Dev1/ai0", min_val=-10, max_val=10)
        task.timing.cfg_samp_clk_timing(1000.0, sample_mode=AcquisitionType.CONTINUOUS, samps_per_chan=samples)
        return task

    def encoder(self, counter: str = "ctr0") -> tuple[Any, Any]:
        from nidaqmx.constants import EncoderType, LengthUnits

        task = self.task()
        channel = task.ci_channels.add_ci_lin_encoder_chan(
            f"Dev1/{counter}", decoding_type=EncoderType.X_4, units=LengthUnits.TICKS, dist_per_pulse=20e-6
        )
        return task, channel


@pytest.fixture
def wired() -> Iterator[Wired]:
    made = Wired()
    yield made
    for task in made.tasks:
        if task._handle is not None:
            task.close()
    made.channel.close()
    made.server.stop(0.1).wait()


def code(call: Callable[[], object]) -> int:
    """The number of the error."""
    with pytest.raises(nidaqmx.DaqError) as problem:
        call()
    return int(problem.value.error_code)


def test_limits_of_an_output(wired: Wired) -> None:
    assert code(lambda: wired.output(high=10.5)) == -200077
    assert code(lambda: wired.output(low=5.0, high=1.0)) == -200077
    task = wired.output(0.0, 4.4)
    assert code(lambda: task.write(4.5, auto_start=True)) == -200561
    assert code(lambda: task.write(-0.1, auto_start=True)) == -200561
    assert code(lambda: task.write(1.0, auto_start=False)) == -200846
    task.write(4.4, auto_start=True)
    assert wired.clock.rig.command == pytest.approx(4.4, abs=1e-3)


def test_a_resource_has_one_task_at_a_time(wired: Wired) -> None:
    timed, static = wired.clocked(), wired.output()
    timed.write(np.zeros(10))
    assert code(lambda: static.write(1.0, auto_start=True)) == -50103
    from nidaqmx.constants import TaskMode

    timed.control(TaskMode.TASK_ABORT)
    static.write(1.0, auto_start=True)
    assert code(lambda: timed.write(np.zeros(10))) == -50103
    static.close()
    timed.write(np.zeros(10))
    first, second = wired.inputs(), wired.inputs()
    first.start()
    assert code(second.start) == -50103
    place, _ = wired.encoder()
    other, _ = wired.encoder()
    place.read()
    assert code(other.read) == -50103


def test_the_buffer_of_an_output(wired: Wired) -> None:
    task = wired.clocked()
    assert code(lambda: task.write(np.zeros(1))) == -200547
    assert code(task.start) == -200462
    task.write(np.zeros(10))
    assert code(lambda: task.write(np.zeros(1), auto_start=False)) == -200293
    inputs = wired.inputs()
    task.start()
    inputs.start()
    with pytest.raises(nidaqmx.errors.DaqWriteError) as problem:
        task.write(np.zeros(5), timeout=0.01)
    assert (problem.value.error_code, problem.value.samps_per_chan_written) == (-200292, 0)
    inputs.read(3)
    with pytest.raises(nidaqmx.errors.DaqWriteError) as problem:
        task.write(np.zeros(5), timeout=0.01)
    assert (problem.value.error_code, problem.value.samps_per_chan_written) == (-200292, 3)  # a part of it was written

    def resize() -> None:
        task.out_stream.output_buf_size = 100

    assert code(resize) == -200557


def test_an_output_that_has_run_out_says_so(wired: Wired) -> None:
    for end in ("write", "stop", "close", "is_task_done"):
        task, inputs = wired.clocked(100), wired.inputs()
        task.write(np.zeros(10))
        task.start()
        inputs.start()
        inputs.read(5)
        assert not task.is_task_done()
        inputs.read(10)
        call = (lambda task=task: task.write(np.zeros(10))) if end == "write" else getattr(task, end)
        assert code(call) == -200290
        from nidaqmx.constants import TaskMode

        if end in ("write", "is_task_done"):
            task.control(TaskMode.TASK_ABORT)
        if end != "close":
            task.close()
        else:
            task._handle = None
        inputs.close()


def test_filters_of_the_encoder(wired: Wired) -> None:
    task, channel = wired.encoder()

    def width(value: float) -> None:
        channel.ci_encoder_a_input_dig_fltr_min_pulse_width = value

    assert code(lambda: width(1e-6)) == -200777
    channel.ci_encoder_a_input_dig_fltr_enable = True
    assert code(task.start) == -200771
    width(6.425e-6)
    task.start()
    assert code(lambda: width(125e-9)) == -200557
    other, second = wired.encoder("ctr1")
    second.ci_encoder_a_input_term = "/Dev1/PFI8"
    second.ci_encoder_a_input_dig_fltr_min_pulse_width = 125e-9
    second.ci_encoder_a_input_dig_fltr_enable = True
    assert code(other.start) == -200775


def test_reads(wired: Wired) -> None:
    from nidaqmx.stream_readers import AnalogSingleChannelReader, CounterReader

    inputs, (place, _) = wired.inputs(), wired.encoder()
    ticks, volts = np.empty(1, np.uint32), np.empty(1)
    assert code(lambda: CounterReader(inputs.in_stream).read_many_sample_uint32(ticks, 1)) == -200525
    assert code(lambda: AnalogSingleChannelReader(place.in_stream).read_many_sample(volts, 1)) == -200525
    inputs.start()
    inputs.read(10)
    wired.clock.rig.run_unattended(10.1)  # the host is away for longer than the buffer lasts
    assert code(lambda: inputs.read(10)) == -200279
