"""Dampers and references that the tests of this room share."""

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest

from dampyr.models import Damper, Polynomial
from dampyr.structures import Building, shear_building


def _law(*coefficients: float) -> Polynomial:
    return Polynomial(coefficients, low=0.0, high=3.212)


@pytest.fixture(scope="session")
def cubics() -> Damper:
    """The published cubics (4.6)-(4.8) of Raminelli (2020), N s/mm, N, 1/mm turned into SI."""
    return Damper(
        "dahl",
        {
            "dahl.kx": _law(802.0, 493.1, 34.2, 85.5),
            "dahl.kw": _law(50.237, 201.92, -24.866, 3.6157),
            "dahl.rho": _law(42745.0, -39038.0, 17881.0, -2836.8),
        },
    )


@pytest.fixture(scope="session")
def tangent() -> Damper:
    """A rate-dependent damper without memory."""
    values = {"c": 2100.0, "ft": 409.0, "v0": 0.0086, "s": 0.46}
    return Damper("hyperbolic_tangent", {f"hyperbolic_tangent.{k}": v for k, v in values.items()})


@pytest.fixture(scope="session")
def late() -> Damper:
    """A Dahl damper with a delay that divides no step."""
    return Damper("dahl + delay", {"dahl.kx": 2500.0, "dahl.kw": 380.0, "dahl.rho": 13000.0, "delay.tau": 0.0073})


def _stiff(
    building: Building, motion: SimpleNamespace, sites: list[tuple[int, Callable, Callable]], until: float
) -> np.ndarray:
    """Peak displacements (n,) of the plain equations, by scipy's Radau between samples of the motion.

    ``sites``: (storey, rate(w, v), force(w, x, v)) of each damper, one state each. Peaks at 401 points of
    the dense output of every sample interval.
    """
    from scipy.integrate import solve_ivp

    n = building.n
    rows = [building.connection(storey) for storey, _, _ in sites]
    minv = np.linalg.inv(building.M)
    steps = round(until / motion.dt)
    y, peak = np.zeros(2 * n + len(sites)), np.zeros(n)
    for k in range(steps):
        a0, a1 = motion.acceleration[k], motion.acceleration[k + 1]

        def rhs(t: float, y: np.ndarray, a0: float = a0, a1: float = a1) -> np.ndarray:
            q, v, w = y[:n], y[n : 2 * n], y[2 * n :]
            pull = -building.K @ q - building.C @ v
            dw = np.empty(len(sites))
            for d, (_, rate, force) in enumerate(sites):
                pull = pull - rows[d] * force(w[d], rows[d] @ q, rows[d] @ v)
                dw[d] = rate(w[d], rows[d] @ v)
            return np.concatenate([v, minv @ pull - (a0 + (a1 - a0) * t / motion.dt), dw])

        done = solve_ivp(
            rhs,
            (0.0, motion.dt),
            y,
            "Radau",
            rtol=1e-8,
            atol=1e-11,
            max_step=motion.dt / 4,
            dense_output=True,
        )
        assert done.success
        inside = done.sol(np.linspace(0, motion.dt, 401))
        peak = np.maximum(peak, np.abs(inside[:n]).max(axis=1))
        y = done.y[:, -1]
    return peak


@pytest.fixture(scope="session")
def stiff_reference() -> Callable:
    """An independent reference: the plain ODE, integrated in time by scipy."""
    return _stiff


@pytest.fixture(scope="session")
def building() -> Building:
    """A building of three floors with names."""
    bare = shear_building([150.0, 140.0, 120.0], [140e3, 110e3, 80e3], damping_ratio=0.03)
    return Building(bare.M, bare.C, bare.K, "three floors", floors=("low", "middle", "top"))
