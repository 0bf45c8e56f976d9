"""Marks: faults of the measurement that a finished test shows by itself, each a sentence that its record keeps.

A check is a function of what was measured that gives the marks it sees; `CHECKS` and `CHECKS_OF_WHOLE` list them. A mark
that ``spoils`` its test ends the campaign, and the test is not complete: what was measured is not the damper.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.campaigns.campaign_thresholds import USUAL, CampaignThresholds
from dampyr.errors import InputError
from dampyr.records.checks.quality import flat_levels, motion_start
from dampyr.records.cycle_analysis.cycles import similar_cycles
from dampyr.records.record import MIN_SAMPLES, Array, Record
from dampyr.rig.cell_noise import least_noise
from dampyr.rig.interlock import RAIL
from dampyr.rig.settings import RigSettings
from dampyr.rig.thermal_model import COLD, COPPER
from dampyr.rig.uncertainty_budget import slow_errors

PIECE = 2**17  # samples that are looked at at a time: two minutes at 1 kHz
CHUNK = 64  # samples that are looked at together first, where a stretch is followed to its end
WINDOW = 0.02  # s in which a reading is looked at: 20 samples at 1 kHz, which the noise of a live cell leaves
ABRUPT = 0.05  # s about a reversal or a change of the voltage, within which the force may leap
CREEPS = 0.02  # m/s; below, the force of a damper changes with its speed, by all of the friction
SOON = 0.005  # s before and after a sample, in which the table's speed is looked at
AT_REST = 5.0e-5  # m: ten counts of the encoder; the force of a table at rest does not leap
ALIKE = 0.1  # of the stroke, by which the cycles of a motion that repeats itself differ, and end off where they began
LEAST_VOLTAGE = 0.2  # V from which a coil's resistance is taken
SETTLED_COIL = 8.0  # time constants of the coil after which its current is within 0.03 %
COIL_STEADY = 0.01  # V: a command that changes less from sample to sample is a slow ramp
SLIDES = 3.0e-4  # m of way in one direction, after which the force of any damper changes slowly
SLID = 2.0  # s in which such a way is looked for
MAX_LEAPS = 2000  # candidates that are looked at: a good test at 60 mm/s has some hundred
CLOSED = 0.1  # of the stroke, within which a test ends where it began
RESTED = 0.25  # s of a rest from which its force is taken


@dataclass(frozen=True)
class Mark:
    """A fault in words, and whether it spoils the test."""

    text: str
    spoils: bool = False


@dataclass(frozen=True)
class MeasuredTest:
    """What was measured in a test, (n,) SI, and by which rig; ``volts`` are those of the load cell."""

    time: Array
    displacement: Array
    force: Array
    volts: Array
    voltage: Array | float
    rig: RigSettings
    temperature: float = math.nan
    """degC of the damper after the test, as estimated or measured."""
    command: Array | None = None
    """V at the coil, as commanded; where anything reads the coil."""
    coil_voltage: Array | None = None
    """V at the coil, as read back."""
    coil_current: Array | None = None
    """A through the coil."""
    noise: float = math.nan
    """V rms of the load cell from sample to sample on the run's first slow pass, where it tells something."""
    closed_loop: bool = False
    """Whether the set points followed from the measured force, so that the table was driven also where it seems to stand."""
    thresholds: CampaignThresholds = USUAL

    @property
    def jitter(self) -> float:
        """m by which the position may stray while nothing moves: the encoder's reading changes at the border of two counts."""
        return 1.5 * self.rig.encoder.count


Check = Callable[[MeasuredTest], Iterator[Mark]]


