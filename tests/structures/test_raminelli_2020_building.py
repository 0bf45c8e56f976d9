"""The two buildings of the laboratory: their published frequencies and damping."""

import numpy as np
import pytest

from dampyr.structures import two_storey
from dampyr.structures.raminelli_2020_building import two_storey_model


def test_two_storey_is_the_published_building_in_si():
    building = two_storey()
    assert building.frequencies == pytest.approx([2.0856, 5.4603], abs=5e-5)
    assert building.damping_ratios == pytest.approx([0.030, 0.030], abs=5e-5)
    assert np.asarray(building.M)[0, 0] == pytest.approx(145.8)
    assert building.floors == ("1", "2")


def test_two_storey_damping_is_rayleigh():
    building = two_storey()
    fit, residual, *_ = np.linalg.lstsq(
        np.column_stack([building.M.ravel(), building.K.ravel()]), building.C.ravel(), rcond=None
    )
    assert fit == pytest.approx([0.5686, 0.001266], rel=1e-3)
    assert np.sqrt(residual[0]) < 1e-3 * np.linalg.norm(building.C)


def test_the_laboratory_model_has_storey_elements():
    model = two_storey_model()
    assert model.M.tolist() == [[24.3, 0.0], [0.0, 24.3]]
    assert model.K.tolist() == [[15040.0, -8220.0], [-8220.0, 8220.0]]
    np.testing.assert_allclose(model.C, [[1.229, -0.29], [-0.29, 0.29]], rtol=1e-14)
    # the roots of m^2 w^4 - m (k1 + 2 k2) w^2 + k1 k2 = 0
    root = np.sqrt((6820.0 + 2 * 8220.0) ** 2 - 4 * 6820.0 * 8220.0)
    square = np.array([6820.0 + 2 * 8220.0 - root, 6820.0 + 2 * 8220.0 + root]) / (2 * 24.3)
    assert model.frequencies == pytest.approx(np.sqrt(square) / (2 * np.pi), rel=1e-10)
    assert model.frequencies == pytest.approx([1.687, 4.626], abs=5e-4)
