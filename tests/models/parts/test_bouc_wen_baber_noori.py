# Foliente (1995), J. Structural Engineering 121, 1013, solved by scipy; OpenSees 3.7.1 (openseespy 3.7.1.2), its BWBN material.
"""The Bouc-Wen-Baber-Noori model: its equations, OpenSees as its step shrinks, bouc_wen without wear, energy, and a fit."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.models.parts.found_again import assert_found_again, damper

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.models.parts._falling_limit import falling_by_c, falling_by_n, falling_by_xi, falling_by_y, falling_flow
from dampyr.models.parts.bouc_wen_baber_noori import from_opensees

NAME = "bouc_wen_baber_noori"
SHAPE = {"k0": 5e3, "kw": 150.0, "rho": 1500.0, "sigma": 0.7, "n": 1.6}
WEAR = {"zetas": 0.9, "q": 0.1, "p": 60.0, "Shi": 0.4, "deltaShi": 2.0, "lamda": 0.3, "deltanu": 4.0, "deltaeta": 6.0}
NUMBERS = SHAPE | WEAR


def along(x: np.ndarray, **changes: float) -> np.ndarray:
    return damper(NAME, NUMBERS | changes).force(np.arange(x.size) * 1.0, x, voltage=0.0, velocity=np.zeros(x.size))


def published(s: np.ndarray) -> np.ndarray:
    """The equations of the source for x = (s/2000) sin s, the phase s in the place of the time."""
    g = NUMBERS

    def rate(at: float, y: np.ndarray) -> list[float]:
        w, e = y
        v = (np.sin(at) + at * np.cos(at)) / 2000.0
        nu, eta, taken = 1.0 + g["deltanu"] * e, 1.0 + g["deltaeta"] * e, g["zetas"] * (1.0 - np.exp(-g["p"] * e))
        spread = (g["Shi"] + g["deltaShi"] * e) * (g["lamda"] + taken)
        h = 1.0 - taken * np.exp(-((w * np.sign(v) - g["q"] * (1.0 / nu) ** (1.0 / g["n"])) ** 2) / spread**2)
        size = abs(w) ** (g["n"] - 1.0)
        loss = nu * (g["sigma"] * abs(v) * size * w + (1.0 - g["sigma"]) * v * size * abs(w))
        return [g["rho"] * h / eta * (v - loss), w * v]

    w = solve_ivp(rate, (s[0], s[-1]), [0.0, 0.0], "LSODA", t_eval=s, rtol=1e-9, atol=1e-11, max_step=2e-3).y[0]
    return g["k0"] * s * np.sin(s) / 2000.0 + g["kw"] * w


@pytest.mark.prove
def test_the_published_equations_are_approached_at_second_order() -> None:
    errors = []
    for n in (800, 3200):
        s = np.linspace(0.0, 20.0, n + 1)
        exact = published(s)
        errors.append(np.abs(along(s * np.sin(s) / 2000.0) - exact).max() / np.abs(exact).max())
    assert errors[0] < 3e-3
    assert errors[1] < errors[0] / 12


BWBN = {"alpha": 0.05, "ko": 2.0, "n": 1.5, "gamma": 0.4, "beta": 0.6, "Ao": 1.0}
BWBN |= {"q": 0.1, "zetas": 0.9, "p": 0.05, "Shi": 0.3, "deltaShi": 0.002, "lamda": 0.2}
STRESS = {  # at every half quarter of a cycle, with so many steps a quarter, as OpenSees gives it
    4000: [1.344111, 1.779829, 1.139624, -1.089044, -1.976016, -2.128564, -0.8591729, 1.648722, 2.121518, 2.248631, 0.4188413,
           -1.82449, -2.199676, -2.34991, -0.271877, 1.86833],
    8000: [1.344186, 1.779889, 1.139667, -1.089145, -1.976081, -2.128587, -0.859162, 1.648891, 2.121536, 2.248634, 0.4187292,
           -1.824606, -2.199679, -2.349911, -0.2716526, 1.868408],
}  # fmt: skip


@pytest.mark.prove
def test_the_material_of_opensees_goes_to_it_at_first_order() -> None:
    """Backward Euler; strain (1 + s/2) sin(pi s/2), s the quarters of a cycle."""
    s = np.arange(8 * 4000 + 1) / 4000
    strain = (1.0 + 0.5 * s) * np.sin(0.5 * np.pi * s)
    ours = Damper([from_opensees(**BWBN)]).force(s, strain, voltage=0.0, velocity=np.zeros(s.size))[2000::2000]
    coarse, fine = (np.array(stress) for stress in STRESS.values())
    np.testing.assert_allclose(2.0 * fine - coarse, ours, atol=3e-6)
    assert np.abs(fine - ours).max() == pytest.approx(0.5 * np.abs(coarse - ours).max(), rel=0.01)
    assert np.abs(coarse - ours).max() > 1e-4


@pytest.mark.usefixtures("plain")
def test_of_opensees_its_first_stresses_are_met_in_few_steps() -> None:
    s = np.arange(0.0, 2.0 + 1e-9, 1 / 64)
    strain = (1.0 + 0.5 * s) * np.sin(0.5 * np.pi * s)
    ours = Damper([from_opensees(**BWBN)]).force(s, strain, voltage=0.0, velocity=np.zeros(s.size))[32::32]
    np.testing.assert_allclose(ours, 2.0 * np.array(STRESS[8000][:4]) - np.array(STRESS[4000][:4]), atol=1e-3)


@pytest.mark.usefixtures("plain")
def test_without_wear_it_is_bouc_wen_whatever_the_step() -> None:
    x = 0.004 * np.random.default_rng(0).standard_normal(60)
    plain = Damper("bouc_wen", {f"bouc_wen.{key}": value for key, value in (SHAPE | {"c0": 0.0}).items()})
    expected = plain.force(np.arange(60.0), x - x[0], voltage=0.0, velocity=np.zeros(60))
    np.testing.assert_allclose(along(x - x[0], zetas=0.0, deltanu=0.0, deltaeta=0.0), expected, atol=1e-9)


@pytest.mark.prove
def test_it_stays_within_its_limit_and_takes_work_from_rest() -> None:
    for seed in range(3):
        nodes = np.append(0.0, 0.004 * np.random.default_rng(seed).standard_normal(60))
        coarse = along(nodes) - SHAPE["k0"] * nodes
        assert np.abs(coarse).max() <= SHAPE["kw"] * (1.0 + 1e-12)
        x = np.interp(np.linspace(0.0, 60.0, 60_001), np.arange(61.0), nodes)
        force = along(x) - SHAPE["k0"] * x
        assert np.min(np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(x))) >= -1e-9


def test_the_flow_from_beyond_its_limit_meets_that_from_within_and_has_its_derivatives() -> None:
    n, c = 1.6, 0.4
    for y in (-1.002, -0.9999, -0.3, 0.5, 0.9999, 1.002):
        for xi in (1e-4, 0.02, 0.7, 3.0):
            at = (y, xi, n, c)
            end = falling_flow(*at)
            if abs(y) > 1.0:
                s = np.sign(y)
                rate = solve_ivp(
                    lambda _, z: 1.0 - np.abs(z) ** n * (1.0 if z[0] > 0 else -c),
                    (0.0, xi),
                    [y],
                    rtol=1e-11,
                    atol=1e-13,
                )
                assert end == pytest.approx(rate.y[0, -1], abs=5e-6), (y, xi, s)
            for k, slope in enumerate((falling_by_y, falling_by_xi, falling_by_n, falling_by_c)):
                h = 1e-6
                up, down = (
                    falling_flow(*(value + sign * h * (i == k) for i, value in enumerate(at))) for sign in (1, -1)
                )
                assert slope(end, *at) == pytest.approx((up - down) / (2 * h), abs=2e-6, rel=1e-5), (y, xi, k)


def test_the_numbers_of_opensees_are_converted_or_refused() -> None:
    one = from_opensees(**(BWBN | {"gamma": 0.1, "beta": 0.3, "Ao": 0.8}))
    z_max = 2.0 ** (1 / 1.5)
    assert one.kw == pytest.approx(1.9 * z_max)
    assert one.rho * one.kw == pytest.approx(1.9 * 0.8)
    assert one.sigma == pytest.approx(0.75)
    assert one.k0 == pytest.approx(0.1)
    for bad in ({"beta": -0.4}, {"gamma": -0.7}, {"alpha": 1.0}, {"Ao": 0.0}):
        with pytest.raises(InputError, match="must be greater than 0"):
            from_opensees(**(BWBN | bad))


@pytest.mark.prove
def test_a_fit_of_six_sines_gives_the_numbers_back() -> None:
    assert_found_again(NAME, NUMBERS)
