"""The standard suite of 21 cases: the building of chapter 5 with the published damper; steps at an error."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrWarning
from dampyr.ground_motions import GroundMotion, el_centro, kanai_tajimi
from dampyr.structures import respond, two_storey
from dampyr.studies import raminelli_2020

Array = NDArray[np.float64]

VOLTS = (0.0, 1.0, 2.25)
EL_CENTRO_SCALES = (0.5, 1.0, 2.0)
SYNTHETIC_PGA = (1.0, 3.0, 5.0, 8.0)  # m/s2
ALLOWED = 1e-3  # of the first floor's peak
HISTORY = 31.2  # s, what counts as one history
SHORTEST_STEP = 2e-5  # s


@dataclass(frozen=True, eq=False)
class Case:
    """One history: the ground's acceleration [m/s2] every dt seconds, and the damper's kx, kw, rho."""

    acceleration: Array
    dt: float
    damper: tuple[float, float, float]


@dataclass(frozen=True)
class Error:
    """Largest relative errors of peaks over the suite: of the first floor (the first drift too) and of the second drift."""

    floor: float
    drift: float

    def __str__(self) -> str:
        return f"error {100 * self.floor:.2g} % (second drift {100 * self.drift:.2g} %)"


@lru_cache(maxsize=1)
def motions() -> tuple[GroundMotion, ...]:
    """Three scales of El Centro 1940 and four synthetic records, every 0.02 s for about 30 s."""
    recorded = [el_centro().scaled(scale) for scale in EL_CENTRO_SCALES]
    made = [kanai_tajimi(30.0, 0.02, seed=k, pga=pga, rest=0.0) for k, pga in enumerate(SYNTHETIC_PGA, 1)]
    return (*recorded, *made)


def suite() -> list[Case]:
    """The 21 cases, the motion fastest."""
    return [case(motion, volts) for volts in VOLTS for motion in motions()]


def case(motion: GroundMotion, volts: float) -> Case:
    """The published damper at a voltage under a motion."""
    kx, kw, rho = (float(value) for value in raminelli_2020.damper().values(volts, static=False))
    return Case(motion.acceleration, motion.dt, (kx, kw, rho))


def histories(cases: list[Case]) -> float:
    """How many histories of 31.2 s the cases make."""
    return sum((len(each.acceleration) - 1) * each.dt for each in cases) / HISTORY


@lru_cache(maxsize=1)
def reference() -> Array:
    """(21, 2): the peaks of the first floor and of the second storey's drift [m], by `respond` to 2e-6."""
    damper, rows = {1: raminelli_2020.damper()}, []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)  # the published damper was calibrated on smaller motions
        for volts in VOLTS:
            for motion in motions():
                one = respond(two_storey(), motion, damper, voltage=volts, accuracy=2e-6)
                rows.append((one.peak_displacement[0], one.peak_drift[1]))
    return np.array(rows)


def error(peaks: Any) -> Error:
    """How far (21, 2) peaks are from the reference; infinite where one is no number."""
    return _largest(_gaps(peaks))


def _gaps(peaks: Any, which: Any = slice(None)) -> Array:
    gaps = np.abs(np.asarray(peaks) / reference()[which] - 1.0)
    return np.where(np.isfinite(gaps), gaps, np.inf)


def _largest(gaps: Array) -> Error:
    floor, drift = gaps.max(axis=0)
    return Error(float(floor), float(drift))


def coarsest(peaks: Callable[[list[Case], int], Any], first: int = 8) -> tuple[int, Error]:
    """The fewest steps per sample that keep the first floor's error in bounds, by doubling and then bisection to an eighth."""
    trial = _Trial(peaks)
    good, bad = first, 0
    while not trial.passes(good):
        if suite()[0].dt / good < SHORTEST_STEP:
            return good, trial.error
        good, bad = 2 * good, good
    best = trial.error
    while good - bad > max(1, good // 8):
        middle = (good + bad + 1) // 2
        if trial.passes(middle):
            good, best = middle, trial.error
        else:
            bad = middle
    return good, best


@dataclass
class _Trial:
    """Tries of a contender; the case that was worst goes first, so that most steps that are too long are found out soon."""

    peaks: Callable[[list[Case], int], Any]
    worst: int | None = None
    error: Error = Error(np.inf, np.inf)

    def passes(self, m: int) -> bool:
        cases = suite()
        if self.worst is not None:
            floor = float(_gaps(self.peaks([cases[self.worst]], m), [self.worst])[0, 0])
            if floor > ALLOWED:
                return False
        gaps = _gaps(self.peaks(cases, m))
        self.error, self.worst = _largest(gaps), int(gaps[:, 0].argmax())
        return self.error.floor <= ALLOWED
