"""Motions that could be tested next: what a drive that made the records could also make.

They stay within the stroke, the speed and the acceleration of the records at hand, unless asked to leave the stroke by name.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.identification.search.fit_data import Piece

Array = NDArray[np.float64]
AMPLITUDES = (1.0, 0.5, 0.25, 0.1)  # of the largest stroke: down to where a loop still has its 25 steps of an encoder
SPEEDS = (1.0, 0.3, 0.1, 0.03)  # of what the drive can do at that amplitude
PEAK = 0.995  # quantile of speed and acceleration that counts as their largest: above it is noise
CYCLES = 6  # with which a motion is tried: each more tells the same again
PER_CYCLE = 100  # samples of the fastest part: the path is integrated exactly between them
TONES = 12  # of a random motion
LOWEST = 0.1  # of its highest frequency: its lowest one
SHARE = 0.25  # of the amplitude that the fast part of two sines has
RATIO = 8.0  # between the frequencies of two sines
PERIODS = {
    "two sines": (3, RATIO),
    "random": (2 / LOWEST, 1.0),
}  # of the frequency, and how much faster the fastest part is
SEED = 0  # of the phases of a random motion: the same proposal each time


@dataclass(frozen=True)
class MotionReach:
    """What the records reach: amplitude m, speed m/s, acceleration m/s2."""

    amplitude: float
    speed: float
    acceleration: float


@dataclass(frozen=True)
class CandidateMotion:
    """A motion: its ``kind``, amplitude m (half the stroke), frequency Hz (the highest of a random one), samples (n,)."""

    kind: str
    amplitude: float
    frequency: float
    t: Array
    x: Array
    v: Array

    def in_words(self) -> str:
        """Such as ``a sine of ±2.5 mm, 0.4 Hz,``."""
        size, f = f"±{1e3 * self.amplitude:.3g} mm", f"{self.frequency:.3g} Hz"
        if self.kind == "two sines":
            fast = f"±{1e3 * SHARE * self.amplitude:.3g} mm, {RATIO * self.frequency:.3g} Hz"
            return f"a sum of two sines (±{1e3 * (1 - SHARE) * self.amplitude:.3g} mm, {f}, and {fast})"
        if self.kind == "random":
            return f"a random motion within {size} and up to {f}"
        return f"a {self.kind} of {size}, {f},"


def measure_reach(pieces: Sequence[Piece]) -> MotionReach:
    """What several records reach together."""
    speed = max(float(np.quantile(np.abs(piece.v), PEAK)) for piece in pieces)
    acceleration = max(float(np.quantile(np.abs(np.gradient(piece.v, piece.t)), PEAK)) for piece in pieces)
    return MotionReach(max(0.5 * float(np.ptp(piece.x)) for piece in pieces), speed, acceleration)


def candidate_motions(envelope: MotionReach, beyond: float = 1.0) -> Iterator[CandidateMotion]:
    """Sines, triangles, two sines and random motions inside an envelope; the stroke may be ``beyond`` times as large."""
    for share in AMPLITUDES:
        amplitude = _round_down(beyond * share * envelope.amplitude)
        fastest = min(envelope.speed, math.sqrt(envelope.acceleration * amplitude))
        for part in SPEEDS:
            frequency = _round_down(part * fastest / (2.0 * math.pi * amplitude))  # 2 pi f a is the peak speed
            yield _make_motion("sine", amplitude, frequency)
        for part in SPEEDS[1:]:
            # four amplitudes a period, at constant speed; its corners ask for no acceleration that a drive has to follow
            yield _make_motion("triangle", amplitude, _round_down(part * envelope.speed / (4.0 * amplitude)))
        if share >= 0.5:
            yield _make_motion("two sines", amplitude, _limit_two_sines(envelope, amplitude))
            yield _make_motion("random", amplitude, _limit_random(envelope, amplitude))


def _round_down(value: float) -> float:
    """Two digits, downwards, so that a proposal that is read from a page stays inside the envelope."""
    digits = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.floor(value / digits + 1e-9) * digits:.6g}")


def _limit_two_sines(envelope: MotionReach, amplitude: float) -> float:
    slow, fast = (1.0 - SHARE) * amplitude, SHARE * amplitude
    by_speed = envelope.speed / (2.0 * math.pi * (slow + RATIO * fast))
    by_acceleration = math.sqrt(envelope.acceleration / (slow + RATIO**2 * fast)) / (2.0 * math.pi)
    return _round_down(min(by_speed, by_acceleration))


def _limit_random(envelope: MotionReach, amplitude: float) -> float:
    """The highest one of a random motion inside the envelope: its speed goes with it, its acceleration with its square."""
    tried = _make_motion("random", amplitude, 1.0)
    by_speed = envelope.speed / float(np.max(np.abs(tried.v)))
    by_acceleration = math.sqrt(envelope.acceleration / float(np.max(np.abs(np.gradient(tried.v, tried.t)))))
    return _round_down(min(by_speed, by_acceleration))


def _make_motion(kind: str, amplitude: float, frequency: float) -> CandidateMotion:
    periods, fastest = PERIODS.get(kind, (CYCLES, 1.0))
    t = np.linspace(0.0, periods / frequency, int(periods * fastest * PER_CYCLE))
    w = 2.0 * math.pi * frequency * t
    if kind == "sine":
        x, v = np.sin(w), 2.0 * math.pi * frequency * np.cos(w)
    elif kind == "triangle":
        x = 2.0 / math.pi * np.arcsin(np.sin(w))
        v = 4.0 * frequency * np.sign(np.cos(w))
    elif kind == "two sines":
        x = (1.0 - SHARE) * np.sin(w) + SHARE * np.sin(RATIO * w)
        v = np.gradient(x, t)
    else:
        phases = np.random.default_rng(SEED).uniform(0.0, 2.0 * math.pi, TONES)
        tones = frequency * np.geomspace(LOWEST, 1.0, TONES)
        x = np.sum(np.sin(2.0 * math.pi * tones * t[:, None] + phases) / tones, axis=1)
        x = (x - x[0]) / float(np.max(np.abs(x - x[0])))
        v = np.gradient(x, t)
    return CandidateMotion(kind, amplitude, frequency, t, amplitude * x, amplitude * v)
