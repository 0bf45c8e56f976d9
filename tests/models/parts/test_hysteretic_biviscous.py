# Wereley, Pang and Park, Idealized hysteresis modeling of ER and MR dampers, J. Intell. Mater. Syst. Struct. 9 (1998) 642.
"""The hysteretic biviscous model against the six branches of the source."""

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.identification import fit
from dampyr.models import Damper

C, FY, VY, VH = 500.0, 120.0, 0.012, 0.006


def damper() -> Damper:
    name = "hysteretic_biviscous"
    return Damper(name, {f"{name}.c": C, f"{name}.fy": FY, f"{name}.vy": VY, f"{name}.vh": VH})


def published(v: np.ndarray, rising: np.ndarray) -> np.ndarray:
    """The six branches in the letters of the source: Cpo, Cpr, Fy, v0, v1, v2."""
    pre = C + FY / VY
    v0 = VH * (pre - C) / pre
    v1, v2 = (FY - pre * v0) / (pre - C), (FY + pre * v0) / (pre - C)
    up = np.where(v <= -v1, C * v - FY, np.where(v <= v2, pre * (v - v0), C * v + FY))
    down = np.where(v >= v1, C * v + FY, np.where(v >= -v2, pre * (v + v0), C * v - FY))
    return np.where(rising, up, down)


@pytest.mark.parametrize("per_cycle", [16, 1000])
def test_a_cycle_that_yields_follows_the_published_branches(per_cycle: int) -> None:
    omega, V = 3.0, VY + VH
    phase = np.arange(3 * per_cycle + 1) / per_cycle * 2 * np.pi
    v = V * np.sin(phase)
    force = damper().force(phase / omega, -V / omega * np.cos(phase), voltage=0.0, velocity=v)
    last = slice(2 * per_cycle + 1, 3 * per_cycle)
    expected = published(v, np.cos(phase) > 0)
    turns = np.abs(np.cos(phase)) < 1e-9
    np.testing.assert_allclose(force[last][~turns[last]], expected[last][~turns[last]], atol=1e-9)


def test_the_force_is_continuous_where_a_small_cycle_turns() -> None:
    t = np.linspace(0.0, 6.0, 60_001)
    v = 0.8 * VY * np.sin(3.0 * t)
    force = damper().force(t, np.cumsum(v) * 1e-4, voltage=0.0, velocity=v)
    assert np.abs(np.diff(force)).max() < 1.01 * (C + FY / VY) * np.abs(np.diff(v)).max()


@pytest.mark.prove
def test_a_fit_gives_the_parameters_back() -> None:
    fit_result = fit(sine(damper(), 0.0), "hysteretic_biviscous")
    assert fit_result.converged, fit_result.reason
    assert list(fit_result.parameters.values()) == pytest.approx([C, FY, VY, VH], rel=1e-4)
