"""exp and tanh without branches, against the C library's and at the ends of their range."""

import math

import numpy as np
import pytest

from dampyr.models.codegen.kernels import compile_cached
from dampyr.models.numerics import fast_math


def values(function, y):
    return np.array([compile_cached(function)(float(one)) for one in y])


@pytest.mark.parametrize("reach", [700.0, 20.0, 0.3, 1e-9])
@pytest.mark.parametrize(("ours", "theirs"), [(fast_math.quick_exp, math.exp), (fast_math.quick_tanh, math.tanh)])
def test_relative_error_of_rounding(ours, theirs, reach: float) -> None:
    y = np.random.default_rng(0).uniform(-reach, reach, 4000)
    assert values(ours, y) == pytest.approx([theirs(one) for one in y], rel=1e-15, abs=0.0)


def test_ends_of_the_range_and_what_is_no_number() -> None:
    y = [-np.inf, -1e300, -745.0, 0.0, 710.0, 1e300, np.inf, np.nan]
    assert values(fast_math.quick_exp, y) == pytest.approx(
        [0.0, 0.0, 0.0, 1.0, np.inf, np.inf, np.inf, np.nan], nan_ok=True
    )
    result = values(fast_math.quick_tanh, [-np.inf, -1e300, -0.0, 0.0, 1e300, np.inf, np.nan])
    assert result == pytest.approx([-1.0, -1.0, -0.0, 0.0, 1.0, 1.0, np.nan], nan_ok=True)
    assert math.copysign(1.0, result[2]) == -1.0
