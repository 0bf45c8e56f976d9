r"""Mechanics, coil current and temperature of the plant: a fixed small step, compiled with the specimen's own formulas.

The bridge drives the motor and its screw as a source of velocity that lags and gives way under load,

.. math:: T \dot v_m = v^* - v_m, \qquad v^* = v_0 d - r F

with :math:`v_0` the free speed, r the droop, d the duty beyond the dead band and F the load. A load against the motion slows
it to standstill at most, and one along it does not hasten it: the screw locks itself. Without duty the motor is shorted and
stops, :math:`T_b \dot v_m = -v_m - (v_f + r |F|) \,\mathrm{sgn}\, v_m`, with :math:`v_f` the speed that the dead band's duty
would give. The motor's current is
:math:`i_0 + (v_0 d - v_m) k/r`, that of its load once it has settled, with the currents of Table A.2. The table follows the
screw with its backlash (a play operator), has friction in its guides, and moves the specimen.
The coil is :math:`L \dot i = u - R(T) i`; the specimen's input is the current, or the voltage R i that would
drive it when cool. The specimen takes up the work done on it and :math:`i^2 R`, and cools to the room.

At the ends of its stroke the damper has stops, stiff springs. End switches and the emergency stop, where they are wired,
open the Uno's inputs; the latter cuts the bridge's supply and the coil's by itself.

The play operator as in Krasnosel'skii and Pokrovskii (1989), Systems with Hysteresis; the numbers in `dampyr.rig.settings`.
"""

from __future__ import annotations

from math import exp, floor
from typing import Any, NamedTuple

from dampyr.rig.firmware import control_core

R_DUTY, R_STATE, R_FAULTS = control_core.R_DUTY, control_core.R_STATE, control_core.R_FAULTS
LOW_END, HIGH_END, PRESSED = control_core.LOW_END, control_core.HIGH_END, control_core.PRESSED
BRAKING = 0.4  # lag of the shorted motor over that of the driven one: no supply and leads in its circuit
STATIC_SHARE = 0.3  # of the static force that slows the motor: in the records the two directions differ by so little
COPPER = 0.0039  # 1/K, temperature coefficient of copper's resistance
COPPER_AT = 20.0  # degC at which the coil has its resistance

# the state of the plant
(
    Y_SCREW, Y_MOTOR, Y_X, Y_V, Y_FORCE, Y_CURRENT, Y_COIL, Y_TEMPERATURE, Y_CELL, Y_COMMAND, Y_INPUT,
    Y_REST, Y_WORK, Y_RUBBED, Y_TAKEN, Y_HEATED, Y_COOLED, Y_TICK, Y_BRIDGE,
) = range(19)  # fmt: skip
PLANT = Y_BRIDGE + 1
# counters: steps made; counts of the Uno and of the board less those of the encoder; the last count; the index; samples;
# whether the specimen's laws are held; how often the board saw the index
N_STEP, N_UNO, N_NI, N_SHOWN, N_PASSED, N_TAKEN, N_HELD, N_LATCHED = range(8)
N_LATCH = 8  # the board's counts at the last passes of the index, the k-th at k % LATCHES
LATCHES = 64
NUMBERS = N_LATCH + LATCHES
# active faults; the shunt across the load cell's bridge as the force [N] that it simulates, the bandwidth [rad/s] of a slow
# cell, the share of its voltage that the supply lacks, the volts at which it stands, ppm by which the Uno's clock is slower,
# the speed [m/s] at which a hand turns the screw, and which end switch a finger opens (-1 the lower one, 1 the upper one)
(
    Z_STALLED, Z_UNO, Z_NI, Z_GLITCH, Z_SWAPPED, Z_PRESSED, Z_DEAD, Z_OPEN, Z_SHUNT, Z_SLOW, Z_LACKS, Z_STUCK, Z_STANDS,
    Z_CLOCK, Z_TURNED, Z_FINGER,
) = range(16)  # fmt: skip
FLAGS = Z_FINGER + 1
STOP_STIFFNESS = 1e7  # N/m of the stops at the ends of the damper's stroke: steel on steel
TRUTH = (
    "time", "position", "speed", "force", "voltage", "current", "temperature", "enable", "state", "faults", "duty", "held",
)  # fmt: skip


