"""The adaptive compensators against their equations in plain numpy."""

import numpy as np
import pytest
from matplotlib import pyplot
from scipy import signal
from tests.hybrid.by_scipy import RATE, ByScipy, FilterByScipy, agree, ideal

from dampyr.ground_motions import GroundMotion
from dampyr.hybrid import (
    KalmanCompensator,
    ModelBasedCompensator,
    perform_virtual,
)
from dampyr.hybrid.compensators import inverse_coefficients
from dampyr.structures import Building


@pytest.mark.parametrize("kalman", [False, True])
def test_the_adaptive_loops_are_their_equations(building: Building, motion: GroundMotion, kalman: bool) -> None:
    setup = ideal(building)
    own = KalmanCompensator.designed(setup, lead=0.5) if kalman else ModelBasedCompensator()
    powers = RATE ** np.arange(5)
    start = np.array(own.start)
    theta, P = start.copy(), np.diag(start) @ np.array(getattr(own, "covariance", np.eye(4))) @ np.diag(start)
    low = signal.butter(4, 20.0, fs=RATE)
    smooth_x, smooth_u = FilterByScipy(*low), FilterByScipy(*low)
    targets, measured = np.zeros(5), np.zeros(4)
    derivatives = np.array([np.pad(np.atleast_1d(np.poly(np.ones(i))), (0, 4 - i)) for i in range(5)]) * powers[:, None]

    def command(target: float, displacement: float) -> float:
        nonlocal targets, measured, theta, P
        targets = np.concatenate([[target], targets[:-1]])
        d = derivatives @ targets
        u = theta @ (d[:4] + (0.5 / RATE * d[1:] if kalman else 0.0))
        measured = np.concatenate([[smooth_x(displacement)], measured[:-1]])
        phi = derivatives[:4, :4] @ measured
        error = smooth_u(u) - theta @ phi
        if kalman:
            g = P @ phi
            theta, P = theta + g * error / (own.noise**2 + phi @ g), P - np.outer(g, g) / (own.noise**2 + phi @ g)
        else:
            theta = np.maximum(0.0, theta + np.array(own.gains) / RATE * error / (1 + phi @ phi) * phi)
        return float(u)

    floors, x = ByScipy(building, motion).run(command, 1, own.extrapolation)
    run = perform_virtual(setup, own, motion)
    assert np.max(np.abs(run.theta[-1] / run.theta[0] - 1.0)) > 0.005
    agree(run.floors, floors, 1e-6)
    agree(run.displacement, x, 1e-6)
    np.testing.assert_allclose(run.theta[-1] * (start if kalman else 1.0), theta, rtol=0.02)


def test_a_matched_inverse_follows(building: Building, motion: GroundMotion) -> None:
    """theta of the actual plant, no noise: what the order of the inverse leaves is 0.3 % of the target."""
    setup = ideal(building)
    fixed = ModelBasedCompensator(start=tuple(inverse_coefficients(setup)), gains=(0.0, 0.0, 0.0, 0.0))
    quiet = GroundMotion(np.sin(2 * np.pi * 3.6 * np.arange(400) * 0.01), 0.01)
    run = perform_virtual(setup, fixed, quiet)
    assert run.criteria().J2 < 0.3
    [panel] = run.plot()
    whole, test = (line for line in panel.lines if len(line.get_xdata()) > 1)
    drawn = {line.get_label().partition(":")[0]: np.abs(line.get_ydata()).max() for line in (whole, test)}
    assert list(drawn) == ["whole, computed", "hybrid test"]
    np.testing.assert_allclose(
        [*drawn.values()], 1e3 * np.abs([run.reference[-1], run.floors[-1]]).max(axis=1), rtol=1e-12
    )
    pyplot.close(panel.figure)
