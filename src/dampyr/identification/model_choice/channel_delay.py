r"""Whether the force of records was sampled later or earlier than their displacement, by a fit to them.

Two devices that begin a sample apart, or a filter in one channel, shift one channel against the other. A fit hides that: its
numbers bend until the misfit is small, and are wrong by tens of per cent. What they cannot take up shows in the residual
r = measured - modelled force F. To first order,

.. math:: r \approx \sum_k \frac{\partial F}{\partial p_k}\,\Delta p_k + c - \tau \dot F ,

so that :math:`\tau` is one more coefficient of a linear regression beside those of the parameters. Where it takes up `SHARE`
of what the parameters leave of the residual, the delay is searched with which the model, fitted again to moved motions, misses
least, up to `REACH` times the first estimate. It is told where the mean L1 ratio then is at most
`dampyr.identification.model_choice.missing_effect.WORTH` of that before, and at
most `FITTING`.

A delay within the damper, as of its coil, looks alike where it is positive; the part ``delay`` is for that. Records with a
varying input are left out. Models without a memory, to which every hysteresis is a delay, and those with a delay or a lag are
not looked at.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrError, DampyrWarning
from dampyr.identification.fits.fit_options import FitOptions
from dampyr.identification.fits.least_squares import fit_model
from dampyr.identification.fits.result import Fit
from dampyr.identification.model_choice.missing_effect import ADDED, WORTH, MissingEffect
from dampyr.identification.scoring.score import prediction
from dampyr.models import Damper
from dampyr.phrases import rounded
from dampyr.records import Record
from dampyr.records.conditioning.force_lag import correct_delay
from dampyr.records.conditioning.velocity import with_velocity

Array = NDArray[np.float64]
SHARE = (
    0.3  # of the residual's sum of squares beyond the parameters: what a delay takes up less of is the model's misfit
)
FITTING = 0.05  # mean L1 ratio: what misses more lacks something else, which a delay may resemble
PROMISING = 0.85  # of the mean L1 ratio: a first estimate that leaves more is not searched further
REACH = 4.0  # times the first estimate, which is one of first order, the delay is searched
MAX_FITS = 20  # of the search
SETTLED = 0.005  # of the first estimate, to which the delay is searched
MAX_RECORDS = 3  # that are looked at, from the first to the last
MAX_ROWS = 4000  # of a record's regression, which needs no more
# The correlation of a residual with itself, one sample on: white noise has none, and a delay that takes up `SHARE` of it leaves
# about that, as the slope of the force goes on from sample to sample.
NOISE = 0.05
STEP = 1e-4  # of a parameter, or of its unit where it is 0: for differences of the force
DELAYED = {"delay", "lag"}


def list_channel_delays(fit: Fit, options: FitOptions) -> list[MissingEffect]:
    """The delay of the force against the motion that a fit's records have in common; empty where there is none."""
    damper, records = fit.damper, [record for record in fit.records if not isinstance(record.input_channel, np.ndarray)]
    if damper is None or damper.temperatures is not None or not records:
        return []
    if not damper.composition.n_states or DELAYED & set(damper.composition.names):
        return []
    if all(_is_noise(residual) for residual in fit.optimum.residuals):
        return []
    chosen = [records[k] for k in np.unique(np.linspace(0, len(records) - 1, MAX_RECORDS).astype(int))]
    # what is to be said of the records and the model the fit itself has said
    with np.errstate(over="ignore", invalid="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        delay, share = _common_delay(damper, chosen, options.fixed)
        return _search(fit, chosen, delay, options) if share >= SHARE else []


def _is_noise(residual: Array) -> bool:
    """Whether nothing in a residual goes on from one sample to the next."""
    return abs(float(residual[1:] @ residual[:-1])) <= NOISE * float(residual @ residual)


def _search(fit: Fit, records: Sequence[Record], estimate: float, options: FitOptions) -> list[MissingEffect]:
    """The delay with which the model misses least, from an estimate in s; empty where it is not worth telling."""
    from scipy.optimize import minimize_scalar

    composition = fit.problem.composition
    whole = len(records) == len(fit.records) and options.laws is None
    moved = {0.0: fit} if whole else dict[float, Fit]()
    quick = replace(options, predict=(), starts=1, budget=None, laws=None)  # numbers of their own for the few inputs

    def cost(seconds: float) -> float:
        if seconds not in moved:
            motions = [correct_delay(record, seconds) for record in records] if seconds else records
            moved[seconds] = fit_model(composition, motions, quick)
        return math.inf if moved[seconds].damper is None else moved[seconds].outcome.cost

    def misfit(seconds: float) -> float:
        return float(np.mean([score.l1 for score in moved[seconds].scores.values()]))

    try:
        usual = cost(0.0)
        if not cost(estimate) < usual < math.inf or misfit(estimate) > PROMISING * misfit(0.0):
            return []
        ends, exact = sorted((0.0, REACH * estimate)), SETTLED * abs(estimate)
        found = minimize_scalar(cost, bounds=ends, method="bounded", options={"xatol": exact, "maxiter": MAX_FITS})
    except DampyrError:  # a motion that cannot be moved so far, or a model that cannot be fitted to it
        return []
    if not found.fun < usual:
        return []
    delay = float(found.x)
    before, after = misfit(0.0), misfit(delay)
    if not after <= min(WORTH * before, FITTING):
        return []
    return [MissingEffect(*_cause_and_repair(delay), after, before, len(composition.parameters))]


def _cause_and_repair(delay: float) -> tuple[str, str]:
    """The cause and the repair of a delay in s."""
    size = rounded(1e3 * abs(delay), 3)
    if delay < 0.0:
        return (
            f"the force was sampled {size} ms earlier than the displacement, which bends the parameters",
            f"read the files with force_delay={-1e-3 * float(size):g} (--force-delay -{size}ms)",
        )
    return (
        f"{ADDED['delay']}, of {size} ms, which bends the parameters",
        f"where the force was sampled later than the displacement, read the files with force_delay={1e-3 * float(size):g} "
        f"(--force-delay {size}ms); where the damper itself is late, fit with the part delay",
    )


def _common_delay(damper: Damper, records: Sequence[Record], fixed: Collection[str]) -> tuple[float, float]:
    """The median delay (s) of the records, and the mean share of their residuals that it takes up."""
    delays, shares = zip(*(_delay_of(damper, record, fixed) for record in records), strict=True)
    return float(np.median(delays)), float(np.mean(shares))


def _delay_of(damper: Damper, record: Record, fixed: Collection[str]) -> tuple[float, float]:
    """The delay of a record (s), and the share of what the parameters, but those ``fixed``, leave of its residual that it
    takes up."""
    if record.velocity is None or damper.bandwidth is not None:
        record = with_velocity(record, damper.bandwidth)
    fitted_input = float(np.clip(record.input_value or 0.0, *damper.range))  # which may differ from an end by rounding
    values = dict(zip(damper.all_laws, map(float, damper.values(fitted_input)), strict=True))

    def force_with(**changed: float) -> Array:
        return prediction(Damper(str(damper.composition), values | changed), record)

    force = force_with()
    columns = [np.ones(record.n)]
    for name, value in values.items():
        if name in fixed:
            continue
        change = STEP * (abs(value) or 1.0)
        if value + change > damper.composition.quantities[name].high:
            change = -change
        columns.append((force_with(**{name: value + change}) - force) / change)
    if not all(np.all(np.isfinite(each)) for each in (force, *columns)):  # a force that grows beyond all bounds
        return 0.0, 0.0
    every = max(1, record.n // MAX_ROWS)
    columns = [column[::every] for column in columns]
    # what of the force's derivative the parameters cannot take up is all that tells a delay from them
    residual = _regression_residual(columns, (record.force - force)[::every])
    slope = _regression_residual(columns, -np.gradient(force, record.time)[::every])
    product, of_slope, of_residual = float(slope @ residual), float(slope @ slope), float(residual @ residual)
    if min(of_slope, of_residual) <= 0.0:
        return 0.0, 0.0
    return product / of_slope, product**2 / (of_slope * of_residual)


def _regression_residual(columns: Sequence[Array], values: Array) -> Array:
    """What a least-squares regression on these columns leaves of the values."""
    table = np.stack(columns, axis=1)
    table = table / (np.linalg.norm(table, axis=0) + 1e-300)
    return np.asarray(values - table @ np.linalg.lstsq(table, values, rcond=1e-10)[0])
