"""Lyapunov's law: its matrix solves the linear equations written out here."""

import numpy as np
import pytest
from tests.structures.control.sensed_signals import sensed

from dampyr.structures import two_storey
from dampyr.structures.propagator import system


def test_lyapunovs_matrix_solves_its_linear_equations():
    building, weights = two_storey(), (2e3, 1e3, 3.0, 5.0)
    a, _, b = system(building, building.connection(2)[None])
    whole = np.kron(a.T, np.eye(4)) + np.kron(np.eye(4), a.T)
    p = np.linalg.solve(whole, -np.diag(weights).ravel()).reshape(4, 4)
    assert sensed("lyapunov", 2, weights=weights) == pytest.approx([*(-b.T @ p)[0], 0.0], rel=1e-9)
