"""Candidate tests: what a rig could be asked to do with a damper, each inside all of the rig's limits.

The plane of amplitude and frequency is divided evenly in both logarithms. At each frequency the largest amplitude that passes
the check before motion with the force that the damper's card predicts is found, and shares of it are candidates too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.campaigns.check import STROKE_MARGIN, largest, violations_of
from dampyr.campaigns.force_prediction import specimen
from dampyr.campaigns.kinds import kind
from dampyr.campaigns.step import quantity_of, words
from dampyr.errors import InputError
from dampyr.models import Damper, Interpolation
from dampyr.rig import RigSettings
from dampyr.units import round_trip

Array = NDArray[np.float64]
KINDS = ("sine", "voltage_steps", "sweep", "random")
SECONDS = 20.0  # of steady motion: as long as the median record of the published campaign
LOWEST = 0.41  # Hz: below it a test of twenty seconds has fewer than eight cycles
HIGHEST = 3.83  # Hz: above it the original rig's motor, with its lag, does less than 2 mm; no whole number of samples a cycle,
# or every reversal would lie at the same place between two samples
FREQUENCIES = 8  # with six, rounds repeat the same few motions, and intervals are up to twice as wide
MARGIN = 0.95  # of the largest amplitude: a damper that is stronger than its card is tested, too
# Shares of the largest amplitude at a frequency: in smaller motions records differ by more than is assumed.
SHARES = (MARGIN, 0.7, 0.5)
LEAST = 100.0  # counts of the encoder in an amplitude: below it they are a per cent of the motion
LEVELS = 4  # inputs at which a law of a card without knots is tested: a cubic law needs as many
SEEDS = (0, 1)  # of random motions
MAX_LEVELS = 8  # inputs of a design; more are most likely readings that should have been one
SHORTEST = 4.0  # s of steady motion: scores begin 2 s after a motion starts


@dataclass(frozen=True)
class Candidate:
    """A step that the rig can do; ``frequency`` [Hz] and ``amplitude`` [m] place it in the envelope, a band by its middle."""

    kind: str
    step: Any
    frequency: float
    amplitude: float
    duration: float
    has_input: bool = True

    @property
    def words(self) -> str:
        """What it does, such as ``sine 20 mm at 2 Hz, 0.8712 V``; of a damper without an input the motion alone."""
        return words(self.kind, self.step, () if self.has_input else ("voltage",))

    @property
    def table(self) -> dict[str, Any]:
        """The ``[[step]]`` of a campaign file: what differs from the kind's defaults, numbers with their units."""
        table: dict[str, Any] = {"kind": self.kind}
        for setting in fields(self.step):
            value = getattr(self.step, setting.name)
            if value != setting.default:
                table[setting.name] = _write_value(self.step, setting.name, value)
        return table


def _write_value(step: Any, name: str, value: Any) -> Any:
    if isinstance(value, tuple):
        return [_write_value(step, name, item) for item in value]
    if isinstance(value, bool | int | str):
        return value
    unit = quantity_of(step, name).unit
    if unit == "m":
        return f"{round_trip(1e3 * value)} mm"
    return f"{value} {unit}" if unit else value


@dataclass(frozen=True)
class RigEnvelope:
    """The candidates, and the largest amplitude [m] (n,) of a sine at each frequency [Hz] (n,), by voltage."""

    candidates: tuple[Candidate, ...]
    frequencies: Array
    limits: dict[float, Array]
    voltages: tuple[float, ...]


