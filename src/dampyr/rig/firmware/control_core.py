"""What the firmware does a thousand times a second, in whole numbers as on the Uno (docs/reference/protocol.md).

The registers are one row of int64: what requests set and what a status shows, the queue of set points and the last
positions; but for the sum of `R_FREE`, every number here fits into 32 bits. `tick` is plain Python that numba compiles together
with the simulated rig.
"""

from __future__ import annotations

from dampyr.rig.firmware import protocol
from dampyr.rig.firmware.protocol import Fault, State

RATE = 1000  # Hz
FULL_SPEED = 15600  # counts/s at duty 255: 78 mm/s
GAIN = 40  # 1/s: counts/s for each count away from the set point
DEAD_DUTY = 15  # duty that only overcomes friction
AHEAD = 24  # ms: the speed that is fed forward is the one asked for so much later, the motor's lag
STILL = 4  # counts away from a resting set point that the brake may hold
WINDOW = 10  # ms over which the speed is taken
AWAY = 1000  # counts from the set point
STALL_DUTY, STALL_MOVE = 64, 2
FREE_TRAVEL = 400  # counts, 2 mm, that a free motor would have made while the encoder counted less than STALL_MOVE
CREEP = 1000  # counts/s, 5 mm/s, below which a load may hold the table for long until the duty has grown
STOP_TIME = 60  # ms
FIRST_SWEEP = 250  # counts to the first turn of a search for the index
INDEX_SHIFT = 2  # counts by which the index may be passed away from its place
# while the table is slow: not homed, or outside of the limits
SLOW = 400  # counts/s: 2 mm/s
SLOW_BRAKE, SLOW_FAULT = 600, 1000  # counts/s: the brake's, and the fault's
SLOW_AHEAD = 80  # counts by which the moving set point may be ahead
SLOW_DUTY = 64  # pushes with 800 N at most against a stop
SPARE = 200  # counts beyond what a search needs
REVERSED, PROVEN = 40, 100  # counts against the duty, a fault; counts with it, after which the direction is proven
JUMP = 60  # counts in a millisecond: more than any motor makes
OVER_TIME = 20  # ms for which the motor's current may be above the largest
EDGE = 100  # counts that a table outside of the limits may go farther out

QUEUE = protocol.QUEUE
IDLE, ARMED, FOLLOWING, REVERSING, JOGGING, HOMING, STOPPING, FAULT = (int(state) for state in State)
HEARTBEAT, LOW, HIGH, SPEED, STALL, LOST, UNDERRUN, ENCODER = (int(fault) for fault in Fault if fault < Fault.ABORTED)
INDEX, END, EMERGENCY, DIRECTION, OVERCURRENT = (int(fault) for fault in Fault if fault > Fault.RESTARTED)
LOW_END, HIGH_END, PRESSED = protocol.LOW_END, protocol.HIGH_END, protocol.PRESSED
ENDS_WIRED, EMERGENCY_WIRED = protocol.ENDS_WIRED, protocol.EMERGENCY_WIRED

# registers
(
    R_STATE, R_FAULTS, R_TIME, R_POSITION, R_SPEED, R_DUTY, R_COUNTS, R_OFFSET, R_HOMED, R_LIMITED,
    R_LOW, R_HIGH, R_MAX_SPEED, R_HEARTBEAT, R_MAX_DUTY, R_STALL, R_WIRED, R_SLEW, R_MAX_CURRENT,
    R_SINCE, R_STALLED, R_STALL_AT, R_FREE,
    R_HEAD, R_NEXT, R_LAST, R_PERIOD, R_PHASE, R_TARGET, R_RATE, R_LEFT, R_HALF, R_PAUSE, R_STROKES,
    R_INDEX, R_INDEX_SET, R_SHIFT, R_PASSES, R_TURN, R_START, R_SIGN, R_ENDS, R_END_AT, R_FILLED,
    R_INPUTS, R_OUTSIDE, R_EDGE, R_ORIGIN, R_WAY, R_WAY_AT, R_PROVEN,
    R_RESTING, R_CURRENT, R_OVER, R_JUMPED,
) = range(55)  # fmt: skip
R_QUEUE = 56  # after the 55 above, with places left for more
R_PAST = R_QUEUE + QUEUE
REGISTERS = R_PAST + WINDOW


def quotient(a, b):
    """a / b towards 0, as C divides whole numbers, for b > 0."""
    return a // b if a >= 0 else -(-a // b)


