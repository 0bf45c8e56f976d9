"""Connections to a rig: the real one that a ``rig.toml`` names, or a simulated one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from dampyr.errors import InputError
from dampyr.rig.calibration import load_calibration
from dampyr.rig.instruments.catalogue import with_absolute_folders
from dampyr.rig.instruments.connection import open_instruments
from dampyr.rig.loop_process import LoopProcess, remote_rig
from dampyr.rig.session import Rig
from dampyr.rig.settings import RigSettings, load_settings
from dampyr.rig.simulation.faults import FaultSpec
from dampyr.rig.simulation.instrument_ends import simulate_instruments
from dampyr.rig.simulation.process import Process
from dampyr.rig.simulation.shared_clock import SharedClock
from dampyr.rig.simulation.simulator import Simulator
from dampyr.rig.specimen import specimen_of


def connect(settings: RigSettings | str | Path) -> Rig:
    """The rig whose wires ``settings`` (or a ``rig.toml``) name; nothing moves and no voltage is set.

    Raises :class:`~dampyr.errors.InputError` where no wires are named, :class:`~dampyr.errors.RigFault` where nothing answers.
    """
    rig, folder = _settings(settings)
    if not rig.wires.serial:
        raise InputError(
            "wires.serial is empty, so there is nothing to connect to; name the Uno's port, or simulate the rig"
        )
    return _in_real_time(rig, rig, folder)


def simulated(
    settings: RigSettings | str | Path | None = None,
    seed: int = 0,
    faults: Sequence[FaultSpec | str] = (),
    in_process: bool = False,
    real_time: bool = False,
    black_box: str | Path | None = None,
    parts: RigSettings | None = None,
    chip: tuple[str | Path, str | Path] | None = None,
) -> Rig:
    """A simulated rig: a process of its own that speaks the real wires, or, ``in_process``, the plant without them.

    Parameters
    ----------
    settings
        A rig or its ``rig.toml``; the original rig where nothing is given. Its wires are not used.
    seed
        Of noise and lost bytes: in lockstep the same calls give the same bits.
    faults
        The faults and their times, such as "stuck-encoder@12.5s for 3s" (`dampyr.rig.simulation.faults`).
    real_time
        The rig follows the wall clock; without it the host advances it, and thirty seconds take one. Where the machine is too
        busy to keep up its clock is held back, by ``Rig.clock_held`` s in all, which its records say.
    black_box
        A file for a line of JSON per event, as it happens; only of a process.
    parts
        What the rig really is, where ``settings`` are wrong about it: its supply, load cell, actuator and the others but wires,
        board and limits. None: what ``settings`` say.
    chip
        The program that runs the firmware's binary in simavr, and the binary, in place of the firmware's model
        (docs/how-to/firmware.md); only of a process.

    Raises :class:`~dampyr.errors.InputError` for a wrong argument, :class:`~dampyr.errors.RigFault` where the process does
    not start.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> still = dp.rig.Drive(0.01, np.zeros(51), np.zeros(51))
    >>> with dp.rig.simulated(in_process=True) as rig, rig.armed() as table:
    ...     table.home()
    ...     table.go(0.0)
    ...     samples = sum(block.force.size for block, _ in table.play(still))
    >>> samples
    600
    """
    rig, folder = _settings(settings)
    fault_specs = tuple(FaultSpec.parse(each) if isinstance(each, str) else each for each in faults)
    true = rig if parts is None else replace(parts, wires=rig.wires, board=rig.board, limits=rig.limits)
    specimen = specimen_of(true, folder)
    if in_process:
        if real_time or black_box is not None or chip is not None:
            raise InputError("a rig in this process has no clock, no black box and no chip; leave in_process out")
        simulator = Simulator(true, seed, fault_specs, specimen)
        uno, board = simulate_instruments(with_absolute_folders(rig, folder), simulator)
        return Rig(
            rig, uno, board, threaded=False, folder=folder, clocked_by_reads=True, damper_persists=False, simulated=True
        )
    process = Process(with_absolute_folders(true, folder), specimen, seed, fault_specs, real_time, black_box, chip)
    try:
        wires: dict[str, Any] = dict(process.wires)
        wired = replace(rig, wires=replace(rig.wires, **wires))
        if real_time:
            return _in_real_time(
                rig, wired, folder, [process.close], clock=process.clock, damper_persists=False, simulated=True
            )
        named = with_absolute_folders(_calibrated(wired, folder), folder)
        answering, sampling = open_instruments(named, simulated=True)
        closing = [process.close]
        return Rig(
            rig,
            answering,
            sampling,
            threaded=False,
            folder=folder,
            on_close=closing,
            damper_persists=False,
            simulated=True,
        )
    except BaseException:
        process.close()
        raise


def open_rig(
    settings: RigSettings | str | Path | None = None,
    seed: int = 0,
    faults: Sequence[FaultSpec | str] = (),
    in_process: bool = False,
    real_time: bool = False,
    chip: tuple[str | Path, str | Path] | None = None,
) -> Rig:
    """The real rig where ``settings`` name its wires, else a simulated one; see `connect` and `simulated`."""
    rig, _ = _settings(settings)
    if not rig.wires.serial:
        return simulated(settings, seed, faults, in_process, real_time, chip=chip)
    if faults or in_process or real_time or chip:
        raise InputError(
            "faults, in_process, real_time and chip are of a simulated rig, and wires.serial names a real one"
        )
    return connect(rig if settings is None else settings)


def _in_real_time(
    rig: RigSettings,
    wired: RigSettings,
    folder: Path | None,
    on_close: Sequence[Callable[[], None]] = (),
    damper_persists: bool = True,
    clock: SharedClock | None = None,
    simulated: bool = False,
) -> Rig:
    """A rig that is read, at the wires of ``wired``, by a process of its own; ``clock``: simulated, by that time."""
    process = LoopProcess(with_absolute_folders(_calibrated(wired, folder), folder), clock)
    try:
        return remote_rig(process, rig, folder, on_close, damper_persists, clock, simulated)
    except BaseException:
        process.close()
        raise


def _calibrated(rig: RigSettings, folder: Path | None) -> RigSettings:
    """The settings with the calibration that lies beside them: an instrument that is opened takes its ranges from these."""
    calibration = load_calibration(folder) if folder else None
    return rig if calibration is None else calibration.corrected(rig)


def _settings(given: RigSettings | str | Path | None) -> tuple[RigSettings, Path | None]:
    """The settings, and the folder beside which their card lies."""
    if given is None or isinstance(given, RigSettings):
        return given or RigSettings(), None
    return load_settings(given), Path(given).parent
