r"""Error that the samples of a path make in a force that changes within a small speed, such as LuGre's within vs.

Between samples the velocity is taken as linear and the state follows a mean of its two ends. Where the motion crosses the
speed within a sample, that mean misses it. So the force is computed again along the same motion with samples in between, but
only there, each less than a sixteenth of the speed from the next: the cubic through displacements and velocities would do, but
measured ones contradict each other by their noise, so the gap between the displacement's step and the velocity's mean is
divided evenly,

.. math:: x(s) = x_0 + s\,(x_1 - x_0) - \tfrac12\,\Delta t\,s(1-s)(v_1 - v_0), \qquad v(s) = v_0 + s\,(v_1 - v_0).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dampyr.models.codegen.composition import Composition

Array = NDArray[np.float64]

REACH = 3.0  # times the speed: beyond it friction has changed by all but exp(-9) of its fall
STEPS_PER_SPEED = 16.0  # an error of second order falls to less than a hundredth of what a step of one speed makes
MAX_STEPS = 64  # within a sample: where that does not do, the speed is passed so fast that it hardly matters
# Of the force's spread in the mean, and of its largest size at one sample: a fifth of what a good model misses of a measured
# force, and all of it.
TOLERABLE, TOLERABLE_ONCE = 0.01, 0.05


def sampling_error(
    composition: Composition, t: Array, x: Array, v: Array, values: Array, state0: Array | None = None
) -> tuple[float, float]:
    """What the samples make wrong in the force along a path: in the mean, over the force's mean deviation from its median, and
    at the worst sample, over its largest size.

    The path is t [s], x [m], v [m/s] of shape (n,), ``values`` the parameters (P,) or (n, P) in SI. (0, 0) for parts that
    have no such speed.
    """
    from dampyr.models.path_integration import along

    speed = _smallest_speed(composition, values)
    if speed is None:
        return 0.0, 0.0
    # where the velocity changes its sign within a sample it has passed every small speed, however fast both ends are
    near = np.where(v[:-1] * v[1:] < 0.0, 0.0, np.minimum(np.abs(v[:-1]), np.abs(v[1:]))) < REACH * speed
    count = np.clip(np.ceil(STEPS_PER_SPEED * np.abs(np.diff(v)) / speed), 1, MAX_STEPS).astype(int)
    count[~near] = 1
    if np.all(count == 1):
        return 0.0, 0.0
    ends = np.cumsum(count)
    k = np.repeat(np.arange(count.size), count)  # the sample before each finer one
    s = (np.arange(ends[-1]) - (ends - count)[k] + 1.0) / count[k]
    dt, dx, dv = (np.diff(channel)[k] for channel in (t, x, v))
    fine = (t[k] + s * dt, x[k] + s * dx - 0.5 * dt * s * (1.0 - s) * dv, v[k] + s * dv)
    time, place, rate = (np.concatenate([whole[:1], part]) for whole, part in zip((t, x, v), fine, strict=True))
    rows = values if values.ndim == 1 else values[np.concatenate([[0], k + 1])]
    force = along(composition, t, x, v, values, state0)[1:]
    right = along(composition, time, place, rate, rows, state0)[ends]
    gap = np.abs(right - force)
    spread, peak = float(np.mean(np.abs(right - np.median(right)))), float(np.max(np.abs(right)))
    return (float(np.mean(gap)) / spread, float(np.max(gap)) / peak) if spread > 0.0 else (0.0, 0.0)


def sampling_words(
    composition: Composition, t: Array, x: Array, v: Array, values: Array, state0: Array | None = None
) -> str:
    """A sentence without its full stop where `sampling_error` is more than 1 % in the mean or 5 % at a sample, else nothing."""
    share, once = sampling_error(composition, t, x, v, values, state0)
    if share <= TOLERABLE and once <= TOLERABLE_ONCE:
        return ""
    speed, rate = 1e3 * (_smallest_speed(composition, values) or 0.0), (t.size - 1) / (t[-1] - t[0])
    return (
        f"the velocity crosses {speed:.3g} mm/s within a sample at {rate:.4g} samples a second, within which this friction "
        f"falls: that alone makes the force wrong by {100 * share:.2g} % of its spread in the mean, "
        f"by {100 * once:.2g} % of its peak at the worst sample; sample faster"
    )


def _smallest_speed(composition: Composition, values: Array) -> float | None:
    """The smallest of the speeds that the parts name, over all inputs."""
    names = [f"{part.name}.{part.speed}" for part in composition.parts if part.speed]
    columns = [list(composition.parameters).index(name) for name in names]
    return float(np.min(values[..., columns])) if columns else None
