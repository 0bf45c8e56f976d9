"""A virtual hybrid test: its reference, noise, converters and the actuator's greatest force."""

import numpy as np
import pytest
from scipy import signal
from tests.hybrid.by_scipy import RATE, K, agree, ideal

from dampyr.ground_motions import GroundMotion
from dampyr.hybrid import (
    HybridSetup,
    PhaseLeadCompensator,
    TransferSystem,
    perform_virtual,
)
from dampyr.structures import Building


def test_the_reference_is_the_linear_response(building: Building, motion: GroundMotion) -> None:
    run = perform_virtual(ideal(building), PhaseLeadCompensator(), motion)
    a = np.block([[np.zeros((3, 3)), np.eye(3)], [-K / 1000.0, -building.C / 1000.0]])
    b = np.concatenate([np.zeros(3), -np.ones(3)])[:, None]
    _, y, _ = signal.lsim((a, b, np.eye(6)[:3], np.zeros((3, 1))), run.ground, run.time)
    agree(run.reference, y.T)


class TestSensors:
    def test_noise_has_its_power_and_its_seed(self, building: Building, motion: GroundMotion) -> None:
        setup = HybridSetup(building)
        first, again, other = (perform_virtual(setup, PhaseLeadCompensator(), motion, seed) for seed in (1, 1, 2))
        noise = first.measured - first.displacement
        assert noise.std() == pytest.approx(np.sqrt(6.25e-14 * RATE), rel=0.05)
        np.testing.assert_array_equal(first.displacement, again.displacement)
        assert np.max(np.abs(first.displacement - other.displacement)) > 0.0

    def test_converters_have_steps(self, building: Building, motion: GroundMotion) -> None:
        run = perform_virtual(HybridSetup(building), PhaseLeadCompensator(), motion)
        counts = run.command * 2**18
        np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)

    def test_the_actuator_ends_at_its_force_and_says_how_often(self, building: Building, motion: GroundMotion) -> None:
        free = perform_virtual(HybridSetup(building), PhaseLeadCompensator(), motion)
        limit = 0.5 * float(np.max(np.abs(free.force)))
        weak = HybridSetup(building, transfer=TransferSystem(max_force=limit))
        run = perform_virtual(weak, PhaseLeadCompensator(), motion)
        assert free.at_limit == 0
        assert run.at_limit > 10
        assert np.max(np.abs(run.force)) <= limit
