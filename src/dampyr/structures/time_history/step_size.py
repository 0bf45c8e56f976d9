r"""Length of the time steps: the rule that bounds it, and halving until the peaks stop changing.

Under control laws the peaks alone do not tell: a decision that falls the same wrong way at two steps leaves them alike. So two
successive halvings must agree, and a further run too in which every decision that the step leaves open is taken the other way.

The rule, for a limit L on the product of step and frequency:

.. math:: h \le 5\,\mathrm{ms}, \qquad \omega_s h \le L, \qquad \lambda h \le 2L, \qquad h \le L\,\tau_d, \qquad h \le \tau_l/2

:math:`\omega_s^2` and :math:`\lambda` are the largest slopes of the dampers at rest by stroke and by rate, over the mass that
they move, :math:`\tau_d` is the delay of a damper and :math:`\tau_l` the lag of a coil under a control law. `respond` ends at
L = 1/2 or below; an ensemble takes L = 1 in one run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.phrases import counted
from dampyr.structures.building import Building
from dampyr.structures.control_laws import lag_of, parts
from dampyr.structures.sites import Site, connections, describe_place, laws_of
from dampyr.structures.time_history.response import Integration, Output, relative_change

Array = NDArray[np.float64]

# The largest change of a peak on halving the step. The scheme is of fourth order, so the error is well below it.
ACCURACIES = {"strict": 2e-4, "fast": 1e-3}
MAX_STEP = 0.005  # s; on strong motion the peaks are good to 3e-4 with it
MAX_STEP_COUNT = 20_000_000  # of one integration: a minute or more
MAX_STEP_COUNT_UNDER_LAWS = 1_000_000  # seconds; some cases chatter at any step, and would all go on to the limit above
JUDGED = ("displacement", "drift")  # whose peaks the accuracy is of; the others have their own changes


def largest_step(building: Building, sites: tuple[Site, ...], slopes: Array, limit: float) -> float:
    """The longest step (s) that the rule allows; ``slopes`` (N, 2) are the greatest of each damper at rest.

    The slopes are an argument because they have two sources, which agree to about six digits: ``greatest_slopes`` of
    `dampyr.structures.time_history.kernel_run.DampedRun` where the kernel of the dampers runs anyway, and `difference_slopes`
    where it would be compiled for nothing else.
    """
    step = MAX_STEP
    for site, (by_stroke, by_rate) in zip(sites, slopes, strict=True):
        [row] = connections(building, (site,))
        flexibility = float(row @ np.linalg.solve(building.M, row))  # one over the mass that the damper moves
        if by_stroke > 0:
            step = min(step, limit / math.sqrt(by_stroke * flexibility))
        if by_rate > 0:
            step = min(step, 2.0 * limit / (by_rate * flexibility))
        if site.delay > 0:
            step = min(step, limit * site.delay)
        if site.law is not None and (lag := lag_of(site.law, site.damper)) > 0:
            step = min(step, 0.5 * lag)
    return step


def largest_stiffness(building: Building, sites: tuple[Site, ...], slopes: Array) -> float:
    r"""The largest :math:`\omega_s^2` (1/s2) of the dampers at rest; a tiny number where none resists a stroke."""
    flexibility = [float(row @ np.linalg.solve(building.M, row)) for row in connections(building, sites)]
    return max([1e-30, *(slopes[:, 0] * flexibility if sites else ())])


def difference_slopes(sites: tuple[Site, ...]) -> Array:
    """The greatest slopes of the dampers at rest (N, 2), over the inputs that their laws may take, by small differences along a
    path."""
    greatest = []
    for site in sites:
        greatest.append(np.max([_slopes_at_rest(site, values) for values in site.levels()], axis=0))
    return np.array(greatest).reshape(len(sites), 2)


SMALL_STROKE, SMALL_RATE = 1e-9, 1e-9  # m, m/s; far below any yield stroke, far above rounding


def _slopes_at_rest(site: Site, values: Array) -> tuple[float, float]:
    """The size of dF/dx and dF/dv of a damper at rest."""
    from dampyr.models.path_integration import along

    t = np.array([0.0, 1e-3])
    rest, moved, quick = (
        along(site.composition, t, np.array([0.0, x]), np.array([0.0, v]), values)[-1]
        for x, v in ((0.0, 0.0), (SMALL_STROKE, 0.0), (0.0, SMALL_RATE))
    )
    return abs(moved - rest) / SMALL_STROKE, abs(quick - rest) / SMALL_RATE


def steps_per_sample(dt: float, step: float, sites: tuple[Site, ...]) -> int:
    """The least number of steps in a sample of ``dt`` seconds that are no longer than ``step`` and suit the laws."""
    fitting = parts(laws_of(sites), dt)
    return fitting * max(1, math.ceil(dt / step / fitting * (1 - 1e-9)))


def given_steps_per_sample(motion: GroundMotion, step: float, sites: tuple[Site, ...]) -> int:
    """The number of steps of ``step`` seconds in a sample of the motion, checked."""
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


def halve_until_converged(run: Any, motion: GroundMotion, tolerance: float, m: int) -> Integration:
    """Halve the step until the peaks stop changing, or until there would be more than `MAX_STEP_COUNT` steps."""
    coarse = run(m)
    while True:
        m *= 2
        if m * len(motion.acceleration) > MAX_STEP_COUNT:
            reason = f"{m} steps per sample would pass {MAX_STEP_COUNT} steps"
            return replace(coarse, tolerance=tolerance, reason=reason)
        fine = run(m)
        changed = changes(coarse.out, fine.out)
        if largest(changed) <= tolerance and fine.out.misfit[0] == 0:
            return replace(fine, tolerance=tolerance, changes=changed)
        coarse = replace(fine, tolerance=tolerance, changes=changed)


def halve_under_laws(run: Any, motion: GroundMotion, tolerance: float, m: int) -> Integration:
    """As `halve_until_converged` under control laws: until two successive halvings agree, and a further run at the finest
    step agrees too, in which each decision that hangs on the step is taken the other way.

    A decision hangs on the step where the law could have taken another one, had it sensed each quantity as far off as it did at
    twice the step. One without consequence is not held against a case, as damped small motion chatters at any step. Where the
    runs never agree, the error is the larger of the last two changes. No run has more than `MAX_STEP_COUNT_UNDER_LAWS` steps,
    or than four times those of the first.
    """
    samples = len(motion.acceleration)
    max_step_count = min(MAX_STEP_COUNT, max(MAX_STEP_COUNT_UNDER_LAWS, 4 * m * samples))
    coarse, last, agreed, reason = run(m), dict[str, float](), False, ""
    while 2 * m * samples <= max_step_count:
        m *= 2
        fine = run(m, before=coarse.decisions.sensed)
        changed, others, unsolved = changes(coarse.out, fine.out), fine.decisions.others(), fine.out.misfit[0]
        agreed_before, agreed, reason = agreed, largest(changed) <= tolerance, ""
        if not (agreed and agreed_before):
            change = max(largest(changed), largest(last) if last else 0.0)
            reason = f"peaks of displacement and drift changed by {100 * change:.2g} % in the last two halvings"
        elif unsolved:
            reason = f"the forces of {counted(int(unsolved), 'step')} converged to {fine.out.misfit[1]:.1g} only"
        elif others is not None:
            other_way = changes(run(m, imposed=others).out, fine.out)
            if (change := largest(other_way)) > tolerance:
                share = f"{np.isfinite(others).sum()} of {fine.decisions.count} decisions of its laws"
                reason = f"{share} hang on the step, and taken the other way they change a peak by {100 * change:.2g} %"
            changed = {name: max(changed[name], other_way[name]) for name in changed}
        errors = {name: max(value, last.get(name, 0.0)) for name, value in changed.items()} if reason else changed
        coarse, last = replace(fine, tolerance=tolerance, changes=errors), changed
        if not reason:
            break
    if not coarse.changes:
        reason = "its first run has as many steps as are allowed, so that its error is not known"
    elif reason:
        reason += f", down to a step of {1e3 * coarse.step:.2g} ms; give the coil a lag, or the law a longer period"
    return replace(coarse, tolerance=tolerance, reason=reason)


def run_once(run: Any, m: int) -> Integration:
    """One run with m steps per sample, without an error estimate."""
    integration: Integration = run(m)
    unsolved, gap, _ = integration.out.misfit
    reason = f"the forces of {counted(int(unsolved), 'step')} converged to {gap:.1g} only" if unsolved else ""
    return replace(integration, reason=reason)


def changes(coarse: Output, fine: Output) -> dict[str, float]:
    """The largest relative change of the peaks of each quantity, and the largest change of a mean input in V or A."""
    before = coarse.peaks
    changed = {name: relative_change(before[name], peaks) for name, peaks in fine.peaks.items() if len(peaks)}
    if len(fine.mean_input):
        changed["mean_input"] = float(np.max(np.abs(coarse.mean_input - fine.mean_input)))
    return changed


def largest(changed: Mapping[str, float]) -> float:
    """The largest change of what the accuracy is of."""
    return max(changed[name] for name in JUDGED)


def tolerance_of(accuracy: str | float) -> float:
    """An accuracy as a number."""
    value = ACCURACIES.get(accuracy) if isinstance(accuracy, str) else accuracy
    if value is None or isinstance(value, bool) or not 0 < value < 1:
        raise InputError(
            f"accuracy = {accuracy!r} is not allowed; write 'strict' (2e-4), 'fast' (1e-3) or a number between 0 and 1"
        )
    return float(value)
