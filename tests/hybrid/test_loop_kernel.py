"""The loop, sample by sample, against scipy's."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal
from tests.hybrid.by_scipy import RATE, ByScipy, FilterByScipy, agree, ideal

from dampyr.ground_motions import GroundMotion
from dampyr.hybrid import (
    PhaseLeadCompensator,
    PhysicalSubstructure,
    TransferSystem,
    perform_virtual,
)
from dampyr.structures import Building


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_the_loop_with_the_sample_controller_is_scipys(building: Building, motion: GroundMotion, delay: int) -> None:
    by_scipy = ByScipy(building, motion)
    lead = FilterByScipy(*signal.bilinear([50.83163360273612, 8570.397339444286], [1.0, 8570.397339444286], RATE))
    pi = FilterByScipy(*signal.bilinear([2.0, 95.0], [1.0, 0.0], RATE))
    floors, x = by_scipy.run(lambda target, own: pi(lead(target) - own), delay)
    run = perform_virtual(ideal(building, force_delay=delay), PhaseLeadCompensator(), motion)
    assert np.max(np.abs(x)) > 1e-4
    agree(run.floors, floors)
    agree(run.displacement, x)


def test_a_planted_error_is_noticed_by_the_comparison_with_scipy(building: Building, motion: GroundMotion) -> None:
    lead = FilterByScipy(*signal.bilinear([50.83163360273612, 8570.397339444286], [1.0, 8570.397339444286], RATE))
    pi = FilterByScipy(*signal.bilinear([2.0, 95.0], [1.0, 0.0], RATE))
    floors, _ = ByScipy(building, motion).run(lambda target, own: pi(lead(target) - own), 1)
    t = TransferSystem(max_force=np.inf)
    for planted in (
        ideal(building, force_delay=0),
        ideal(building, transfer=replace(t, beta1=426.0)),
        ideal(building, transfer=replace(t, pole=3.4)),
        ideal(building, specimen=PhysicalSubstructure(damping_ratio=0.0098)),
    ):
        with pytest.raises(AssertionError):
            agree(perform_virtual(planted, PhaseLeadCompensator(), motion).floors, floors)
