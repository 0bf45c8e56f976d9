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
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.records import Record, cycles, motion_start, with_velocity
from dampyr.records.moving_average import averaged
from dampyr.records.smoothing import comparable, force_average
from dampyr.representation import Representation, Summary, percent

Array = NDArray[np.float64]
SETTLING = 2.0  # s after the motion starts: the unknown past is forgotten by then
MIN_SCORED = 8  # samples: fewer make no loop
SCORED_SHARE = 0.25  # of the motion: where settling leaves less, what is scored does not stand for the record
SMALL = 0.01  # of half the range of the force: below it the pointwise error divides by nothing
RELEVEL_CYCLES = 2  # whole cycles that give the level: one could hold a false sample
RELEVEL_SHARE = 0.2  # of the window, where the motion does not repeat
TAIL = 0.01  # of the samples at either end of the range: more false ones than a record has that is worth a score
Centre = Literal["quantiles", "midrange"]


@dataclass(frozen=True)
class Window:
    """The samples that a score was computed on."""

    first: int
    last: int
    start: float
    end: float

    @property
    def slice(self) -> slice:
        """As an index."""
        return slice(self.first, self.last + 1)


@dataclass(frozen=True, repr=False)
class Score(Representation):
    """Ratios without unit (0.05 is 5 %); ``peak_force`` and ``energy`` are signed errors, model over measured less one.

    ``energy`` is per cycle (of the whole cycles in the window), NaN where there is none. ``offset`` in N is what was
    taken from the record. ``window`` says which samples. ``level`` is the factor that the first cycles put on the
    model's force, ``relevelled_l1`` the L1 ratio of the rest with it; both are NaN where too little is left.
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

    def _summary(self) -> Summary:
        return f"Score, L1 {percent(self.l1)}", [
            ("NRMSE", f"{percent(self.nrmse)}, R² {self.r2:.4g}"),
            ("pointwise", percent(self.pointwise)),
            ("peak force", f"{100 * self.peak_force:+.3g} % against the measured one"),
            ("energy", f"{100 * self.energy:+.3g} % against the measured one, per cycle"),
            ("level", f"{self.level:.4g} by the first cycles; with it L1 {percent(self.relevelled_l1)}"),
            ("offset", f"{self.offset:.4g} N"),
            ("window", f"{self.window.start:.4g} … {self.window.end:.4g} s"),
        ]

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers, for JSON."""
        return asdict(self)


