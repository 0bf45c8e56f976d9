"""Predictive bands: between which limits a record's force, its peak and its energy are expected, before it is measured.

A band is made of draws (`dampyr.models.prediction_error`): of the coefficients, of the levels of the fitted sessions and of the
record to come, of the shape error and the noise. Limits are quantiles of the draws, sample by sample for the force, and of the
draws' own peaks and energies for these. As with a score only the offset is taken from the record: each draw has the
record's mean in the window.

A sample holds the white noise of its sensor, the peak of the damper's force does not: the largest of a thousand noisy samples
lies three of its standard deviations higher. So the draws' peaks have their shape error and their correlated noise, and no
white one, and from the peak that was measured is taken what white noise adds to the draws' (their median), of the size that
the record itself has by the median of its second differences.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.argument_kinds import DAMPER, RECORD, Argument, check_kinds
from dampyr.errors import InputError
from dampyr.identification.scoring.scoring_window import SETTLING, Window, loop_work, scoring_window, whole_cycles
from dampyr.models import Damper
from dampyr.models.prediction_error import check_level, force_draws, prior_words
from dampyr.origin import NOT_STATED, Origin, combined
from dampyr.phrases import percent
from dampyr.records import Record, with_velocity
from dampyr.records.conditioning.moving_average import averaged
from dampyr.records.conditioning.nominal_input import without_noise_beyond
from dampyr.records.conditioning.smoothing import force_average
from dampyr.shown import Shown

Array = NDArray[np.float64]
LEVEL = 0.9  # of the band unless told otherwise
DRAWS = 200  # the 5 % quantile of 200 draws has a standard error of 1.5 points


@dataclass(frozen=True)
class Interval:
    """An interval of a quantity, SI, and what was measured, NaN where nothing was."""

    low: float
    high: float
    measured: float

    @property
    def holds(self) -> bool:
        """Whether the measured value lies inside."""
        return bool(self.low <= self.measured <= self.high)

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers, for JSON."""
        return {"low": self.low, "high": self.high, "measured": self.measured, "holds": self.holds}


@dataclass(frozen=True, repr=False)
class Band(Shown):
    """The band of a record at ``level``: ``low`` and ``high`` (n,) of the ``measured`` force in N, its offset included.

    ``holds`` is the share of the window's samples inside, ``width`` half the mean width over the mean size of the force
    about the middle of its range (0.12 is ± 12 %). ``peak`` is half the range of the force in N without white noise of the
    sensor, ``energy`` that of a cycle in J, None where the window has no whole cycle. ``session`` is the fitted session that
    the record belongs to, None where it counts as a new one; ``prior`` says what level between sessions is in it, and whether
    that is stated.
    """

    level: float
    time: Array
    measured: Array
    low: Array
    high: Array
    holds: float
    width: float
    peak: Interval
    energy: Interval | None
    session: str | None
    window: Window
    prior: str = ""
    origin: Origin = NOT_STATED
    record_origin: Origin = NOT_STATED

    @property
    def words(self) -> str:
        """What it holds and how wide it is."""
        text = f"holds {percent(self.holds)} of the samples, width ± {percent(self.width)} of the mean force"
        return f"{text}, {self.prior}" if self.prior else text


def why_no_band(damper: Damper) -> str:
    """Why predictions of a damper have no band, in words; empty where they have."""
    if damper.prediction_error is None:
        return (
            "the card has no prediction error (it was not identified by this version), so its predictions have no band"
        )
    if damper.covariance is None or not np.all(np.isfinite(damper.covariance)):
        return "the records do not determine every coefficient of the card, so its predictions have no band"
    return ""


def draw_forces(
    damper: Damper, record: Record, draws: int = DRAWS, seed: int = 0, allow_extrapolation: bool = False
) -> tuple[Array, Array, str | None]:
    """Forces (draws, n) in N of the damper along a record, without its offset, the white noise (draws, n) that is measured
    besides, and the fitted session that the record is of."""
    error = damper.prediction_error
    if error is None or why_no_band(damper):
        raise InputError(f"{why_no_band(damper)}; identify it again from its records")
    if record.velocity is None or damper.bandwidth is not None:
        record = with_velocity(record, damper.bandwidth)
    if record.temperature is not None:
        damper = damper.at_temperature(float(np.mean(record.temperature)), allow_extrapolation=True)
    record = without_noise_beyond(record, *damper.range)
    session = record.measurement_session if record.measurement_session in error.sessions else None
    average = force_average(record)
    reach = None if average is None else average.reach(record.dt)
    path = {
        "t": record.time,
        "x": record.displacement,
        "voltage": record.voltage,
        "current": record.current,
        "velocity": record.velocity,
    }
    averaging = None if reach is None else lambda force: averaged(force, *reach)
    return *force_draws(damper, path, draws, seed, session, allow_extrapolation, averaging), session


