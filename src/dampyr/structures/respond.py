r"""The response of a building with dampers to a ground motion.

The coupling (:mod:`dampyr.structures.time_stepping`) is one for every damper. Its step is found here: the final
one satisfies :math:`\omega_s h \le 1/2`, with :math:`\omega_s^2 = k/m` of the dampers at rest, and is
halved until no peak of displacement or drift changes by more than the accuracy asked for.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrWarning, InputError
from dampyr.ground_motions import GroundMotion
from dampyr.structures.building import Building
from dampyr.structures.connection import describe_place, label
from dampyr.structures.control_law import describe_law, lag_of, parts
from dampyr.structures.kernel_run import Run, connections, drifts, runner
from dampyr.structures.linear_response import largest
from dampyr.structures.response import Energy, Response
from dampyr.structures.sites import LEVELS, Site, laws_of, place
from dampyr.structures.workspace import Output

Array = NDArray[np.float64]

ACCURACIES = {"strict": 2e-4, "fast": 1e-3}
MAX_STEP = 0.005
MAX_STEP_COUNT = 20_000_000


def respond(
    building: Building,
    motion: GroundMotion,
    dampers: Mapping[Any, Any] | None = None,
    voltage: Any = None,
    current: Any = None,
    accuracy: str | float = "strict",
    step: float | None = None,
    allow_extrapolation: bool = False,
) -> Response:
    """The response of ``building`` to ``motion``, from rest.

    Parameters
    ----------
    dampers : place -> damper, or a list of dampers that stand side by side. A place is a storey i, which
        joins the floors i-1 and i (0 is the ground), or any two floors (i, j) by label or count, such as
        (0, 2): the stroke is q_j - q_i, and (1, 2) is storey 2. None for the bare building. The static
        force of a damper is left out, springs stay; ``damper.on_brace(stiffness)`` puts it on a brace.
    voltage, current : the input: a number, which is constant, or a control law
        (:func:`~dampyr.structures.control_law.control_law`); one for all dampers or a mapping from place to one.
    accuracy : "strict" (2e-4), "fast" (1e-3) or a number: the largest relative change of a peak
        displacement or drift when the step is halved. The scheme is of fourth order, so the error of the
        finer one is well below.
    step : s; run once with this step, which must divide the motion's and the period of every law.
    allow_extrapolation : take an input outside the range that a damper was calibrated on, with a warning.

    Raises :class:`~dampyr.errors.InputError` for a wrong argument and warns
    (:class:`~dampyr.errors.DampyrWarning`) where the accuracy was not reached or where a damper, on the
    whole, fed the building.
    """
    sites = place(building, dampers, voltage, current, allow_extrapolation)
    run = runner(building, motion, sites)
    if step is None:
        best = refined(run, motion, _tolerance(accuracy), _first_division(building, motion, sites, run))
    else:
        best = _single(run, _division(motion, step, sites))
    response = _response(building, motion, sites, best)
    _warn(response, sites)
    for note in response.outside:
        warnings.warn(note, DampyrWarning, stacklevel=2)
    return response


def _tolerance(accuracy: str | float) -> float:
    value = ACCURACIES.get(accuracy) if isinstance(accuracy, str) else accuracy
    if value is None or isinstance(value, bool) or not 0 < value < 1:
        raise InputError(
            f"accuracy = {accuracy!r} is not allowed; write 'strict' (2e-4), 'fast' (1e-3) or a number between 0 and 1"
        )
    return float(value)


def _division(motion: GroundMotion, step: float, sites: tuple[Site, ...]) -> int:
    """How many of the given steps make one of the motion's."""
    if not math.isfinite(step) or step <= 0:
        raise InputError(f"step = {step!r} s is not allowed; it must be greater than 0")
    m = max(round(motion.dt / step), 1)
    if abs(m * step / motion.dt - 1) > 1e-6:
        low = max(math.floor(motion.dt / step), 1)
        near = f"{motion.dt / low:.6g} s or {motion.dt / (low + 1):.6g} s"
        raise InputError(
            f"step = {step:g} s does not divide the motion's {motion.dt:g} s; the nearest that do are {near}"
        )
    for site in sites:
        if 0 < site.delay < motion.dt / m * (1 - 1e-9):
            raise InputError(
                f"step = {step:g} s is longer than the delay of {site.delay:g} s "
                f"of the damper {describe_place(site.place)}; "
                "take a step of at most the delay"
            )
    if m % (fitting := parts(laws_of(sites), motion.dt)):
        raise InputError(
            f"step = {step:g} s does not divide the periods of the laws; "
            f"take {motion.dt / fitting:.6g} s or a whole part of it"
        )
    return m


def _first_division(building: Building, motion: GroundMotion, sites: tuple[Site, ...], run: Any) -> int:
    """The first, coarse division of a sample: twice the step of the rule, so that the first halving
    meets the rule."""
    lags = (lag_of(site.law, site.damper) for site in sites if site.law)
    step = min([2 * MAX_STEP, motion.dt, *(s.delay for s in sites if s.delay > 0), *(lag for lag in lags if lag > 0)])
    if sites:
        slopes = _rest_slopes(run, sites)
        rows = connections(building, sites)
        flexibility = np.einsum("si,si->s", rows, np.linalg.solve(building.M, rows.T).T)
        omega = math.sqrt(float(np.max(np.abs(slopes[:, 0]) * flexibility)))
        rate = float(np.max(np.abs(slopes[:, 1]) * flexibility))
        step = min(step, 1.0 / omega if omega > 0 else step, 2.0 / rate if rate > 0 else step)
    fitting = parts(laws_of(sites), motion.dt)
    return fitting * math.ceil(motion.dt / step / fitting * (1 - 1e-9))