class Constants(NamedTuple):
    """Constants of the plant, SI."""

    dt: float
    per_tick: int
    free_speed: float
    droop: float
    lag: float
    dead_band: float
    stroke: float
    play: float
    friction: float
    gain: float
    cut: bool
    resistance: float
    inductance: float
    per_ampere: float
    low: float
    high: float
    input_lag: float
    delay: int
    heat_capacity: float
    cooling: float
    softening: float
    ambient_temperature: float
    pulse: float
    mark: int
    bandwidth: float
    end: float
    switch: float
    ends_wired: bool
    emergency_wired: bool
    clock_ppm: float
    clock_warming: float
    warming_time: float
    no_load_current: float
    per_newton: float
    step: float
    mass: float


def _unbound(*_: Any) -> Any:
    raise TypeError("a driver runs only after dampyr.models.codegen.kernels.bind has given it a composition")


advance = force = _unbound
tick = control_core.tick
BOUND_WITH = (control_core.__name__,)  # the firmware's control is compiled with the plant


def run(until, m, y, n, z, s, p, table, static, past, r, start, period, readings, counts, truth):
    """Step the plant until step number ``until``, and return how many rows of ``truth`` were written.

    ``m`` the `Constants`, ``y`` the plant's state, ``n`` its counters, ``z`` the active faults, ``s`` the specimen's
    states, ``p`` its parameters, overwritten, ``table`` (K, P) these over its input, ``static`` (P,) 1 where a static force,
    ``past`` the forces of the last steps for a specimen that delays, ``r`` the firmware's registers. While samples are wanted,
    ``readings`` (3, N), the filtered force [N] and the coil's voltage [V] and current [A], and ``counts`` take those at
    ``start`` + (k + 1)*``period`` s.
    """
    rows = 0
    while n[N_STEP] < until:
        before = y[Y_MOTOR]
        drive_motor(m, y, z, r)
        update_coil(m, y, z, r)
        cell = y[Y_CELL]
        x = move_table(m, y, n, z, s, p, table, static, past, before)
        n[N_STEP] += 1
        update_counts(m, y, n, z, x)
        take_samples(m, y, n, x, cell, start, period, readings, counts)
        if n[N_STEP] > y[Y_TICK] - 1e-6:  # a millisecond of the Uno's is over
            inputs = open_inputs(m, y, z)
            tick(
                r,
                n[N_SHOWN] + n[N_UNO],
                n[N_PASSED] != 0,
                m.mark + n[N_UNO],
                z[Z_GLITCH] != 0,
                inputs,
                min(1023, int(y[Y_BRIDGE] / m.step)),
            )
            n[N_PASSED] = 0
            y[Y_TICK] += m.per_tick * (1.0 + 1e-6 * clock_ppm(m, n, z))
        if n[N_STEP] % m.per_tick == 0:
            write_truth(m, y, n, r, truth[rows])
            rows += 1
    return rows


def clock_ppm(m, n, z):
    """ppm by which the Uno's clock is slower than the board's, which is the plant's: more as the Uno warms."""
    return m.clock_ppm + z[Z_CLOCK] + m.clock_warming * (1.0 - exp(-n[N_STEP] * m.dt / m.warming_time))


def drive_motor(m, y, z, r):
    """The motor's speed after a step."""
    duty = 0.0 if emergency(m, z) else r[R_DUTY] / 255.0
    v, load = y[Y_MOTOR], y[Y_FORCE] - (1.0 - STATIC_SHARE) * y[Y_REST]
    if y[Y_V] != 0.0:
        load += m.friction if y[Y_V] > 0.0 else -m.friction
    size = max(0.0, abs(duty) - m.dead_band) / (1.0 - m.dead_band)
    y[Y_BRIDGE] = 0.0  # the bridge shows what its high side carries, and none is on where the motor is shorted
    if size > 0.0:
        way = 1.0 if duty > 0.0 else -1.0
        push = max(0.0, load * way) if m.droop == 0.0 else max(0.0, m.free_speed * size - v * way) / m.droop
        y[Y_BRIDGE] = m.no_load_current + m.per_newton * push
        target = way * max(0.0, m.free_speed * size - m.droop * max(0.0, load * way))
        v = target + (v - target) * exp(-m.dt / m.lag)
    elif v != 0.0:
        way = 1.0 if v > 0.0 else -1.0
        drag = m.free_speed * m.dead_band / (1.0 - m.dead_band) + m.droop * max(0.0, load * way)
        v = way * max(0.0, -drag + (abs(v) + drag) * exp(-m.dt / (BRAKING * m.lag)))
    if z[Z_STALLED] != 0.0:
        v = 0.0
    if z[Z_TURNED] != 0.0:
        v = z[Z_TURNED]
    y[Y_MOTOR] = v


