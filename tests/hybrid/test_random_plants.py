"""Many plants: each is the single test, in however many threads."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.hybrid import (
    HybridSetup,
    KalmanCompensator,
    PhaseLeadCompensator,
    perform_virtual,
    run_many,
)
from dampyr.hybrid.random_plants import draw_plants
from dampyr.hybrid.setup import IDEAL
from dampyr.structures import Building


class TestManyPlants:
    def test_each_plant_is_the_single_test(self, building: Building, motion: GroundMotion) -> None:
        setup = HybridSetup(building, sensors=IDEAL)
        compensator = KalmanCompensator.designed(setup)
        batch = run_many(setup, compensator, motion, 3, seed=5, workers=2)
        plants = draw_plants(setup, 3, 5)
        np.testing.assert_array_equal(batch.plants, plants)
        alone = perform_virtual(setup.with_plant(*plants[1]), compensator, motion)
        np.testing.assert_allclose(batch.true[1], alone.criteria(), rtol=1e-9)
        assert batch.radius[1] == pytest.approx(alone.stability.radius, rel=1e-12)
        assert batch.unstable == 0

    def test_threads_change_nothing(self, building: Building, motion: GroundMotion) -> None:
        setup = HybridSetup(building)
        one, three = (run_many(setup, PhaseLeadCompensator(), motion, 4, workers=w) for w in (1, 3))
        np.testing.assert_array_equal(one.true, three.true)
        np.testing.assert_array_equal(one.measured, three.measured)
        assert np.ptp(one.true[:, 1]) > 0.0

    def test_the_worst_is_named_and_shown(self, building: Building, motion: GroundMotion) -> None:
        batch = run_many(HybridSetup(building), PhaseLeadCompensator(), motion, 3)
        assert batch.worst("J4") == int(np.argmax(batch.true[:, 3]))
        assert "3" in repr(batch)
        assert list(batch.to_dataframe()["J2"]) == list(batch.true[:, 1])
        with pytest.raises(InputError, match="'J10' is not a criterion"):
            batch.worst("J10")

    def test_an_unstable_plant_is_counted(self, building: Building, motion: GroundMotion) -> None:
        batch = run_many(HybridSetup(building), PhaseLeadCompensator(kp=40.0), motion, 2)
        assert batch.unstable == 2