def voltages_of(damper: Damper, rig: RigSettings, wanted: Sequence[float] | None = None) -> tuple[float, ...]:
    """The voltages of a design: those ``wanted``, else the knots of the card's laws, else four from end to end.

    Raises :class:`~dampyr.errors.InputError` for a damper over the current and a voltage that neither rig nor card allow. A
    damper without an input is tested with the coil of the rig off.
    """
    if not damper.has_input:
        if wanted:
            raise InputError("voltages are given, and the damper has no input; leave them out")
        return (0.0,)
    if damper.input != "V":
        raise InputError(
            "this card is over the current in A, and a rig is told voltages; give a card over the voltage, such as one "
            "identified from this rig's records"
        )
    low, high = damper.range
    high = min(high, rig.limits.voltage)
    if wanted is not None:
        chosen = sorted({float(u) for u in wanted})
        for u in chosen:
            if not low - 1e-9 <= u <= high + 1e-9:
                raise InputError(
                    f"voltage = {u:g} V is outside of {low:.4g} to {high:.4g} V, for which the card and the rig allow a test; "
                    "leave it out"
                )
    else:
        knots = {u for law in damper.all_laws.values() if isinstance(law, Interpolation) for u in law.knots}
        chosen = sorted(u for u in knots if low <= u <= high) or np.unique(np.linspace(low, high, LEVELS)).tolist()
    if not 0 < len(chosen) <= MAX_LEVELS:
        raise InputError(f"{len(chosen)} voltages are not allowed; give 1 to {MAX_LEVELS} of them")
    return tuple(chosen)


def envelope(
    rig: RigSettings,
    damper: Damper,
    voltages: Sequence[float] | None = None,
    kinds: Sequence[str] = KINDS,
    seconds: float = SECONDS,
    progress: Callable[[float], None] = lambda done: None,
) -> RigEnvelope:
    """All candidates of these ``kinds`` with about ``seconds`` of steady motion.

    Raises :class:`~dampyr.errors.InputError` where there is none.
    """
    unplanned = [name for name in kinds if name not in KINDS]
    if unplanned or not kinds:
        raise InputError(
            f"kinds {'names ' + repr(unplanned[0]) if unplanned else 'is empty'}; choose among {', '.join(KINDS)}"
        )
    if not SHORTEST <= seconds <= 600.0:
        raise InputError(f"seconds = {seconds:g} is not allowed; give {SHORTEST:g} to 600 s of steady motion")
    levels = voltages_of(damper, rig, voltages if damper.has_input else None)
    frequencies = np.array([round(float(f), 3) for f in np.geomspace(LOWEST, HIGHEST, FREQUENCIES)])
    limits, candidates, rounds = {}, [], len(levels) + 2
    for k, u in enumerate(levels):
        limits[u] = np.array([_limit_sine(f, u, rig, damper) for f in frequencies])
        progress((k + 1) / rounds)
        if "sine" in kinds:
            candidates += _take_shares(frequencies, limits[u], rig, partial(make_sine, u=u, seconds=seconds))
    if "voltage_steps" in kinds and len(levels) > 1:
        steps = partial(_make_voltage_steps, levels=levels, seconds=seconds)
        candidates += _take_shares(frequencies, limits[max(levels)], rig, steps)
    progress((rounds - 1) / rounds)
    for u in levels:
        if "sweep" in kinds:
            candidates += _fit_bands(
                rig, damper, [_make_sweep(start, stop, u, seconds, rig) for start, stop in ((0.3, 1.5), (0.8, 4.0))]
            )
        if "random" in kinds:
            candidates += _fit_bands(
                rig, damper, [_make_random(0.2, top, u, seconds, s, rig) for top in (1.5, 4.0) for s in SEEDS]
            )
    dampers = list_dampers(rig, damper)
    passed = tuple(
        replace(c, has_input=damper.has_input)
        for c in candidates
        if not any(violations_of(c.step, rig, checked) for checked in dampers)
    )
    progress(1.0)
    if not passed:
        at, lower = "", ""
        if damper.has_input:
            at, lower = f" at {min(levels):.4g} to {max(levels):.4g} V", "lower the voltages, or "
        raise InputError(
            f"the rig {rig.name!r} can do none of {len(candidates)} candidate tests with this damper{at}: with at least "
            f"{1e3 * smallest_amplitude(rig):.3g} mm none is within its limits; {lower}check actuator and limits in the "
            "rig's file"
        )
    return RigEnvelope(passed, frequencies, limits, levels)


def smallest_amplitude(rig: RigSettings) -> float:
    """What the encoder tells to a per cent, m."""
    return LEAST * rig.encoder.count


def _largest_amplitude_of_rig(rig: RigSettings) -> float:
    """The farthest amplitude that the stroke allows, m."""
    return max(round(rig.travel - STROKE_MARGIN, 9), 1e-6)