def _rest_slopes(run: Any, sites: tuple[Site, ...]) -> Array:
    """The greatest slopes of the dampers at rest (N, 2), over the inputs that their laws may take."""
    inputs = range(LEVELS) if any(site.law for site in sites) else range(1)
    slopes = [np.abs(run(1, samples=1, start=k / (LEVELS - 1)).out.rest_slopes) for k in inputs]
    return np.asarray(np.max(slopes, axis=0))


def refined(run: Any, motion: GroundMotion, tolerance: float, m: int, max_step_count: int | None = None) -> Run:
    """Halve the step until the peaks stand still, or until there would be more than ``most`` steps."""
    max_step_count = max_step_count or MAX_STEP_COUNT
    coarse = run(m)
    while True:
        m *= 2
        if m * len(motion.acceleration) > max_step_count:
            reason = f"{m} steps per sample would pass {max_step_count} steps"
            return Run(coarse.out, coarse.step, tolerance, coarse.error, reason)
        fine = run(m)
        error = _change(coarse.out, fine.out)
        if error <= tolerance and fine.out.misfit[0] == 0:
            return Run(fine.out, fine.step, tolerance, error)
        coarse = Run(fine.out, fine.step, tolerance, error)


def _single(run: Any, m: int) -> Run:
    done: Run = run(m)
    missed, gap, _ = done.out.misfit
    reason = f"the forces of {missed:.0f} steps were found to {gap:.1g} only" if missed else ""
    return Run(done.out, done.step, None, None, reason)


def _change(coarse: Output, fine: Output) -> float:
    """The largest relative change of a peak displacement or drift."""
    worst = 0.0
    for a, b in ((coarse.displacement_peak, fine.displacement_peak), (coarse.drift_peak, fine.drift_peak)):
        size = np.maximum(np.abs(b), 1e-9 * np.max(np.abs(b)) + 1e-300)
        worst = max(worst, float(np.max(np.abs(a - b) / size)))
    return worst


def _response(building: Building, motion: GroundMotion, sites: tuple[Site, ...], run: Run) -> Response:
    out, n = run.out, building.n
    rows, pull = connections(building, sites), building.influence @ building.M
    q = np.ascontiguousarray(out.state[:, :n].T)
    drift = drifts(building) @ q
    general = any(not site.composition.path_only or site.delay > 0 for site in sites)
    return Response(
        time=motion.time,
        ground_acceleration=motion.acceleration,
        displacement=q,
        velocity=np.ascontiguousarray(out.state[:, n:].T),
        acceleration=np.ascontiguousarray(out.acceleration.T),
        drift=drift,
        base_shear=-(out.acceleration @ pull),
        force=np.ascontiguousarray(out.force.T),
        stroke=rows @ q,
        peak_displacement=out.displacement_peak,
        peak_drift=out.drift_peak,
        peak_acceleration=out.acceleration_peak,
        peak_base_shear=float(out.shear_peak[0]),
        peak_force=out.force_peak,
        energy=_energy(building, out),
        storeys=tuple(site.storey for site in sites),
        sites=tuple(label(building, site.place) for site in sites),
        inputs=tuple(site.input_value for site in sites),
        laws=tuple(describe_law(site.law, site.damper.input) if site.law else "" for site in sites),
        input=np.ascontiguousarray(out.input.T),
        input_units=tuple(site.damper.input for site in sites),
        floors=tuple(building.floors),
        scheme="linear" if not sites else "general" if general else "exact path",
        step=run.step,
        accuracy=run.tolerance,
        error_estimate=run.error,
        converged=not run.reason,
        reason=run.reason,
        title=f"{building.name}, {motion.name}",
        outside=tuple(note for d, site in enumerate(sites) for note in _outside(site, rows[d], out, motion.dt)),
    )


def _outside(site: Site, row: Array, out: Output, dt: float) -> list[str]:
    """Which calibrated limits of displacement and velocity the motion of a site leaves."""
    n = len(row)
    stroke, rate = out.state[:, :n] @ row, out.state[:, n:] @ row
    reach = out.drift_peak[site.storey - 1] if site.storey else largest(stroke, rate, dt)
    reached = {"displacement": (float(reach), "m"), "velocity": (float(np.max(np.abs(rate))), "m/s")}
    notes = []
    for name, (value, unit) in reached.items():
        limit = site.damper.ranges.get(name, (0.0, math.inf))[1]
        if value > 1.01 * limit:
            notes.append(
                f"the damper {describe_place(site.place)} reaches a {name} of {value:.4g} {unit}; "
                f"it was calibrated up to {limit:.4g} {unit}"
            )
    return notes


def _energy(building: Building, out: Output) -> Energy:
    q, v = out.state[:, : building.n], out.state[:, building.n :]
    kinetic = 0.5 * np.einsum("ti,ij,tj->t", v, building.M, v)
    strain = 0.5 * np.einsum("ti,ij,tj->t", q, building.K, q)
    work = out.work.T
    return Energy(work[0].copy(), kinetic, strain, work[1].copy(), work[2:].copy())


def _warn(response: Response, sites: tuple[Site, ...]) -> None:
    if not response.converged:
        warnings.warn(f"the response is not to its accuracy: {response.reason}", DampyrWarning, stacklevel=3)
    scale = 1e-6 * float(np.max(np.abs(response.energy.input)))
    for site, work in zip(sites, response.energy.dampers, strict=True):
        if work[-1] < -scale:
            warnings.warn(
                f"the damper {describe_place(site.place)} fed {-work[-1]:.3g} J into "
                "the building over the whole motion; "
                "check its delay and the sign of its force",
                DampyrWarning,
                stacklevel=3,
            )
