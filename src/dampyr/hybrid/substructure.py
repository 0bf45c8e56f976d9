r"""The computed part of a hybrid test with a damper: a building that takes the measured force and gives the set points.

.. math:: M \ddot q + C \dot q + K q = -M \iota\, s\, a_g - \lambda f, \qquad x = \lambda^T q

with the scale s, the measured force f and the displacement x that the specimen is to have. A set point has to leave its host
``lead`` before its time; until then the force is predicted (`dampyr.hybrid.substructure_kernel`). What is still late
is compensated: the achieved displacement y is compared with what was sent, u, by recursive least squares that forget,

.. math:: y = g\,u - g\,\delta\,\dot u, \qquad u = (x + \delta \dot x + \tfrac12 \delta^2 \ddot x)/g

and the lag :math:`\delta` and the gain g of the last seconds correct the next set points. The error of energy is the work that
the actuator adds because the specimen is not where the computation has it,

.. math:: W = \int f\, d(y - x)

and is compared with the energy that the ground has put in.

Where a control law sets the damper's input, it decides on the same prediction: at its samples it measures the structure, the
ground and the force as they will be when its decision acts, from what was measured last. The model that predicts the force
has the inputs that were decided, through the lag of the coil.

References: G. Mosqueda, B. Stojadinovic, S. Mahin, Real-time error monitoring for hybrid simulation, J. Struct. Eng. 133
(2007); Y. Chae, K. Kazemibidokhti, J. Ricles, Adaptive time series compensator for delay compensation of servo-hydraulic
actuator systems, Earthquake Eng. Struct. Dyn. 42 (2013).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.hybrid import substructure_kernel
from dampyr.hybrid.setup import building_step
from dampyr.models import Damper, compose
from dampyr.models.codegen.kernels import bind
from dampyr.models.laws import look_up, polynomial_table
from dampyr.shown import Shown
from dampyr.structures import Building, Response
from dampyr.structures.control_laws import check_decided
from dampyr.structures.law_input import LawInput
from dampyr.structures.time_history.modal_coordinates import refined

Array = NDArray[np.float64]
MEMORY = 2.0  # s of the structure's time after which the estimate of the lag has forgotten 63 %
ANCHOR = 0.002  # s of the structure's time, see `LagEstimator`
SMALLEST = 1e-5  # m of a stroke: two counts of the encoder
SMOOTHING = 0.1  # s of the structure's time in which the difference of measured and predicted force is smoothed
LARGEST_LAG = 0.05  # s of the structure's time in either direction that is compensated
GAINS = (0.8, 1.25)  # between which the gain of the actuator is believed
FLOOR = 0.25  # of the energy that the ground is expected to put in: an error of energy is compared with no less


@dataclass
class LagEstimator:
    """The lag [s] and the gain of an actuator, by recursive least squares with an exponential window of ``memory`` s.

    What it begins with stays in it with the weight of `ANCHOR` s of a motion of ``size`` m: where the table hardly moves, its
    friction and its backlash say nothing of its lag.
    """

    h: float
    size: float
    lag: float = 0.0
    gain: float = 1.0
    memory: float = MEMORY
    adaptive: bool = True
    _A: Array = field(init=False, repr=False)
    _b: Array = field(init=False, repr=False)
    _prior: Array = field(init=False, repr=False)
    start: tuple[float, float] = field(init=False)

    def __post_init__(self) -> None:
        self._prior = (
            ANCHOR / self.h * max(self.size, SMALLEST) ** 2 * np.diag([1.0, 100.0])
        )  # of a sine of 1.6 Hz or so
        self.start = self.lag, self.gain
        self._A, self._b = np.zeros((2, 2)), np.zeros(2)

    def take(self, sent: float, rate: float, achieved: float, delay: float = 0.0) -> None:
        """One more set point with its rate, and the displacement achieved ``delay`` s later."""
        if not self.adaptive:
            return
        forget = 1.0 - self.h / self.memory
        u = np.array([sent, rate])
        self._A = forget * self._A + np.outer(u, u)
        self._b = forget * self._b + u * achieved
        anchor = self._prior @ [self.start[1], self.start[1] * (delay - self.start[0])]
        gain, slope = np.linalg.solve(self._A + self._prior, self._b + anchor)
        self.gain = float(np.clip(gain, *GAINS))
        self.lag = float(np.clip(delay - slope / self.gain, 0.0, LARGEST_LAG))


@dataclass(frozen=True, eq=False, repr=False)
class Substructure(Shown):
    """The building, where the specimen is in it, the ground and how set points are made; it can be sent to another process.

    ``ground`` (T,) m/s2 every ``h`` s of the structure's time, scaled. ``model`` with its ``voltage`` predicts the force
    (None: it is held). ``lag`` s is known of the actuator beforehand; ``adaptive``: it is followed. ``size`` m is the stroke
    that is expected, ``input_energy`` J what the ground is expected to put in, and ``energy_limit`` the error of energy, over
    the energy that the ground has put in, at which the test is stopped. ``law`` is a control law that sets the input in the
    place of ``voltage``, which is that before the test then; its decisions, at least ``law_lead`` s before their time, are the
    ``commands`` of the run.
    """

    building: Building
    place: Any
    ground: Array
    h: float
    model: Damper | None = None
    voltage: float = 0.0
    lag: float = 0.0
    adaptive: bool = True
    size: float = 0.01
    input_energy: float = 0.0
    energy_limit: float = 0.1
    law: Any = None
    law_lead: float = 0.0

    def __post_init__(self) -> None:
        if not self.h > 0.0:
            raise InputError(f"h = {self.h:g} s is not allowed; it must be greater than 0")
        if len(self.ground) < 2:
            raise InputError("the ground motion is shorter than two steps of the hybrid test; give a shorter period")
        if self.law is not None:
            self._check_law()

    def _check_law(self) -> None:
        """Raise InputError where the law cannot decide on what is predicted."""
        if self.model is None:
            raise InputError("a control law decides on what the damper's model predicts; give a model")
        steps = self.law.period / self.h
        if round(steps) < 1 or abs(steps - round(steps)) > 1e-9 * steps:
            near = max(1, round(steps)) * self.h
            raise InputError(
                f"period = {self.law.period:g} s of the control law is not a whole number of the test's steps of {self.h:g} s; "
                f"give period={near:.6g}"
            )

    @property
    def steps(self) -> int:
        """The number of steps, one less than the points of the ground motion."""
        return len(self.ground) - 1

    @cached_property
    def row(self) -> Array:
        """What makes the specimen's displacement of the floors' (n,)."""
        return np.ascontiguousarray(self.building.connection(self.place))

    def run(self) -> SubstructureRun:
        """A run from rest."""
        return SubstructureRun(self)


def substructure_of(
    building: Building, place: Any, response: Response, h: float, model: Damper | None, value: float
) -> Substructure:
    """The computed part every ``h`` s for the ground of a computed ``response`` of the same building with the damper's model.

    ``value`` is the model's input. The stroke and the energy that are expected are those of the response, and a reduced
    building has the coordinates of the response.
    """
    steps = math.ceil(float(response.time[-1]) / h - 1e-9)
    ground = np.interp(np.arange(steps + 1) * h, response.time, response.ground_acceleration)
    size, energy = float(np.abs(response.stroke[0]).max()), float(response.energy.input[-1])
    return Substructure(refined(building, [place]), place, ground, h, model, value, size=size, input_energy=energy)


def lag_of(sent: Array, achieved: Array, h: float, largest: float) -> tuple[float, float]:
    """The lag [s] and the gain with which an actuator follows its set points, by least squares.

    Parameters
    ----------
    sent, achieved : (n,) m, set points and the displacements at their times.
    h : s from set point to set point; between two of them what was sent goes straight.
    largest : s, the longest lag that is looked for.

    Raises
    ------
    InputError
        What was sent stands still, or is too short.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> from dampyr.hybrid.substructure import lag_of
    >>> time = 0.002 * np.arange(200)
    >>> sent = 0.004 * np.sin(2 * np.pi * 2.0 * time)
    >>> lag, gain = lag_of(sent, 0.9 * np.interp(time - 0.006, time, sent), 0.002, 0.02)
    >>> round(lag, 4), round(gain, 3)
    (0.006, 0.9)
    """
    from scipy.optimize import minimize_scalar

    skip = math.ceil(largest / h)
    index, y = np.arange(skip, len(sent), dtype=float), achieved[skip:]
    if len(index) < 3 or np.ptp(sent) == 0.0:
        raise InputError("the lag cannot be identified from set points that stand still; move the table")

    def fit(lag: float) -> tuple[float, float]:
        u = np.interp(index - lag / h, np.arange(len(sent)), sent)
        gain = float(u @ y / (u @ u))
        return float(np.sum((y - gain * u) ** 2)), gain

    lags = np.linspace(0.0, largest, 26)
    best = int(np.argmin([fit(lag)[0] for lag in lags]))
    bounds = lags[max(best - 1, 0)], lags[min(best + 1, 25)]
    lag = float(
        minimize_scalar(lambda trial: fit(trial)[0], bounds=bounds, method="bounded", options={"xatol": 1e-6}).x
    )
    return lag, fit(lag)[1]


class SubstructureRun(Shown):
    """One run: measured forces in, set points out.

    Arrays over the steps: ``z`` (T, 2n) states of the structure, ``target`` the displacement [m] that the specimen should have
    and ``achieved`` that it had, ``force`` [N] the mean of the step that follows, ``sent`` the set points [m], ``lags`` [s] and
    ``gains`` as estimated, ``inputs`` [V or A] of the damper in the step that follows, and ``commands`` [V or A], what a law
    has asked for then; ``now`` steps of them are made.
    """

    def __init__(self, about: Substructure) -> None:
        self.about, n = about, about.building.n
        self.states, self.by_ground, self.by_force = building_step(about.building, about.row, about.h)
        size, beyond = about.steps + 1, math.ceil(max(LARGEST_LAG, about.law_lead) / about.h)
        self._ground = np.concatenate([about.ground, np.zeros(beyond)])
        self.path, self._rate, self._model = (np.zeros(size + beyond) for _ in range(3))
        self.z, self.sent, self._sent_rate = np.zeros((size, 2 * n)), np.zeros(size), np.zeros(size)
        self.force, self.achieved, self.target = np.zeros(size), np.zeros(size), np.zeros(size)
        self.lags, self.gains = np.full(size, about.lag), np.ones(size)
        self.inputs = np.full(size, float(about.voltage))
        self.commands = self.inputs.copy()
        self.now = self.given = self._fixed = 0
        self.error = self.input = self.largest_input = 0.0
        composition = compose("spring") if about.model is None else about.model.composition
        self._s = np.array(composition.state0, float)
        self._work, self._trial = np.zeros((2, 2 * n)), self._s.copy()
        self._p = (
            np.zeros(1)
            if about.model is None
            else np.ascontiguousarray(about.model.values(about.voltage, static=False))
        )
        self._look_ahead = bind(substructure_kernel.look_ahead, (composition,))
        self._law: LawInput | None = None
        if about.law is not None:
            assert about.model is not None  # as `Substructure` checks
            motion = GroundMotion(about.ground, about.h, "ground")
            self._law = LawInput(about.law, about.model, about.building, about.row, motion)
            self._force_now = bind(substructure_kernel.force_now, (composition,))
            self._parameters = polynomial_table(about.model, static=False)
        self._pull = about.building.influence @ about.building.M
        self._difference, self._share = 0.0, 1.0 - math.exp(-about.h / SMOOTHING)
        self.begin(about.lag)

    def set_input(self, value: float) -> None:
        """From this step on the damper has this input [V or A], and the model that predicts its force."""
        self.inputs[self.now :] = value
        if self.about.model is not None:
            self._p[:] = self.about.model.values(value, static=False)

    @property
    def over(self) -> bool:
        """Whether all steps were made."""
        return self.now >= self.about.steps

    def begin(self, lag: float, gain: float = 1.0) -> None:
        """Begin with an actuator of this lag [s] and gain: set points are what will be wanted so much later."""
        about = self.about
        self.lag = LagEstimator(about.h, about.size, lag, gain, adaptive=about.adaptive)
        self._first_lag = lag
        self.lags[self.now], self.gains[self.now] = lag, gain

    def measured(self, displacement: float, force: float) -> None:
        """Take the mean force [N] of the next step, and the displacement [m] at its end."""
        k, h, n = self.now, self.about.h, self.about.building.n
        g = self.about.ground
        self.z[k + 1] = self.states @ self.z[k] + self.by_ground @ g[k : k + 2] + self.by_force * force
        self.force[k : k + 2], self.achieved[k + 1] = force, displacement
        self.target[k + 1] = self.about.row @ self.z[k + 1, :n]
        # The work of the force over the way by which the specimen went elsewhere than the computation.
        self.error += force * (displacement - self.achieved[k] - (self.target[k + 1] - self.target[k]))
        velocity = 0.5 * (self.z[k, n:] + self.z[k + 1, n:])
        # The ground's power is -(iota M) v a: the building goes against the force of inertia.
        self.input -= float(self._pull @ velocity) * 0.5 * (g[k] + g[k + 1]) * h
        self.largest_input = max(self.largest_input, self.input)
        before = k + 1 - self._first_lag / h
        sent, rate = (_interpolate(values, before) for values in (self.sent, self._sent_rate))
        self.lag.take(sent, rate, displacement, self._first_lag)
        self.lags[k + 1], self.gains[k + 1] = self.lag.lag, self.lag.gain
        difference = force - (self._model[k] if self.about.model is not None else 0.0)
        self._difference += (difference - self._difference) * self._share
        self.now = k + 1

    @property
    def energy_error(self) -> float:
        """The error of energy over the energy that the ground has put in, or `FLOOR` of what it is expected to."""
        reference = max(self.largest_input, FLOOR * self.about.input_energy)
        return abs(self.error) / reference if reference > 0.0 else 0.0

    def fix(self, until: int) -> None:
        """Fix the path, and what a law decides on it, to index ``until`` of the steps.

        InputError where the law asks for an input beyond its own bounds.
        """
        first, last = self._fixed, min(until, len(self.path) - 1)
        if last <= first:
            return
        if self._law is None:
            self._predict(first, last)
        else:
            self._predict(first, first)
            for k in range(first, last):
                self._decide(k, self._law)
                self._predict(k, k + 1)
        self._fixed = last

    def _predict(self, fixed: int, until: int) -> None:
        """The path from index ``fixed`` on to ``until``; ``_work[0]`` is the structure's state there then."""
        self._look_ahead(
            self.now, until, fixed, self.states, self.by_ground, self.by_force, self.about.row, self._ground,
            self.about.h, self.z[self.now], self._work, self._difference, self.about.model is not None, self.path,
            self._rate, self._model, self._s, self._trial, self._p,
        )  # fmt: skip

    def _decide(self, k: int, law: LawInput) -> None:
        """The law's decision at index k, on the state that was predicted for it; the model has the input from there on."""
        h, n = self.about.h, self.about.building.n
        if law.is_due(k * h):
            force = self._force_now(self.path[k], self._rate[k], self._s, self._p) + self._difference
            law.decide_at(k * h, self._work[0, :n], self._work[0, n:], float(force))
            check_decided(law.law, "of the hybrid test", law.command, law.command)
            self.commands[k:] = law.command
        value = law.input_at((k + 0.5) * h)
        self.inputs[k:] = value
        look_up(*self._parameters, value, self._p)

    def set_points(self, until: int) -> Array:
        """The set points [m] after the last that was given, to index ``until`` of the steps."""
        first, until = self.given, min(until, self.about.steps)
        if until <= first:
            return np.zeros(0)
        h = self.about.h
        self.fix(max(until + math.ceil(self.lag.lag / h - 1e-9), self.now + math.ceil(self.about.law_lead / h - 1e-9)))
        self.given = until
        new = np.arange(first + 1, until + 1)
        place = new + self.lag.lag / self.about.h
        every = np.arange(first, self._fixed + 1)
        self.sent[new] = np.interp(place, every, self.path[every]) / self.lag.gain
        self._sent_rate[new] = np.interp(place, every, self._rate[every]) / self.lag.gain
        return self.sent[new]


def coil_inputs(commands: Array, first: float, lag: float, h: float) -> Array:
    """The input (T,) in the middle of each step of ``h`` s: the coil follows the ``commands`` (T,) with its ``lag`` [s]."""
    if lag == 0.0:
        return commands.copy()
    inputs, level, left = np.empty(len(commands)), first, math.exp(-0.5 * h / lag)
    for k, command in enumerate(commands):
        inputs[k] = command + (level - command) * left
        level = command + (inputs[k] - command) * left
    return inputs


def _interpolate(values: Array, place: float) -> float:
    """The value at a place between two indices, straight between them; the first before the begin."""
    index = max(0, int(place))
    part = max(0.0, place - index)
    return float(values[index] * (1.0 - part) + values[min(index + 1, len(values) - 1)] * part)