def _limit_sine(frequency: float, voltage: float, rig: RigSettings, damper: Damper) -> float:
    """The largest amplitude [m] of a short sine there; 0 where none passes."""
    step = kind("sine")(
        amplitude=_largest_amplitude_of_rig(rig), frequency=float(frequency), voltage=voltage, cycles=2, rest_before=0.0
    )
    return _limit_amplitude(step, rig, damper) or 0.0


def list_dampers(rig: RigSettings, damper: Damper) -> tuple[Damper | None, ...]:
    """What a step is checked with: the damper, and where the rig's file names no card, what a campaign is checked with then."""
    return (damper,) if rig.specimen.card else (damper, specimen(rig))


def _limit_amplitude(step: Any, rig: RigSettings, damper: Damper) -> float | None:
    """The largest amplitude [m] that passes, at most the step's own; None where none does."""
    a: float | None = float(step.amplitude)
    for checked in list_dampers(rig, damper):
        if a is not None and violations_of(replace(step, amplitude=a), rig, checked):
            a = largest(replace(step, amplitude=a), "amplitude", rig, checked)
    return a


def _take_shares(
    frequencies: Array, limits: Array, rig: RigSettings, candidate_of: Callable[[float, float], Candidate]
) -> list[Candidate]:
    """Candidates at each frequency with shares of the largest amplitude there, to three digits, rounded down."""
    candidates = []
    for f, limit in zip(frequencies, limits, strict=True):
        for share in SHARES:
            a = round_down(share * limit)
            if a >= smallest_amplitude(rig):
                candidates.append(candidate_of(float(f), a))
    return candidates


def round_down(value: float) -> float:
    """To three digits, never up."""
    if value <= 0.0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return round_trip(math.floor(value / unit + 2e-3) * unit)


def make_sine(f: float, a: float, u: float, seconds: float) -> Candidate:
    """A sine of ``f`` Hz, ``a`` m and ``u`` V, for about so many seconds."""
    step = kind("sine")(amplitude=a, frequency=f, voltage=u, cycles=max(1, round(seconds * f)), rest_before=1.0)
    return _place("sine", step, f, a)


def _make_voltage_steps(f: float, a: float, levels: tuple[float, ...], seconds: float) -> Candidate:
    """Up through all levels and down again, each for whole cycles and as long as all others.

    From the highest level straight to 0 V the current would pass all levels between, and what the model of its lag misses there
    would be the largest error of the record.
    """
    hold = max(1, round(seconds * f / len(levels) / 2)) / f
    up_and_down = (*levels, *levels[::-1])
    step = kind("voltage_steps")(amplitude=a, frequency=f, voltages=up_and_down, hold=round(hold, 3), rest_before=1.0)
    return _place("voltage_steps", step, f, a)


def _make_sweep(start: float, stop: float, u: float, seconds: float, rig: RigSettings) -> Candidate:
    step = kind("sweep")(
        amplitude=_largest_amplitude_of_rig(rig), start=start, stop=stop, duration=seconds, voltage=u, rest_before=1.0
    )
    return _place("sweep", step, math.sqrt(start * stop), _largest_amplitude_of_rig(rig))


def _make_random(low: float, high: float, u: float, seconds: float, seed: int, rig: RigSettings) -> Candidate:
    taper = min(2.0, 0.25 * seconds)
    step = kind("random")(
        amplitude=_largest_amplitude_of_rig(rig),
        low=low,
        high=high,
        duration=seconds,
        voltage=u,
        seed=seed,
        taper=taper,
        rest_before=1.0,
    )
    return _place("random", step, math.sqrt(low * high), _largest_amplitude_of_rig(rig))


def _place(name: str, step: Any, frequency: float, amplitude: float) -> Candidate:
    return Candidate(name, step, frequency, amplitude, step.drive(RigSettings()).duration)


def _fit_bands(rig: RigSettings, damper: Damper, wanted: list[Candidate]) -> list[Candidate]:
    """Tests over a band of frequencies with the largest amplitude that passes, where that is enough."""
    candidates = []
    for candidate in wanted:
        a = _limit_amplitude(candidate.step, rig, damper)
        if a is not None and a >= smallest_amplitude(rig):
            a = round_down(MARGIN * a)
            candidates.append(replace(candidate, step=replace(candidate.step, amplitude=a), amplitude=a))
    return candidates
