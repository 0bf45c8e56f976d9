"""The verdict on a loop before it runs: it agrees with runs on both sides of the boundary."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.hybrid import (
    HybridSetup,
    KalmanCompensator,
    ModelBasedCompensator,
    PhaseLeadCompensator,
    TransferSystem,
    loop_stability,
    perform_virtual,
)
from dampyr.hybrid.compensators import Compensator
from dampyr.hybrid.setup import IDEAL
from dampyr.structures import Building
from dampyr.structures.damping import modal

K = np.array([[26e6, -23e6, 6e6], [-23e6, 32.5e6, -14.4e6], [6e6, -14.4e6, 9.3e6]])
M = 1000.0 * np.eye(3)
KICK = GroundMotion(np.concatenate([[0.0, 0.1, 0.0], np.zeros(797)]), 0.01, "kick")


def ideal(damping_ratio: float, force_delay: int = 1) -> HybridSetup:
    building = Building(M, modal(M, K, damping_ratio), K, "frame")
    return HybridSetup(building, transfer=TransferSystem(max_force=np.inf), sensors=IDEAL, force_delay=force_delay)


def growth_of_a_run(setup: HybridSetup, compensator: Compensator) -> float:
    """1/s, from the peaks of the specimen's displacement in the run's third and last quarter."""
    run = perform_virtual(setup, compensator, KICK, check=False)
    quarter = len(run.displacement) // 4
    third, last = (np.max(np.abs(run.displacement[k * quarter : (k + 1) * quarter])) for k in (2, 3))
    return float(np.log(last / third) / (quarter * setup.dt))


def boundary(lower: float, upper: float) -> float:
    """The damping ratio at which the loop with the sample controller is neither stable nor unstable."""
    for _ in range(30):
        middle = 0.5 * (lower + upper)
        if loop_stability(ideal(middle), PhaseLeadCompensator()).stable:
            upper = middle
        else:
            lower = middle
    return upper


def test_a_loop_that_delays_needs_damping_and_the_verdict_says_how_much() -> None:
    limit = boundary(0.001, 0.05)
    assert 0.01 < limit < 0.03
    for factor in (0.8, 1.25):
        verdict = loop_stability(ideal(factor * limit), PhaseLeadCompensator())
        assert verdict.stable == (factor > 1.0)
        measured = growth_of_a_run(ideal(factor * limit), PhaseLeadCompensator())
        assert measured == pytest.approx(verdict.growth, rel=0.1, abs=0.01)
        assert np.sign(measured) == np.sign(verdict.growth)


def test_an_unstable_set_up_is_refused_with_the_reason_and_diverges_where_it_is_run() -> None:
    setup = ideal(0.05)
    wild = PhaseLeadCompensator(kp=40.0)
    with pytest.raises(
        InputError, match=r"frame was not run: the loop is unstable: its mode at [\d.]+ Hz grows by"
    ) as said:
        perform_virtual(setup, wild, KICK)
    assert "take a compensator that delays less" in str(said.value)
    run = perform_virtual(setup, wild, KICK, check=False)
    assert run.diverged
    assert "diverged" in repr(run)
    with pytest.raises(InputError, match="the run diverged at"):
        run.criteria()


def test_a_compensator_that_does_not_delay_needs_little_damping() -> None:
    setup = ideal(0.005)
    assert not loop_stability(setup, PhaseLeadCompensator()).stable
    for compensator in (KalmanCompensator.designed(setup), KalmanCompensator.designed(setup, lead=0.5)):
        verdict = loop_stability(setup, compensator)
        assert verdict.stable
        assert "slowest mode, at 3.9" in verdict.reason


def test_a_start_that_is_unstable_is_said_and_adapts() -> None:
    setup = ideal(0.01)
    verdict = loop_stability(setup, ModelBasedCompensator())
    assert verdict.stable
    assert verdict.start_radius > 1.0
    assert "with the published start it is not" in verdict.reason
    assert not perform_virtual(setup, ModelBasedCompensator(), KICK).diverged
    fixed = ModelBasedCompensator(gains=(0.0,) * 4)
    assert growth_of_a_run(setup, fixed) == pytest.approx(np.log(verdict.start_radius) * setup.rate, rel=0.1)


@pytest.mark.parametrize("delay", [0, 1, 4])
def test_a_later_force_takes_damping_and_extrapolation_gives_it_back(delay: int) -> None:
    """Held force and delay take (delay + 1/2) samples of phase: k tau / m of damping."""
    setup = ideal(0.03, delay)
    bare = loop_stability(setup, KalmanCompensator.designed(setup, extrapolation=0.0))
    extrapolated = loop_stability(setup, KalmanCompensator.designed(setup))
    omega, modes = setup.structure.modes()
    whole = -0.03 * np.sqrt(omega[0])
    lost = 0.5 * setup.specimen.stiffness * modes[0, 0] ** 2 * (delay + 0.5) * setup.dt
    assert extrapolated.growth == pytest.approx(whole, rel=0.02)
    assert bare.growth - extrapolated.growth == pytest.approx(lost, rel=0.05)
    assert growth_of_a_run(setup, KalmanCompensator.designed(setup)) == pytest.approx(whole, rel=0.1)
