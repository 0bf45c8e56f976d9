# Spencer, Dyke, Sain and Carlson, Phenomenological model for magnetorheological dampers, J. Eng. Mech. 123 (1997) 230.
"""The modified Bouc-Wen model against an independent solver in the letters of the source."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.identification.synthetic import sine

from dampyr.identification import fit
from dampyr.models import Damper
from dampyr.models.parts.modified_bouc_wen import ModifiedBoucWen, PrintedModifiedBoucWen, from_printed, to_printed

CM = 100.0
RD_1000 = PrintedModifiedBoucWen(  # as printed for 1.5 V, in N and cm, with gamma = beta = 363 cm^-2 and A = 301
    c0=21.0 * CM, c1=283.0 * CM, k0=46.9 * CM, k1=5.0 * CM, alpha=140.0 * CM, A=301.0, beta=363.0 * CM**2,
    gamma=363.0 * CM**2, n=2.0,
)  # fmt: skip
SOFT = PrintedModifiedBoucWen(c0=300.0, c1=4000.0, k0=900.0, k1=400.0, alpha=2e4, A=1.0, beta=5e3, gamma=9e3, n=1.7)


def damper(model: ModifiedBoucWen) -> Damper:
    return Damper("modified_bouc_wen", {f"modified_bouc_wen.{key}": value for key, value in vars(model).items()})


def motion(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    w = 2 * np.pi * 2.5
    return 0.015 * np.sin(w * t), 0.015 * w * np.cos(w * t)


def reference(p: PrintedModifiedBoucWen, t: np.ndarray) -> np.ndarray:
    """The printed equations in y and z."""

    def speed(time: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        x, v = motion(time)
        return (p.alpha * z + p.c0 * v + p.k0 * (x - y)) / (p.c0 + p.c1)

    def slope(time: float, state: np.ndarray) -> list[float]:
        y, z = state
        dy = float(speed(np.array(time), y, z))
        u = float(motion(np.array(time))[1]) - dy
        return [dy, -p.gamma * abs(u) * z * abs(z) ** (p.n - 1) - p.beta * u * abs(z) ** p.n + p.A * u]

    done = solve_ivp(slope, (0, t[-1]), [0.0, 0.0], method="LSODA", t_eval=t, rtol=1e-10, atol=1e-14, max_step=2e-3)
    y, z = done.y
    return p.c1 * speed(t, y, z) + p.k1 * motion(t)[0]


def error(p: PrintedModifiedBoucWen, n: int) -> float:
    t = np.linspace(0.0, 1.0, n + 1)
    x, v = motion(t)
    force = damper(from_printed(p)).force(t, x, voltage=0.0, velocity=v)[:: n // 100]
    expected = reference(p, t[:: n // 100])
    return float(np.sqrt(np.mean((force - expected) ** 2)) / np.abs(expected).max())


@pytest.mark.parametrize(("p", "at_2400"), [(RD_1000, 2e-4), (SOFT, 1e-5)])
@pytest.mark.prove
def test_the_step_is_of_second_order(p: PrintedModifiedBoucWen, at_2400: float) -> None:
    errors = [error(p, n) for n in (600, 2400, 9600)]
    assert errors[1] < at_2400
    assert errors[0] / errors[2] > 150.0  # 256 but for where the turns fall between the samples


@pytest.mark.prove
@pytest.mark.parametrize("step", [0.02, 1.0])
def test_a_long_step_stays_bounded(step: float) -> None:
    t = np.arange(200) * step
    x = 0.01 * np.sign(np.sin(0.7 * np.arange(200)))
    force = damper(from_printed(RD_1000)).force(t, x, voltage=0.0, velocity=np.zeros(200))
    assert np.all(np.isfinite(force))
    assert np.abs(force).max() < 200.0


def test_a_held_element_creeps_back_to_rest() -> None:
    t = np.linspace(0.0, 60.0, 6001)
    x = np.minimum(0.02 * t, 0.01)
    force = damper(from_printed(SOFT)).force(t, x, voltage=0.0, velocity=np.where(t < 0.5, 0.02, 0.0))
    assert force[-1] == pytest.approx(SOFT.k1 * 0.01, rel=1e-3)


def test_with_a_stiff_dashpot_in_series_it_is_bouc_wen() -> None:
    t = np.linspace(0.0, 1.0, 801)
    x, v = motion(t)
    c1 = 1e9
    model = from_printed(PrintedModifiedBoucWen(**(vars(SOFT) | {"c1": c1, "k1": 0.0})))
    inner = {"c0": SOFT.c0, "k0": SOFT.k0, "kw": model.kw, "rho": model.rho, "sigma": model.sigma, "n": model.n}
    plain = Damper("bouc_wen", {f"bouc_wen.{key}": value for key, value in inner.items()})
    force = damper(model).force(t, x, voltage=0.0, velocity=v)
    np.testing.assert_allclose(force, plain.force(t, x, voltage=0.0, velocity=v), atol=0.01)


def test_the_letters_of_the_source_come_back() -> None:
    again = to_printed(from_printed(RD_1000), A=301.0)
    assert vars(again) == pytest.approx(vars(RD_1000), rel=1e-12)


@pytest.mark.prove
def test_a_fit_gives_the_parameters_back() -> None:
    model = ModifiedBoucWen(kw=120.0, k1=600.0, vc=0.01, r=0.15, kappa=8.0, rho=900.0, sigma=1.0, n=1.6)
    fit_result = fit(sine(damper(model), 0.0), "modified_bouc_wen")
    assert fit_result.converged, fit_result.reason
    assert list(fit_result.parameters.values()) == pytest.approx(list(vars(model).values()), rel=1e-3)
