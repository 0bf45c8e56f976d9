r"""The inverse of a damper: the input at which it gives a wanted force at the end of a step.

The force that is inverted is the one that `Damper.force` gives there: with the parameters at the candidate input u, the states
go from the step's start to its end, and

.. math:: F(u) = F\big(s_1(u), x_1, v_1, p(u)\big), \qquad u^* = \arg\min_{low \le u \le high} |F(u) - F_\text{wanted}|

F is evaluated on nodes: the knots and turning points of the laws, and so many between that no gap is over 1/16 of the bounds.
Between two nodes on either side of the wanted force the input is found by regula falsi with Illinois weights; where several
pairs are, in the one nearest to the last input. Where no pair is, a turning point of F near the best node is found by golden
section, its input to 1e-5 of the bounds. Where every law is straight between its knots and only parameters follow the input to
which the force is proportional, F is straight between the nodes and the first secant is the closed form. An extreme that lies
between two nodes and not beside the best one is not seen.

References: B. F. Spencer, S. J. Dyke, M. K. Sain and J. D. Carlson, Phenomenological model for magnetorheological dampers,
Journal of Engineering Mechanics 123 (1997) 230-238, of the need for it in control; M. Dowell and P. Jarratt, A modified regula
falsi method for computing the root of an equation, BIT 11 (1971) 168-174.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.input_kinds import INPUTS
from dampyr.models.codegen.kernels import bind
from dampyr.models.laws import Constant, Polynomial, look_up, polynomial_table, polynomials
from dampyr.units import in_si

Array = NDArray[np.float64]
BOUND_WITH = ("dampyr.models.laws",)
CELLS = 16  # gaps between nodes over the bounds, where the force is not straight in the input
BEYOND = 1e30  # the last node, which no bound reaches
TOLERANCE = 1e-9  # of the largest force within the bounds: what counts as the wanted force, and as monotone
REASONS = ("met", "wrong_sign", "above_largest", "below_smallest", "jump")


@dataclass(frozen=True)
class InverseInput:
    """An input and the force that the damper gives at it, numbers of one step or arrays (n,) of a path.

    ``input`` is in V or A, ``force`` in N. ``reason`` is "met" where that is the wanted force to 1e-9 of the largest within the
    bounds; else the force is the nearest that there is, and the wanted one has the "wrong_sign", is "above_largest" or
    "below_smallest" in magnitude (less than the damper gives at any input), or lies in a "jump" of the force. ``monotone`` is
    False where the force both rises and falls over the input within the bounds, so that several inputs may give it.
    """

    input: Any
    force: Any
    reason: Any
    monotone: Any


class Inverse:
    """A damper run backwards, step by step: it holds the states, and each step finds the input of the wanted force.

    `Damper.inverse` makes it. With a part ``lag`` the input is the command, held over the step, and the bounds are those of the
    command: the acting input is reached only as far as the lag lets it.

    Parameters
    ----------
    damper
        a `Damper` whose parameters follow its input.
    displacement, velocity
        m and m/s at the start.
    low, high
        the least and the greatest input in V or A; by default the calibrated range.
    state0
        the hysteretic states at the start; by default 0, no memory.
    allow_extrapolation
        bounds outside the calibrated range, with a warning.

    Raises
    ------
    InputError
        a damper that has no input or follows none, one whose force is delayed or needs the acceleration, bounds in the wrong
        order.
    RangeError
        bounds outside the calibrated range.
    """

    def __init__(
        self,
        damper: Any,
        displacement: float = 0.0,
        velocity: float = 0.0,
        low: float | None = None,
        high: float | None = None,
        state0: ArrayLike | None = None,
        allow_extrapolation: bool = False,
    ) -> None:
        check_invertible(damper)
        self.damper = damper
        ends = [damper.range[k] if bound is None else bound for k, bound in enumerate((low, high))]
        bounds = [_number(end, damper.input, name) for end, name in zip(ends, ("low", "high"), strict=True)]
        self.low, self.high = map(float, damper.check_input(bounds, allow_extrapolation))
        if not self.low <= self.high:
            raise InputError(f"low = {self.low:g} is above high = {self.high:g} {damper.input}; exchange them")
        self.lag = damper.input_lag
        self._nodes = nodes(damper, self.low, self.high)
        damper.values(np.append(self._nodes[:-1], self.high), allow_extrapolation=allow_extrapolation)  # all allowed
        self._table = polynomial_table(damper)
        start = damper.composition.path0 if state0 is None else damper.check_states(state0)
        self._start: Array = np.array(start, dtype=float)
        self._states = self._start.copy()
        self._past = np.array(
            [_number(displacement, "m", "displacement"), _number(velocity, "m/s", "velocity"), self.low]
        )

    def __repr__(self) -> str:
        return f"Inverse of {self.damper.composition}, {self.low:g} to {self.high:g} {self.damper.input}"

    def find(self, displacement: float, velocity: float, wanted_force: float, dt: float) -> InverseInput:
        """The input for a step of ``dt`` s that ends at ``displacement`` m and ``velocity`` m/s with ``wanted_force`` N; the
        states stay at the step's start."""
        return self._step(displacement, velocity, wanted_force, dt, self._states.copy(), self._past.copy())

    def advance(self, displacement: float, velocity: float, dt: float, input: float) -> float:
        """Go on by a step with the ``input`` (V or A; with a lag the command) that was applied; the force at its end in N."""
        u = _number(input, self.damper.input, INPUTS[self.damper.input])
        if not self.low <= u <= self.high:
            raise InputError(
                f"the {INPUTS[self.damper.input]} {u:g} {self.damper.input} is outside the bounds {self.low:g} to "
                f"{self.high:g} {self.damper.input} of this inverse; stay inside them, or make an inverse with wider ones"
            )
        return float(self._step(displacement, velocity, 0.0, dt, self._states, self._past, u).force)

    def step(self, displacement: float, velocity: float, wanted_force: float, dt: float) -> InverseInput:
        """`find`, and go on with the input that it found.

        Examples
        --------
        >>> import dampyr as dp
        >>> inverse = dp.studies.raminelli_2020.damper().inverse()
        >>> found = inverse.step(displacement=0.001, velocity=0.05, wanted_force=300.0, dt=0.02)
        >>> round(found.input, 3), round(found.force, 6), found.reason
        (0.992, 300.0, 'met')
        >>> inverse.step(displacement=0.002, velocity=0.05, wanted_force=-300.0, dt=0.02).reason
        'wrong_sign'
        """
        return self._step(displacement, velocity, wanted_force, dt, self._states, self._past)

    def _step(
        self, x: float, v: float, wanted: float, dt: float, states: Array, past: Array, applied: float | None = None
    ) -> InverseInput:
        passed = _number(dt, "s", "dt")
        if not passed > 0.0:
            raise InputError(f"dt = {passed:g} s is not a step; it must be greater than 0")
        numbers = (_number(x, "m", "displacement"), _number(v, "m/s", "velocity"), _number(wanted, "N", "wanted_force"))
        steps, displacements, speeds, forces = (np.array([value]) for value in (passed, *numbers))
        out = self._run(steps, displacements, speeds, forces, states, past, applied)
        return InverseInput(float(out[0, 0]), float(out[0, 1]), REASONS[int(out[0, 2])], bool(out[0, 3]))

    def along(
        self, t: ArrayLike, x: ArrayLike, wanted_force: ArrayLike, velocity: ArrayLike | None = None
    ) -> InverseInput:
        """The inputs (n,) along a path t [s], x [m] for the wanted forces (n,) N, from the states at the start.

        ``velocity`` [m/s] is by default the derivative of x, as in `Damper.force`. What `step` has gone through does not count
        here. `Damper.force` gives ``force`` again from ``input``; with a lag, that of a command which is straight between
        samples differs from the one here, which is held.
        """
        time, displacement, speed = self.damper.check_path(t, x, velocity)
        wanted = np.ascontiguousarray(in_si(wanted_force, "N", "wanted_force"), dtype=float)
        if wanted.shape != time.shape or not np.all(np.isfinite(wanted)):
            raise InputError(
                f"wanted_force has shape {wanted.shape}, the path {time.shape}; give as many finite values"
            )
        self.damper.warn_outside(displacement, speed)
        past = np.array([displacement[0], speed[0], self.low])
        steps = np.append(0.0, np.diff(time))
        out = self._run(steps, displacement, speed, wanted, self._start.copy(), past)
        return InverseInput(out[:, 0], out[:, 1], np.array(REASONS)[out[:, 2].astype(int)], out[:, 3] > 0)

    def _run(
        self, dt: Array, x: Array, v: Array, wanted: Array, states: Array, past: Array, applied: float | None = None
    ) -> Array:
        """Rows of input, force, reason and monotone; ``states`` and ``past`` go on to the last sample."""
        composition = self.damper.composition
        low, high = (self.low, self.high) if applied is None else (applied, applied)
        out = np.empty((dt.size, 4))
        work, p = np.empty(composition.n_states), np.empty(len(composition.parameters))
        bind(track, (composition,))(
            dt, x, v, wanted, low, high, self.lag, self._nodes, *self._table, states, past, work, p, out
        )  # fmt: skip
        out[:, 0] += 0.0  # the kernel may give a zero a sign
        return out


