"""Dampers on braces, and different ones together, beside scipy's solution of the plain equations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.models import Constant, Damper, Interpolation, Polynomial
from dampyr.structures import respond, shear_building

MOTION = GroundMotion(np.asarray(el_centro().acceleration)[:151], 0.02, "start of El Centro")
BUILDING = shear_building([150.0, 140.0, 120.0], [140e3, 110e3, 80e3], damping_ratio=0.03)
KX, KW, RHO, BRACE = 2500.0, 380.0, 9000.0, 4e5
C, FT, V0, S = 400.0, 250.0, 0.02, 0.4
C0, K0, BW, BRHO, SIGMA = 300.0, 5e3, 200.0, 2500.0, 0.8  # Bouc-Wen with n = 2

DAHL = Damper("dahl", {"dahl.kx": KX, "dahl.kw": KW, "dahl.rho": RHO})
TANH = Damper(
    "hyperbolic_tangent",
    {f"hyperbolic_tangent.{k}": v for k, v in {"c": C, "ft": FT, "v0": V0, "s": S}.items()},
)
BOUC_WEN = Damper(
    "bouc_wen",
    {f"bouc_wen.{k}": v for k, v in {"c0": C0, "k0": K0, "kw": BW, "rho": BRHO, "sigma": SIGMA, "n": 2.0}.items()},
)
PLACED = {1: DAHL.on_brace(BRACE), (1, 3): TANH, 2: BOUC_WEN}


def plain(t: float, y: np.ndarray, a0: float, a1: float) -> np.ndarray:
    """The equations as on paper: floors, the stretch z of the brace from F = k z, and two hysteretic states."""
    q, v, z, w, b = y[:3], y[3:6], y[6], y[7], y[8]
    force = BRACE * z
    piston = (force - KW * w) / KX  # what the damper behind the brace moves at, from its own law
    x2, v2 = q[1] - q[0], v[1] - v[0]
    x3, v3 = q[2] - q[0], v[2] - v[0]
    across = C * v3 + FT * np.tanh((v3 + S * x3) / V0)
    second = C0 * v2 + K0 * x2 + BW * b
    pull = -BUILDING.K @ q - BUILDING.C @ v
    pull = (
        pull - np.array([force, 0.0, 0.0]) - across * np.array([-1.0, 0.0, 1.0]) - second * np.array([-1.0, 1.0, 0.0])
    )
    ground = a0 + (a1 - a0) * t / MOTION.dt
    return np.concatenate([
        v,
        pull / np.diag(BUILDING.M) - ground,
        [v[0] - piston],
        [RHO * (piston - abs(piston) * w)],
        [BRHO * (v2 - SIGMA * abs(v2) * abs(b) * b + (SIGMA - 1.0) * v2 * b * b)],
    ])  # fmt: skip


@pytest.fixture(scope="module")
def reference() -> np.ndarray:
    """Floors, their rates and the three states at the samples of the motion (9, samples)."""
    y = [np.zeros(9)]
    for a0, a1 in zip(MOTION.acceleration[:-1], MOTION.acceleration[1:], strict=True):
        done = solve_ivp(
            plain, (0.0, MOTION.dt), y[-1], "Radau", args=(a0, a1), rtol=1e-8, atol=1e-11, max_step=MOTION.dt / 8
        )
        assert done.success
        y.append(done.y[:, -1])
    return np.array(y).T


@pytest.mark.prove  # its kernels take long to compile
def test_three_dampers_and_a_brace_equal_a_stiff_reference(reference):
    size = np.abs(reference[:3]).max()
    response = respond(BUILDING, MOTION, PLACED, voltage=0.0)
    assert response.converged
    assert response.scheme == "general"
    np.testing.assert_allclose(response.displacement, reference[:3], atol=5e-4 * size)
    np.testing.assert_allclose(response.force[0], BRACE * reference[6], atol=1e-3 * BRACE * np.abs(reference[6]).max())


@pytest.mark.by_hand  # its kernels take long to compile; with the default step it equals the reference above
def test_the_error_falls_with_the_step_to_the_reference(reference):
    size = np.abs(reference[:3]).max()
    errors = [
        np.abs(respond(BUILDING, MOTION, PLACED, voltage=0.0, step=h).displacement - reference[:3]).max() / size
        for h in (5e-4, 1.25e-4)
    ]
    assert errors[1] < 1e-4
    assert errors[1] == pytest.approx(0.25 * errors[0], rel=0.1)  # of first order, for the brace's rate
    rigid = respond(BUILDING, MOTION, PLACED | {1: DAHL}, voltage=0.0)
    assert np.abs(rigid.displacement - reference[:3]).max() > 50 * errors[0] * size  # the brace does matter here


@pytest.mark.prove  # its kernels take long to compile
def test_energy_closes_with_braces_and_connections():
    worst = []
    for step in (0.002, 0.001, 0.0005):
        energy = respond(BUILDING, MOTION, PLACED, voltage=0.0, step=step).energy
        worst.append(np.abs(energy.residual).max() / energy.input.max())
    assert worst[0] < 1e-7
    assert worst[1] < worst[0] / 12  # of fourth order
    assert worst[2] < worst[1] / 12


def test_braces_in_series_add_up():
    t = np.linspace(0.0, 2.0, 400)
    x = 0.004 * np.sin(9.0 * t)
    twice = DAHL.on_brace(2e6).on_brace(3e6)
    once = DAHL.on_brace(1.0 / (1 / 2e6 + 1 / 3e6))
    assert twice.all_laws["compliance.s"](0.0) == pytest.approx(1 / 2e6 + 1 / 3e6, rel=1e-14)
    np.testing.assert_allclose(twice.force(t, x, voltage=0.0), once.force(t, x, voltage=0.0), rtol=1e-12)


def test_a_spring_beside_the_damper_stands_behind_the_brace_too():
    k, brace = 4e4, 6e4
    damper = Damper("spring + dahl", {"spring.k0": k, "dahl.kx": 0.0, "dahl.kw": 1e-9, "dahl.rho": 1e3})
    t = np.linspace(0.0, 1.0, 100)
    x = 0.01 * np.sin(6 * t)
    np.testing.assert_allclose(damper.on_brace(brace).force(t, x, voltage=0.0), x / (1 / k + 1 / brace), atol=1e-6)


@pytest.mark.parametrize(
    "law",
    [
        Constant(2e-6, 0.0, 3.0),
        Polynomial((2e-6, 1e-6, -2e-7), 0.0, 3.0),
        Interpolation((0.0, 1.0, 3.0), (2e-6, 5e-6, 4e-6)),
    ],
)
def test_a_compliance_over_the_voltage_is_shifted_at_every_voltage(law):
    laws = {"dahl.kx": 900.0, "dahl.kw": 150.0, "dahl.rho": 9000.0, "compliance.s": law}
    stiff = Damper("dahl + compliance", laws, covariance=np.eye(3 + len(law.coefficients)) * 1e-18)
    braced = stiff.on_brace(1e6)
    u = np.linspace(0.0, 3.0, 13)
    np.testing.assert_allclose(braced.all_laws["compliance.s"](u), law(u) + 1e-6, rtol=1e-12)
    assert np.array_equal(braced.covariance, stiff.covariance)


def test_a_brace_is_known_exactly_and_kept_on_the_card(tmp_path):
    fitted = Damper("dahl", dict(DAHL.laws), covariance=np.diag([1.0, 2.0, 3.0]))
    braced = fitted.on_brace(4e5)
    assert braced.covariance.tolist() == np.diag([1.0, 2.0, 3.0, 0.0]).tolist()
    assert {draw.values(0.0)[-1] for draw in braced.draws(5, seed=1)} == {1 / 4e5}
    assert Damper.load(braced.save(tmp_path / "card.toml")).values(0.0) == pytest.approx(braced.values(0.0))


@pytest.mark.parametrize("stiffness", [0.0, -1.0, np.nan, np.inf, True])
def test_a_brace_needs_a_stiffness(stiffness):
    with pytest.raises(InputError, match=r"stiffness of a brace .* greater than 0"):
        DAHL.on_brace(stiffness)


def test_inertia_does_not_stand_behind_a_brace():
    heavy = Damper("dahl + inertia", dict(DAHL.laws) | {"inertia.m": 2.0})
    with pytest.raises(InputError, match=r"inertia needs the acceleration .* \.without\('inertia'\)"):
        heavy.on_brace(1e6)