def tick(r, counts, latched, index, glitch, inputs=0, current=0):
    """One millisecond: ``counts`` of the encoder, whether the index was passed (``latched``) and at which count, whether both
    lines changed at once (``glitch``), which of the end switches and of the emergency stop are open (``inputs``), and the
    larger reading of the bridge's two current outputs (``current``)."""
    r[R_TIME] += 1
    r[R_SINCE] = min(r[R_SINCE] + 1, 1000000)
    r[R_INPUTS] = inputs
    r[R_CURRENT] = current if r[R_MAX_CURRENT] != 0 else 0
    observe(r, counts)
    faults = 0
    if latched:
        faults = see_index(r, index)
    if ARMED <= r[R_STATE] <= STOPPING:
        faults |= watched(r, glitch)
        if faults:
            fail(r, faults)
    elif faults:
        lose_place(r)
    act(r)


def observe(r, counts):
    """Position, and speed over the last `WINDOW`."""
    slot = R_PAST + r[R_TIME] % WINDOW
    old = r[slot] if r[R_FILLED] >= WINDOW else counts
    r[R_FILLED] += 1 if r[R_FILLED] < WINDOW else 0
    r[slot] = counts
    r[R_JUMPED] = 1 if abs(counts - r[R_COUNTS]) > JUMP else 0
    r[R_COUNTS] = counts
    r[R_POSITION] = counts + r[R_OFFSET]
    r[R_SPEED] = (counts - old) * (RATE // WINDOW)
    if r[R_OUTSIDE] != 0 and r[R_LOW] <= r[R_POSITION] <= r[R_HIGH]:
        r[R_OUTSIDE] = 0


def see_index(r, index):
    """The index was passed at a count: a search ends there, else it is compared with its place; the fault where it moved."""
    if r[R_STATE] == HOMING:
        r[R_OFFSET] = r[R_INDEX] - index
        r[R_POSITION] = r[R_COUNTS] + r[R_OFFSET]
        r[R_HOMED] = r[R_INDEX_SET] = r[R_PASSES] = 1
        r[R_SHIFT] = 0
        rest(r)
    elif r[R_HOMED]:
        if not r[R_INDEX_SET]:  # homed by hand: the first pass tells the place
            r[R_INDEX] = index + r[R_OFFSET]
            r[R_INDEX_SET] = 1
        r[R_PASSES] += 1
        r[R_SHIFT] = index + r[R_OFFSET] - r[R_INDEX]
        if abs(r[R_SHIFT]) > INDEX_SHIFT:
            return INDEX
    return 0


def slow(r):
    """Whether the table may only be moved slowly."""
    return not r[R_HOMED] or r[R_OUTSIDE] != 0


def watched(r, glitch):
    """The faults of this moment."""
    faults = 0
    if r[R_SINCE] > r[R_HEARTBEAT]:
        faults |= HEARTBEAT
    faults |= beyond(r)
    if not r[R_JUMPED] and (abs(r[R_SPEED]) > r[R_MAX_SPEED] or (slow(r) and abs(r[R_SPEED]) > SLOW_FAULT)):
        faults |= SPEED
    if stalled(r) and r[R_STATE] != HOMING:  # where a search takes it for the end of the stroke
        faults |= STALL
    if overcurrent(r):
        faults |= OVERCURRENT
    if reversed_leads(r):
        faults |= DIRECTION
    if not r[R_JUMPED] and r[R_STATE] == FOLLOWING and abs(r[R_TARGET] - r[R_POSITION]) > AWAY:
        faults |= LOST
    if (r[R_WIRED] & EMERGENCY_WIRED) != 0 and (r[R_INPUTS] & PRESSED) != 0:
        faults |= EMERGENCY
    if both_ends(r) or (r[R_STATE] != HOMING and (at_end(r, r[R_DUTY]) or at_end(r, r[R_SPEED]))):
        faults |= END
    if glitch or r[R_JUMPED]:
        faults |= ENCODER
    return faults


def beyond(r):
    """The fault of a table outside of its limits, or, while it is not homed, farther than a stroke from where it was."""
    if not r[R_HOMED]:
        gone, farthest = r[R_COUNTS] - r[R_ORIGIN], r[R_HIGH] - r[R_LOW] + 2 * SPARE
        return HIGH if gone > farthest else (LOW if gone < -farthest else 0)
    if r[R_POSITION] < (r[R_EDGE] if r[R_OUTSIDE] < 0 else r[R_LOW]):
        return LOW
    return HIGH if r[R_POSITION] > (r[R_EDGE] if r[R_OUTSIDE] > 0 else r[R_HIGH]) else 0


def at_end(r, way):
    """Whether the end switch in the direction of ``way`` is open."""
    if (r[R_WIRED] & ENDS_WIRED) == 0:
        return False
    return (way < 0 and (r[R_INPUTS] & LOW_END) != 0) or (way > 0 and (r[R_INPUTS] & HIGH_END) != 0)


def both_ends(r):
    """Whether both end switches are open, as with a broken wire."""
    return (r[R_WIRED] & ENDS_WIRED) != 0 and (r[R_INPUTS] & (LOW_END | HIGH_END)) == (LOW_END | HIGH_END)


def stalled(r):
    """Whether much duty has moved nothing for too long, or any duty for as long as would make `FREE_TRAVEL`."""
    if abs(r[R_COUNTS] - r[R_STALL_AT]) >= STALL_MOVE or r[R_DUTY] == 0:
        r[R_STALL_AT] = r[R_COUNTS]
        r[R_STALLED] = r[R_FREE] = 0
        return False
    r[R_STALLED] = r[R_STALLED] + 1 if abs(r[R_DUTY]) >= STALL_DUTY else 0
    lost = STALL_DUTY if r[R_STATE] == REVERSING else DEAD_DUTY
    if not r[R_RESTING]:
        r[R_FREE] += max(0, abs(r[R_DUTY]) - lost) * FULL_SPEED // (255 - DEAD_DUTY)
    return r[R_STALLED] >= r[R_STALL] or r[R_FREE] > FREE_TRAVEL * RATE


def overcurrent(r):
    """Whether the motor's current has been above the largest for too long; 0 is not above 0 where it is not wired."""
    r[R_OVER] = r[R_OVER] + 1 if r[R_CURRENT] > r[R_MAX_CURRENT] else 0
    return r[R_OVER] > OVER_TIME


def reversed_leads(r):
    """Whether the table goes against the duty, until it has gone with it once: leads of motor or encoder are swapped."""
    if r[R_PROVEN] or r[R_DUTY] == 0:
        return False
    way = 1 if r[R_DUTY] > 0 else -1
    if way != r[R_WAY]:
        r[R_WAY] = way
        r[R_WAY_AT] = r[R_COUNTS]
    moved = (r[R_COUNTS] - r[R_WAY_AT]) * way
    if moved >= PROVEN:
        r[R_PROVEN] = 1
    return moved <= -REVERSED or (moved < 0 and abs(r[R_SPEED]) > SLOW_FAULT)


def fail(r, faults):
    """To FAULT; an encoder that lost its place is no longer homed."""
    r[R_FAULTS] |= faults
    r[R_STATE] = FAULT
    r[R_DUTY] = 0
    if (faults & (ENCODER | INDEX)) != 0:
        lose_place(r)
    empty(r)


def lose_place(r):
    """No longer homed; what is gone without is counted from here."""
    r[R_HOMED] = r[R_OUTSIDE] = 0
    r[R_ORIGIN] = r[R_COUNTS]


def empty(r):
    """Forget the set points."""
    r[R_HEAD] = 0
    r[R_NEXT] = 0


def rest(r):
    """Begin to stop."""
    r[R_STATE] = STOPPING
    r[R_LEFT] = STOP_TIME
    r[R_DUTY] = 0
    empty(r)


def act(r):
    """The duty of this moment."""
    before = r[R_DUTY]
    state = r[R_STATE]
    if state == FOLLOWING:
        follow(r)
    elif state == REVERSING:
        reverse(r)
    elif state == JOGGING:
        jog(r)
    elif state == HOMING:
        search(r)
    elif state == STOPPING:
        stop(r)
    else:
        r[R_DUTY] = 0
    largest = r[R_MAX_DUTY]
    if slow(r):
        largest = min(largest, SLOW_DUTY)
        if r[R_SPEED] * r[R_DUTY] > 0 and abs(r[R_SPEED]) > SLOW_BRAKE:
            r[R_DUTY] = 0
    r[R_DUTY] = max(-largest, min(r[R_DUTY], largest))
    if r[R_DUTY] != 0:  # the brake comes at once
        r[R_DUTY] = max(before - r[R_SLEW], min(r[R_DUTY], before + r[R_SLEW]))


def follow(r):
    """Towards the set points, straight between them."""
    r[R_PHASE] += 1
    if r[R_PHASE] >= r[R_PERIOD]:
        r[R_PHASE] = 0
        r[R_HEAD] += 1
    head = r[R_HEAD]
    if head >= r[R_LAST]:
        r[R_STATE] = ARMED
        r[R_DUTY] = 0
        empty(r)
    elif head + 1 >= r[R_NEXT]:
        fail(r, UNDERRUN)
    elif abs(slope(r, head)) > r[R_MAX_SPEED]:
        fail(r, SPEED)
    else:
        here, there = point(r, head), point(r, head + 1)
        r[R_TARGET] = here + quotient((there - here) * r[R_PHASE], r[R_PERIOD])
        ahead = slope(r, head + (r[R_PHASE] + AHEAD) // r[R_PERIOD])
        towards(r, r[R_TARGET], max(-r[R_MAX_SPEED], min(ahead, r[R_MAX_SPEED])))


def point(r, number):
    """A set point by its number."""
    return r[R_QUEUE + number % QUEUE]


def slope(r, number):
    """Counts per second from a set point to the next; the last known where they have not come yet, 0 after the end."""
    if number >= r[R_LAST]:
        return 0
    number = min(number, r[R_NEXT] - 2)
    return quotient((point(r, number + 1) - point(r, number)) * RATE, r[R_PERIOD])


def towards(r, target, speed):
    """Duty in proportion to the distance, and for the speed that the set points ask for."""
    away = target - r[R_POSITION]
    r[R_RESTING] = 1 if abs(speed) < CREEP and not slow(r) else 0
    if speed == 0 and abs(away) <= STILL:
        r[R_DUTY] = 0
        return
    wanted = speed + GAIN * away
    size = abs(wanted) * (255 - DEAD_DUTY) // FULL_SPEED
    r[R_DUTY] = 0 if wanted == 0 else (DEAD_DUTY + size if wanted > 0 else -DEAD_DUTY - size)


def reverse(r):
    """Duty that rises evenly in half of the half period, pauses at its top, and falls again; then the other way."""
    r[R_PHASE] += 1
    r[R_RESTING] = 0
    whole = r[R_HALF] + r[R_PAUSE]
    if r[R_PHASE] > whole:
        r[R_PHASE] = 1
        r[R_SIGN] = -r[R_SIGN]
        r[R_STROKES] -= 1
    if r[R_STROKES] == 0:
        rest(r)
    else:
        near = min(2 * r[R_PHASE], 2 * (whole - r[R_PHASE]), r[R_HALF])
        r[R_DUTY] = r[R_SIGN] * (r[R_RATE] * near // r[R_HALF])


def glide(r):
    """Constant speed: the set point moves on from where it was, but never far from the table."""
    farthest = SLOW_AHEAD if slow(r) else AWAY
    r[R_TARGET] += r[R_RATE]
    ahead = quotient(r[R_TARGET] - r[R_POSITION] * RATE, RATE)
    if abs(ahead) > farthest:
        r[R_TARGET] = (r[R_POSITION] + (farthest if ahead > 0 else -farthest)) * RATE
    towards(r, quotient(r[R_TARGET], RATE), r[R_RATE])


def jog(r):
    """Constant speed until the time is over."""
    r[R_LEFT] -= 1
    if r[R_LEFT] < 0:
        rest(r)
    else:
        glide(r)


def search(r):
    """To and fro about the start, each turn twice as far as the one before, until the index is passed.

    An open end switch, or a table that stands against its duty, is an end of the stroke: from there on the search goes the
    other way only, to the other end.
    """
    gone = (r[R_POSITION] - r[R_START]) * r[R_SIGN]
    reach = (r[R_HIGH] - r[R_LOW]) // 2 + abs(r[R_INDEX]) + SPARE
    if at_end(r, r[R_SIGN]) or (stands(r) and r[R_DUTY] != 0):
        if r[R_ENDS] and stands(r) and abs(r[R_COUNTS] - r[R_END_AT]) < FIRST_SWEEP:
            fail(r, STALL)
        elif r[R_ENDS]:
            rest(r)
        else:
            r[R_ENDS] = 1
            r[R_END_AT] = r[R_COUNTS]
            turn(r)
    elif r[R_ENDS]:
        if gone > r[R_HIGH] - r[R_LOW] + SPARE:
            rest(r)
        else:
            glide(r)
    elif gone >= r[R_TURN] and r[R_SIGN] < 0 and r[R_TURN] >= reach:
        rest(r)
    else:
        if gone >= r[R_TURN]:
            if r[R_SIGN] < 0:
                r[R_TURN] = min(2 * r[R_TURN], reach)
            turn(r)
        glide(r)


def stands(r):
    """Whether the table stands against its duty, as `stalled` has seen in this tick."""
    return r[R_STALLED] >= r[R_STALL] or r[R_FREE] > FREE_TRAVEL * RATE


def turn(r):
    """The search goes the other way, from where the table is."""
    r[R_SIGN] = -r[R_SIGN]
    r[R_RATE] = SLOW * r[R_SIGN]
    r[R_TARGET] = r[R_POSITION] * RATE
    r[R_DUTY] = r[R_STALLED] = r[R_FREE] = 0


def stop(r):
    """Brake until the table stands."""
    r[R_DUTY] = 0
    r[R_LEFT] -= 1
    if r[R_LEFT] <= 0 or (r[R_SPEED] == 0 and r[R_LEFT] <= STOP_TIME - WINDOW):
        r[R_STATE] = ARMED
