"""Whether the rig can do a step, before anything moves; where it cannot, what is in the way and what it could do.

This is the outermost of the three safety layers: firmware and interlock do not rely on it. At every set point the
actuator's free speed at the largest duty that it may have, less its droop under the expected force and the table's friction,
must exceed the path's speed, and also the speed that the motor's lag makes of it, :math:`|v + \\tau a|`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import floor, log10
from typing import Any

import numpy as np

from dampyr.campaigns.force_prediction import Array, Course, course
from dampyr.campaigns.step import quantity_of, shown
from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.rig import Drive, RigSettings
from dampyr.rig.settings import FULL_DUTY
from dampyr.units import round_trip

STROKE_MARGIN = 0.0005  # m that the path stays inside of the stroke: the table follows its set points with an error
MAX_DURATION = 7200.0  # s of one test
DIGITS = 3
HALVINGS = 16  # down to 3e-5 of the value: what passes only below that does not repair a test


@dataclass(frozen=True)
class Violation:
    """One limit that a step would leave: which one, and a sentence without its beginning."""

    limit: str
    words: str


def violations_of(step: Any, rig: RigSettings, damper: Damper | None = None) -> tuple[Violation, ...]:
    """What the rig cannot do of a step; empty where it can do all of it."""
    drive = step.drive(rig)
    violations = [*_duration(drive), *_duty(drive, rig), *_temperature(drive, rig), *_voltage(drive, rig, damper)]
    if not any(
        violation.limit in ("voltage", "duration") for violation in violations
    ):  # the force follows from the voltage
        trajectory = course(drive, rig, damper)
        violations += [
            *_stroke(step, trajectory, rig),
            *_speed(step, drive, trajectory, rig),
            *_force(trajectory, rig, damper),
        ]
    else:
        violations += _stroke(step, None, rig)
    return tuple(violations)


def _duration(drive: Drive) -> list[Violation]:
    if drive.duration <= MAX_DURATION:
        return []
    words = f"takes {drive.duration / 60:.4g} min, a test takes at most {MAX_DURATION / 60:g} min; shorten it"
    return [Violation("duration", words)]


def _duty(drive: Drive, rig: RigSettings) -> list[Violation]:
    largest = rig.actuator.max_duty
    if drive.reversals is None or round(FULL_DUTY * drive.reversals.duty) <= rig.actuator.duty_steps:
        return []
    words = f"asks for a duty of {drive.reversals.duty:.4g}, the largest is {largest:.4g} (actuator.max_duty); lower the duty"
    return [Violation("duty", words)]


def _temperature(drive: Drive, rig: RigSettings) -> list[Violation]:
    wanted, limit = drive.until_temperature, rig.limits.temperature
    if wanted is None:
        return []
    if not rig.wires.temperature:
        return [Violation("temperature", "waits for a temperature, the rig has no thermocouple (wires.temperature); "
                                       "give cycles and no temperature")]  # fmt: skip
    if wanted < limit:
        return []
    return [Violation("temperature", f"warms up to {wanted:g} degC, the limit is {limit:g} degC; stay below it")]


def _voltage(drive: Drive, rig: RigSettings, damper: Damper | None) -> list[Violation]:
    least, high = drive.voltage_range
    limit = min(rig.limits.voltage, rig.board.range * rig.supply.gain)
    lower = "" if not drive.law else "; give the law another high or low"
    if high > limit * (1 + 1e-9):
        return [Violation("voltage", f"needs {high:.4g} V at the coil, the limit is {limit:.4g} V{lower}")]
    if damper is None:
        return []
    if not damper.has_input:
        return []
    factor = 1.0 if damper.input == "V" else rig.supply.resistance
    low, top = (value * factor for value in damper.range)
    slack = 1e-9 * max(abs(low), abs(top), 1.0)
    for worst in (high, least):
        if not low - slack <= worst <= top + slack:
            words = f"needs {worst:.4g} V at the coil, the damper was calibrated from {low:.4g} to {top:.4g} V{lower}"
            return [Violation("voltage", words)]
    return []


def _stroke(step: Any, trajectory: Course | None, rig: RigSettings) -> list[Violation]:
    limit = round(rig.travel - STROKE_MARGIN, 9)
    far = max(step.peaks(rig).position, 0.0 if trajectory is None else float(np.abs(trajectory.x).max()))
    if far <= limit * (1 + 1e-9):
        return []
    less = rig.limits.braking + STROKE_MARGIN
    allowed = f"{1e3 * limit:.4g} mm (half of the stroke, less {1e3 * less:g} mm to brake and to follow)"
    return [Violation("stroke", f"goes {1e3 * far:.4g} mm from the middle, the table may go {allowed}")]


def _speed(step: Any, drive: Drive, trajectory: Course, rig: RigSettings) -> list[Violation]:
    peak, fast = step.peaks(rig).speed, float(trajectory.speed.max())
    between = max(peak / fast, 1.0) if fast else 1.0  # the peak of the path between set points
    too_slow = [] if drive.reversals is not None else _actuator(trajectory, between * trajectory.speed, rig)
    fast = max(fast, peak)
    if too_slow or fast <= rig.limits.speed:
        return too_slow
    return [Violation("speed", f"reaches {1e3 * fast:.4g} mm/s, the limit is {1e3 * rig.limits.speed:.4g} mm/s")]


def _actuator(trajectory: Course, speed: Array, rig: RigSettings) -> list[Violation]:
    """Where the path is faster than the loaded actuator, or, with what its lag takes, its motor."""
    loaded = trajectory.against + rig.table.friction
    gives = rig.actuator.top_speed - rig.actuator.droop * loaded
    lagging = np.abs(trajectory.v + rig.actuator.lag * trajectory.a)
    for need, words in ((speed, ","), (lagging, " of the motor, with what its lag takes,")):
        short = np.where(trajectory.speed > 0, need - gives, -np.inf)
        worst = int(np.argmax(short))
        if short[worst] > 0:
            have = f"{1e3 * gives[worst]:.4g} mm/s at {loaded[worst]:.3g} N"
            return [Violation("speed", f"needs {1e3 * need[worst]:.4g} mm/s{words} the actuator gives {have}")]
    return []


def _force(trajectory: Course, rig: RigSettings, damper: Damper | None) -> list[Violation]:
    high = float(np.abs(trajectory.force).max())
    if high <= rig.limits.force:
        return []
    kind = "expects" if damper is not None else "may meet, by a conservative envelope,"
    return [Violation("force", f"{kind} {high:.4g} N, the limit is {rig.limits.force:.4g} N")]


def repairs(step: Any, rig: RigSettings, damper: Damper | None = None, limit: str | None = None) -> tuple[str, ...]:
    """What could be lowered, each alone, and to what: ``the amplitude to 6.2 mm``; for one ``limit``, or for all."""
    suggestions = []
    for field in step.lowers:
        value = largest(step, field, rig, damper, limit)
        if value is not None:
            unit = quantity_of(step, field).unit
            lowered = shown(replace(step, **{field: value}), field) if unit else f"{value:.6g}"
            suggestions.append(f"the {field.replace('_', ' ')} to {lowered}")
    return tuple(suggestions)


def largest(
    step: Any, field: str, rig: RigSettings, damper: Damper | None = None, limit: str | None = None
) -> float | None:
    """The largest value of ``field`` below the step's that passes the check, found by halving and then by bisection.

    Parameters
    ----------
    step
        A step, such as `dampyr.campaigns.steps.sine.Sine`.
    field
        The name of its number that is lowered, such as "amplitude".
    rig
        The rig whose limits hold.
    damper
        Gives the expected force; None: a conservative envelope does.
    limit
        The name of the one limit that has to hold, such as "speed"; None: all of them.

    Returns
    -------
    float or None
        SI, to three digits, rounded down; None where lowering this field alone does not help.

    Examples
    --------
    >>> import dampyr as dp
    >>> from dampyr.campaigns.check import largest, violations_of
    >>> from dampyr.campaigns.kinds import kind
    >>> step = kind("sine")(amplitude=0.02, frequency=2.0)
    >>> [violation.limit for violation in violations_of(step, dp.rig.RigSettings())]
    ['speed']
    >>> largest(step, "amplitude", dp.rig.RigSettings())
    0.00539
    """

    def passes(value: float) -> bool:
        try:
            violations = violations_of(replace(step, **{field: value}), rig, damper)
        except InputError:  # such as a frequency below the least that is allowed
            return False
        return not [violation for violation in violations if limit in (None, violation.limit)]

    highest = float(getattr(step, field))
    halves = (highest * 0.5**k for k in range(1, HALVINGS) if highest > 0)
    low = next((value for value in halves if passes(value)), None)
    if low is None:
        return None
    high = min(2 * low, highest)  # does not pass: the halving would have stopped there
    while high - low > 1e-5 * low:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if passes(middle) else (low, middle)
    unit = 10.0 ** (floor(log10(low)) - DIGITS + 1)
    # The bisection ends up to 1e-5 below the bound, which may itself be a round value: 6.19996 mm is to give 6.2 mm.
    rounded = round_trip(floor(low / unit + 2e-3) * unit)
    return rounded if passes(rounded) else low
