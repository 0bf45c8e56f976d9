"""The series of a short step of the Bouc-Wen state: beside the hyperbolic tangent, and where it does not suffice."""

import numpy as np
import pytest
from tests.models.numerics.bouc_wen_phases import by_phases

from dampyr.models.numerics.bouc_wen_taylor import short_enough, short_step


def test_a_series_that_does_not_suffice_says_so() -> None:
    assert short_step(0.05, 0.3, 1.4, 1.0, -1.0) == -2.0
    h = short_enough(0.8, 1.4, 1.0, -1.0)
    assert short_step(0.8, h, 1.4, 1.0, -1.0) == pytest.approx(by_phases(0.8, h, 1.4, 1.0), abs=1e-13)


def test_every_term_of_the_series_is_right() -> None:
    worst, taken = 0.0, 0
    for y in np.linspace(0.2, 0.98, 40):
        for h in np.linspace(0.5, 2.0, 8) * short_enough(y, 2.0, 1.0, -1.0):
            value = short_step(y, h, 2.0, 1.0, -1.0)
            if value > 0.0:
                worst, taken = max(worst, abs(value - np.tanh(np.arctanh(y) + h))), taken + 1
    assert taken > 100
    assert worst < 6e-15
