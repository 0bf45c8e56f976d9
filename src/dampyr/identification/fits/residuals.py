r"""Residual analysis: the measured less the modelled force of each record, by time, cycle and direction of motion.

The residual is measured less modelled force, :math:`r = F - \hat F` in N, sample by sample of each record; fits and
free runs are treated alike. Definitions, for one record of n samples at the median interval :math:`\Delta t`:

- **directions**: out (the damper is pulled, v > 0) and in (it is pushed, v < 0), see below.
- **autocorrelation** :math:`\rho_k = \sum_i r_i r_{i+k} / \sum_i r_i^2`, the record's mean taken off.
- **correlation time** :math:`\tau = \Delta t\,(1 + 2\sum_{k \ge 1} \rho_k)`, the sum of pairs :math:`\rho_{2m} + \rho_{2m+1}`
  ended where the first is not positive [Geyer1992]_, never below one interval. White noise has :math:`\tau = \Delta t`.
- **effective samples** :math:`n \Delta t / \tau`: as many independent ones give the mean as well. An upper bound, as
  what repeats from cycle to cycle returns after the sum has ended.
- **repeats**: :math:`\rho` at one period of the motion, unbiased: the share of the residual's variance that comes again in
  each cycle. Noise does not; a model's wrong shape does.
- **noise**: :math:`\text{rms}(r_{i+1} - r_i)/\sqrt 2`, the size that a residual without memory would have [vonNeumann1941]_;
  at most that, as a smooth residual has differences too.
- **misfit**: the residual is not noise alone where :math:`\tau` exceeds ``correlated`` intervals, or its rms exceeds
  ``beyond_noise`` times the noise (`dampyr.identification.fit_thresholds.FitThresholds`).

Each way is halved where the motion passes the middle of its stroke: before it the damper speeds up, beyond it it slows down.
The middle is a straight line through the displacement, so that a drift moves no boundary. Samples slower than `SLOW` of the
record's greatest speed belong to no side.

A model that is the same in both directions has a residual :math:`m(v)` that changes its sign with the mirrored motion. Its
even part :math:`e(v) = (m(v) + m(-v))/2`, of the medians binned over velocity before and beyond the middle, less the mean
that each record's offset takes, is what such a model cannot follow; **asymmetry** is its rms over the samples in N. By chance
alone its share of the residual's variance is at most about b/n for b bins and n effective samples. The damper may be the
cause, or a motion that is not alike in both directions. A friction that differs between the directions is an offset, and no
analysis of these residuals can see it.

References
----------
.. [Geyer1992] C. J. Geyer, "Practical Markov chain Monte Carlo", Statistical Science 7 (1992) 473-483.
.. [vonNeumann1941] J. von Neumann, "Distribution of the ratio of the mean square successive difference to the variance",
   Annals of Mathematical Statistics 12 (1941) 367-395.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.identification.fit_thresholds import FitThresholds
from dampyr.origin import NOT_STATED, Origin
from dampyr.records import Record, cycle_bounds
from dampyr.records.cycle_analysis.measure import peak_to_peak
from dampyr.shown import Shown

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
MAX_LAG = 3.0  # s, of the autocorrelation that is returned
MIN_TRACE = 8  # samples
MIN_PERIODS = 3.0  # for the autocorrelation after one period
SLOW = 0.02  # of the greatest speed: slower samples belong to no direction
BINS = 24  # of velocity, even so that none straddles zero
MIN_BIN_SAMPLES = 10  # for quartiles
BRANCHES = ("before the middle", "beyond the middle")
SIDES = ("out", "in", *(f"{way}, {branch}" for way in ("out", "in") for branch in BRANCHES))


@dataclass(frozen=True, repr=False)
class Trace(Shown):
    """One record as it is analysed.

    Parameters
    ----------
    name
        of the record; no two traces of an analysis have the same.
    time, displacement, velocity
        (n,) in s, m and m/s, of 8 samples or more.
    force
        (n,) N, measured.
    residual
        (n,) N, measured less modelled.
    input_value
        its mean input in V or A.
    stroke
        peak to peak, m.
    frequency
        Hz, NaN where there is no whole cycle.

    Raises
    ------
    InputError
        channels of different lengths or too short, or a residual that is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> from dampyr.identification.fits.residuals import Trace
    >>> t = np.linspace(0.0, 10.0, 2001)
    >>> noise = np.random.default_rng(0).normal(0.0, 3.0, t.size)
    >>> x, v, force = np.sin(6.0 * t), 6.0 * np.cos(6.0 * t), 100.0 * np.cos(6.0 * t)
    >>> trace = Trace("one", t, x, v, force, noise, 1.0, 2.0, 6.0 / (2.0 * np.pi))
    >>> dp.identification.analyse([trace]).misfits
    ()
    """

    name: str
    time: Array
    displacement: Array
    velocity: Array
    force: Array
    residual: Array
    input_value: float
    stroke: float
    frequency: float

    def __post_init__(self) -> None:
        sizes = {np.shape(a) for a in (self.time, self.displacement, self.velocity, self.force, self.residual)}
        if len(sizes) > 1 or self.time.ndim != 1 or self.time.size < MIN_TRACE:
            raise InputError(
                f"{self.name}: its channels have the shapes {sorted(sizes)}; give vectors of one length, 8 or more"
            )
        if not np.all(np.isfinite(self.residual)):
            raise InputError(f"{self.name}: its residual holds a value that is not finite, so it cannot be analysed")

    @cached_property
    def dt(self) -> float:
        """The median interval in s."""
        return float(np.median(np.diff(self.time)))

    @property
    def periods(self) -> float:
        """How many periods of the motion it lasts; NaN without frequency."""
        return self.time.size * self.dt * self.frequency


@dataclass(frozen=True)
class RecordResidual:
    """The numbers of one record, see the head of this file. N, s, m, Hz; ``relative`` is rms over the force's standard
    deviation; ``autocorrelation`` is by ``lags``; ``repeats`` NaN where there are fewer than three periods."""

    name: str
    input_value: float
    stroke: float
    frequency: float
    samples: int
    duration: float
    rms: float
    relative: float
    noise: float
    correlation_time: float
    effective: float
    repeats: float
    misfit: bool
    lags: Array = field(repr=False)
    autocorrelation: Array = field(repr=False)


@dataclass(frozen=True)
class Side:
    """The samples that move one way: how many, mean and rms of their residual in N (NaN without samples)."""

    samples: int
    mean: float
    rms: float


@dataclass(frozen=True)
class ResidualCurve:
    """Median and quartiles of the residual in N over `BINS` bins of velocity (centres in m/s, alike on both sides of zero).

    NaN in bins of fewer than `MIN_BIN_SAMPLES` samples; ``counts`` says how many there are.
    """

    velocity: Array
    lower: Array
    median: Array
    upper: Array
    counts: NDArray[np.int64]


@dataclass(frozen=True)
class ResidualGroup:
    """The records at one input, or all of them (``input_value`` None).

    ``rms`` and ``asymmetry`` in N; ``chance`` is the share of the variance
    that the latter may have by chance; ``sides``
    by `SIDES`, ``curves`` by `BRANCHES`.
    """

    input_value: float | None
    records: tuple[str, ...]
    rms: float
    sides: dict[str, Side]
    curves: dict[str, ResidualCurve]
    asymmetry: float
    chance: float


@dataclass(frozen=True, repr=False)
class Residuals(Shown):
    """The analysis of all records; ``unit`` is the input's, "V" or "A"; ``thresholds`` say what is a misfit, and a finding."""

    unit: str
    records: tuple[RecordResidual, ...]
    whole: ResidualGroup
    groups: tuple[ResidualGroup, ...]
    origin: Origin = NOT_STATED
    thresholds: FitThresholds = field(default_factory=FitThresholds)

    @property
    def inputs(self) -> list[float]:
        """The inputs of the records, in rising order."""
        return [float(group.input_value) for group in self.groups if group.input_value is not None]

    @property
    def samples(self) -> int:
        """Of all records."""
        return sum(r.samples for r in self.records)

    @property
    def effective(self) -> float:
        """Effective samples of all records."""
        return float(sum(r.effective for r in self.records))

    @property
    def correlation_time(self) -> float:
        """All records' duration over their effective samples, s."""
        return float(sum(r.duration for r in self.records)) / self.effective

    @property
    def noise(self) -> float:
        """The noise of all records in N, rms."""
        return float(np.sqrt(np.average([r.noise**2 for r in self.records], weights=[r.samples for r in self.records])))

    @property
    def misfits(self) -> tuple[str, ...]:
        """The records whose residual is not noise alone."""
        return tuple(r.name for r in self.records if r.misfit)