def marks_of(read: Callable[[slice], MeasuredTest], rows: int) -> list[Mark]:
    """The marks of a test, in which ``read`` gives some of its ``rows`` samples; none of one with too few for a record.

    A long test is looked at in pieces, and the first mark of each check is given; as a whole it is looked at in every k-th
    sample, so that a test of any length takes the same memory.
    """
    if rows < MIN_SAMPLES:
        return []
    marks: dict[Check, Mark] = {}
    count = -(-rows // PIECE)
    for k in range(count):
        piece = read(slice(rows * k // count, rows * (k + 1) // count))
        for check in CHECKS:
            if check not in marks:
                marks.update((check, mark) for mark in check(piece))
    thinned = read(slice(0, rows, count))
    found = [marks[check] for check in CHECKS if check in marks]
    spoiled = any(mark.spoils for mark in found)  # a force that stands for a while makes the loop of a cycle flat, too
    whole = [check for check in CHECKS_OF_WHOLE if not (spoiled and check is changed_height)]
    return [*found, *(mark for check in whole for mark in check(thinned))]


def flat_force(measured: MeasuredTest) -> Iterator[Mark]:
    """A force that stands while the table moves, or leaps to where it stands: the cell's wire or its amplifier is broken, or
    the amplifier saturates."""
    x = measured.displacement
    stretches = [stretch for stretch in _find_standing(measured) if _should_change(measured, stretch)]
    if not stretches:
        yield from _mark_saturation(measured)
        return
    main = max(stretches, key=lambda stretch: stretch.stop - stretch.start)
    path = float(np.abs(np.diff(x[main])).sum())
    seconds = sum(float(measured.time[stretch.stop - 1] - measured.time[stretch.start]) for stretch in stretches)
    yield Mark(
        f"the force stands at {float(np.median(measured.force[main])):.4g} N for {seconds:.3g} s, from "
        f"{float(measured.time[main.start]):.4g} s over {1e3 * path:.3g} mm of the table's path: look at the load cell's "
        "wire and amplifier",
        spoils=True,
    )


def _mark_saturation(measured: MeasuredTest) -> Iterator[Mark]:
    """A force that stands without its noise at one level or two again and again, each time too shortly to be broken."""
    x, n = measured.displacement, max(1, round(0.5 * WINDOW * measured.rig.board.rate))
    moves = np.zeros(len(x), dtype=bool)
    moves[n : len(x) - n] = np.abs(x[2 * n :] - x[: len(x) - 2 * n]) > measured.jitter
    moving = np.flatnonzero(moves)
    levels = flat_levels(measured.volts, moving, measured.rig.step)
    if not levels:
        return
    flat = np.any([rows for _, rows in levels], axis=0)
    forces = [float(np.median(measured.force[rows])) for _, rows in levels]
    yield Mark(
        f"the force stands at {' and '.join(f'{force:.4g} N' for force in forces)} in {np.sum(flat) / len(moving):.2g} of the "
        f"samples in which the table moves, first at {float(measured.time[int(np.argmax(flat))]):.4g} s, without its noise: "
        "the load cell's amplifier saturates below the converter's rail; look at its gain and its supply",
        spoils=True,
    )


def _find_standing(measured: MeasuredTest) -> list[slice]:
    """The stretches in which the cell's reading stays within ``flat_steps`` of the converter."""
    volts, rig = measured.volts, measured.rig
    n, step = max(MIN_SAMPLES, round(WINDOW * rig.board.rate)), rig.step
    spread = measured.thresholds.flat_steps * step
    count = len(volts) // n
    windows = volts[: count * n].reshape(count, n)
    flat = np.ptp(windows, axis=1) <= spread
    stretches: list[slice] = []
    for k in np.flatnonzero(flat):
        level = float(np.median(windows[k]))
        if stretches and stretches[-1].stop >= k * n and abs(level - float(np.median(volts[stretches[-1]]))) <= step:
            first = stretches.pop().start
        else:
            first = _extend_stretch(volts, int(k) * n, level, -1, spread)
        stretches.append(slice(first, _extend_stretch(volts, int(k + 1) * n - 1, level, 1, spread) + 1))
    return stretches


def _extend_stretch(volts: Array, at: int, level: float, way: int, spread: float) -> int:
    """The last sample from ``at`` on, forwards or backwards, that is still at ``level``."""
    length = CHUNK
    while 0 <= at + way < len(volts):
        ahead = volts[at + 1 : at + 1 + length] if way > 0 else volts[max(0, at - length) : at][::-1]
        leaves = np.flatnonzero(~(np.abs(ahead - level) <= spread))
        if leaves.size:
            return at + way * int(leaves[0])
        at += way * len(ahead)
        length *= 2
    return at


def _should_change(measured: MeasuredTest, stretch: slice) -> bool:
    """Whether the force of a damper changes in a stretch, or leaps at an end of it as no damper's force does."""
    x, volts = measured.displacement, measured.volts
    if _reverses(x[stretch], measured.thresholds.reversal):
        return True
    leap = measured.thresholds.leap * max(measured.rig.step, float(np.median(np.abs(np.diff(volts)))))
    ends = [(stretch.start, stretch.start - 1), (stretch.stop - 1, stretch.stop)]
    inside = [(inner, outer) for inner, outer in ends if 0 <= outer < len(volts)]
    return any(abs(volts[inner] - volts[outer]) > leap and not _may_leap(measured, inner) for inner, outer in inside)


def _may_leap(measured: MeasuredTest, at: int) -> bool:
    """Whether the table turns around or the voltage changes about a sample, so that the force may change at once."""
    n = max(2, round(ABRUPT * measured.rig.board.rate))
    near = slice(max(0, at - n), at + n)
    if np.ndim(measured.voltage) and float(np.ptp(np.asarray(measured.voltage)[near])):
        return True
    x = measured.displacement
    if not float(np.ptp(x[near])) > AT_REST:
        return False
    return any(
        _turns_around(x, near.start + int(extreme(x[near])), 4 * n, measured) for extreme in (np.argmax, np.argmin)
    )


def _turns_around(x: Array, at: int, reach: int, measured: MeasuredTest) -> bool:
    """Whether the table leaves this sample to the side that it came from, be it slowly: a motor with friction sticks there."""
    sides = []
    for away in (x[max(0, at - reach) : at][::-1] - x[at], x[at : at + reach] - x[at]):
        beyond = away[np.abs(away) > measured.jitter]
        sides.append(np.sign(beyond[0]) if beyond.size else 0.0)
    return bool(sides[0] == sides[1] != 0.0)


def _reverses(x: Array, way: float) -> bool:
    """Whether the table turns and moves by ``way`` [m] on either side of it."""
    for turn in (int(np.argmax(x)), int(np.argmin(x))):
        sides = (np.ptp(x[: turn + 1]), np.ptp(x[turn:]))
        if min(sides) >= way:
            return True
    return False


def drifting_zero(measured: MeasuredTest) -> Iterator[Mark]:
    """A zero of the force that drifts: between the rests before and after the motion, or from cycle to cycle at one voltage."""
    half, allowed = 0.5 * float(np.ptp(measured.force)), measured.thresholds
    try:
        record = Record(measured.time, measured.displacement, measured.force)
    except InputError:  # samples that do not make a record are refused elsewhere
        return
    before, after = _force_at_rests(record)
    limit = allowed.rest_drift + allowed.rest_drift_share * half
    if before is not None and after is not None and abs(after - before) > limit:
        yield _mark_drift(
            f"from {before:.4g} N at rest before the motion to {after:.4g} N after it", after - before, limit
        )
        return
    spans = _repeated_cycles(record)[1:-1]  # growing and fading ones are left out
    if float(np.ptp(measured.voltage)) or len(spans) < allowed.cycles:
        return
    means = np.array([np.mean(measured.force[first:last]) for first, last in spans])
    times = np.array([measured.time[(first + last) // 2] for first, last in spans])
    rate = float(np.polyfit(times - times[0], means, 1)[0])
    limit = allowed.cycle_drift + allowed.cycle_drift_share * half
    if abs(rate) * record.duration > limit:
        yield _mark_drift(f"at {rate:+.3g} N/s, by the means of {len(spans)} cycles", rate * record.duration, limit)


def _repeated_cycles(record: Record) -> list[tuple[int, int]]:
    """The whole cycles of a motion that repeats itself; none of an earthquake, a random or a hybrid one.

    Between two turning points of such a motion the table goes anywhere, and does not come back to where it began: the mean
    force over it holds hysteresis and stiffness, and the spring gives back what an earlier stretch put in.
    """
    spans, x = similar_cycles(record), record.displacement
    if not spans:
        return []
    strokes = np.array([np.ptp(x[first : last + 1]) for first, last in spans])
    unclosed = np.array([abs(x[last] - x[first]) for first, last in spans])
    stroke = float(np.median(strokes))
    alike = np.abs(strokes - stroke) <= ALIKE * stroke
    return spans if np.all(alike & (unclosed <= ALIKE * stroke)) else []


def _mark_drift(course: str, change: float, limit: float) -> Mark:
    return Mark(
        f"the force's zero drifts {course}: {abs(change):.3g} N in the test, {limit:.3g} N at most; look at the load cell"
    )


def _force_at_rests(record: Record) -> tuple[float | None, float | None]:
    """The force [N] at the end of the rest before the motion, and at the end of that after it, where there are such rests."""
    n = max(1, round(RESTED / record.dt))
    mirrored = Record(-record.time[::-1], record.displacement[::-1], record.force[::-1])
    start = int(np.searchsorted(record.time, motion_start(record)))
    end = record.n - int(np.searchsorted(mirrored.time, motion_start(mirrored)))
    before = float(np.mean(record.force[start - n : start])) if start >= n else None
    after = float(np.mean(record.force[-n:])) if record.n - end >= n else None
    return before, after


def force_at_rail(measured: MeasuredTest) -> Iterator[Mark]:
    """A reading at the end of the converter's range."""
    limit = RAIL * measured.rig.board.range
    at_rail: NDArray[np.bool_] = np.abs(measured.volts) >= limit
    if at_rail.any():
        count = int(at_rail.sum())
        yield Mark(
            f"the force is at the converter's rail, {limit:.4g} V or more, in {count} samples, first at "
            f"{float(measured.time[int(np.argmax(at_rail))]):.4g} s: what was beyond it is not in the record"
        )


def changed_height(measured: MeasuredTest) -> Iterator[Mark]:
    """A loop whose height changes from a cycle to the next, where the motion repeats itself: a damper's changes over many."""
    if float(np.ptp(measured.voltage)) > COIL_STEADY:
        return
    try:
        record = Record(measured.time, measured.displacement, measured.force)
    except InputError:  # samples that do not make a record are refused elsewhere
        return
    spans = _repeated_cycles(record)[1:-1]  # growing and fading ones are left out
    if len(spans) < 2:
        return
    x, force = measured.displacement, measured.force
    steps = np.diff(x)
    work, path = 0.5 * (force[1:] + force[:-1]) * steps, np.abs(steps)
    heights = np.array([np.sum(work[a:b]) / np.sum(path[a:b]) for a, b in spans])
    usual, changes = float(np.median(heights)), np.diff(heights)
    # A cycle that is a little longer, or takes less time, is faster, and a damper's force grows no more than its speed.
    sizes = np.array([(np.ptp(x[a:b]), measured.time[b] - measured.time[a]) for a, b in spans])
    faster = np.sum(np.abs(np.diff(sizes, axis=0)) / np.median(sizes, axis=0), axis=1)
    allowed = measured.thresholds
    limits = (allowed.cycle_height + faster) * abs(usual) + allowed.pass_height * slow_errors(measured.rig)
    worst = int(np.argmax(np.abs(changes) - limits))
    if abs(changes[worst]) > limits[worst]:
        yield Mark(
            f"the force's loop grows by {changes[worst]:+.3g} N from a cycle to the next at "
            f"{float(measured.time[spans[worst + 1][0]]):.4g} s, of {usual:.4g} N, and {limits[worst]:.3g} N at most are a "
            "damper's: the gain of the load cell's chain has changed, or the coil's voltage; look at the amplifier and at the "
            "supply"
        )


def coil_without_its_voltage(measured: MeasuredTest) -> Iterator[Mark]:
    """A coil that does not have the voltage that was commanded: the supply is off, at its limit, or its enable line is low."""
    command, coil_voltage = measured.command, measured.coil_voltage
    if command is None or coil_voltage is None:
        return
    steady, allowed = _steady(command, measured), measured.thresholds
    size = float(np.abs(command).max(initial=0.0))
    difference = np.abs(coil_voltage - command)
    off_command = steady & (difference > allowed.coil_voltage_share * size + allowed.coil_voltage)
    if int(off_command.sum()) < WINDOW * measured.rig.board.rate:
        return
    worst = int(np.argmax(np.where(off_command, difference, -1.0)))
    yield Mark(
        f"the coil has {coil_voltage[worst]:.3g} V where {command[worst]:.3g} V were commanded, at {measured.time[worst]:.4g} "
        f"s, and other than commanded for {off_command.sum() / measured.rig.board.rate:.3g} s: look at the supply, its "
        "enable line and supply.gain",
        spoils=float(difference[worst]) > allowed.spoiling_share * size + allowed.coil_voltage,
    )


def coil_without_its_current(measured: MeasuredTest) -> Iterator[Mark]:
    """A current that is not the one which the voltage drives through a coil of that temperature."""
    command, current, rig = measured.command, measured.coil_current, measured.rig
    if command is None or current is None:
        return
    volts = command if measured.coil_voltage is None else measured.coil_voltage
    steady = _steady(command, measured) & (np.abs(volts) > LEAST_VOLTAGE)
    if int(steady.sum()) < WINDOW * rig.board.rate:
        return
    u, i = volts[steady], current[steady]
    # The conductance i = G u by least squares, over that of the coil at 20 degC: high voltages tell most of it.
    share = float(u @ i) / float(u @ u) * rig.supply.resistance
    first = float(measured.time[int(np.argmax(steady))])
    if share < 1.0 - measured.thresholds.spoiling_share - COPPER * max(0.0, rig.limits.temperature - COLD):
        yield Mark(
            f"{np.mean(i):.3g} A flow through the coil at {np.mean(u):.3g} V, from {first:.4g} s, and "
            f"{np.mean(u) / rig.supply.resistance:.3g} A do at 20 degC: look at the supply and at the coil's wires",
            spoils=True,
        )
        return
    # Copper: R = R20 (1 + COPPER (T - COLD)), solved for T.
    warm, expected = COLD + (1.0 / share - 1.0) / COPPER, measured.temperature
    of_resistance = math.hypot(rig.supply.resistance_uncertainty, rig.supply.reading_uncertainty) / COPPER
    uncertain = measured.thresholds.coil_warmth + of_resistance
    if abs(warm - expected) > uncertain or warm > rig.limits.temperature + uncertain:
        yield Mark(
            f"the coil's resistance is {rig.supply.resistance / share:.4g} ohm, that of {warm:.0f} degC, and the damper is at "
            f"{expected:.0f} degC as estimated: the voltage at 20 degC in the record is off by "
            f"{abs((1.0 + COPPER * (expected - COLD)) * share - 1.0):.1%}"
        )


def _steady(command: Array, measured: MeasuredTest) -> NDArray[np.bool_]:
    """Where the command has not changed for `SETTLED_COIL` time constants of the coil, and will not at the next sample."""
    supply = measured.rig.supply
    n = 2 + round(SETTLED_COIL * supply.inductance / supply.resistance * measured.rig.board.rate)
    changed = np.abs(np.diff(command, prepend=command[0])) > COIL_STEADY
    changed[0] = changed[-1] = True  # what was before and comes after is not in this stretch
    near = np.convolve(changed, np.ones(2 * n + 1), mode="full")[n : n + len(command)] > 0.5
    return np.asarray(~near)


def slow_cell(measured: MeasuredTest) -> Iterator[Mark]:
    """A reading with less noise than before: the cell's amplifier has grown slow, so that the force is late as well."""
    rig = measured.rig
    # Below a step of the converter what is read is the converter's own noise, which no amplifier lessens.
    if not measured.noise > rig.step / math.sqrt(3.0):
        return
    share = least_noise(measured.volts, rig.board.rate, rig.step) / measured.noise
    if share < measured.thresholds.quiet_share:
        yield Mark(
            f"the load cell's noise from sample to sample is {share:.0%} of what it was on the run's first slow pass: its "
            "amplifier has grown slow, so that the force is late and its turns are rounded; look at it and at its filter"
        )


def sudden_force(measured: MeasuredTest) -> Iterator[Mark]:
    """A force that leaps where no damper's does: while the table slides or stands, at one voltage."""
    limit = max(measured.thresholds.sudden_force, measured.thresholds.sudden_rate / measured.rig.board.rate)
    leaps = np.flatnonzero(np.abs(np.diff(measured.force)) > limit)
    for at in leaps[:MAX_LEAPS].tolist():
        if _is_steady(measured, at):
            size = float(measured.force[at + 1] - measured.force[at])
            yield Mark(
                f"the force leaps by {size:+.4g} N from a sample to the next at {float(measured.time[at]):.4g} s, while "
                "nothing that moves the damper does: look at the load cell's wires and amplifier, and for play in the pins"
            )
            return


def _is_steady(measured: MeasuredTest, at: int) -> bool:
    """Whether the table about a sample slides one way for `SLIDES` already, or stands, at one voltage.

    One that follows a computed building never stands: its set points change by a part of a count, which the encoder does not
    show, and the force by all of the friction. Nor does it slide evenly: they follow the force. A table whose speed changes may
    creep or stick, unseen within a count, and a motor changes its speed by 3 mm/s in a millisecond, which changes the force of
    any damper that creeps.
    """
    x, n = measured.displacement, max(2, round(ABRUPT * measured.rig.board.rate))
    # Within the two counts of a reading that strays the stiffest of dampers has 30 N.
    near, jitter = slice(max(0, at - n), at + n), measured.jitter
    if np.ndim(measured.voltage) and float(np.ptp(np.asarray(measured.voltage)[max(0, at - 2 * n) : at + n])):
        return False
    if float(np.ptp(x[near])) <= jitter:
        return not measured.closed_loop
    past = x[max(0, at - round(SLID * measured.rig.board.rate)) : at + 1]
    far = np.flatnonzero(np.abs(past - x[at]) >= SLIDES)
    if not far.size:
        return False
    way = past[far[-1] :]
    ahead, behind = x[at : at + n // 2], x[max(0, at - n // 2) : at]
    few = max(2, round(SOON * measured.rig.board.rate))
    soon, just = (abs(float(side[-1] - side[0])) for side in (x[at : at + few + 1], x[max(0, at - few) : at + 1]))
    evenly = abs(soon - just) <= jitter < min(soon, just) and not measured.closed_loop
    if min(soon, just) < CREEPS * few / measured.rig.board.rate and not evenly:
        return False
    forward = float(np.sign(way[-1] - way[0]))
    one_way = float(np.ptp(way)) <= abs(float(way[-1] - way[0])) + jitter
    goes, went = forward * float(ahead[-1] - ahead[0]), forward * float(behind[-1] - behind[0])
    return (
        one_way
        and went >= jitter
        and goes >= max(jitter, 0.5 * went)
        and float(np.min(forward * np.diff(ahead))) >= 0.0
    )


def created_energy(measured: MeasuredTest) -> Iterator[Mark]:
    """A damper that gives energy in a whole cycle, or in the whole test: the force's sign is inverted."""
    try:
        record = Record(measured.time, measured.displacement, measured.force)
    except InputError:  # samples that do not make a record are refused elsewhere
        return
    x, force = measured.displacement, measured.force
    # The integral of F dx is positive for what the damper takes, by the trapezoid rule at any sample.
    work = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(x))])
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(x)))])
    spans = [
        *_repeated_cycles(record),
        *([(0, record.n - 1)] if abs(float(x[-1] - x[0])) < CLOSED * float(np.ptp(x)) else []),
    ]
    for first, last in spans:
        gained, way = float(work[first] - work[last]), float(path[last] - path[first])
        if gained > measured.thresholds.created_force * way:
            yield Mark(
                f"the damper gives {gained:.3g} J from {float(measured.time[first]):.4g} s to {float(measured.time[last]):.4g} "
                "s, and should take some: is the force's sign inverted? Look at the load cell's wires",
                spoils=True,
            )
            return


CHECKS: tuple[Check, ...] = (
    flat_force,
    force_at_rail,
    coil_without_its_voltage,
    coil_without_its_current,
    slow_cell,
    sudden_force,
)
"""The checks of every stretch of a test, in the order in which their marks stand in a record."""
CHECKS_OF_WHOLE: tuple[Check, ...] = (drifting_zero, changed_height, created_energy)
"""The checks of a test as a whole, whose marks follow."""
