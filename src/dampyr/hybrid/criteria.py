"""The criteria J1 to J9 of the benchmark: how well the specimen follows, and how well the whole answers as the structure would.

J1 is the delay at the greatest correlation, from 0 to 49 samples; J2 and J3 are the error of the specimen's displacement x to
the target x_n, its standard deviation and peak over those of x_n; J4 and J5 the same to the reference structure's floor; J6 to
J9 the numerical part's second and third floor to the reference: standard deviations, then peaks. In % but J1, in ms.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.hybrid.loop_kernel import lag_products
from dampyr.models.codegen.kernels import compile_cached

Array = NDArray[np.float64]

LAGS = 50  # samples
CRITERIA = ("J1", "J2", "J3", "J4", "J5", "J6", "J7", "J8", "J9")
"""The names of the criteria."""


class Criteria(NamedTuple):
    """J1 [ms], J2 to J9 [%]; of a structure of one floor J6 to J9 are nan, of two J7 and J9."""

    J1: float
    J2: float
    J3: float
    J4: float
    J5: float
    J6: float
    J7: float
    J8: float
    J9: float


def tracking_criteria(
    displacement: Array, target: Array, floors: Array, reference: Array, floor: int, dt: float
) -> Criteria:
    """The criteria J1 to J9 of a run.

    Parameters
    ----------
    displacement : (T,) m, of the specimen, true or as measured.
    target : (T,) m, of the numerical part there.
    floors : (n, T) m, of the numerical part.
    reference : (n, T) m, of the whole structure, computed.
    floor : the specimen's, counted from 1.
    dt : s between two samples.

    Returns
    -------
    Criteria
        J1 [ms], J2 to J9 [%]; nan for floors that the structure does not have.

    Raises
    ------
    InputError
        The shapes do not match, there are fewer than 51 samples, or nothing moves.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> from dampyr.hybrid.criteria import tracking_criteria
    >>> x = np.sin(0.02 * np.arange(4096))
    >>> criteria = tracking_criteria(0.99 * x, x, x[None], x[None], 1, 1 / 4096)
    >>> criteria.J1, round(criteria.J2, 6)
    (0.0, 1.0)
    """
    if displacement.shape != target.shape or floors.shape != reference.shape or floors.shape[1:] != target.shape:
        raise InputError(
            f"shapes {displacement.shape}, {target.shape}, {floors.shape}, {reference.shape} do not match; give one "
            "number a sample and floor"
        )
    if not len(target) > LAGS:
        raise InputError(f"{len(target)} samples are too few; the criteria need more than {LAGS}")
    other_floors = [k for k in range(len(floors)) if k != floor - 1][:2]
    errors = [_relative(floors[k], reference[k]) for k in other_floors] + [(np.nan, np.nan)] * (2 - len(other_floors))
    of_specimen = tracking_error(displacement, target, reference[floor - 1], dt)
    return Criteria._make([*of_specimen, errors[0][0], errors[1][0], errors[0][1], errors[1][1]])


def tracking_error(displacement: Array, target: Array, reference: Array, dt: float) -> tuple[float, ...]:
    """J1 to J5 of a displacement (T,)."""
    to_target, to_reference = _relative(displacement, target), _relative(displacement, reference)
    return 1e3 * dt * delay_in_samples(displacement, target), *to_target, *to_reference


def delay_in_samples(late: Array, early: Array) -> int:
    """The shift of ``early``, from 0 to 49 samples, at which the two correlate best."""
    a, b = np.ascontiguousarray(late - late.mean()), np.ascontiguousarray(early - early.mean())
    count = len(a) - np.arange(LAGS)
    products = np.zeros(LAGS)
    compile_cached(lag_products)(a, b, products)
    # what a lag leaves out is the start of a and the end of b
    sum_a, square_a = (np.concatenate([[0.0], np.cumsum(values[: LAGS - 1])]) for values in (a, a**2))
    sum_b, square_b = (np.concatenate([[0.0], np.cumsum(values[:-LAGS:-1])]) for values in (b, b**2))
    spread = (np.sum(a**2) - square_a - sum_a**2 / count) * (np.sum(b**2) - square_b - sum_b**2 / count)
    return int(np.argmax((products - sum_a * sum_b / count) / np.sqrt(spread)))


def _relative(history: Array, reference: Array) -> tuple[float, float]:
    """Standard deviation and peak of the difference, in % of those of ``reference``."""
    gap = history - reference
    spread, peak = float(np.std(reference)), float(np.max(np.abs(reference)))
    if spread == 0.0:
        raise InputError("nothing moves, so that an error has nothing to be compared with; give a motion")
    return 100.0 * float(np.std(gap)) / spread, 100.0 * float(np.max(np.abs(gap))) / peak
