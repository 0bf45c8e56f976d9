"""The building's step in the coordinates of its modes."""

from __future__ import annotations

import numpy as np
import pytest

from dampyr.ground_motions import el_centro
from dampyr.models import Damper
from dampyr.structures import Building, ensemble, shear_building
from dampyr.structures.batch.modal import classical_modes

pytestmark = pytest.mark.filterwarnings("ignore:.*was calibrated:dampyr.errors.DampyrWarning")


@pytest.mark.prove
@pytest.mark.parametrize("dashpot", [0.0, 2e3])  # in the second storey: with it the modes are complex
def test_modal_and_dense_agree(monkeypatch: pytest.MonkeyPatch, cubics: Damper, dashpot: float) -> None:
    classical = shear_building([1e3] * 5, [2e6] * 5, damping_ratio=0.03)
    row = classical.connection(2)
    building = Building(classical.M, classical.C + dashpot * np.outer(row, row), classical.K)
    assert (classical_modes(building) is None) == bool(dashpot)
    given = (building, el_centro(), {1: cubics, 3: cubics}, [1.0], [1.0, 2.0])
    modal = ensemble(*given).dataset
    monkeypatch.setattr("dampyr.structures.batch.engine.basis_of", lambda _: None)
    dense = ensemble(*given).dataset
    for quantity in modal.data_vars:
        np.testing.assert_allclose(modal[quantity], dense[quantity], rtol=1e-10)