def _make_interval(draws: Array, measured: float, tails: tuple[float, float]) -> Interval:
    low, high = np.quantile(draws, tails)
    return Interval(float(low), float(high), measured)


def _draw_white_noise(residual: Array, seed: int, draws: int) -> Array:
    """White noise (draws, n) as large as that of a residual (n,): the median tells it without false samples."""
    second = residual[1:-1] - 0.5 * (residual[:-2] + residual[2:])  # of white noise it has 1.5 times the variance
    size = 1.4826 * float(np.median(np.abs(second))) / np.sqrt(1.5)
    return np.asarray(size * np.random.default_rng([seed, 1]).standard_normal((draws, residual.size)))


def prediction_band(
    damper: Damper,
    record: Record,
    level: float = LEVEL,
    settling: float = SETTLING,
    window: tuple[float, float] | None = None,
    draws: int = DRAWS,
    seed: int = 0,
    allow_extrapolation: bool = False,
) -> Band:
    """The band of a record's force, of its peak and of its energy, and whether they hold what was measured.

    A record whose ``measurement_session`` is one that the damper was fitted on has the level of that session; any other
    counts as of a new session.

    Parameters
    ----------
    damper
        with a `prediction_error`, as every fit gives it.
    record
        whose force is to be held.
    level
        share of the force that the band is to hold, between 0 and 1.
    settling, window
        which samples count, in s: as of `dampyr.identification.score`.
    draws, seed
        how many draws the quantiles are taken of, and the seed of the draws.
    allow_extrapolation
        also at an input, or a motion, beyond what the damper was calibrated on.

    Returns
    -------
    Band
        its limits (n,) in N along the whole record, and what they hold of the window.

    Raises
    ------
    InputError
        the damper's card has no prediction error, or the record cannot be scored.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> damper, rng = dp.studies.raminelli_2020.damper(), np.random.default_rng(0)
    >>> t = np.linspace(0.0, 4.0, 801)
    >>> def record(f):
    ...     x = 0.008 * np.sin(2 * np.pi * f * t)
    ...     force = damper.force(t, x, voltage=1.98) + rng.normal(0.0, 5.0, t.size)
    ...     return dp.records.Record(t, x, force, voltage=1.98, name=f"{f} Hz")
    >>> fitted = dp.identification.fit([record(0.7), record(1.0), record(1.6)], "dahl").damper
    >>> dp.identification.prediction_band(fitted, record(1.3), level=0.95).holds > 0.95
    True
    """
    check_kinds(
        "prediction_band", Argument("damper", damper, (Damper,), DAMPER), Argument("record", record, (Record,), RECORD)
    )
    check_level(level, "band")
    where = scoring_window(record, settling, window)
    forces, noise, session = draw_forces(damper, record, draws, seed, allow_extrapolation)
    inside = where.slice
    measured = record.force
    # the offset is the record's own, as in a score: each draw has the measured mean
    forces += (np.mean(measured[inside]) - np.mean(forces[:, inside], axis=1))[:, None]
    tails = 0.5 * (1.0 - level), 0.5 * (1.0 + level)
    low, high = np.quantile(forces + noise, tails, axis=0)
    seen = (low[inside] <= measured[inside]) & (measured[inside] <= high[inside])
    spread = np.mean(np.abs(measured[inside] - 0.5 * sum(np.quantile(measured[inside], (0.01, 0.99)))))
    peaks = 0.5 * np.ptp(forces[:, inside], axis=1)
    rough = forces[:, inside] + _draw_white_noise(
        measured[inside] - np.median(forces[:, inside], axis=0), seed, len(forces)
    )
    # the largest of many noisy samples lies above the force's own peak: by how much, noise of this size on the draws tells
    from_noise = float(np.median(0.5 * np.ptp(rough, axis=1) - peaks))
    energy = None
    if span := whole_cycles(record, where):
        part, count = span
        x = record.displacement[part]
        work = [loop_work(force[part], x) / count for force in (*(forces + noise), measured)]
        energy = _make_interval(np.array(work[:-1]), float(work[-1]), tails)
    return Band(
        level=level,
        origin=combined([damper.origin, record.origin]),
        record_origin=record.origin,
        time=record.time,
        measured=measured,
        low=low,
        high=high,
        holds=float(np.mean(seen)),
        width=float(0.5 * np.mean(high[inside] - low[inside]) / spread),
        peak=_make_interval(peaks, 0.5 * float(np.ptp(measured[inside])) - from_noise, tails),
        energy=energy,
        session=session,
        window=where,
        prior="" if damper.prediction_error is None else prior_words(damper.prediction_error),
    )
