"""What a hybrid test has shown: the building's response with the measured force, beside the one that is all computed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.findings import Finding, worst_first
from dampyr.hybrid import substructure_kernel
from dampyr.hybrid.rig_drive import HybridDrive, static_force
from dampyr.hybrid.substructure import Substructure, SubstructureRun, coil_inputs
from dampyr.models.codegen.kernels import bind
from dampyr.origin import NOT_STATED, Origin
from dampyr.rig import RigSettings
from dampyr.shown import Shown
from dampyr.structures import Response

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class HybridResult(Shown):
    """A hybrid test and the same building all computed.

    ``time`` (T,) s of the building's time; ``displacement`` (n, T) m of its floors with the measured force, ``target`` (T,) m
    that the damper was to have and ``achieved`` that it had, ``force`` (T,) N measured, less the ``static_force``, and
    ``modelled`` (T,) N that of the model along the same path; ``computed`` the response with the model in the damper's place.
    ``origin`` is that of the forces: "virtual" where the actuator was computed too, and so the damper.
    ``lag`` s: what was left of the table's lag, of the building's time; ``energy_error`` the error of energy over the ground's
    energy.
    """

    title: str
    scale: float
    clock: float
    voltage: float
    time: Array
    displacement: Array
    target: Array
    achieved: Array
    force: Array
    modelled: Array
    static_force: float
    lag: float
    gain: float
    energy_error: float
    computed: Response
    origin: Origin = NOT_STATED
    of_record: tuple[Finding, ...] = ()  # what is wrong or in doubt in the record of the test; none of a computed one
    law: str = ""  # what set the input, in words, where a control law did; ``voltage`` is its mean then
    inputs: Array | None = None  # (T,) what that law asked for in the step that follows, in ``input_unit``
    input_unit: str = "V"

    @property
    def input_words(self) -> str:
        """The input as text."""
        return self.law or f"{self.voltage:g} V"

    @property
    def tested(self) -> str:
        """What tables and legends call the test: a hybrid test, simulated or virtual where it is."""
        return f"{self.origin.kind} hybrid test" if self.origin.notice else "hybrid test"

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is wrong or in doubt in the record of the test, in the response that it is compared with and in its damper."""
        return worst_first(self.of_record, self.computed.findings)

    @property
    def peaks(self) -> Array:
        """The floors' peak displacements (n,) [m] of the hybrid test."""
        peaks: Array = np.abs(self.displacement).max(axis=1)
        return peaks

    @property
    def differences(self) -> Array:
        """By how much each floor's peak differs from the computed one (n,), over it."""
        differences: Array = self.peaks / self.computed.peak_displacement - 1.0
        return differences

    @property
    def tracking_error(self) -> float:
        """The rms of the achieved less the wanted displacement, over the rms of the wanted one."""
        return float(np.sqrt(np.mean((self.achieved - self.target) ** 2) / np.mean(self.target**2)))

    def histories(self, floor: int) -> dict[str, Array]:
        """The displacement (T,) [m] of a floor, counted from 0: computed, and in the hybrid test."""
        computed = np.interp(self.time, self.computed.time, self.computed.displacement[floor])
        return {"computed": computed, self.tested: self.displacement[floor]}


def modelled_force(part: Substructure, run: SubstructureRun) -> Array:
    """The model's force (T,) [N] along the achieved path, the mean of the step that follows; without its static force."""
    assert part.model is not None
    follow = bind(substructure_kernel.follow_path, (part.model.composition,))
    s, out = np.array(part.model.composition.state0, float), np.zeros(len(run.achieved))
    begins = np.flatnonzero(np.diff(run.inputs[: part.steps], prepend=np.nan))  # of stretches of one input
    table = np.ascontiguousarray(part.model.values(run.inputs[begins], static=False))
    for first, last, p in zip(begins, [*begins[1:], part.steps], table, strict=True):
        follow(run.achieved, part.h, int(first), int(last), s, p, out)
    out[-1] = out[-2]
    return out


def replayed(drive: HybridDrive, displacement: Array, force: Array, rig: RigSettings) -> tuple[SubstructureRun, float]:
    """The computed part with the forces of a record, and the static force [N]; the record begins with the drive."""
    points, late = round(drive.period * rig.board.rate), round(rig.force_delay * rig.board.rate)
    first, last = (place * points + late for place in drive.cycles)
    static, begin = static_force(force, first, last), drive.lead_in * points + late
    run = replace(drive.substructure, adaptive=False).run()
    if len(force) < begin + drive.substructure.steps * points:
        raise InputError("the record ends before the hybrid test does; run it again")
    for k in range(drive.substructure.steps):
        rows = slice(begin + k * points, begin + (k + 1) * points)
        run.measured(float(displacement[rows.stop - 1]), float(np.mean(force[rows])) - static)
    return run, static


def follow_record(drive: HybridDrive, run: SubstructureRun, voltage: Array, rig: RigSettings) -> Array:
    """What the law asked for (T,) [V or A] in each step, by the voltage of a record; the model of ``run`` gets its inputs."""
    part, points = drive.substructure, round(drive.period * rig.board.rate)
    middle = (drive.lead_in + np.arange(part.steps)) * points + points // 2
    asked = np.append(voltage[middle], voltage[middle[-1]]) / drive.volts_per_input
    # A voltage that is read back has noise, which the range of the model does not allow for.
    run.inputs[:] = coil_inputs(np.clip(asked, part.law.low, part.law.high), part.law.low, part.law.lag, part.h)
    return asked
