"""Ground motions that the tests of ensembles share."""

import pytest

from dampyr.ground_motions import GroundMotion, el_centro, kanai_tajimi


@pytest.fixture(scope="session")
def motions() -> list[GroundMotion]:
    """Of different lengths, so that lanes end at different times."""
    return [
        el_centro(),
        kanai_tajimi(duration=8.0, dt=0.02, seed=1, pga=3.0),
        kanai_tajimi(8.0, dt=0.01, seed=2, pga=2.0),
    ]
