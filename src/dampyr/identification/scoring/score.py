r"""Score of a damper on a record: a free run, only the offset taken from the record.

With the error :math:`e = \hat F - F` of which its mean is removed, and the force measured from the middle of its range but for
a hundredth of the samples at either end, :math:`F_c = F - (Q_{0.99} + Q_{0.01})/2`, over the samples of the window:

.. math:: L_1 = \frac{\sum|e|}{\sum|F_c|}, \quad \text{NRMSE} = \frac{\text{rms}(e)}{\text{rms}(F - \bar F)}, \quad
          R^2 = 1 - \text{NRMSE}^2, \quad \text{pointwise} = \text{mean}\frac{|e|}{|F_c|}

L1 is (3.1) of Raminelli (2020), where the force is measured from the middle of its range, :math:`(\max F + \min F)/2`. One
false sample of the load cell moves that middle, and with it the denominator: the L1 ratio falls as the record gets worse.
The quantiles do not follow it; with ``centre="midrange"`` the ratio is (3.1) to the letter. The pointwise error leaves out
samples with :math:`|F_c|` below 1 % of half that range, where it is a division by nothing. The measured force is never
smoothed here; where a laboratory did (``record.smoothed``), the model's force goes through the same moving average, and samples
at the ends without a whole window are left out.

The *level* of a record is a factor on its whole force, which is no property of the damper where it changes from one measurement
session to the next. With :math:`F'` and :math:`\hat F'` less their means over the first two whole cycles of the window
(of a motion that does not repeat, over its first fifth),

.. math:: g = \sum F' \hat F' / \sum \hat F'^2

is ``level``, and ``relevelled_l1`` is the L1 ratio of :math:`g \hat F` on the rest of the window: what is left once the
level is known.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.argument_kinds import DAMPER, RECORD, Argument, check_kinds
from dampyr.errors import InputError
from dampyr.identification.scoring.prediction_band import Band, prediction_band
from dampyr.identification.scoring.scoring_window import (
    MIN_SCORED,
    SETTLING,
    Window,
    loop_work,
    scoring_window,
    whole_cycles,
)
from dampyr.models import Damper
from dampyr.models.prediction_error import check_level
from dampyr.records import Record, cycle_bounds, with_velocity
from dampyr.records.conditioning.moving_average import averaged
from dampyr.records.conditioning.nominal_input import without_noise_beyond
from dampyr.records.conditioning.smoothing import force_average
from dampyr.shown import Shown

Array = NDArray[np.float64]
SMALL = 0.01  # of half the range of the force: below it the pointwise error divides by nothing
RELEVEL_CYCLES = 2  # whole cycles that give the level: one could hold a false sample
RELEVEL_SHARE = 0.2  # of the window, where the motion does not repeat
TAIL = 0.01  # of the samples at either end of the range: more false ones than a record has that is worth a score
Centre = Literal["quantiles", "midrange"]


@dataclass(frozen=True, repr=False)
class Score(Shown):
    """Ratios without unit (0.05 is 5 %); ``peak_force`` and ``energy`` are signed errors, model over measured less one.

    ``energy`` is per cycle (of the whole cycles in the window), NaN where there is none. ``offset`` in N is what was
    taken from the record. ``window`` says which samples. ``level`` is the factor that the first cycles put on the
    model's force, ``relevelled_l1`` the L1 ratio of the rest with it; both are NaN where too little is left. ``band`` is the
    predictive band where `score` was asked for one.
    """

    l1: float
    nrmse: float
    r2: float
    pointwise: float
    peak_force: float
    energy: float
    offset: float
    window: Window
    level: float = math.nan
    relevelled_l1: float = math.nan
    band: Band | None = None


def score(
    damper: Damper,
    record: Record,
    settling: float = SETTLING,
    window: tuple[float, float] | None = None,
    allow_extrapolation: bool = False,
    centre: Centre = "quantiles",
    band: float | None = None,
    session_prior: float | None = None,
) -> Score:
    """Run ``damper`` freely along ``record`` and compare.

    Parameters
    ----------
    damper
        whose force is predicted; only the offset is taken from the record.
    record
        with an input in the damper's unit, inside its calibrated range.
    settling
        s after the motion starts that are not scored: the unknown past is forgotten by then.
    window
        (from, to) in s, in the place of what ``settling`` leaves.
    allow_extrapolation
        also score at an input, or a motion, beyond what the damper was calibrated on.
    centre
        what the L1 ratio measures the force from: the middle of its ``"quantiles"``, or the ``"midrange"`` as (3.1) of
        Raminelli (2020).
    band
        share of the force, such as 0.9, that a `prediction_band` is to hold; without it there is no band.
    session_prior
        how much the force differs between measurement sessions (0.05 is 5 %), for the band; that of the card by default.

    Returns
    -------
    Score
        ratios without unit over the samples of its ``window``.

    Raises
    ------
    InputError
        the record's input is not the damper's, too little is left of the motion, or the card has nothing to make a band of.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> damper = dp.studies.raminelli_2020.damper()
    >>> t = np.linspace(0.0, 4.0, 801)
    >>> x = 0.008 * np.sin(2 * np.pi * t)
    >>> record = dp.records.Record(t, x, damper.force(t, x, voltage=1.98), voltage=1.98)
    >>> dp.identification.score(damper, record).l1 < 1e-4
    True
    """
    check_kinds("score", Argument("damper", damper, (Damper,), DAMPER), Argument("record", record, (Record,), RECORD))
    if band is not None:
        check_level(band, "band")
    plain = compare(record, prediction(damper, record, allow_extrapolation), settling, window, centre)
    if band is None:
        return plain
    stated = damper if session_prior is None else damper.with_session_prior(session_prior)
    predictive_band = prediction_band(stated, record, band, settling, window, allow_extrapolation=allow_extrapolation)
    return replace(plain, band=predictive_band)


def score_or_reason(damper: Damper, record: Record, settling: float = SETTLING) -> Score | str:
    """The score of a record, or why it has none."""
    try:
        return score(damper, record, settling)
    except InputError as problem:
        return str(problem)


def prediction(damper: Damper, record: Record, allow_extrapolation: bool = False) -> Array:
    """The force in N, shape (n,), that ``damper`` predicts along ``record``, with the velocity it was calibrated with, at
    the record's mean temperature where its laws depend on that. What the noise of a varying input reaches beyond the damper's
    range counts as the end of the range (`dampyr.records.conditioning.nominal_input.without_noise_beyond`).

    Where the record's force went through a moving average that is not undone, so does this one; at the ends, over what is there
    of the window.
    """
    check_kinds(
        "prediction", Argument("damper", damper, (Damper,), DAMPER), Argument("record", record, (Record,), RECORD)
    )
    if record.velocity is None or damper.bandwidth is not None:
        record = with_velocity(record, damper.bandwidth)
    temperature = None if record.temperature is None else float(np.mean(record.temperature))
    if damper.temperatures is not None and temperature is None:
        raise InputError(
            f"{record.name}: the damper's parameters depend on its temperature, and the record has none; give it a temperature "
            "channel in degC, or predict with damper.at_temperature(...)"
        )
    record = without_noise_beyond(record, *damper.range)
    force = damper.force(
        record.time,
        record.displacement,
        voltage=record.voltage,
        current=record.current,
        velocity=record.velocity,
        allow_extrapolation=allow_extrapolation,
        temperature=temperature,
    )
    average = force_average(record)
    return force if average is None else averaged(force, *average.reach(record.dt))


def span(force: Array) -> tuple[float, float]:
    """The range of a force in N but for a hundredth of its samples at either end, which may be false."""
    low, high = np.quantile(force, (TAIL, 1.0 - TAIL))
    return float(low), float(high)


def compare(
    record: Record,
    force: ArrayLike,
    settling: float = SETTLING,
    window: tuple[float, float] | None = None,
    centre: Centre = "quantiles",
) -> Score:
    """The scores of a force (n,) in N, from wherever, against a record; arguments as in `score`.

    Where the record's force holds a moving average (``record.smoothed``), ``force`` must have gone through the same, as that of
    `prediction` has.
    """
    if centre not in ("quantiles", "midrange"):
        raise InputError(f"centre = {centre!r} is unknown; choose 'quantiles' or 'midrange'")
    where = scoring_window(record, settling, window)
    measured, model = record.force[where.slice], np.asarray(force, dtype=float)[where.slice]
    offset = float(np.mean(measured - model))
    error = model + offset - measured
    low, high = span(measured) if centre == "quantiles" else (measured.min(), measured.max())
    centred = measured - 0.5 * (low + high)
    seen = np.abs(centred) > SMALL * 0.5 * (high - low)
    spread = float(np.sqrt(np.mean((measured - measured.mean()) ** 2)))
    if spread == 0.0:
        raise InputError(
            f"{record.name}: the force is constant at {measured[0]:g} N in the window; nothing to compare with"
        )
    nrmse = float(np.sqrt(np.mean(error**2))) / spread
    level, relevelled = _relevel(record, np.asarray(force, dtype=float), where, centre)
    return Score(
        l1=float(np.sum(np.abs(error)) / np.sum(np.abs(centred))),
        nrmse=nrmse,
        r2=1.0 - nrmse**2,
        pointwise=float(np.mean(np.abs(error[seen]) / np.abs(centred[seen]))),
        peak_force=float(np.ptp(model) / np.ptp(measured) - 1.0),
        energy=_compare_energy(record, np.asarray(force, dtype=float), where),
        offset=offset,
        window=where,
        level=level,
        relevelled_l1=relevelled,
    )


def relevelling_part(record: Record, where: Window) -> slice:
    """The samples of a window that its level is taken from: two whole cycles, or the first fifth where nothing repeats."""
    spans = [(a, b) for a, b in cycle_bounds(record) if a >= where.first and b <= where.last]
    if len(spans) > RELEVEL_CYCLES:
        return slice(spans[0][0], spans[RELEVEL_CYCLES - 1][1] + 1)
    count = where.last + 1 - where.first
    return slice(where.first, where.first + max(int(RELEVEL_SHARE * count), 1))


def _relevel(record: Record, force: Array, where: Window, centre: Centre) -> tuple[float, float]:
    """The level by the first cycles and the L1 ratio of the rest with it, NaN where one of the two holds next to nothing."""
    part = relevelling_part(record, where)
    rest = slice(part.stop, where.last + 1)
    if part.stop - part.start < MIN_SCORED or rest.stop - rest.start < MIN_SCORED:
        return math.nan, math.nan
    measured, model = (force_trace[part] - np.mean(force_trace[part]) for force_trace in (record.force, force))
    square = float(model @ model)
    level = float(measured @ model) / square if square > 0.0 else math.nan
    if not level > 0.0:
        return math.nan, math.nan
    later = record.force[rest]
    error = level * force[rest] - later
    centred = later - 0.5 * sum(span(later) if centre == "quantiles" else (later.min(), later.max()))
    return level, float(np.sum(np.abs(error - np.mean(error))) / max(np.sum(np.abs(centred)), 1e-300))


def _compare_energy(record: Record, force: Array, where: Window) -> float:
    whole = whole_cycles(record, where)
    if whole is None:
        return float("nan")
    span, _ = whole
    x = record.displacement[span]
    return float(loop_work(force[span], x) / loop_work(record.force[span], x) - 1.0)