def _number(value: Any, unit: str, name: str) -> float:
    number = np.asarray(in_si(value, unit, name), dtype=float)
    if number.ndim or not np.isfinite(number):
        raise InputError(f"{name} = {value!r} is not allowed; give one finite number in {unit}")
    return float(number)


def check_invertible(damper: Any) -> None:
    """Raise :class:`~dampyr.errors.InputError` for a damper whose force no input of the same step can choose."""
    composition = damper.composition
    if not damper.has_input:
        raise InputError("this damper has no input, so no input gives a wanted force; nothing can be inverted")
    if not damper.needs_input:
        raise InputError(
            "the parameters of this damper are the same at every input; give a damper with laws over its input"
        )
    if composition.has_delay:
        raise InputError(
            "the force of this damper is delayed, so the input of a step acts on later ones; invert damper.without('delay'), "
            "and give it the motion and the force that are wanted when the delay has passed"
        )
    for p in composition.parts:
        if p.needs_acceleration:
            raise InputError(
                f"{p.name} needs the acceleration, which an inverse is not given; invert damper.without({p.name!r}), and take "
                "its force off the wanted one"
            )


def nodes(damper: Any, low: float, high: float) -> Array:
    """The inputs at which the force is evaluated first, rising from ``low``; the last is beyond every bound."""
    followed = [law for law in damper.all_laws.values() if not isinstance(law, Constant)]
    points = [low, high]
    for law in followed:
        points += [*polynomials(law)[0][1:], *(law.turning_points() if isinstance(law, Polynomial) else ())]
    inside = np.unique([point for point in points if low <= point <= high])
    if not is_straight(damper) and high > low:
        cells = [max(1, int(np.ceil(CELLS * gap / (high - low) - 1e-9))) for gap in np.diff(inside)]
        gaps = zip(inside[:-1], inside[1:], cells, strict=True)
        inside = np.append(np.concatenate([np.linspace(a, b, n, endpoint=False) for a, b, n in gaps]), high)
    return np.append(inside, BEYOND)


