# Kaliske and Rothert, Computational Mechanics 19 (1997) 228; the closed forms of linear viscoelasticity.
"""The generalised Maxwell model: relaxation, storage and loss of a sine, the exact step, passivity, and what a fit finds."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from tests.models.parts.found_again import assert_found_again, damper

from dampyr.models.parts._relaxation import phi_1, phi_1_derivative

NUMBERS = {"k0": 2e4, "k1": 1.5e4, "k2": 8e3, "k3": 1.2e4, "tau": 0.02}
K0, TAU = NUMBERS["k0"], NUMBERS["tau"]
ARMS = [(NUMBERS["k1"], TAU), (NUMBERS["k2"], 10 * TAU), (NUMBERS["k3"], 100 * TAU)]


def along(t: np.ndarray, x: np.ndarray, **changes: float) -> np.ndarray:
    return damper("generalised_maxwell", NUMBERS | changes).force(t, x, voltage=0.0, velocity=np.zeros(t.size))


@pytest.mark.usefixtures("plain")
def test_after_a_ramp_it_relaxes_as_its_prony_series() -> None:
    """After a ramp of T the arm holds k v tau (1 - exp(-T/tau)), and relaxes as exp(-t/tau)."""
    ramp, v = 0.05, 0.1
    t = np.array([0.0, ramp, ramp + 0.01, ramp + 0.3, ramp + 4.0, ramp + 90.0])
    x = v * np.minimum(t, ramp)
    expected = [
        K0 * v * ramp + sum(k * v * tau * -np.expm1(-ramp / tau) * np.exp(-(at - ramp) / tau) for k, tau in ARMS)
        for at in t[1:]
    ]
    np.testing.assert_allclose(along(t, x)[1:], expected, rtol=1e-12)
    assert along(t, x)[-1] == pytest.approx(K0 * v * ramp, rel=1e-9)


@pytest.mark.prove
def test_a_sine_meets_the_storage_and_loss_stiffness_of_the_closed_form() -> None:
    for omega in (1.0, 20.0, 300.0):
        n, cycles, period = 2_000, 40, 2 * np.pi / omega
        t = np.linspace(0.0, cycles * period, cycles * n + 1)
        A = 0.004
        x = A * np.sin(omega * t)
        start = np.zeros(t.size)
        force = along(t, x)
        wt = [omega * tau for _, tau in ARMS]
        for (k, tau), r in zip(ARMS, wt, strict=True):  # what the start from rest adds, which dies away
            start += k * -A * r / (1 + r * r) * np.exp(-t / tau)
        storage = K0 + sum(k * r * r / (1 + r * r) for (k, _), r in zip(ARMS, wt, strict=True))
        loss = sum(k * r / (1 + r * r) for (k, _), r in zip(ARMS, wt, strict=True))
        expected = A * (storage * np.sin(omega * t) + loss * np.cos(omega * t)) + start
        np.testing.assert_allclose(force, expected, atol=2e-6 * np.abs(expected).max())


@pytest.mark.usefixtures("plain")
def test_it_follows_the_equations_that_scipy_solves() -> None:
    t, taus = np.linspace(0.0, 3.0, 61), np.array([tau for _, tau in ARMS])
    x = np.cumsum(1e-3 * np.random.default_rng(1).standard_normal(t.size))
    x -= x[0]

    def rate(_: float, e: np.ndarray, v: float) -> np.ndarray:
        return v - e / taus

    e, expected = np.zeros(3), [0.0]
    for i in range(1, t.size):
        v = (x[i] - x[i - 1]) / (t[i] - t[i - 1])
        e = solve_ivp(rate, (t[i - 1], t[i]), e, "DOP853", args=(v,), rtol=1e-11, atol=1e-16).y[:, -1]
        expected.append(K0 * x[i] + float(e @ [k for k, _ in ARMS]))
    np.testing.assert_allclose(along(t, x), expected, rtol=1e-9, atol=1e-9)


@pytest.mark.prove
def test_a_cycle_of_any_path_takes_energy() -> None:
    rng = np.random.default_rng(2)
    for tau in (1e-4, 0.02, 5.0):
        nodes = 0.01 * rng.standard_normal(40)
        nodes[0] = nodes[-1] = 0.0
        t = np.linspace(0.0, 4.0, 40_001)
        x = np.interp(t, np.linspace(0.0, 4.0, 40), nodes)
        force = along(t, x, tau=tau)
        work = np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(x)) - 0.5 * K0 * x[1:] ** 2
        assert np.min(work) >= -1e-9  # from rest no more comes out than has gone in


def test_what_is_kept_of_a_stretch_is_smooth_across_the_change_of_formula() -> None:
    for turns in (1e-9, 5e-5, 0.999e-2, 1.001e-2, 0.3, 1.0, 40.0, 800.0):
        assert phi_1(turns) == pytest.approx(-np.expm1(-turns) / turns, rel=1e-13)
        slope = quad(lambda y, t=turns: -y * np.exp(-y * t), 0.0, 1.0, epsrel=1e-13, limit=200)[0]
        assert phi_1_derivative(phi_1(turns), turns) == pytest.approx(slope, rel=1e-11)
    assert phi_1(0.0) == 1.0


@pytest.mark.prove
def test_a_fit_of_six_sines_gives_the_numbers_back() -> None:
    assert_found_again("generalised_maxwell", NUMBERS)