def motion(record: Record) -> tuple[float, float]:
    """Stroke (peak to peak per cycle, m) and frequency (Hz) of a record; without whole cycles its range, and NaN."""
    spans = cycle_bounds(record)
    if not spans:
        return float(np.ptp(record.displacement)), float("nan")
    lasting = float(record.time[spans[-1][1]] - record.time[spans[0][0]])
    return peak_to_peak(record, spans), len(spans) / lasting


def analyse(traces: Sequence[Trace], unit: str = "V", thresholds: FitThresholds | None = None) -> Residuals:
    """The analysis of any residuals, with ``unit`` of the inputs ("V" or "A"), judged by ``thresholds``.

    Raises :class:`~dampyr.errors.InputError` without traces, or for values not finite.
    """
    limits = thresholds or FitThresholds()
    if not traces:
        raise InputError("there are no residuals to analyse; give one trace or more")
    by_name = {trace.name: _analyse_record(trace, limits) for trace in traces}
    if len(by_name) < len(traces):
        raise InputError("two traces have the same name; rename one, so that results can be told apart")
    inputs: dict[float, list[Trace]] = {}
    for trace in sorted(traces, key=lambda trace: trace.input_value):
        inputs.setdefault(round(trace.input_value, 9), []).append(trace)

    def make_group(at_input: Sequence[Trace], u: float | None) -> ResidualGroup:
        return group(at_input, sum(by_name[trace.name].effective for trace in at_input), u)

    groups = tuple(make_group(at_input, u) for u, at_input in inputs.items())
    return Residuals(unit, tuple(by_name.values()), make_group(traces, None), groups, thresholds=limits)