def emergency(m, z):
    """Whether the emergency stop is wired and pressed: its own contacts cut the bridge's supply and the coil's."""
    return m.emergency_wired and z[Z_PRESSED] != 0.0


def open_inputs(m, y, z):
    """Which inputs of the Uno are open: a switch that is pressed, and those that are not wired."""
    inputs = 0
    if not m.ends_wired or y[Y_X] <= -m.switch or z[Z_FINGER] < 0.0:
        inputs |= LOW_END
    if not m.ends_wired or y[Y_X] >= m.switch or z[Z_FINGER] > 0.0:
        inputs |= HIGH_END
    if not m.emergency_wired or z[Z_PRESSED] != 0.0:
        inputs |= PRESSED
    return inputs


def update_coil(m, y, z, r):
    """The coil's current after a step at its voltage, and the heat in it."""
    enabled = (control_enabled(r[R_STATE]) or not m.cut) and not emergency(m, z)
    supply = z[Z_STANDS] if z[Z_STUCK] != 0.0 else (1.0 - z[Z_LACKS]) * m.gain * y[Y_COMMAND]
    y[Y_COIL] = supply if enabled and z[Z_DEAD] == 0.0 else 0.0
    R = m.resistance * (1.0 + COPPER * (y[Y_TEMPERATURE] - COPPER_AT))
    end = y[Y_COIL] / R if z[Z_OPEN] == 0.0 else 0.0
    old = y[Y_CURRENT]
    y[Y_CURRENT] = end + (old - end) * (exp(-m.dt * R / m.inductance) if m.inductance > 0.0 else 0.0)
    y[Y_HEATED] += R * 0.5 * (old * old + y[Y_CURRENT] * y[Y_CURRENT]) * m.dt
    y[Y_TEMPERATURE] += R * 0.5 * (old * old + y[Y_CURRENT] * y[Y_CURRENT]) * m.dt / m.heat_capacity
    u = m.per_ampere * abs(y[Y_CURRENT])
    y[Y_INPUT] = u + (y[Y_INPUT] - u) * (exp(-m.dt / m.input_lag) if m.input_lag > 0.0 else 0.0)


def control_enabled(state):
    """Whether the Uno's enable line is high."""
    return 1 <= state <= 6


def move_table(m, y, n, z, s, p, table, static, past, before):
    """Screw, table and specimen over a step, the motor's speed ``before`` it given; return where the table was."""
    x0, v0, f0 = y[Y_X], y[Y_V], y[Y_FORCE]
    y[Y_SCREW] += 0.5 * (before + y[Y_MOTOR]) * m.dt
    if abs(y[Y_SCREW]) > m.stroke:
        y[Y_SCREW] = m.stroke if y[Y_SCREW] > 0.0 else -m.stroke
        y[Y_MOTOR] = 0.0
    x1 = min(max(x0, y[Y_SCREW] - m.play), y[Y_SCREW] + m.play)
    v1 = y[Y_MOTOR] if x1 != x0 else 0.0
    n[N_HELD] = 1 if y[Y_INPUT] < m.low - 1e-9 or y[Y_INPUT] > m.high + 1e-9 else 0
    rest = look_up_parameters(min(max(y[Y_INPUT], m.low), m.high), m.low, m.high, p, table, static)
    advance(0, s, x0, x1, v0, v1, m.dt, p)
    f1 = force(0, s, x1, v1, (v1 - v0) / m.dt, p)
    f1 = rest + (f1 - rest) * max(0.0, 1.0 - m.softening * (y[Y_TEMPERATURE] - m.ambient_temperature))
    f1 += STOP_STIFFNESS * (max(0.0, x1 - m.end) + min(0.0, x1 + m.end))
    y[Y_X], y[Y_V], y[Y_FORCE] = x1, v1, delay_force(m, n, p, past, f1)
    y[Y_REST] = rest
    update_energy(m, y, z, x1 - x0, f0, rest, m.mass * (v1 - v0) / m.dt)
    return x0


