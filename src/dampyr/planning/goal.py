"""What a plan is after: the damper's parameters, or the peak of a structure in an earthquake."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrWarning, InputError
from dampyr.ground_motions import GroundMotion
from dampyr.identification import Fit
from dampyr.models import Damper
from dampyr.planning.choose import ParameterGoal, PeakGoal
from dampyr.planning.expected_information import CoefficientLayout
from dampyr.shown import Shown
from dampyr.structures import Building, respond

Array = NDArray[np.float64]
PEAKS = ("drift", "displacement", "acceleration")
INSENSITIVE = 1e-6  # of a peak's logarithm by that of a coefficient: below it the peak does not depend on it
NEGLIGIBLE = 1e-3  # of the same: were it unknown to a factor of two, the peak would be within what it is computed to
STEP = 0.02  # of a coefficient, to either side: well above the 1e-3 to which peaks are computed


@dataclass(frozen=True, eq=False, repr=False)
class Peak(Shown):
    """The largest peak of a structure, over its storeys or floors, with the damper in storey 1.

    Parameters
    ----------
    building
        the structure.
    motion
        the earthquake.
    voltage
        of the damper, V; None where it has no input.
    of
        which peak: ``"drift"``, ``"displacement"`` or ``"acceleration"``.

    Examples
    --------
    >>> import dampyr as dp
    >>> peak = dp.planning.Peak(dp.structures.two_storey(), dp.ground_motions.el_centro(), 1.98)
    >>> peak.words
    'the largest drift at 1.98 V'
    """

    building: Building
    motion: GroundMotion
    voltage: float | None
    of: str = "drift"

    def __post_init__(self) -> None:
        if self.of not in PEAKS:
            raise InputError(f"{self.of!r} is not a peak of a structure; choose {', '.join(PEAKS)}")

    @property
    def words(self) -> str:
        """Such as ``the largest drift at 1.98 V``."""
        return f"the largest {self.of}" + ("" if self.voltage is None else f" at {self.voltage:.4g} V")

    def check(self, damper: Damper) -> None:
        """:class:`~dampyr.errors.InputError` unless the voltage is one that the damper takes."""
        if self.voltage is not None and damper.has_input:
            damper.check_input(self.voltage)
        elif self.voltage is not None:
            raise InputError("the goal peak has a voltage, and the damper has no input; leave it out")
        elif damper.has_input:
            raise InputError("the goal peak needs the damper's voltage in the earthquake, such as 1.98 V; give it")

    def value(self, damper: Damper) -> float:
        """The peak, in m or m/s2."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DampyrWarning)  # an earthquake goes beyond the tests: a prediction says so
            response = respond(self.building, self.motion, damper, voltage=self.voltage, accuracy="fast")
        return float(np.max(np.abs(getattr(response, f"peak_{self.of}"))))

    def gradient(self, plan: CoefficientLayout) -> tuple[Array, float]:
        """The derivatives (G,) of the peak's logarithm by the relative coefficients, and the peak."""

        def compute_peak(theta: Array) -> float:
            damper = plan.damper(theta)
            return self.value(damper.without("lag") if "lag" in damper.composition.names else damper)

        out = np.zeros(plan.theta.size)
        for k in np.flatnonzero(~plan.held):
            sides = []
            for sign in (1.0, -1.0):
                theta = plan.theta.copy()
                theta[k] *= 1.0 + sign * STEP
                sides.append(math.log(compute_peak(theta)))
            out[k] = (sides[0] - sides[1]) / (
                2.0 * STEP
            )  # central: a peak is computed to 1e-3, one side would show that
        return out, compute_peak(plan.theta)


def is_named(label: str, name: str) -> bool:
    """Whether a target's ``name`` means this coefficient: its label, or the parameter that it is of."""
    return name in (label, label.partition(" @ ")[0])


def parameter_goal(plan: CoefficientLayout, targets: Mapping[str, float]) -> ParameterGoal:
    """The goal of all free parameters alike, or of ``targets``: a parameter, or its value at one input, and the half width of
    its 95 % interval over its value.

    Raises :class:`~dampyr.errors.InputError` for one that the damper does not have or that is held.
    """
    if not targets:
        return ParameterGoal(np.where(plan.held, 0.0, 1.0))
    aims = np.full(len(plan.labels), np.inf)
    for name, target in targets.items():
        places = [k for k, label in enumerate(plan.labels) if is_named(label, name)]
        if not places:
            names = [*dict.fromkeys(label.partition(" @ ")[0] for label in plan.labels)]
            at = next((f", also at one input as in {label!r}" for label in plan.labels if "@" in label), "")
            raise InputError(f"target names {name!r}; choose among {', '.join(names)}{at}")
        if not 0.0 < target < 1.0:
            raise InputError(
                f"the target of {name} is {target:g}; give a half width over the value, such as 5% or 0.05"
            )
        open_ones = [k for k in places if not plan.held[k]]
        if not open_ones:
            raise InputError(
                f"{name} is 0 or at its limit, so that nothing is a share of it; leave it out of the targets"
            )
        aims[open_ones] = np.minimum(aims[open_ones], target)
    return ParameterGoal(np.where(np.isfinite(aims), 1.0, 0.0), aims)


def peak_goal(plan: CoefficientLayout, peak: Peak) -> tuple[PeakGoal, float]:
    """The goal of a peak, and the peak. Raises :class:`~dampyr.errors.InputError` where no parameter changes it."""
    gradient, value = peak.gradient(plan)
    if not np.any(np.abs(gradient) > INSENSITIVE):
        raise InputError(
            f"no parameter of the damper changes {peak.words}; choose "
            + f"{'a voltage or ' * (peak.voltage is not None)}a structure that it acts on"
        )
    return PeakGoal(gradient), value


def peak_half_of_fit(fit: Fit, plan: CoefficientLayout, goal: PeakGoal) -> tuple[float, float]:
    """The half width of the peak's 95 % interval over the peak by the covariance of a fit, and its degrees of freedom.

    Infinite where the peak depends on a coefficient that the records do not determine, or that fewer than three of them do.
    Coefficients of the plan that the fit does not have, or that stand at a limit, count as known.
    """
    errors = np.array([fit.stderr.get(label, 0.0) for label in plan.labels])
    depends = np.isfinite(goal.gradient) & (np.abs(goal.gradient) > NEGLIGIBLE) & ~plan.held
    few = np.array([label in fit.within_records for label in plan.labels])
    freedom = np.array([fit.freedom.get(label, 1.0) for label in plan.labels])
    if np.any(depends & (few | np.isinf(errors))):
        return np.inf, float(np.median(freedom))
    places = {label: k for k, label in enumerate(fit.stderr)}
    order = np.array([places.get(label, -1) for label in plan.labels])
    sd = np.where(np.isfinite(errors), errors, 0.0) / np.where(plan.theta == 0.0, np.inf, plan.theta)
    correlation = np.where((order[:, None] >= 0) & (order >= 0), fit.correlation[np.ix_(order, order)], 0.0)
    return goal.half_of(np.nan_to_num(correlation) * np.outer(sd, sd), freedom), float(np.median(freedom))
