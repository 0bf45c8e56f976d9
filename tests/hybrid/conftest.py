"""The building and the motion of virtual hybrid tests."""

import numpy as np
import pytest
from tests.hybrid.by_scipy import K, M

from dampyr.ground_motions import GroundMotion
from dampyr.structures import Building
from dampyr.structures.damping import modal


@pytest.fixture(scope="session")
def building() -> Building:
    return Building(M, modal(M, K, 0.05), K, "frame")


@pytest.fixture(scope="session")
def motion() -> GroundMotion:
    """Two seconds whose samples do not fall on those of the loop."""
    return GroundMotion(np.random.default_rng(3).normal(0.0, 1.0, 201), 0.01, "noise")
