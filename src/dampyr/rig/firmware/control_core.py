"""What the firmware does a thousand times a second, in whole numbers as on the Uno (docs/reference/protocol.md).

The registers are one row of int64: what requests set and what a status shows, the queue of set points and the last
positions. `tick` is plain Python that numba compiles together with the simulated rig.
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
SLOW = 400  # counts/s: 2 mm/s, while not homed
AWAY = 1000  # counts from the set point
STALL_DUTY, STALL_MOVE = 64, 2
STOP_TIME = 60  # ms
FIRST_SWEEP = 250  # counts to the first turn of a search for the index

QUEUE = protocol.QUEUE
IDLE, ARMED, FOLLOWING, REVERSING, JOGGING, HOMING, STOPPING, FAULT = (int(state) for state in State)
HEARTBEAT, LOW, HIGH, SPEED, STALL, LOST, UNDERRUN, ENCODER = (int(fault) for fault in Fault if fault < Fault.ABORTED)

# registers
(
    R_STATE, R_FAULTS, R_TIME, R_POSITION, R_SPEED, R_DUTY, R_COUNTS, R_OFFSET, R_HOMED, R_LIMITED,
    R_LOW, R_HIGH, R_MAX_SPEED, R_HEARTBEAT, R_MAX_DUTY, R_STALL, R_SINCE, R_STALLED, R_STALL_AT,
    R_HEAD, R_NEXT, R_LAST, R_PERIOD, R_PHASE, R_TARGET, R_RATE, R_LEFT, R_HALF, R_PAUSE, R_STROKES,
    R_INDEX, R_TURN, R_START, R_SIGN, R_FILLED,
) = range(35)  # fmt: skip
R_QUEUE = 40  # after the 35 above, with places left for more
R_PAST = R_QUEUE + QUEUE
REGISTERS = R_PAST + WINDOW


def tick(r, counts, latched, index, glitch):
    """One millisecond: ``counts`` of the encoder, whether the index was passed (``latched``) and at which count, and
    whether both lines changed at once (``glitch``)."""
    r[R_TIME] += 1
    r[R_SINCE] = min(r[R_SINCE] + 1, 1000000)
    observe(r, counts)
    if r[R_STATE] == HOMING and latched:
        r[R_OFFSET] = r[R_INDEX] - index
        r[R_POSITION] = counts + r[R_OFFSET]
        r[R_HOMED] = 1
        rest(r)
    if ARMED <= r[R_STATE] <= STOPPING:
        faults = watched(r, glitch)
        if faults:
            fail(r, faults)
    act(r)


def observe(r, counts):
    """Position, and speed over the last `WINDOW`."""
    slot = R_PAST + r[R_TIME] % WINDOW
    old = r[slot] if r[R_FILLED] >= WINDOW else counts
    r[R_FILLED] += 1 if r[R_FILLED] < WINDOW else 0
    r[slot] = counts
    r[R_COUNTS] = counts
    r[R_POSITION] = counts + r[R_OFFSET]
    r[R_SPEED] = (counts - old) * (RATE // WINDOW)


def watched(r, glitch):
    """The faults of this moment."""
    faults = 0
    if r[R_SINCE] > r[R_HEARTBEAT]:
        faults |= HEARTBEAT
    if r[R_HOMED] and r[R_POSITION] < r[R_LOW]:
        faults |= LOW
    if r[R_HOMED] and r[R_POSITION] > r[R_HIGH]:
        faults |= HIGH
    if abs(r[R_SPEED]) > r[R_MAX_SPEED]:
        faults |= SPEED
    if stalled(r):
        faults |= STALL
    if r[R_STATE] == FOLLOWING and abs(r[R_TARGET] - r[R_POSITION]) > AWAY:
        faults |= LOST
    if glitch:
        faults |= ENCODER
    return faults


def stalled(r):
    """Whether much duty has moved nothing for too long."""
    if abs(r[R_DUTY]) < STALL_DUTY or abs(r[R_COUNTS] - r[R_STALL_AT]) >= STALL_MOVE:
        r[R_STALLED] = 0
        r[R_STALL_AT] = r[R_COUNTS]
    else:
        r[R_STALLED] += 1
    return r[R_STALLED] >= r[R_STALL]


def fail(r, faults):
    """To FAULT; an encoder that lost its place is no longer homed."""
    r[R_FAULTS] |= faults
    r[R_STATE] = FAULT
    r[R_DUTY] = 0
    if faults & ENCODER:
        r[R_HOMED] = 0
    empty(r)


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
    r[R_DUTY] = max(-r[R_MAX_DUTY], min(r[R_DUTY], r[R_MAX_DUTY]))


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
    else:
        here, there = point(r, head), point(r, head + 1)
        r[R_TARGET] = here + (there - here) * r[R_PHASE] // r[R_PERIOD]
        towards(r, r[R_TARGET], slope(r, head + (r[R_PHASE] + AHEAD) // r[R_PERIOD]))


def point(r, number):
    """A set point by its number."""
    return r[R_QUEUE + number % QUEUE]


def slope(r, number):
    """Counts per second from a set point to the next; the last known where they have not come yet, 0 after the end."""
    if number >= r[R_LAST]:
        return 0
    number = min(number, r[R_NEXT] - 2)
    return (point(r, number + 1) - point(r, number)) * RATE // r[R_PERIOD]


def towards(r, target, speed):
    """Duty in proportion to the distance, and for the speed that the set points ask for."""
    away = target - r[R_POSITION]
    if speed == 0 and abs(away) <= STILL:
        r[R_DUTY] = 0
        return
    wanted = speed + GAIN * away
    size = abs(wanted) * (255 - DEAD_DUTY) // FULL_SPEED
    r[R_DUTY] = 0 if wanted == 0 else (DEAD_DUTY + size if wanted > 0 else -DEAD_DUTY - size)


def reverse(r):
    """Duty that rises evenly in half of the half period, pauses at its top, and falls again; then the other way."""
    r[R_PHASE] += 1
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
    r[R_TARGET] += r[R_RATE]
    ahead = (r[R_TARGET] - r[R_POSITION] * RATE) // RATE
    if abs(ahead) > AWAY:
        r[R_TARGET] = (r[R_POSITION] + (AWAY if ahead > 0 else -AWAY)) * RATE
    towards(r, r[R_TARGET] // RATE, r[R_RATE])


def jog(r):
    """Constant speed until the time is over."""
    r[R_LEFT] -= 1
    if r[R_LEFT] < 0:
        rest(r)
    else:
        glide(r)


def search(r):
    """To and fro about the start, each turn twice as far as the one before, until the index is passed."""
    gone = (r[R_TARGET] // RATE - r[R_START]) * r[R_SIGN]
    if gone >= r[R_TURN]:
        if r[R_SIGN] < 0:
            r[R_TURN] *= 2
        r[R_SIGN] = -r[R_SIGN]
        r[R_RATE] = SLOW * r[R_SIGN]
    if r[R_TURN] > (r[R_HIGH] - r[R_LOW]) // 2:
        rest(r)
    else:
        glide(r)


def stop(r):
    """Brake until the table stands."""
    r[R_DUTY] = 0
    r[R_LEFT] -= 1
    if r[R_LEFT] <= 0 or (r[R_SPEED] == 0 and r[R_LEFT] <= STOP_TIME - WINDOW):
        r[R_STATE] = ARMED
