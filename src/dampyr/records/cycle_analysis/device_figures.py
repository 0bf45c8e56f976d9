r"""Figures of a cycle by which devices are judged: energy, forces, stiffnesses, characteristic strength, loss factor.

.. math::

    W = \oint F\,dx, \quad k_e = \frac{|F(x_{max})| + |F(x_{min})|}{|x_{max}| + |x_{min}|}, \quad
    \xi_e = \frac{2}{\pi}\,\frac{W}{k_e\,(|x_{max}| + |x_{min}|)^2}, \quad
    k_2 = \frac{F(x_{max}) - F^+_0}{2\,x_{max}} + \frac{F(x_{min}) - F^-_0}{2\,x_{min}}, \quad
    K' + iK'' = \frac{F_1}{X_1}

The stiffness takes the forces at the largest displacements, which are not the largest forces; the second slope is the mean of
the two chords from the force on the way there through the middle, :math:`F_0^\pm`; :math:`F_1` and :math:`X_1` are the first
harmonics over the cycle, by least squares beside a mean. Displacements count from the middle of the cycle, forces
from the mean of the largest and the least, but for those that are said to be as recorded. The damping ratio and the loss factor
belong to displacement-dependent devices: of a viscous one the stiffness goes to zero and both to infinity, so that they are
asked for by name. docs/reference/cycle-figures.md has the sources.

A loop that does not end where it began, by a drift or since the record ends early, is closed by a straight line: the energy is
its area, and no force that is constant adds to it.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import gamma, hypot, inf, pi

import numpy as np

from dampyr.errors import InputError
from dampyr.records.cycle_analysis.cycles import Cut, cut_cycles, no_cycle
from dampyr.records.cycle_analysis.path_work import path_work
from dampyr.records.record import Array, Record

STEADY_CYCLES = "steady_cycles"  # in a record's provenance
AT_MIDDLE = 0.02  # of the amplitude: a cycle that begins or ends so close to its middle was cut there


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
    """Of one cycle, SI; ``number`` counts from the start of the motion, ``in_level`` from the start of its level.

    ``start`` and ``stop`` in s. As recorded are ``peak_out`` and ``peak_in``, the largest and the least force, and ``zero_out``
    and ``zero_in``, those where the motion passes the middle of the cycle in extension and in compression.
    """

    number: int
    level: int
    in_level: int
    amplitude: float
    energy: float
    largest_force: float
    effective_stiffness: float
    characteristic_strength: float
    start: float
    stop: float
    peak_out: float
    peak_in: float
    zero_out: float
    zero_in: float
    second_slope: float
    storage_stiffness: float
    loss_stiffness: float

    @property
    def frequency(self) -> float:
        """One over the duration, Hz."""
        return 1.0 / (self.stop - self.start)

    @property
    def damping_ratio(self) -> float:
        """The equivalent damping of a displacement-dependent device; means nothing for a viscous one."""
        return self.energy / (2.0 * pi * self.effective_stiffness * self.amplitude**2)

    @property
    def loss_factor(self) -> float:
        """The loss stiffness over the storage stiffness; means nothing for a viscous device, whose storage stiffness is 0 but
        for rounding: infinite where it is 0."""
        return self.loss_stiffness / self.storage_stiffness if self.storage_stiffness else inf

    @property
    def dynamic_stiffness(self) -> float:
        """The magnitude of the complex stiffness, N/m."""
        return hypot(self.storage_stiffness, self.loss_stiffness)

    @property
    def viscous_coefficient(self) -> float:
        """The loss stiffness over the angular frequency, N s/m: of the dashpot that dissipates as much at this frequency."""
        return self.loss_stiffness / (2.0 * pi * self.frequency)

    @property
    def stiffness_share(self) -> float:
        """The force at the largest displacements over the largest force: 1 of a spring, 0 of a dashpot."""
        return self.effective_stiffness * self.amplitude / self.largest_force if self.largest_force else 0.0


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
        figures.append(_figures(number, level, counts[level], *_samples_between(record, start, stop)))
    return figures


def loop_between(record: Record, start: float, stop: float) -> tuple[Array, Array]:
    """Displacement and force from ``start`` to ``stop`` s, which may lie between samples."""
    _, x, force = _samples_between(record, start, stop)
    return x, force


def _samples_between(record: Record, start: float, stop: float) -> tuple[Array, Array, Array]:
    """Time, displacement and force."""
    inside = (record.time > start) & (record.time < stop)
    time: Array = np.r_[start, record.time[inside], stop]
    x, force = (np.interp(time, record.time, values) for values in (record.displacement, record.force))
    return time, np.asarray(x), np.asarray(force)


def _figures(number: int, level: int, in_level: int, time: Array, x: Array, recorded: Array) -> DeviceFigures:
    x = x - 0.5 * (x.max() + x.min())
    middle = 0.5 * float(recorded.max() + recorded.min())
    force = recorded - middle
    high, low = int(np.argmax(x)), int(np.argmin(x))
    out, back = _forces_at_middle(x, force)
    storage, loss = complex_stiffness(time, x, force)
    return DeviceFigures(
        number=number,
        level=level,
        in_level=in_level,
        amplitude=float(0.5 * (x[high] - x[low])),
        energy=path_work(x, force) + 0.5 * float((force[0] + force[-1]) * (x[0] - x[-1])),
        largest_force=float(force.max()),
        effective_stiffness=float((abs(force[high]) + abs(force[low])) / (x[high] - x[low])),
        characteristic_strength=0.5 * (abs(out) + abs(back)),
        start=float(time[0]),
        stop=float(time[-1]),
        peak_out=float(recorded.max()),
        peak_in=float(recorded.min()),
        zero_out=out + middle,
        zero_in=back + middle,
        second_slope=0.5 * float((force[high] - out) / x[high] + (force[low] - back) / x[low]),
        storage_stiffness=storage,
        loss_stiffness=loss,
    )


def _forces_at_middle(x: Array, force: Array) -> tuple[float, float]:
    """The mean forces where the motion passes its middle upwards and downwards, N; NaN where it does not.

    A cycle that is cut there ends with a pass; the one that it begins with counts only without that, for the first begins at
    rest.
    """
    near = np.abs(x) <= AT_MIDDLE * float(np.max(np.abs(x)))
    begin, end = (
        int(np.argmin(near)),
        x.size - int(np.argmin(near[::-1])),
    )  # between them lies what is not near its ends
    k = np.flatnonzero((x[1:end] < 0.0) != (x[: end - 1] < 0.0))
    k = k[k >= begin]
    part = x[k] / (x[k] - x[k + 1])
    at, up = force[k] + part * (force[k + 1] - force[k]), x[k + 1] > x[k]
    if end < x.size:
        at, up = np.r_[at, force[-1]], np.r_[up, x[end - 1] < 0.0]
    elif begin > 0:
        at, up = np.r_[at, force[0]], np.r_[up, x[begin] > 0.0]
    return tuple(float(np.mean(at[way])) if way.any() else np.nan for way in (up, ~up))  # type: ignore[return-value]


def complex_stiffness(time: Array, x: Array, force: Array) -> tuple[float, float]:
    """Storage and loss stiffness, N/m, by the first harmonics of a cycle of ``(n,)`` samples, from its start to its end."""
    phase = 2.0 * pi * (time - time[0]) / (time[-1] - time[0])
    intervals = np.diff(time)
    root = np.sqrt(np.r_[intervals, 0.0] + np.r_[0.0, intervals])  # each sample counts for the time about it
    basis = np.column_stack([np.ones_like(phase), np.cos(phase), np.sin(phase)])
    (_, xc, xs), (_, fc, fs) = np.linalg.lstsq(
        root[:, None] * basis, root[:, None] * np.column_stack([x, force]), rcond=None
    )[0].T
    ratio = complex(fc, -fs) / complex(xc, -xs)
    return ratio.real, ratio.imag


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