def look_up_parameters(u, low, high, p, table, static):
    """Fill ``p`` with the parameters at the input ``u``, and return the static force."""
    place = (u - low) / (high - low) * (table.shape[0] - 1) if high > low else 0.0
    k = min(int(place), table.shape[0] - 2)
    part, rest = place - k, 0.0
    for j in range(p.size):
        p[j] = table[k, j] + part * (table[k + 1, j] - table[k, j])
        rest += static[j] * p[j]
    return rest


def delay_force(m, n, p, past, f):
    """The force one delay earlier, where the specimen has a delay."""
    if m.delay < 0:
        return f
    here = n[N_STEP] + past.size
    past[here % past.size] = f
    back = p[m.delay] / m.dt
    whole = int(back)
    early, late = past[(here - whole - 1) % past.size], past[(here - whole) % past.size]
    return late + (early - late) * (back - whole)


def update_energy(m, y, z, dx, f0, rest, inertia):
    """Work, temperature, and the load cell's filter after a step; the cell feels the ``inertia`` [N] of what hangs at it."""
    work = 0.5 * (f0 + y[Y_FORCE]) * dx
    cooled = m.cooling * (y[Y_TEMPERATURE] - m.ambient_temperature) * m.dt
    y[Y_RUBBED] += m.friction * abs(dx)
    y[Y_TAKEN] += work
    y[Y_WORK] += work + m.friction * abs(dx)
    y[Y_COOLED] += cooled
    y[Y_TEMPERATURE] += (work - rest * dx - cooled) / m.heat_capacity
    mean = 0.5 * (f0 + y[Y_FORCE]) + z[Z_SHUNT] + inertia
    bandwidth = z[Z_SLOW] if z[Z_SLOW] != 0.0 else m.bandwidth
    y[Y_CELL] = mean + (y[Y_CELL] - mean) * exp(-bandwidth * m.dt)


def update_counts(m, y, n, z, x0):
    """The encoder's count after a step, for both counters; a stuck one misses the counts of its time."""
    shown = floor(y[Y_X] / m.pulse)
    change = shown - n[N_SHOWN]
    passed = min(shown, n[N_SHOWN]) < m.mark <= max(shown, n[N_SHOWN])
    missed = 2 * change if z[Z_SWAPPED] != 0.0 else 0
    n[N_UNO] -= change if z[Z_UNO] != 0.0 else missed
    n[N_NI] -= change if z[Z_NI] != 0.0 else missed
    if passed and z[Z_UNO] == 0.0:
        n[N_PASSED] = 1
    if passed and z[Z_NI] == 0.0:
        n[N_LATCH + n[N_LATCHED] % LATCHES] = m.mark + n[N_NI]
        n[N_LATCHED] += 1
    n[N_SHOWN] = shown


def take_samples(m, y, n, x0, cell0, start, period, readings, counts):
    """The samples that fall into the step just made."""
    now = n[N_STEP] * m.dt
    while n[N_TAKEN] < counts.size:
        due = start + (n[N_TAKEN] + 1) * period
        if due > now + 1e-9:
            break
        part = min(1.0, max(0.0, 1.0 - (now - due) / m.dt))
        readings[0, n[N_TAKEN]] = cell0 + part * (y[Y_CELL] - cell0)
        readings[1, n[N_TAKEN]], readings[2, n[N_TAKEN]] = y[Y_COIL], y[Y_CURRENT]
        counts[n[N_TAKEN]] = floor((x0 + part * (y[Y_X] - x0)) / m.pulse) + n[N_NI]
        n[N_TAKEN] += 1


def write_truth(m, y, n, r, row):
    """Write a row of the ground truth."""
    row[0], row[1], row[2], row[3] = n[N_STEP] * m.dt, y[Y_X], y[Y_V], y[Y_FORCE]
    row[4], row[5], row[6] = y[Y_COIL], y[Y_CURRENT], y[Y_TEMPERATURE]
    row[7], row[8], row[9] = 1.0 if control_enabled(r[R_STATE]) else 0.0, float(r[R_STATE]), float(r[R_FAULTS])
    row[10], row[11] = float(r[R_DUTY]), float(n[N_HELD])
