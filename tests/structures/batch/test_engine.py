"""An engine of blocks of histories is told its steps."""

from __future__ import annotations

import numpy as np
import pytest

from dampyr.ground_motions import el_centro
from dampyr.models import Damper
from dampyr.structures import two_storey
from dampyr.structures.batch.assemble import QUANTITIES
from dampyr.structures.batch.engine import engine
from dampyr.structures.ensembles.ensemble_grid import cases
from dampyr.structures.sites import connections

pytestmark = pytest.mark.filterwarnings("ignore:.*was calibrated:dampyr.errors.DampyrWarning")


def test_an_engine_is_told_its_steps(cubics: Damper) -> None:
    """Half the step moves the peaks by less than the fourth order allows."""
    site = cases(two_storey(), el_centro(), cubics, [0.0], [1.0]).sites_of(0, 0, 0)
    rows = connections(two_storey(), site)
    peaks = []
    for m in (4, 8, 16):
        one = engine(two_storey(), rows, (site[0].composition,), 0.02, m, QUANTITIES)
        peaks.append(
            one.run([el_centro().acceleration], [site[0].values[None]], np.zeros((1, 1)))["displacement"][0, 0]
        )
    assert abs(peaks[1] - peaks[2]) < abs(peaks[0] - peaks[2]) < 1e-3 * peaks[2]
