r"""Score of a damper on a record: a free run, only the offset taken from the record.

With the error :math:`e = \hat F - F` of which its mean is removed, and the force measured from the middle of its range,
:math:`F_c = F - (\max F + \min F)/2`, over the samples of the window:

.. math:: L_1 = \frac{\sum|e|}{\sum|F_c|}, \quad \text{NRMSE} = \frac{\text{rms}(e)}{\text{rms}(F - \bar F)}, \quad
          R^2 = 1 - \text{NRMSE}^2, \quad \text{pointwise} = \text{mean}\frac{|e|}{|F_c|}

L1 is (3.1) of Raminelli (2020). The pointwise error leaves out samples with :math:`|F_c|` below 1 % of its peak, where it
is a division by nothing. The measured force is never smoothed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.records import Record, cycles, motion_start, with_velocity
from dampyr.representation import Representation, Summary, percent

Array = NDArray[np.float64]
SETTLING = 2.0  # s after the motion starts: the unknown past is forgotten by then
SMALL = 0.01  # of the peak of F_c: below it the pointwise error divides by nothing


@dataclass(frozen=True)
class Window:
    """The samples that a score was computed on."""

    first: int
    last: int
    start: float
    end: float

    @property
    def slice(self) -> slice:
        """As an index."""
        return slice(self.first, self.last + 1)


@dataclass(frozen=True, repr=False)
class Score(Representation):
    """Ratios without unit (0.05 is 5 %); ``peak_force`` and ``energy`` are signed errors, model over measured less one.

    ``energy`` is per cycle (of the whole cycles in the window), NaN where there is none. ``offset`` in N is what was
    taken from the record. ``window`` says which samples.
    """

    l1: float
    nrmse: float
    r2: float
    pointwise: float
    peak_force: float
    energy: float
    offset: float
    window: Window

    def _summary(self) -> Summary:
        return f"Score, L1 {percent(self.l1)}", [
            ("NRMSE", f"{percent(self.nrmse)}, R² {self.r2:.4g}"),
            ("pointwise", percent(self.pointwise)),
            ("peak force", f"{100 * self.peak_force:+.3g} % against the measured one"),
            ("energy", f"{100 * self.energy:+.3g} % against the measured one, per cycle"),
            ("offset", f"{self.offset:.4g} N"),
            ("window", f"{self.window.start:.4g} … {self.window.end:.4g} s"),
        ]

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers, for JSON."""
        return asdict(self)


def score(
    damper: Damper,
    record: Record,
    settling: float = SETTLING,
    window: tuple[float, float] | None = None,
    allow_extrapolation: bool = False,
) -> Score:
    """Run ``damper`` freely along ``record`` and compare.

    The window goes from ``settling`` s after the motion starts to the end, or is ``window`` = (from, to) in s. Raises
    :class:`~dampyr.errors.InputError` where the record's input is not the damper's, or the window is empty.
    """
    return compare(record, prediction(damper, record, allow_extrapolation), settling, window)


def prediction(damper: Damper, record: Record, allow_extrapolation: bool = False) -> Array:
    """The force in N, shape (n,), that ``damper`` predicts along ``record``, with the velocity it was calibrated with."""
    if record.velocity is None or damper.bandwidth is not None:
        record = with_velocity(record, damper.bandwidth)
    return damper.force(
        record.time,
        record.displacement,
        voltage=record.voltage,
        current=record.current,
        velocity=record.velocity,
        allow_extrapolation=allow_extrapolation,
    )


def scoring_window(record: Record, settling: float = SETTLING, window: tuple[float, float] | None = None) -> Window:
    """The samples from ``settling`` s after the motion starts, or those between the two times of ``window``."""
    start, end = window or (motion_start(record) + settling, float(record.time[-1]))
    inside = np.flatnonzero((record.time >= start - 1e-9) & (record.time <= end + 1e-9))
    if inside.size < 8:
        raise InputError(
            f"{record.name}: the window {start:.3g} to {end:.3g} s holds {inside.size} samples; the record ends at "
            f"{record.time[-1]:.3g} s, so shorten settling or give window=(from, to)"
        )
    return Window(int(inside[0]), int(inside[-1]), float(record.time[inside[0]]), float(record.time[inside[-1]]))


def compare(
    record: Record, force: ArrayLike, settling: float = SETTLING, window: tuple[float, float] | None = None
) -> Score:
    """The scores of a force (n,) in N, from wherever, against a record."""
    where = scoring_window(record, settling, window)
    measured, model = record.force[where.slice], np.asarray(force, dtype=float)[where.slice]
    offset = float(np.mean(measured - model))
    error = model + offset - measured
    centred = measured - 0.5 * (measured.max() + measured.min())
    seen = np.abs(centred) > SMALL * np.abs(centred).max()
    spread = float(np.sqrt(np.mean((measured - measured.mean()) ** 2)))
    if spread == 0.0:
        raise InputError(
            f"{record.name}: the force is constant at {measured[0]:g} N in the window; nothing to compare with"
        )
    nrmse = float(np.sqrt(np.mean(error**2))) / spread
    return Score(
        l1=float(np.sum(np.abs(error)) / np.sum(np.abs(centred))),
        nrmse=nrmse,
        r2=1.0 - nrmse**2,
        pointwise=float(np.mean(np.abs(error[seen]) / np.abs(centred[seen]))),
        peak_force=float(np.ptp(model) / np.ptp(measured) - 1.0),
        energy=_energy_error(record, np.asarray(force, dtype=float), where),
        offset=offset,
        window=where,
    )


def _energy_error(record: Record, force: Array, where: Window) -> float:
    spans = [(a, b) for a, b in cycles(record) if a >= where.first and b <= where.last]
    if not spans:
        return float("nan")
    span = slice(spans[0][0], spans[-1][1] + 1)
    x = record.displacement[span]
    middle = float(np.mean(x))
    measured = np.trapezoid(record.force[span] - np.mean(record.force[span]), x - middle)
    model = np.trapezoid(force[span] - np.mean(force[span]), x - middle)
    return float(model / measured - 1.0)


def group_by_input(records: Iterable[Record], values: Mapping[str, float]) -> dict[str, list[float]]:
    """The records' values under the words for their input, in its order; records without a value are left out."""
    groups: dict[str, list[float]] = {}
    for record in sorted(records, key=lambda r: -math.inf if r.input_value is None else r.input_value):
        if record.name in values:
            groups.setdefault(input_words(record), []).append(values[record.name])
    return groups


def input_words(record: Record) -> str:
    """Such as ``1.98 V``; the mean where the input varies."""
    if record.input_value is None:
        return "input not known"
    varies = np.ptp(record.voltage if record.voltage is not None else record.current) > 1e-9  # type: ignore[arg-type]
    return f"{record.input_value:.5g} {record.input}" + (" (mean)" if varies else "")
