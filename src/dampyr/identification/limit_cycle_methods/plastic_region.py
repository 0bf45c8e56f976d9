r"""The modified method for the viscous Dahl model: (4.1) and (4.2) of Raminelli (2020), after Aguirre et al. (2010).

Far from the turning points the hysteresis is saturated (the plastic region), so the force is linear in the velocity,

.. math:: F = f_0 + k_x v + k_w\,\mathrm{sgn}(v), \qquad \rho = a / k_w ,

with a the slope of :math:`\theta = F - f_0 - k_x v` over x where it crosses zero after a turning point. The plastic region is
found without a hand-picked window: samples further than ``DEPTH``/rho along the path from the last turning point, and
faster than half of the peak speed (the real damper's force rolls off at low speed, which the model cannot follow); rho
and the region are found together.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.models.parts.dahl import Dahl
from dampyr.records import Record, cycle_bounds, with_velocity
from dampyr.records.cycle_analysis.cycles import turning_points
from dampyr.shown import Shown

Array = NDArray[np.float64]
DEPTH = 4.0  # over rho, of path since the turning point: w is within 2 exp(-4), 4 %, of its limit
SPEED = 0.5  # of the peak speed: below it the real damper's force rolls off
CROSSING = 0.5  # of kw: samples with smaller theta give the slope at the zero


@dataclass(frozen=True, repr=False)
class PlasticRegion(Shown):
    """kx in N s/m, kw and offset in N, a in N/m, rho in 1/m; the standard deviation of rho over the turning points.

    ``share`` of the samples make the plastic region.
    """

    kx: float
    kw: float
    rho: float
    a: float
    offset: float
    rho_spread: float
    share: float
    turning_points: int

    @property
    def model(self) -> Dahl:
        """As a model."""
        return Dahl(self.kx, self.kw, self.rho)


def plastic_region(record: Record, bandwidth: float | None = None) -> PlasticRegion:
    """Identify the viscous Dahl model of one record at one input.

    The velocity is the recorded one, or derived with ``bandwidth`` Hz. Raises :class:`~dampyr.errors.InputError` without
    whole cycles or where the force never crosses zero between turning points.
    """
    if record.velocity is None or bandwidth is not None:
        record = with_velocity(record, bandwidth)
    spans = cycle_bounds(record)
    if not spans:
        raise InputError(f"{record.name}: no whole cycle, so there is no plastic region; give at least one cycle")
    whole = slice(spans[0][0], spans[-1][1] + 1)
    points = turning_points(record)
    points = points[(points >= whole.start) & (points < whole.stop)]
    path = _measure_path_since_turning(record, points)[whole]
    assert record.velocity is not None
    force, speed = record.force[whole], record.velocity[whole]
    rho, result = 20.0 / float(np.median(np.abs(np.diff(record.displacement[points])))), None
    for _ in range(20):  # rho says where the plastic region begins, and that region gives rho: some rounds settle it
        plastic = (path > DEPTH / rho) & (np.abs(speed) > SPEED * np.quantile(np.abs(speed), 0.99))
        offset, kx, kw = _fit_line(record, force[plastic], speed[plastic])
        slopes = _measure_crossing_slopes(record, points, offset, kx, kw)
        a = float(np.median(slopes))
        result = PlasticRegion(
            kx, kw, a / kw, a, offset, float(np.std(slopes / kw)), float(plastic.mean()), slopes.size
        )
        if abs(result.rho / rho - 1.0) < 1e-6:
            break
        rho = result.rho
    assert result is not None
    return result


def _measure_path_since_turning(record: Record, points: NDArray[np.int64]) -> Array:
    """The distance in m from the last turning point, along the path."""
    last = np.searchsorted(points, np.arange(record.n), side="right") - 1
    return np.abs(record.displacement - record.displacement[points[np.maximum(last, 0)]])


def _fit_line(record: Record, force: Array, speed: Array) -> tuple[float, float, float]:
    """offset, kx, kw of (4.1) by least squares."""
    if force.size < 10 or not (np.any(speed > 0) and np.any(speed < 0)):
        raise InputError(f"{record.name}: only {force.size} samples are in the plastic region; the stroke is too small")
    columns = np.column_stack((np.ones_like(speed), speed, np.sign(speed)))
    offset, kx, kw = np.linalg.lstsq(columns, force, rcond=None)[0]
    if kw <= 0:
        raise InputError(f"{record.name}: the dry friction comes out as {kw:g} N; is the force's sign inverted?")
    return float(offset), float(kx), float(kw)


def _measure_crossing_slopes(record: Record, points: NDArray[np.int64], offset: float, kx: float, kw: float) -> Array:
    """d theta/dx where theta crosses zero after each turning point, by a line through the samples around."""
    assert record.velocity is not None
    theta = record.force - offset - kx * record.velocity
    slopes = []
    for first, last in itertools.pairwise(points):
        direction = np.sign(record.displacement[last] - record.displacement[first])
        side = direction * theta[first : last + 1]
        up = np.flatnonzero((side[:-1] < 0) & (side[1:] >= 0))
        if up.size == 0:
            continue
        slope = _fit_slope_around(record.displacement[first : last + 1], theta[first : last + 1], int(up[0]), kw)
        if slope > 0:
            slopes.append(slope)
    if not slopes:
        raise InputError(
            f"{record.name}: the force never crosses zero between turning points; remove its offset and drift"
        )
    return np.array(slopes)


def _fit_slope_around(x: Array, theta: Array, k: int, kw: float) -> float:
    """The slope over the samples next to ``k`` with theta within half of kw; at least the two that cross zero."""
    first, last = k, k + 1
    while first > 0 and abs(theta[first - 1]) < CROSSING * kw and abs(theta[first - 1]) > abs(theta[first]):
        first -= 1
    while last < x.size - 1 and abs(theta[last + 1]) < CROSSING * kw and abs(theta[last + 1]) > abs(theta[last]):
        last += 1
    dx, dy = x[first : last + 1], theta[first : last + 1]
    if np.ptp(dx) == 0:
        return 0.0
    return float(np.polyfit(dx - dx.mean(), dy, 1)[0])