def autocorrelation(residual: ArrayLike) -> Array:
    """The autocorrelation (n,) by lags of 0 to n - 1 samples, the mean taken off; a constant has 1 and then 0."""
    r = np.asarray(residual, dtype=float)
    r = r - r.mean()
    power = np.abs(np.fft.rfft(r, 2 * r.size)) ** 2
    products = np.fft.irfft(power)[: r.size]
    out = np.zeros(r.size)
    out[0] = 1.0
    return products / products[0] if products[0] > 0.0 else out


def correlation_intervals(rho: Array) -> float:
    """The correlation time in intervals, 1 or more, from the autocorrelation (n,)."""
    pairs = rho[: 2 * (rho.size // 2)].reshape(-1, 2).sum(axis=1)
    ends = np.flatnonzero(pairs <= 0.0)
    positive = pairs[: ends[0]] if ends.size else pairs
    return max(2.0 * float(np.sum(positive)) - 1.0, 1.0)  # rho_0 = 1 is in the first pair and counts once


def noise_of(residual: ArrayLike) -> float:
    """The noise in N by successive differences: the standard deviation, if the samples are independent."""
    return float(np.sqrt(0.5 * np.mean(np.diff(np.asarray(residual, dtype=float)) ** 2)))


def _analyse_record(trace: Trace, limits: FitThresholds) -> RecordResidual:
    rho = autocorrelation(trace.residual)
    intervals = correlation_intervals(rho)
    rms, noise = _rms(trace.residual), noise_of(trace.residual)
    n_lags = min(trace.time.size // 4, round(MAX_LAG / trace.dt)) + 1
    spread = float(np.std(trace.force))
    return RecordResidual(
        name=trace.name,
        input_value=trace.input_value,
        stroke=trace.stroke,
        frequency=trace.frequency,
        samples=trace.time.size,
        duration=trace.time.size * trace.dt,
        rms=rms,
        relative=rms / spread if spread > 0.0 else float("nan"),
        noise=noise,
        correlation_time=intervals * trace.dt,
        effective=trace.time.size / intervals,
        repeats=_correlate_after_period(rho, trace),
        misfit=bool(intervals > limits.correlated or rms > limits.beyond_noise * noise > 0.0),
        lags=np.linspace(0.0, trace.dt * (n_lags - 1), n_lags),
        autocorrelation=rho[:n_lags],
    )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _correlate_after_period(rho: Array, trace: Trace) -> float:
    """The autocorrelation after one period, unbiased."""
    if not trace.periods >= MIN_PERIODS:
        return float("nan")
    lag = 1.0 / (trace.frequency * trace.dt)
    # of n samples n - k pairs are k apart: without this a long period would look like one that does not repeat
    unbiased = rho * rho.size / (rho.size - np.arange(rho.size))
    return float(np.interp(lag, np.arange(rho.size), unbiased))


def group(traces: Sequence[Trace], effective: float, input_value: float | None = None) -> ResidualGroup:
    """The residuals of some records by direction; ``effective`` is their effective sample size."""
    r = np.concatenate([trace.residual for trace in traces])
    v = np.concatenate([trace.velocity for trace in traces])
    masks = [_sort_by_side(trace) for trace in traces]
    joined = {name: np.concatenate([mask[name] for mask in masks]) for name in SIDES}
    reach = float(np.max(np.abs(v)))
    curves = {}
    for branch in BRANCHES:
        on_branch = joined[f"out, {branch}"] | joined[f"in, {branch}"]
        curves[branch] = _bin_by_velocity(v[on_branch], r[on_branch], reach)
    return ResidualGroup(
        input_value=input_value,
        records=tuple(trace.name for trace in traces),
        rms=_rms(r),
        sides={name: _summarise_side(r[mask]) for name, mask in joined.items()},
        curves=curves,
        asymmetry=_measure_asymmetry(list(curves.values())),
        chance=BINS / effective,
    )


def _sort_by_side(trace: Trace) -> dict[str, Mask]:
    """Which samples belong to each of `SIDES`."""
    fast = np.abs(trace.velocity) > SLOW * float(np.max(np.abs(trace.velocity)))
    t = trace.time - trace.time.mean()
    middle = trace.displacement.mean() + t * float(t @ trace.displacement) / float(t @ t)
    out, back, above = fast & (trace.velocity > 0.0), fast & (trace.velocity < 0.0), trace.displacement > middle
    return dict(zip(SIDES, (out, back, out & ~above, out & above, back & above, back & ~above), strict=True))


def _summarise_side(r: Array) -> Side:
    if r.size == 0:
        return Side(0, float("nan"), float("nan"))
    return Side(r.size, float(np.mean(r)), _rms(r))


def _bin_by_velocity(v: Array, r: Array, reach: float) -> ResidualCurve:
    edges = np.linspace(-reach, reach, BINS + 1)
    number = np.clip(np.searchsorted(edges, v, side="right") - 1, 0, BINS - 1)
    quartiles = np.full((3, BINS), np.nan)
    counts = np.bincount(number, minlength=BINS)
    for k in np.flatnonzero(counts >= MIN_BIN_SAMPLES):
        quartiles[:, k] = np.quantile(r[number == k], (0.25, 0.5, 0.75))
    return ResidualCurve(0.5 * (edges[1:] + edges[:-1]), quartiles[0], quartiles[1], quartiles[2], counts)


def _measure_asymmetry(curves: Sequence[ResidualCurve]) -> float:
    """The rms of the medians' even part, weighted by the samples that both of its bins hold; 0 where there is none."""
    even = np.concatenate([0.5 * (c.median + c.median[::-1]) for c in curves])
    weights = np.concatenate([np.minimum(c.counts, c.counts[::-1]) for c in curves]).astype(float)
    finite = np.isfinite(even)
    if not np.any(weights[finite]):
        return 0.0
    # less its mean, which each record's offset takes: a difference of the directions that is constant is no asymmetry
    even, weights = even[finite], weights[finite] / np.sum(weights[finite])
    return float(np.sqrt(weights @ (even - weights @ even) ** 2))
