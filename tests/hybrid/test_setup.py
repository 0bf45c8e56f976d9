"""Set-ups that cannot be are refused with the reason."""

import pytest
from tests.hybrid.by_scipy import ideal

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.hybrid import (
    HybridSetup,
    KalmanCompensator,
    ModelBasedCompensator,
    PhaseLeadCompensator,
    PhysicalSubstructure,
    TransferSystem,
    perform_virtual,
)
from dampyr.hybrid.random_plants import draw_plants
from dampyr.structures import Building


class TestRefusals:
    def test_a_specimen_that_is_more_than_the_structure(self, building: Building) -> None:
        with pytest.raises(InputError, match=r"without the specimen cannot stand by itself.*less mass"):
            HybridSetup(building, PhysicalSubstructure(mass=2000.0))
        with pytest.raises(InputError, match="cannot stand by itself"):
            HybridSetup(building, PhysicalSubstructure(stiffness=5e7))

    @pytest.mark.parametrize(
        ("make", "says"),
        [
            (lambda b: PhysicalSubstructure(mass=-1.0), "mass = -1.0 kg is not allowed"),
            (lambda b: PhysicalSubstructure(stiffness=float("nan")), "stiffness = nan N/m"),
            (lambda b: TransferSystem(gain=0.0), "gain = 0.0"),
            (lambda b: HybridSetup(b, rate=0.0), "rate = 0.0 Hz"),
            (lambda b: HybridSetup(b, force_delay=-1), "force_delay = -1"),
            (lambda b: HybridSetup(b, place=4), "storey 4 is not in frame"),
            (lambda b: PhaseLeadCompensator(kp=-1.0), "kp = -1"),
            (lambda b: ModelBasedCompensator(start=(1.0, 2.0)), "must be 4 finite numbers"),
            (lambda b: KalmanCompensator.designed(HybridSetup(b), noise=0.0), "noise = 0"),
            (lambda b: draw_plants(HybridSetup(b), 0), "0 plants cannot be drawn"),
        ],
    )
    def test_a_wrong_value(self, building: Building, make: object, says: str) -> None:
        with pytest.raises(InputError, match=says):
            make(building)  # type: ignore[operator]

    def test_a_specimen_between_two_floors_has_no_floor_to_compare(
        self, building: Building, motion: GroundMotion
    ) -> None:
        run = perform_virtual(
            ideal(building, place=2, specimen=PhysicalSubstructure(stiffness=1e5)), _matched(building), motion
        )
        with pytest.raises(InputError, match="storey 2 is not held to the ground"):
            run.criteria()


def _matched(building: Building) -> KalmanCompensator:
    return KalmanCompensator.designed(ideal(building, place=2, specimen=PhysicalSubstructure(stiffness=1e5)))
