# Fenz and Constantinou (2008), Earthquake Engineering and Structural Dynamics 37, 163: its regimes; its springs by scipy
"""The triple friction pendulum bearing: its regimes, the series model with a little viscosity, any step, energy, letters."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.models.part import part
from dampyr.models.parts.triple_pendulum import TriplePendulum, from_bearing

W, MU, R, D = 1e6, (0.04, 0.02, 0.02, 0.08), (2.0, 0.3, 0.3, 2.2), (0.30, 0.05, 0.05, 0.32)
BEARING = from_bearing(W, MU, R, D, 1e-8)
SOFT = TriplePendulum(f1=150.0, r2=2.0, r3=3.0, l1=0.002, l2=0.004, l3=0.005, d1=0.002, d2=0.004, d3=0.01, uy=1e-4)


def along(x: np.ndarray, bearing: TriplePendulum = SOFT) -> np.ndarray:
    return Damper([bearing]).force(np.arange(x.size) * 1.0, x, voltage=0.0, velocity=np.zeros(x.size))


@pytest.mark.usefixtures("plain")
def test_its_five_regimes_are_the_published_ones() -> None:
    """Where each begins, and the force there: the formulas of the source for a push from the centre."""
    ends = [0.0, (MU[0] - MU[1]) * (R[1] + R[2])]
    ends.append(ends[1] + (MU[3] - MU[0]) * (R[0] + R[2]))
    ends.append(ends[2] + D[0] * (1.0 + R[3] / R[0]) - (MU[3] - MU[0]) * (R[0] + R[3]))
    ends.append(ends[3] + ((D[3] / R[3] + MU[3]) - (D[0] / R[0] + MU[0])) * (R[1] + R[3]))
    ends.append(ends[4] + 0.03)
    lengths = [R[1] + R[2], R[0] + R[2], R[0] + R[3], R[1] + R[3], R[1] + R[2]]
    forces = np.append(
        MU[1] * W,
        MU[1] * W + W * np.cumsum([(b - a) / ell for (a, b), ell in zip(pairwise(ends), lengths, strict=True)]),
    )
    at = np.array(ends)
    at[0] = 1e-8  # where the elastic spring has taken the friction
    np.testing.assert_allclose(along(at, BEARING)[1:], forces[1:], rtol=2e-6)
    assert forces[3] == pytest.approx(W * (D[0] / R[0] + MU[0]), rel=1e-9)
    # the first way back: all stick until twice the friction of the inner surfaces
    back = along(np.array([0.0, ends[2], ends[2] - 1e-4]), BEARING)
    assert back[2] == pytest.approx(back[1] - 2 * MU[1] * W - 1e-4 * W / (R[1] + R[2]), rel=1e-4)


@pytest.mark.prove
def test_the_series_model_with_a_little_viscosity_is_approached_as_that_vanishes() -> None:
    """u_i' = (what the force is beyond friction)/eta, by LSODA."""
    free = replace(SOFT, d1=1.0, d2=1.0, d3=1.0)  # the stops are tested above
    lengths, friction = np.array([free.l1, free.l2, free.l3]), np.array([1.0, free.r2, free.r3])
    fine = np.linspace(0.0, 14.0, 5601)  # with its reversals
    s, x, errors = fine[::100], 0.0012 * fine[::100] * np.sin(fine[::100]), []
    exact = along(0.0012 * fine * np.sin(fine), free)[::100]
    for eta in (40.0, 10.0):

        def rate(at: float, u: np.ndarray, eta: float = eta) -> np.ndarray:
            over = (0.0012 * at * np.sin(at) - u.sum()) / free.uy - u / lengths
            return np.sign(over) * np.maximum(np.abs(over) - friction, 0.0) / eta

        u = solve_ivp(rate, (0.0, 14.0), np.zeros(3), "LSODA", t_eval=s, rtol=1e-7, atol=1e-10, max_step=0.01).y
        errors.append(np.abs(free.f1 * (x - u.sum(axis=0)) / free.uy - exact).max() / np.abs(exact).max())
    assert errors[0] < 0.2
    assert errors[1] < 0.35 * errors[0]


@pytest.mark.usefixtures("plain")
def test_its_step_is_exact_however_long() -> None:
    nodes = np.append(0.0, 0.008 * np.random.default_rng(2).standard_normal(40))
    fine = np.interp(np.linspace(0.0, 40.0, 2001), np.arange(41.0), nodes)
    np.testing.assert_allclose(along(fine)[::50], along(nodes), rtol=1e-9, atol=1e-7)


@pytest.mark.usefixtures("plain")
def test_in_a_closed_cycle_it_takes_work_and_beyond_all_stops_only_its_elastic_spring_is_left() -> None:
    x = np.interp(np.linspace(0.0, 3.0, 1501), np.arange(4.0), [0.0, 0.012, -0.012, 0.012])
    force = along(x)
    assert np.trapezoid(force[500:], x[500:]) > 2 * SOFT.f1 * SOFT.d1  # the inner slider alone takes 4 f1 d1 at most
    far = along(np.array([0.0, 0.03, 0.031]))
    assert far[2] - far[1] == pytest.approx(SOFT.f1 / SOFT.uy * 0.001, rel=1e-9)


def test_a_bearing_that_is_not_one_of_the_source_is_refused() -> None:
    assert part("triple_pendulum").not_tried
    for mu, radii in (((0.04, 0.02, 0.03, 0.08), R), ((0.01, 0.02, 0.02, 0.08), R), (MU, (0.3, 0.3, 0.3, 2.2))):
        with pytest.raises(InputError, match="turn the bearing"):
            from_bearing(W, mu, radii, D, 1e-4)
    assert from_bearing(W, MU, R, D, 1e-4).d1 == pytest.approx(sum(D) - 0.3 * 1.7 / 2.0 - 0.32 * 1.9 / 2.2)
