"""Quality of a record: rest before the motion, gaps, jitter, quantisation and saturation; reported, not repaired."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.phrases import counted
from dampyr.records.checks.channel_noise import last_at_rest, quantum, rest_tolerance
from dampyr.records.cycle_analysis.cycles import cycle_bounds, legs
from dampyr.records.record import CHANNELS, Array, Record
from dampyr.records.record_cache import cached_by_record
from dampyr.records.record_thresholds import USUAL, RecordThresholds
from dampyr.shown import Shown

MAX_GAPS = 3  # that are told one by one
UNEVEN_SHARE = 0.02  # of the intervals that are long: a recorder that loses samples loses fewer
MAX_PLATEAU = 5  # equal samples: a smooth extreme has fewer
SPIKE_WINDOW = 5  # samples of the running median: a false value of one or two samples stands out of it
SPIKE_OVER_REST = 5.0  # times what 99 of 100 samples differ from the running median: steep loops are not spikes
PLATEAU_OF_CYCLE = 0.05  # of a cycle: a sine counted in fine steps stays at its extreme for less
LEAP_OVER_NEIGHBOURS = 3.0  # times the steps before and after: a motion that is only fast has neighbours as fast
RUN_AWAY_STRAIGHT = 0.9  # of the variance of the cycles' middles that a straight line holds
NOISE_WINDOW = 20  # samples in which a channel's noise is looked at
MIN_NOISY = 3  # windows in which it has to show
NOISE_ORDER = 5  # of the differences that hold noise and none of the motion
IN_RUNS = 0.5  # of the samples of a flat level that follow one another
QUIETER = 1.5  # times that the noise on a level may be less than elsewhere, and
FLATTER = 3.0  # times that more samples may stand there than such noise leaves
SHARE_OF_FLAT = 0.005  # of the samples that move: fewer at one level change no result
EXCURSION = 0.1  # of the median distance between turning points: far beyond noise and encoder steps


@dataclass(frozen=True, repr=False)
class Quality(Shown):
    """How well a record is sampled.

    Attributes
    ----------
    samples, dt
        How many, and their median interval, s.
    jitter
        rms deviation of the intervals from the median, over the median, gaps left out.
    gaps
        ``(time, length)`` in s of every interval longer than 1.5 times the median.
    quantum
        The quantisation step of each channel in SI; channels without one are not in it.
    saturated
        For displacement and force, how many samples stand at the channel's extreme in runs of five or more
        that last over 5 % of a cycle, while the table moves; of the force also those at a level at which its noise is gone
        (`flat_levels`); channels without such are not in it.
    spikes
        For displacement and force, the times in s of samples that stand out of their neighbours by more than a tenth of the
        channel's range, and far more than others do; channels without such are not in it.
    per_cycle
        Samples per cycle, or None without whole cycles.
    leaps
        The times in s at which the displacement leaps to another place within one sample, and stays there.
    run_away
        m by which the middle of the stroke goes one way over the whole cycles, where that is more than the stroke, or than
        8 % of it in each cycle; 0 else.
    stroke
        m from the least displacement to the greatest.
    mean_interval
        The mean sampling interval, s.
    """

    samples: int
    dt: float
    jitter: float
    gaps: tuple[tuple[float, float], ...]
    quantum: Mapping[str, float]
    saturated: Mapping[str, int]
    per_cycle: float | None
    spikes: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    leaps: tuple[float, ...] = ()
    run_away: float = 0.0
    stroke: float = 0.0
    mean_interval: float = 0.0

    @property
    def notes(self) -> tuple[str, ...]:
        """What a person should look at by the usual thresholds, one sentence each; empty when all is well.

        Those of a record by its own thresholds are among ``record.findings``.
        """
        return tuple(note for notes in self.by_kind.values() for note in notes)

    @property
    def by_kind(self) -> dict[str, list[str]]:
        """The notes by their kind, all of which are named."""
        return self.judged(USUAL)

    def judged(self, thresholds: RecordThresholds) -> dict[str, list[str]]:
        """The notes by their kind, by other thresholds than the usual ones."""
        return {
            "gap": self._gap_notes(),
            "jitter": [f"sampling jitter of {100 * self.jitter:.2g} % rms"]
            if self.jitter > thresholds.jitter and not self.is_uneven
            else [],
            "saturated": [
                f"{channel} may be saturated: {count} samples stand at its extreme"
                for channel, count in self.saturated.items()
            ],
            "false samples": [
                f"{channel} has {counted(len(times), 'false sample')}, it seems: at {_first_three(times)} s it leaps away from "
                "its neighbours and back; repair them, --repair false-samples or repair='false samples', or fit with a loss "
                "of huber or l1"
                for channel, times in self.spikes.items()
            ],
            "leap": [
                f"the displacement leaps {counted(len(self.leaps), 'time')} within one sample, at {_first_three(self.leaps)} "
                "s, and stays there: the encoder slipped, or counts were lost; cut the record there, or record it again"
            ]
            if self.leaps
            else [],
            "run away": [
                f"the displacement runs away: its middle moves by {1e3 * self.run_away:.3g} mm in one direction; look whether "
                "the encoder counts less one way than the other, or the table drifts; record it again, or fit a part of it"
            ]
            if self.run_away
            else [],
            "unlikely unit": [
                f"the displacement covers {self.stroke:.4g} m: is its unit right? Give it in m, or name the "
                "unit (--unit, units=)"
            ]
            if self.stroke > thresholds.unlikely_stroke
            else [],
            "coarse": [f"only {self.per_cycle:.0f} samples per cycle"]
            if self.per_cycle is not None and self.per_cycle < thresholds.samples_per_cycle
            else [],
        }

    @property
    def is_uneven(self) -> bool:
        """Whether so many intervals are long that these are stamps that jitter, and no samples that are missing."""
        return len(self.gaps) > max(MAX_GAPS, UNEVEN_SHARE * self.samples)

    def _gap_notes(self) -> list[str]:
        """Each gap; of more than a few one sentence for all."""
        if len(self.gaps) <= MAX_GAPS:
            return [f"gap of {length:.4g} s at {at:.4g} s" for at, length in self.gaps]
        times = _first_three([at for at, _ in self.gaps])
        longest = max(length for _, length in self.gaps)
        if not self.is_uneven:
            return [f"{len(self.gaps)} gaps of up to {longest:.4g} s, at {times} s"]
        return [
            f"the time stamps jitter: {len(self.gaps)} of {self.samples - 1} intervals are long, up to {longest:.4g} s for "
            f"{self.dt:.4g} s in the median; where the samples were taken evenly, read them with their interval, "
            f"--dt {self.mean_interval:.4g} or dt={self.mean_interval:.4g} (s), which goes before the stamps"
        ]


def _first_three(times: Sequence[float]) -> str:
    return ", ".join(f"{time:.4g}" for time in times[:3]) + " ..." * (len(times) > 3)


def quality(record: Record) -> Quality:
    """Report gaps, jitter, saturation and quantisation of a record."""
    steps = np.diff(record.time)
    dt = record.dt
    gaps = np.flatnonzero(steps > record.thresholds.gap * dt)
    even = steps[steps <= record.thresholds.gap * dt]
    spans = cycle_bounds(record)
    per_cycle = float(np.mean([i1 - i0 for i0, i1 in spans])) if spans else None
    channels = {name: getattr(record, name) for name in CHANNELS if name != "time"}
    arrays = {name: values for name, values in channels.items() if isinstance(values, np.ndarray)}
    moving = _moving(record, spans)
    counts = {name: _stuck(getattr(record, name)[moving], per_cycle) for name in ("displacement", "force")}
    flat = sum(int(np.sum(at)) for _, at in flat_levels(record.force, _motion(record), quantum(record.force) or 0.0))
    counts["force"] = max(counts["force"], flat)
    return Quality(
        samples=record.n,
        dt=dt,
        jitter=float(np.sqrt(np.mean((even / dt - 1.0) ** 2))),
        gaps=tuple((float(record.time[k]), float(steps[k])) for k in gaps),
        quantum={name: step for name, values in arrays.items() if (step := quantum(values)) is not None},
        saturated={name: count for name, count in counts.items() if count},
        per_cycle=per_cycle,
        spikes={
            name: tuple(map(float, record.time[at]))
            for name in ("displacement", "force")
            if len(at := spikes(getattr(record, name), record.thresholds.false_sample))
        },
        leaps=tuple(map(float, record.time[leaps(record)])),
        run_away=_run_away(record, spans),
        stroke=float(np.ptp(record.displacement)),
        mean_interval=record.duration / (record.n - 1),
    )


def spikes(values: Array, share: float = USUAL.false_sample) -> NDArray[np.int64]:
    """The samples of a channel that leap away from their neighbours and back by more than ``share`` of its range, as their
    numbers."""
    from scipy.ndimage import maximum_filter, median_filter

    apart = np.abs(values - median_filter(values, SPIKE_WINDOW, mode="nearest"))
    low, high = np.quantile(values, (0.01, 0.99))
    usual = float(np.quantile(apart, 0.99))
    limit = max(share * (high - low), SPIKE_OVER_REST * usual, 3.0 * (quantum(values) or 0.0))
    if limit <= 0.0:
        return np.empty(0, dtype=np.int64)
    # Beside a spike the running median is off too, but by less than the spike itself.
    foremost = apart > 0.5 * maximum_filter(apart, SPIKE_WINDOW, mode="nearest")
    return np.asarray(np.flatnonzero((apart > limit) & foremost), dtype=np.int64)


def leaps(record: Record) -> NDArray[np.int64]:
    """The samples at which the displacement is suddenly at another place, and stays there, as their numbers."""
    steps = np.abs(np.diff(record.displacement))
    steps[np.diff(record.time) > record.thresholds.gap * record.dt] = 0.0  # across a gap it had the time to move
    if len(steps) < 4:
        return np.empty(0, dtype=np.int64)
    limit = max(record.thresholds.leap * float(np.quantile(steps, 0.99)), 3.0 * (quantum(record.displacement) or 0.0))
    padded = np.r_[0.0, steps, 0.0]
    around = np.maximum(padded[:-2], padded[2:])  # a spike leaps back at once: its two steps are alike
    alone = (steps > limit) & (steps > LEAP_OVER_NEIGHBOURS * around)
    return np.asarray(np.flatnonzero(alone) + 1, dtype=np.int64) if limit > 0.0 else np.empty(0, dtype=np.int64)


def _run_away(record: Record, spans: list[tuple[int, int]]) -> float:
    """How far, m, the middle of the stroke goes one way; 0 where that is little, or no straight line."""
    if len(spans) < 3:
        return 0.0
    extremes = [(float(x.min()), float(x.max())) for i0, i1 in spans for x in [record.displacement[i0 : i1 + 1]]]
    middles = np.array([0.5 * (low + high) for low, high in extremes])
    stroke = float(np.median([high - low for low, high in extremes]))
    number = np.arange(len(middles)) - 0.5 * (len(middles) - 1)  # of the cycle, about the middle one
    line = float(number @ middles / (number @ number)) * number  # least squares
    rest = middles - middles.mean() - line
    moved = float(line[-1] - line[0]) * len(middles) / (len(middles) - 1)  # from the first begin to the last end
    far = abs(moved) > stroke * min(record.thresholds.run_away, record.thresholds.run_away_per_cycle * len(middles))
    straight = float(rest @ rest) <= (1.0 - RUN_AWAY_STRAIGHT) * float(np.sum((middles - middles.mean()) ** 2))
    return moved if straight and far else 0.0  # a table that wanders to and fro is no run-away


def _moving(record: Record, spans: list[tuple[int, int]]) -> slice:
    """The whole cycles, or without them all that comes after the start of the motion."""
    if spans:
        return slice(spans[0][0], spans[-1][1])
    return slice(int(np.searchsorted(record.time, motion_start(record))) + 1, record.n)


def _motion(record: Record) -> slice:
    """From the start of the motion to its end, whole cycles or not."""
    x = record.displacement
    away = np.flatnonzero(np.abs(x - x[-1]) > rest_tolerance(x))
    return slice(int(np.searchsorted(record.time, motion_start(record))) + 1, int(away[-1]) + 1 if len(away) else 0)


def _stuck(moving: Array, per_cycle: float | None) -> int:
    """How many samples stand at the highest or the lowest value in long runs, once the table moves."""
    shortest = max(MAX_PLATEAU, PLATEAU_OF_CYCLE * (per_cycle or 0.0))
    if len(moving) == 0 or np.ptp(moving) == 0:
        return 0
    count = 0
    for extreme in (moving.max(), moving.min()):
        edges = np.flatnonzero(np.diff(np.r_[False, moving == extreme, False].astype(int)))
        runs = edges[1::2] - edges[::2]
        count += int(np.sum(runs[runs >= shortest]))
    return count


def flat_levels(values: Array, moving: Any, step: float) -> list[tuple[float, NDArray[np.bool_]]]:
    r"""The levels at which a noisy channel stands without its noise, each with the samples (n,) that are there.

    So does an amplifier that saturates: its flat tops lie below the converter's rail, end at a turn of the table, and one
    code takes a large share of the samples. The force of a damper that is constant over its stroke, such as friction, has the
    noise of its cell. In bins of one ``step`` of the converter, and of at least half the noise :math:`\sigma`, three bins in
    the middle of a level with noise hold at most

    .. math:: \frac{P(|z| < 1.5 / \sigma)}{P(1.5 / \sigma < z < 4.5 / \sigma)}

    times the samples of the three beside them, whatever the motion. A level is flat from `FLATTER` times that on, with
    :math:`\sigma` lower by `QUIETER`. ``moving`` are the samples that count, as an index into ``values``. A channel without
    noise that shows has none: nothing tells its flat tops from friction.
    """
    from scipy.special import ndtr

    noise, among = _noise(values), values[moving]
    width = max(step, 0.5 * noise)
    if noise == 0.0 or not len(among):
        return []
    bins = np.rint(values / width)
    ordered = np.sort(bins[moving])

    def count_near(place: Array, reach: float) -> Array:
        """How many samples lie in the bins within ``reach`` of ``place``."""
        first = np.searchsorted(ordered, place - reach, "left")
        last = np.searchsorted(ordered, place + reach, "right")
        return np.asarray(last - first, dtype=np.float64)

    place, count = np.unique(ordered, return_counts=True)
    three, flanks = count_near(place, 1.0), np.maximum(count_near(place - 3.0, 1.0), count_near(place + 3.0, 1.0))
    inner, outer = 1.5 * QUIETER * width / noise, 4.5 * QUIETER * width / noise
    expected = float(ndtr(inner) - ndtr(-inner)) / max(float(ndtr(outer) - ndtr(inner)), 1e-9)
    flat = (three >= FLATTER * expected * (flanks + 1.0)) & (three >= SHARE_OF_FLAT * len(among))
    flat &= count >= np.maximum(
        count_near(place - 1.0, 0.0), count_near(place + 1.0, 0.0)
    )  # and not beside such a level
    levels: list[tuple[float, NDArray[np.bool_]]] = []
    for level in place[flat]:
        at = np.zeros(len(values), dtype=bool)
        at[moving] = np.abs(bins[moving] - level) <= 1.0
        # in runs, as a flat top is: an exact sine without noise repeats its samples in each cycle, and stands nowhere
        if np.sum(at[1:] & at[:-1]) >= IN_RUNS * np.sum(at):
            levels.append((float(level) * width, at))
    return levels


def _noise(values: Array) -> float:
    """The standard deviation of a channel's noise: the lower quartile of that in windows in which it shows, by the median of
    fifth differences, which hold little of the motion; 0 where it shows in too few.

    The differences of noise change their sign at four of five samples, those of a force that turns round hardly ever.
    """
    count = len(values) // NOISE_WINDOW
    differences = np.diff(values[: count * NOISE_WINDOW].reshape(count, NOISE_WINDOW), NOISE_ORDER, axis=1)
    turns = np.mean(differences[:, 1:] * differences[:, :-1] < 0.0, axis=1)
    size = np.median(np.abs(differences), axis=1)
    live = size[(size > 0.0) & (turns > 0.5)]
    # fifth differences of white noise have the variance C(10, 5) times its own; 0.6745 is the median of |z| of a normal one
    gain = 0.6745 * math.sqrt(math.comb(2 * NOISE_ORDER, NOISE_ORDER))
    return float(np.quantile(live, 0.25)) / gain if len(live) >= MIN_NOISY else 0.0


@cached_by_record
def motion_start(record: Record) -> float:
    """The time, s, of the last sample at rest; the first sample's time where the record starts moving.

    The first excursion of a tenth of the median distance between turning points is motion for certain; from
    there the search goes back to the last sample that is still at the rest level, which is within 1.5 encoder
    steps or four standard deviations of the displacement's noise, whichever is wider. A record that never
    moves starts at its end.
    """
    x = record.displacement
    lengths = np.abs(legs(record))
    size = float(np.median(lengths)) if len(lengths) else float(np.ptp(x))
    away = np.flatnonzero(np.abs(x - x[0]) > EXCURSION * size)
    if size == 0 or len(away) == 0:
        return float(record.time[-1])
    return float(record.time[last_at_rest(x, int(away[0]))])
