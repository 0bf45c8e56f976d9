"""The loop of a virtual hybrid test against scipy and plain numpy, and what it says of itself."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

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
    run_many,
)
from dampyr.hybrid.compensators import inverse_coefficients
from dampyr.hybrid.random_plants import draw_plants
from dampyr.hybrid.setup import IDEAL
from dampyr.structures import Building
from dampyr.structures.damping import modal

K = np.array([[26e6, -23e6, 6e6], [-23e6, 32.5e6, -14.4e6], [6e6, -14.4e6, 9.3e6]])
M = 1000.0 * np.eye(3)
RATE = 4096.0


@pytest.fixture(scope="module")
def building() -> Building:
    return Building(M, modal(M, K, 0.05), K, "frame")


@pytest.fixture(scope="module")
def motion() -> GroundMotion:
    """Two seconds whose samples do not fall on those of the loop."""
    return GroundMotion(np.random.default_rng(3).normal(0.0, 1.0, 201), 0.01, "noise")


def ideal(building: Building, **changes: object) -> HybridSetup:
    changes = {"sensors": IDEAL, "transfer": TransferSystem(max_force=np.inf)} | changes
    return HybridSetup(building, **changes)  # type: ignore[arg-type]


class ByScipy:
    """Numerical part and plant of the ideal set-up, made from the published transfer functions by scipy alone."""

    def __init__(self, building: Building, motion: GroundMotion) -> None:
        m, k, zeta = 29.13, 1.19e6, 0.0097
        c = 2 * zeta * np.sqrt(k * m)
        first = np.diag([1.0, 0.0, 0.0])
        Mn, Cn, Kn = M - m * first, building.C - c * first, K - k * first
        a = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.linalg.solve(Mn, Kn), -np.linalg.solve(Mn, Cn)]])
        ground = np.concatenate([np.zeros(3), -np.linalg.solve(Mn, M @ np.ones(3))])[:, None]
        force = np.concatenate([np.zeros(3), -np.linalg.solve(Mn, first[:, 0])])[:, None]
        out = np.eye(6)
        self.a, self.bg, _, self.dg, _ = signal.cont2discrete((a, ground, out, np.zeros((6, 1))), 1 / RATE, "foh")
        self.af, self.bf, *_ = signal.cont2discrete((a, force, out, np.zeros((6, 1))), 1 / RATE, "zoh")
        # force from command, and displacement from force: one system with both outputs, from the polynomials
        specimen = np.array([m, c, k])
        valve, inner = np.array([1.0, 425.0, 9.9976e4]), np.array([1.0, 3.3])
        loop = np.polyadd(np.polymul(inner, specimen), [4.2297e6, 0.0])
        denominator = np.polyadd(np.polymul(valve, loop), [2.1283e13])
        # in milliseconds, in which the coefficients of these polynomials have one size
        numerators = [2.1283e13 * 1.0261 * specimen, np.array([0.0, 0.0, 2.1283e13 * 1.0261])]
        thousands = 1e3 ** np.arange(5, -1, -1)
        outputs = np.array([np.pad(each, (2, 0)) * thousands[1:] for each in numerators])
        denominator = denominator * thousands
        ap = np.eye(5, k=-1)
        ap[0] = -denominator[1:] / denominator[0]
        cp = outputs / denominator[0]
        self.ap, self.bp, self.cp, *_ = signal.cont2discrete(
            (ap, np.eye(5)[:, :1], cp, np.zeros((2, 1))), 1e3 / RATE, "zoh"
        )
        self.ground = np.interp(
            np.arange(int(motion.duration * RATE + 1e-6) + 1) / RATE, motion.time, motion.acceleration
        )

    def run(self, command: object, delay: int, extrapolation: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Floors (3, T) and the specimen's displacement (T,); ``command`` is called with target and displacement."""
        n = len(self.ground)
        by_ground, by_force, p = -self.dg * self.ground[0], np.zeros((6, 1)), np.zeros((5, 1))  # at rest
        floors, x, forces = np.zeros((3, n)), np.zeros(n), np.zeros(n + 10)
        for k in range(n):
            z = (by_ground + self.dg * self.ground[k] + by_force)[:, 0]
            force, x[k] = (self.cp @ p)[:, 0]
            floors[:, k], forces[k] = z[:3], force
            u = command(z[0], x[k])  # type: ignore[operator]
            late, before = (forces[k - d] if k >= d else 0.0 for d in (delay, delay + 1))
            held = late + extrapolation * (late - before)
            by_ground, by_force = self.a @ by_ground + self.bg * self.ground[k], self.af @ by_force + self.bf * held
            p = self.ap @ p + self.bp * u
        return floors, x


class FilterByScipy:
    """A filter sample by sample."""

    def __init__(self, numerator: np.ndarray, denominator: np.ndarray) -> None:
        self.b, self.a = numerator, denominator
        self.state = np.zeros(max(len(self.b), len(self.a)) - 1)

    def __call__(self, value: float) -> float:
        out, self.state = signal.lfilter(self.b, self.a, [value], zi=self.state)
        return float(out[0])


def agree(own: np.ndarray, other: np.ndarray, relative: float = 1e-8) -> None:
    np.testing.assert_allclose(own, other, rtol=0.0, atol=relative * np.max(np.abs(other)))


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


def test_the_reference_is_the_linear_response(building: Building, motion: GroundMotion) -> None:
    run = perform_virtual(ideal(building), PhaseLeadCompensator(), motion)
    a = np.block([[np.zeros((3, 3)), np.eye(3)], [-K / 1000.0, -building.C / 1000.0]])
    b = np.concatenate([np.zeros(3), -np.ones(3)])[:, None]
    _, y, _ = signal.lsim((a, b, np.eye(6)[:3], np.zeros((3, 1))), run.ground, run.time)
    agree(run.reference, y.T)


def test_a_matched_inverse_follows(building: Building, motion: GroundMotion) -> None:
    """theta of the actual plant, no noise: what the order of the inverse leaves is 0.3 % of the target."""
    setup = ideal(building)
    fixed = ModelBasedCompensator(start=tuple(inverse_coefficients(setup)), gains=(0.0, 0.0, 0.0, 0.0))
    quiet = GroundMotion(np.sin(2 * np.pi * 3.6 * np.arange(400) * 0.01), 0.01)
    assert perform_virtual(setup, fixed, quiet).criteria().J2 < 0.3


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
