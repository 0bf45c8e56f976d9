# Maxwell's element: a dashpot and a spring in series; a sine, a step, and a building beside scipy's solution.
"""A compliance in series: closed forms, and a building with a brace that gives way."""

import numpy as np
import pytest
from scipy.signal import StateSpace, lsim
from tests.identification.synthetic import sine

from dampyr.ground_motions import el_centro
from dampyr.identification import fit
from dampyr.models import Damper
from dampyr.structures import respond, two_storey

DASHPOT = {
    "hyperbolic_tangent.c": 2000.0,
    "hyperbolic_tangent.ft": 0.0,
    "hyperbolic_tangent.v0": 1.0,
    "hyperbolic_tangent.s": 0.0,
}


@pytest.mark.usefixtures("plain")
def test_a_dashpot_with_compliance_is_maxwells_element() -> None:
    s, omega, reach = 8e-6, 12.0, 0.01
    damper = Damper("hyperbolic_tangent + compliance", DASHPOT | {"compliance.s": s})
    errors = []
    for n in (4001, 8001):
        t = np.linspace(0.0, 4.0, n)
        ours = damper.force(t, reach * np.sin(omega * t), voltage=0.0, velocity=reach * omega * np.cos(omega * t))
        size = 2000.0 * omega * reach / np.hypot(1.0, 2000.0 * s * omega)
        exact = size * np.cos(omega * t - np.arctan(2000.0 * s * omega))
        errors.append(np.abs(ours - exact)[n // 2 :].max() / size)
    assert errors[0] < 6e-3
    assert errors[1] == pytest.approx(0.5 * errors[0], rel=0.05)  # of first order in the step


@pytest.mark.usefixtures("plain")
def test_without_compliance_it_is_the_damper_itself() -> None:
    laws = {"dahl.kx": 800.0, "dahl.kw": 90.0, "dahl.rho": 3000.0}
    t = np.linspace(0.0, 3.0, 700)
    x = 0.008 * np.sin(5 * t)
    rigid = Damper("dahl", laws).force(t, x, voltage=0.0)
    same = Damper("dahl + compliance", laws | {"compliance.s": 0.0}).force(t, x, voltage=0.0)
    np.testing.assert_allclose(same[1:], rigid[1:], atol=1e-9)


@pytest.mark.usefixtures("plain")
def test_a_spring_in_series_with_a_spring() -> None:
    damper = Damper("spring + compliance", {"spring.k0": 4e4, "compliance.s": 2.5e-5})
    t = np.linspace(0.0, 1.0, 50)
    x = 0.01 * np.sin(6 * t)
    np.testing.assert_allclose(damper.force(t, x, voltage=0.0), x / (1 / 4e4 + 2.5e-5), atol=1e-9)


@pytest.mark.prove
def test_a_building_with_a_dashpot_on_a_brace_that_gives_way() -> None:
    building, motion, c, s = two_storey(), el_centro(), 300.0, 2e-5
    ours = respond(
        building,
        motion,
        dampers={
            1: Damper("hyperbolic_tangent + compliance", DASHPOT | {"hyperbolic_tangent.c": c, "compliance.s": s})
        },
        voltage=0.0,
    )
    A, M = np.zeros((5, 5)), building.M
    A[:2, 2:4] = np.eye(2)
    A[2:4, :2], A[2:4, 2:4] = -np.linalg.solve(M, building.K), -np.linalg.solve(M, building.C)
    A[2:4, 4] = -np.linalg.solve(M, [1.0, 0.0])
    A[4, 2], A[4, 4] = 1.0 / s, -1.0 / (s * c)  # s F' + F / c = v
    B = np.array([0.0, 0.0, -1.0, -1.0, 0.0])[:, None]
    _, expected, _ = lsim(StateSpace(A, B, np.eye(5)[:2], np.zeros((2, 1))), motion.acceleration, motion.time)
    np.testing.assert_allclose(ours.displacement, expected.T, atol=1.2e-3 * np.abs(expected).max())
    assert ours.accuracy is not None


@pytest.mark.prove
def test_a_fit_gives_it_back() -> None:
    laws = {"dahl.kx": 900.0, "dahl.kw": 150.0, "dahl.rho": 9000.0, "compliance.s": 1.5e-6}
    record = sine(Damper("dahl + compliance", laws), 0.0, noise=0.5)
    fit_result = fit(record, "dahl + compliance")
    assert fit_result.converged, fit_result.reason
    for name, value in laws.items():
        assert fit_result.parameters[name] == pytest.approx(value, abs=5 * fit_result.stderr[name] + 0.01 * value)
