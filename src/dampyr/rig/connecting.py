"""Connections to a rig: the real one that a ``rig.toml`` names, or a simulated one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from dampyr.errors import InputError
from dampyr.rig.calibration import calibration_of, load_calibration
from dampyr.rig.instruments.catalogue import with_absolute_folders
from dampyr.rig.loop_process import LoopProcess, remote_rig
from dampyr.rig.session import Rig
from dampyr.rig.settings import RigSettings, load_settings
from dampyr.rig.simulation.faults import FaultSpec
from dampyr.rig.simulation.instrument_ends import Simulation, simulate_instruments
from dampyr.rig.specimen import specimen_of


def connect(settings: RigSettings | str | Path) -> Rig:
    """The rig whose wires ``settings`` (or a ``rig.toml``) name; nothing moves and no voltage is set.

    Raises :class:`~dampyr.errors.InputError` where no wires are named, :class:`~dampyr.errors.RigFault` where nothing answers.
    """
    rig, folder = _load(settings)
    if not rig.wires.serial:
        raise InputError(
            "wires.serial is empty, so there is nothing to connect to; name the Uno's port, or simulate the rig"
        )
    return _in_real_time(rig, folder)


def simulated(
    settings: RigSettings | str | Path | None = None,
    seed: int = 0,
    faults: Sequence[FaultSpec | str] = (),
    in_process: bool = True,
    real_time: bool = False,
    black_box: str | Path | None = None,
    parts: RigSettings | None = None,
    chip: tuple[str | Path, str | Path] | None = None,
) -> Rig:
    """A simulated rig, in this process, or, in ``real_time``, in the process that reads it.

    Parameters
    ----------
    settings
        A rig or its ``rig.toml``; the original rig where nothing is given. Its wires are not used.
    seed
        Of noise and lost bytes: the same calls give the same bits, but not in real time.
    faults
        The faults and their times, such as "stuck-encoder@12.5s for 3s" (`dampyr.rig.simulation.faults`).
    in_process
        Has no effect since 0.4.0, and will be gone in 0.5.0: a simulated rig has no wires.
    real_time
        The rig follows the wall clock; without it its time passes while it is read, and thirty seconds take one. Where the
        machine is too busy to keep up its clock is held back, by ``Rig.clock_held`` s in all, which its records say.
    black_box
        A file for a line of JSON per event, as it happens.
    parts
        What the rig really is, where ``settings`` are wrong about it: its supply, load cell, actuator and the others but wires,
        board and limits. None: what ``settings`` say.
    chip
        The program that runs the firmware's binary in simavr, and the binary, in place of the firmware's model
        (``dampyr help firmware``).

    Returns
    -------
    Rig
        Connected and not armed, its origin simulated; use it in a ``with`` statement, which closes it.

    Raises
    ------
    InputError
        A wrong argument.
    RigFault
        The process that reads it does not start, or the firmware's binary does not run.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> still = dp.rig.Drive(0.01, np.zeros(51), np.zeros(51))
    >>> with dp.rig.simulated() as rig, rig.armed() as table:
    ...     table.home()
    ...     table.go(0.0)
    ...     samples = sum(block.force.size for block, _ in table.play(still))
    >>> samples
    760
    """
    rig, folder = _load(settings)
    fault_specs = tuple(FaultSpec.parse(fault) if isinstance(fault, str) else fault for fault in faults)
    true = rig if parts is None else replace(parts, wires=rig.wires, board=rig.board, limits=rig.limits)
    simulation = Simulation(true, specimen_of(true, folder), seed, fault_specs, black_box, chip)
    if real_time:
        return _in_real_time(rig, folder, simulation)
    simulator = simulation.in_lockstep()
    try:
        uno, board = simulate_instruments(with_absolute_folders(_calibrated(rig, folder), folder), simulator)
    except BaseException:
        simulator.close()
        raise
    return Rig(
        rig,
        uno,
        board,
        threaded=False,
        folder=folder,
        clocked_by_reads=True,
        clock=lambda: simulator.time,
        on_close=[simulator.close],
        damper_persists=False,
        simulated=True,
    )


def open_rig(
    settings: RigSettings | str | Path | None = None,
    seed: int = 0,
    faults: Sequence[FaultSpec | str] = (),
    real_time: bool = False,
    chip: tuple[str | Path, str | Path] | None = None,
) -> Rig:
    """The real rig where ``settings`` name its wires, else a simulated one; see `connect` and `simulated`."""
    rig, _ = _load(settings)
    if not rig.wires.serial:
        return simulated(settings, seed, faults, real_time=real_time, chip=chip)
    if faults or real_time or chip:
        raise InputError("faults, real_time and chip are of a simulated rig, and wires.serial names a real one")
    return connect(rig if settings is None else settings)


def _in_real_time(rig: RigSettings, folder: Path | None, simulation: Simulation | None = None) -> Rig:
    """A rig that is read, at its wires or simulated, by a process of its own."""
    process = LoopProcess(with_absolute_folders(_calibrated(rig, folder), folder), simulation)
    try:
        return remote_rig(process, rig, folder, simulated=simulation is not None)
    except BaseException:
        process.close()
        raise


def _calibrated(rig: RigSettings, folder: Path | None) -> RigSettings:
    """The settings with the calibration that lies beside them: an instrument that is opened takes its ranges from these."""
    calibration = load_calibration(folder) if folder else None
    return (calibration or calibration_of(rig)).corrected(rig)


def _load(settings: RigSettings | str | Path | None) -> tuple[RigSettings, Path | None]:
    """The settings, and the folder beside which their card lies."""
    if settings is None or isinstance(settings, RigSettings):
        return settings or RigSettings(), None
    return load_settings(settings), Path(settings).parent
