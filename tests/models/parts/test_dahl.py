"""Dahl's model, which is Bouc and Wen's with n and sigma of one."""

import math

import numpy as np
import pytest
from tests.models.parts.dahl_and_bouc_wen import bouc_wen, cycle, dahl

from dampyr.models.parts.bouc_wen import BoucWen


@pytest.mark.parametrize("pieces", [1, 7, 1000])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_monotone_piece_of_dahl_is_exact_whatever_the_step(pieces: int, direction: float) -> None:
    rho, path, w0 = 700.0, 0.0031, 0.37
    x = direction * np.linspace(0.0, path, pieces + 1)
    force = dahl(0.0, 1.0, rho).force(np.arange(pieces + 1.0), x, voltage=0.0, state0=[w0])
    assert force[-1] == pytest.approx(direction + (w0 - direction) * math.exp(-rho * path), rel=1e-9)


def test_dahl_is_bouc_wen_with_n_and_sigma_one() -> None:
    t, x, v = cycle(0.006, 5.0, 333)
    one = dahl(700.0, 60.0, 2000.0).force(t, x, voltage=0.0, velocity=v)
    other = bouc_wen(BoucWen(700.0, 0.0, 60.0, 2000.0, 1.0, 1.0)).force(t, x, voltage=0.0, velocity=v)
    np.testing.assert_allclose(other, one, atol=1e-10)