def is_straight(damper: Any) -> bool:
    """Whether the force is straight in the input between the knots of the laws: the input then has a closed form."""
    composition = damper.composition
    following = [(k, law) for k, law in enumerate(damper.all_laws.values()) if not isinstance(law, Constant)]
    return all(k in composition.linear and not np.any(polynomials(law)[1][:, 2:]) for k, law in following)


def _unbound(*_: Any) -> Any:
    raise TypeError("a driver runs only after dampyr.models.codegen.kernels.bind has given it a composition")


advance = force = _unbound


def track(dt, x, v, wanted, low, high, tau, nodes, knots, coefficients, s, past, work, p, out):
    """Fill ``out`` with the input, its force, the reason and whether the force is monotone, for each sample.

    ``past`` holds x, v and the acting input at the start, and goes on with the states ``s``. A command that is held over a step
    moves the acting input by exp(-dt/tau) of the way that is left: the bounds of the step are those of a command at a bound.
    """
    for i in range(dt.size):
        left = exp(-dt[i] / tau) if tau > 0.0 and dt[i] > 0.0 else 0.0
        u = past[2]
        least, most = low + (u - low) * left, high + (u - high) * left
        find_input(
            wanted[i], u, least, most, TOLERANCE, nodes, s, past[0], x[i], past[1], v[i], dt[i], knots, coefficients, work, p,
            0, out[i],
        )  # fmt: skip
        reached = out[i, 0]
        look_up(knots, coefficients, reached, p)
        if dt[i] > 0.0:
            advance(0, s, past[0], x[i], past[1], v[i], dt[i], p)
        past[0], past[1], past[2] = x[i], v[i], reached
        out[i, 0] = min(max((reached - u * left) / (1.0 - left), low), high)


def force_under_input(u, s, x0, x1, v0, v1, dt, knots, coefficients, work, p, kind):
    """F(u): the force at the end of a step from the states ``s``, which stay; ``kind`` is which of the bound dampers it is."""
    look_up(knots, coefficients, u, p)
    for k in range(s.size):
        work[k] = s[k]
    if dt > 0.0:
        advance(kind, work, x0, x1, v0, v1, dt, p)
    return force(kind, work, x1, v1, 0.0, p)


def scan_nodes(wanted, near, low, high, nodes, s, x0, x1, v0, v1, dt, knots, coefficients, work, p, kind):
    """The node whose force is nearest to ``wanted``, its force and its neighbours; the pair of neighbours around ``wanted``
    nearest to ``near``, with their forces and its distance, below 0 where there is no pair; the largest force, and how much the
    force rises and falls from a node to the next."""
    ua = low
    fa = force_under_input(ua, s, x0, x1, v0, v1, dt, knots, coefficients, work, p, kind)
    scale, rise, fall = abs(fa), 0.0, 0.0
    best, at_best, before, after = low, fa, low, low
    a, at_a, b, at_b, away = low, fa, low, fa, -1.0
    for k in range(100000):
        ub = min(nodes[k], high)
        if ub > ua:
            fb = force_under_input(ub, s, x0, x1, v0, v1, dt, knots, coefficients, work, p, kind)
            scale, rise, fall = max(scale, abs(fb)), max(rise, fb - fa), max(fall, fa - fb)
            if best == ua:
                after = ub
            if abs(fb - wanted) < abs(at_best - wanted):
                best, at_best, before, after = ub, fb, ua, ub
            d = max(max(ua - near, near - ub), 0.0)
            if (fa - wanted) * (fb - wanted) <= 0.0 and (away < 0.0 or d < away):
                a, at_a, b, at_b, away = ua, fa, ub, fb, d
            ua, fa = ub, fb
        if ub >= high:
            break
    return best, at_best, before, after, a, at_a, b, at_b, away, scale, rise, fall


