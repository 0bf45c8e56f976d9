"""The Bouc-Wen part: its shape is checked, and the letters of its sources come back."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.models.parts.bouc_wen import BoucWen, from_printed, to_printed


def test_bouc_wen_checks_its_shape() -> None:
    with pytest.raises(InputError, match="sigma"):
        BoucWen(1.0, 1.0, 1.0, 1.0, 0.0, 1.0)
    with pytest.raises(InputError, match="makes energy"):
        from_printed(0.0, 0.0, 1.0, 1.0, beta=3.0, gamma=-1.0, n=1.5)
    with pytest.raises(InputError, match="without bound"):
        from_printed(0.0, 0.0, 1.0, 1.0, beta=-3.0, gamma=1.0, n=1.5)


@pytest.mark.parametrize("n", [1.0, 1.7, 4.0])
@pytest.mark.parametrize("sigma", [0.01, 0.3, 0.5, 2.0])
def test_no_motion_takes_more_energy_out_than_is_stored(sigma: float, n: float) -> None:
    rng = np.random.default_rng(7)
    grid = np.linspace(0.0, 1.0, 100001)
    stored = cumulative_trapezoid(grid / (1.0 + (2.0 * sigma - 1.0) * grid**n), grid, initial=0.0)
    unit = {"c0": 0.0, "k0": 0.0, "kw": 1.0, "rho": 1.0, "sigma": sigma, "n": n}
    damper = Damper("bouc_wen", {f"bouc_wen.{key}": value for key, value in unit.items()})
    for _ in range(10):  # from rest, turned at random after ways of every size
        turns = np.cumsum(np.append(0.0, rng.standard_normal(60) * 10.0 ** rng.uniform(-2.0, 1.0, 60)))
        x = np.interp(np.arange(0.0, 60.0, 5e-4), np.arange(61), turns)
        w = damper.force(np.arange(x.size) / 1e3, x, allow_extrapolation=True)
        work = cumulative_trapezoid(w, x, initial=0.0)
        assert np.min(work - np.interp(np.abs(w), grid, stored)) >= -1e-5


@pytest.mark.parametrize("A", [0.3, 1.0, 250.0])
def test_printed_letters_come_back(A: float) -> None:
    model = BoucWen(c0=500.0, k0=900.0, kw=120.0, rho=3000.0, sigma=1.2, n=1.6)
    there = to_printed(model, A=A)
    again = from_printed(there.c0, there.k0, there.alpha, there.A, there.beta, there.gamma, there.n)
    assert vars(again) == pytest.approx(vars(model), rel=1e-12)
