r"""Figures of a cycle by which devices are judged: energy, largest force, effective stiffness, characteristic strength.

.. math::

    W = \oint F\,dx, \quad k_e = \frac{|F(x_{max})| + |F(x_{min})|}{|x_{max}| + |x_{min}|}, \quad
    \xi_e = \frac{2}{\pi}\,\frac{W}{k_e\,(|x_{max}| + |x_{min}|)^2}

The stiffness takes the forces at the largest displacements, which are not the largest forces. Displacements count from the
middle of the cycle, forces from the mean of the largest and the least. The damping ratio belongs to displacement-dependent
devices: of a viscous one the stiffness goes to zero and the ratio to infinity, so that it is asked for by name.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import gamma, pi

import numpy as np

from dampyr.errors import InputError
from dampyr.records.cycle_analysis.cycles import Cut, cut_cycles, no_cycle
from dampyr.records.record import Array, Record

STEADY_CYCLES = "steady_cycles"  # in a record's provenance


@dataclass(frozen=True)
class SteadyCycles:
    """The cycles of full amplitude that a test commands: ``count`` of ``period`` s, one after another, from ``begin`` s on."""

    begin: float
    period: float
    count: int

    def as_provenance(self, start: float) -> dict[str, str]:
        """What a record says of them whose time is ``start`` s where the test begins."""
        return {STEADY_CYCLES: json.dumps(asdict(self) | {"begin": round(start + self.begin, 9)})}

    @classmethod
    def of(cls, record: Record) -> SteadyCycles | None:
        """Those that a record states, ``begin`` in its time; None where it states none."""
        text = record.provenance.get(STEADY_CYCLES)
        if text is None:
            return None
        try:
            table = json.loads(text)
            steady = cls(float(table["begin"]), float(table["period"]), int(table["count"]))
        except (ValueError, TypeError, KeyError):
            steady = cls(0.0, 0.0, 0)
        if not (np.isfinite(steady.begin) and 0.0 < steady.period < np.inf and steady.count > 0):
            raise InputError(
                f"{record.name}: its {STEADY_CYCLES} = {text} is not allowed; it needs begin, period (both s) and count"
            )
        return steady


@dataclass(frozen=True)
class DeviceFigures:
    """Of one cycle, SI; ``number`` counts from the start of the motion, ``in_level`` from the start of its level."""

    number: int
    level: int
    in_level: int
    amplitude: float
    energy: float
    largest_force: float
    effective_stiffness: float
    characteristic_strength: float

    @property
    def damping_ratio(self) -> float:
        """The equivalent damping of a displacement-dependent device; means nothing for a viscous one."""
        return self.energy / (2.0 * pi * self.effective_stiffness * self.amplitude**2)


def device_figures(record: Record, cut: Cut | None = None) -> list[DeviceFigures]:
    """The figures of every whole cycle of a level, in their order; those of the run-in and run-out are left out.

    A record that states its steady cycles (`SteadyCycles`) has these, by the time of the command; else the motion is cut as
    `dampyr.records.cut_cycles` does it, or as ``cut`` says. InputError where there is no whole cycle.
    """
    steady = SteadyCycles.of(record) if cut is None else None
    if steady is not None:
        edges = steady.begin + steady.period * np.arange(steady.count + 1)
        inside = (edges >= record.time[0] - 0.5 * record.dt) & (edges <= record.time[-1] + 0.5 * record.dt)
        cycles = [(k + 1, 1, edges[k], edges[k + 1]) for k in range(steady.count) if inside[k] and inside[k + 1]]
    else:
        whole = (cut_cycles(record) if cut is None else cut).cycles
        cycles = [(cycle.number, cycle.level, cycle.start_s, cycle.stop_s) for cycle in whole if cycle.level]
    if not cycles:
        raise no_cycle(record, "the figures of devices")
    counts: dict[int, int] = {}
    figures = []
    for number, level, start, stop in cycles:
        counts[level] = counts.get(level, 0) + 1
        figures.append(_figures(number, level, counts[level], *loop_between(record, start, stop)))
    return figures


def loop_between(record: Record, start: float, stop: float) -> tuple[Array, Array]:
    """Displacement and force from ``start`` to ``stop`` s, which may lie between samples."""
    inside = (record.time > start) & (record.time < stop)
    time: Array = np.r_[start, record.time[inside], stop]
    return np.asarray(np.interp(time, record.time, record.displacement)), np.asarray(
        np.interp(time, record.time, record.force)
    )


def _figures(number: int, level: int, in_level: int, x: Array, force: Array) -> DeviceFigures:
    x = x - 0.5 * (x.max() + x.min())
    energy = float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(x)))
    force = force - 0.5 * (force.max() + force.min())
    high, low = int(np.argmax(x)), int(np.argmin(x))
    return DeviceFigures(
        number=number,
        level=level,
        in_level=in_level,
        amplitude=float(0.5 * (x[high] - x[low])),
        energy=energy,
        largest_force=float(force.max()),
        effective_stiffness=float((abs(force[high]) + abs(force[low])) / (x[high] - x[low])),
        characteristic_strength=_strength(x, force),
    )


def _strength(x: Array, force: Array) -> float:
    """The mean of the force's magnitudes where the motion passes its middle."""
    k = np.flatnonzero(np.signbit(x[1:]) != np.signbit(x[:-1]))
    part = x[k] / (x[k] - x[k + 1])
    return float(np.mean(np.abs(force[k] + part * (force[k + 1] - force[k]))))


def power_law_energy(largest_force: float, amplitude: float, exponent: float) -> float:
    r"""The energy of a sine cycle of :math:`F = C\,\mathrm{sgn}(v)|v|^a`, J:
    :math:`\lambda F_{max} D`, :math:`\lambda = 4 \cdot 2^a \Gamma(1 + a/2)^2 / \Gamma(2 + a)`.
    """
    if exponent < 0.0:
        raise InputError(f"exponent = {exponent:g} is not allowed; it must be at least 0, such as 0.3")
    return 4.0 * 2.0**exponent * gamma(1.0 + 0.5 * exponent) ** 2 / gamma(2.0 + exponent) * largest_force * amplitude


def stability(values: Sequence[float], third: int = 2) -> list[float]:
    """How far each value is from the third, relative to it; InputError where there are fewer than three."""
    if len(values) <= third:
        raise InputError(
            f"{len(values)} cycles have no cycle {third + 1} to be compared with; run at least {third + 1}"
        )
    return [value / values[third] - 1.0 for value in values]