def turning_point(side, best, at_best, before, after, s, x0, x1, v0, v1, dt, knots, coefficients, work, p, kind):
    """The input between the neighbours of the best node at which ``side`` times the force is least, and that force: the node
    itself, or by golden section a turning point. At a bound the force has to turn within a thousandth of the gap to be looked
    for."""
    if before == best or after == best:
        u = best + 1e-3 * (after - best) - 1e-3 * (best - before)
        f = force_under_input(u, s, x0, x1, v0, v1, dt, knots, coefficients, work, p, kind)
        if side * (f - at_best) >= 0.0:
            return best, at_best
    u, m, fm = before + 0.6180339887498949 * (after - before), best, at_best
    for k in range(22):
        f = force_under_input(u, s, x0, x1, v0, v1, dt, knots, coefficients, work, p, kind)
        if k == 0:
            m, fm = u, f
        elif side * (f - fm) < 0.0:
            before, after = (before if u < m else m), (m if u < m else after)
            m, fm = u, f
        else:
            before, after = (u if u < m else before), (after if u < m else u)
        u = before + after - m
    if side * (fm - at_best) >= 0.0:
        return best, at_best
    return m, fm


def root_between(wanted, near, allowed, a, at_a, b, at_b, s, x0, x1, v0, v1, dt, knots, coefficients, work, p, kind):
    """The input between a and b, whose forces lie on either side of ``wanted``, where it is met to ``allowed`` N; its force."""
    ga, gb = at_a - wanted, at_b - wanted
    for _ in range(100):
        u = b - gb * (b - a) / (gb - ga) if gb != ga else min(max(near, min(a, b)), max(a, b))
        f = force_under_input(u, s, x0, x1, v0, v1, dt, knots, coefficients, work, p, kind)
        if (f - wanted) * gb < 0.0:
            a, at_a, ga = b, at_b, gb
        else:
            ga = 0.5 * ga
        b, at_b, gb = u, f, f - wanted
        if abs(gb) <= allowed or abs(b - a) <= 1e-14 * max(abs(a), abs(b)):
            break
    if abs(at_a - wanted) < abs(at_b - wanted):
        return a, at_a
    return b, at_b


def find_input(
    wanted, near, low, high, tolerance, nodes, s, x0, x1, v0, v1, dt, knots, coefficients, work, p, kind, out
):
    """Fill ``out`` with the input between ``low`` and ``high`` whose force is nearest to ``wanted``, that force, the reason by
    its number, and 1 where the force is monotone."""
    best, at_best, before, after, a, at_a, b, at_b, away, scale, rise, fall = scan_nodes(
        wanted, near, low, high, nodes, s, x0, x1, v0, v1, dt, knots, coefficients, work, p, kind
    )
    if away < 0.0:  # all nodes lie on one side of the wanted force
        side = 1.0 if at_best > wanted else -1.0
        u, f = turning_point(
            side, best, at_best, before, after, s, x0, x1, v0, v1, dt, knots, coefficients, work, p, kind
        )
        rise, fall = max(rise, abs(f - at_best)), max(fall, abs(f - at_best))
        if side * (f - wanted) <= 0.0:
            a, at_a, b, at_b, away = best, at_best, u, f, 0.0
        best, at_best = u, f
    if away >= 0.0:
        best, at_best = root_between(
            wanted,
            near,
            1e-3 * tolerance * scale,
            a,
            at_a,
            b,
            at_b,
            s,
            x0,
            x1,
            v0,
            v1,
            dt,
            knots,
            coefficients,
            work,
            p,
            kind,
        )
    reason = 2.0 if abs(wanted) > abs(at_best) else 3.0
    reason = 1.0 if wanted * at_best < 0.0 else reason
    reason = 4.0 if away >= 0.0 else reason
    reason = 0.0 if abs(at_best - wanted) <= tolerance * scale else reason
    out[0], out[1], out[2] = best, at_best, reason
    out[3] = 1.0 if min(rise, fall) <= tolerance * scale else 0.0


SEARCH = (scan_nodes, turning_point, root_between, find_input)
"""The functions that the C export writes from their syntax trees."""
