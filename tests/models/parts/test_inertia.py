# Smith, Synthesis of mechanical networks: the inerter, IEEE TAC 47 (2002) 1648; the building: scipy.signal.lsim.
"""An inertance along a record and in a building."""

import numpy as np
import pytest
from scipy.signal import StateSpace, lsim
from tests.identification.synthetic import sine

from dampyr.ground_motions import el_centro
from dampyr.identification import fit
from dampyr.models import Damper
from dampyr.structures import respond, two_storey


@pytest.mark.prove
def test_a_building_carries_it_as_mass_that_the_ground_does_not_shake() -> None:
    building, motion = two_storey(), el_centro()
    mass = 0.2 * float(building.M[0, 0])
    ours = respond(building, motion, dampers={1: Damper("inertia", {"inertia.m": mass})}, voltage=0.0)
    M = building.M + np.diag([mass, 0.0])
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, building.K), -np.linalg.solve(M, building.C)]])
    B = np.concatenate((np.zeros(2), -np.linalg.solve(M, building.M @ np.ones(2))))[:, None]
    _, expected, _ = lsim(StateSpace(A, B, np.eye(4)[:2], np.zeros((2, 1))), motion.acceleration, motion.time)
    np.testing.assert_allclose(ours.displacement, expected.T, atol=1e-6 * np.abs(expected).max())


@pytest.mark.prove
def test_a_fit_gives_the_mass_back() -> None:
    truth = Damper("dahl + inertia", {"dahl.kx": 600.0, "dahl.kw": 60.0, "dahl.rho": 900.0, "inertia.m": 4.0})
    fit_result = fit(sine(truth, 0.0), "dahl + inertia")
    assert fit_result.parameters["inertia.m"] == pytest.approx(4.0, rel=1e-4)