def score(
    damper: Damper,
    record: Record,
    settling: float = SETTLING,
    window: tuple[float, float] | None = None,
    allow_extrapolation: bool = False,
    centre: Centre = "quantiles",
) -> Score:
    """Run ``damper`` freely along ``record`` and compare.

    The window goes from ``settling`` s after the motion starts to the end, or is ``window`` = (from, to) in s. ``centre`` is
    what the L1 ratio measures the force from: the middle of its ``"quantiles"``, or the ``"midrange"`` as (3.1) of Raminelli
    (2020). Raises
    :class:`~dampyr.errors.InputError` where the record's input is not the damper's, or too little is left of the motion.

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
    return compare(record, prediction(damper, record, allow_extrapolation), settling, window, centre)


def prediction(damper: Damper, record: Record, allow_extrapolation: bool = False) -> Array:
    """The force in N, shape (n,), that ``damper`` predicts along ``record``, with the velocity it was calibrated with, at
    the record's mean temperature where its laws depend on that.

    Where the record's force went through a moving average that is not undone, so does this one; at the ends, over what is there
    of the window.
    """
    if record.velocity is None or damper.bandwidth is not None:
        record = with_velocity(record, damper.bandwidth)
    temperature = None if record.temperature is None else float(np.mean(record.temperature))
    if damper.temperatures is not None and temperature is None:
        raise InputError(
            f"{record.name}: the damper's parameters depend on its temperature, and the record has none; give it a temperature "
            "channel in degC, or predict with damper.at_temperature(...)"
        )
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


def check_settling(settling: float) -> None:
    """:class:`~dampyr.errors.InputError` unless ``settling`` is a time in s."""
    if not (math.isfinite(settling) and settling >= 0.0):
        raise InputError(f"settling = {settling:g} s is not allowed; it must be finite and at least 0")


def scoring_window(record: Record, settling: float = SETTLING, window: tuple[float, float] | None = None) -> Window:
    """The samples from ``settling`` s after the motion starts, or those between the two times of ``window``.

    Of a force that went through a moving average which is not undone, only those with whole windows.
    """
    if window is None and (reason := too_short(record, settling)):
        raise InputError(f"{record.name}: {reason}")
    start, end = window or (motion_start(record) + settling, float(record.time[-1]))
    whole = comparable(record)
    inside = np.flatnonzero((record.time >= start - 1e-9) & (record.time <= end + 1e-9))
    inside = inside[(inside >= whole.start) & (inside < whole.stop)]
    if inside.size < MIN_SCORED:
        raise InputError(
            f"{record.name}: the window {start:.3g} to {end:.3g} s holds {inside.size} samples; the record ends at "
            f"{record.time[-1]:.3g} s, so give another window=(from, to)"
        )
    return Window(int(inside[0]), int(inside[-1]), float(record.time[inside[0]]), float(record.time[inside[-1]]))


def too_short(record: Record, settling: float = SETTLING) -> str:
    """Why ``settling`` s leave too little of a record to be scored, in words; empty where they do not."""
    start, average = motion_start(record), force_average(record)
    first, end = start, float(record.time[-1])
    if average is not None:
        whole = comparable(record)
        if whole.stop - whole.start < MIN_SCORED:
            return (
                f"its force is smoothed over {average.window:.3g} s, and its {record.n} samples hold "
                f"{whole.stop - whole.start} with a whole window; give a longer record"
            )
        first, end = max(start, float(record.time[whole.start])), float(record.time[whole.stop - 1])
    motion = end - first
    remaining = end - max(start + settling, first)
    enough = max(SCORED_SHARE * motion, MIN_SCORED * record.dt)
    if remaining >= enough:
        return ""
    limit = max(end - start - enough, 0.0)
    lasts = "lasts" if average is None else f"less what its moving average of {average.window:.3g} s leaves out lasts"
    return (
        f"its motion {lasts} {motion:.3g} s and settling takes the first {settling:g} s of it, so {max(remaining, 0.0):.2g} s "
        f"({max(int(remaining / record.dt), 0)} samples) would stand for the whole; give a settling of at most "
        f"{0.95 * limit:.2g} s or a window=(from, to)"
    )


def scorable(records: Sequence[Record], settling: float = SETTLING) -> dict[str, str]:
    """The records that cannot be scored, and why; :class:`~dampyr.errors.InputError` where none can."""
    reasons = {record.name: reason for record in records if (reason := too_short(record, settling))}
    if reasons and len(reasons) == len(records):
        name, reason = next(iter(reasons.items()))
        raise InputError(f"no record is long enough to be scored; {name}: {reason}")
    return reasons


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
    level, relevelled = _relevelled(record, np.asarray(force, dtype=float), where, centre)
    return Score(
        l1=float(np.sum(np.abs(error)) / np.sum(np.abs(centred))),
        nrmse=nrmse,
        r2=1.0 - nrmse**2,
        pointwise=float(np.mean(np.abs(error[seen]) / np.abs(centred[seen]))),
        peak_force=float(np.ptp(model) / np.ptp(measured) - 1.0),
        energy=_energy_error(record, np.asarray(force, dtype=float), where),
        offset=offset,
        window=where,
        level=level,
        relevelled_l1=relevelled,
    )


def relevelling_part(record: Record, where: Window) -> slice:
    """The samples of a window that its level is taken from: two whole cycles, or the first fifth where nothing repeats."""
    spans = [(a, b) for a, b in cycles(record) if a >= where.first and b <= where.last]
    if len(spans) > RELEVEL_CYCLES:
        return slice(spans[0][0], spans[RELEVEL_CYCLES - 1][1] + 1)
    count = where.last + 1 - where.first
    return slice(where.first, where.first + max(int(RELEVEL_SHARE * count), 1))


def _relevelled(record: Record, force: Array, where: Window, centre: Centre) -> tuple[float, float]:
    """The level by the first cycles and the L1 ratio of the rest with it, NaN where one of the two holds next to nothing."""
    part = relevelling_part(record, where)
    rest = slice(part.stop, where.last + 1)
    if part.stop - part.start < MIN_SCORED or rest.stop - rest.start < MIN_SCORED:
        return math.nan, math.nan
    measured, model = (one[part] - np.mean(one[part]) for one in (record.force, force))
    square = float(model @ model)
    level = float(measured @ model) / square if square > 0.0 else math.nan
    if not level > 0.0:
        return math.nan, math.nan
    later = record.force[rest]
    error = level * force[rest] - later
    centred = later - 0.5 * sum(span(later) if centre == "quantiles" else (later.min(), later.max()))
    return level, float(np.sum(np.abs(error - np.mean(error))) / max(np.sum(np.abs(centred)), 1e-300))


def whole_cycles(record: Record, where: Window) -> tuple[slice, int] | None:
    """The samples of the whole cycles in a window, and how many cycles these are; None where there is none."""
    spans = [(a, b) for a, b in cycles(record) if a >= where.first and b <= where.last]
    return (slice(spans[0][0], spans[-1][1] + 1), len(spans)) if spans else None


def _energy_error(record: Record, force: Array, where: Window) -> float:
    whole = whole_cycles(record, where)
    if whole is None:
        return float("nan")
    span, _ = whole
    x = record.displacement[span]
    middle = float(np.mean(x))
    measured = np.trapezoid(record.force[span] - np.mean(record.force[span]), x - middle)
    model = np.trapezoid(force[span] - np.mean(force[span]), x - middle)
    return float(model / measured - 1.0)


def group_by_input(records: Iterable[Record], values: Mapping[str, float]) -> dict[str, list[float]]:
    """The records' values under the words for their input, in its order; records without a value are left out."""
    groups: dict[str, list[float]] = {}
    for record in sorted(records, key=lambda r: -math.inf if r.input_value is None else r.input_value):
        if record.name in values:
            groups.setdefault(input_words(record), []).append(values[record.name])
    return groups


def input_words(record: Record) -> str:
    """Such as ``1.98 V``; the mean where the input varies."""
    if record.input_value is None:
        return "input not known"
    varies = np.ptp(record.voltage if record.voltage is not None else record.current) > 1e-9  # type: ignore[arg-type]
    return f"{record.input_value:.5g} {record.input}" + (" (mean)" if varies else "")
