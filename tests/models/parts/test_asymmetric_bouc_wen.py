# Song and Der Kiureghian (2006), J. Engineering Mechanics 132, 610: the equation with its six terms, solved by scipy.
"""The generalised Bouc-Wen model: its equation, what bounds it, its energy, its letters, and what a fit finds."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.models.parts.found_again import assert_found_again, damper

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.models.part import part
from dampyr.models.parts.asymmetric_bouc_wen import AsymmetricBoucWen, describe_limits, from_printed

NAME = "asymmetric_bouc_wen"
BETAS = (0.470, -0.118, 0.0294, 0.115, -0.121, -0.112)
NUMBERS = {"c0": 700.0, "k0": 900.0, "kw": 150.0, "rho": 400.0, "n": 1.6}
NUMBERS |= {f"b{k + 1}": beta / BETAS[0] for k, beta in enumerate(BETAS) if k}
PLAIN = NUMBERS | {"c0": 0.0, "k0": 0.0}


def along(x: np.ndarray, one: Damper | None = None, **changes: float) -> np.ndarray:
    one = one or damper(NAME, PLAIN | changes)
    return one.force(np.arange(x.size) * 1.0, x, voltage=0.0, velocity=np.zeros(x.size))


@pytest.mark.usefixtures("plain")
def test_the_published_equation_is_met_at_any_step() -> None:
    """Along x = 1 mm + 6 mm sin s, sampled every half radian and at its reversals: x changes its sign between samples."""
    A, alpha, n = 0.7, 3e4, 1.3
    s = np.sort(np.concatenate([np.arange(0.0, 12.0, 0.5), np.pi * (np.arange(4) + 0.5)]))

    def rate(at: float, y: np.ndarray) -> list[float]:
        x, v, z = 0.001 + 0.006 * np.sin(at), 0.006 * np.cos(at), y[0]
        signs = [np.sign(v * z), np.sign(x * v), np.sign(x * z), np.sign(v), np.sign(z), np.sign(x)]
        return [v * (A - abs(z) ** n * 2e3 * np.dot(BETAS, signs))]

    z = solve_ivp(rate, (0.0, s[-1]), [0.0], "LSODA", t_eval=s, rtol=1e-9, atol=1e-13, max_step=2e-3).y[0]
    one = Damper([from_printed(0.0, 0.0, alpha, A, n, tuple(2e3 * beta for beta in BETAS))])
    np.testing.assert_allclose(along(0.001 + 0.006 * np.sin(s), one), alpha * z, atol=1e-4 * alpha * np.abs(z).max())
    assert abs(abs(z.max()) - abs(z.min())) > 0.05 * z.max()


@pytest.mark.usefixtures("plain")
def test_without_asymmetry_it_is_bouc_wen_with_the_loss_alone() -> None:
    x = np.append(0.0, 0.004 * np.random.default_rng(0).standard_normal(60))
    usual = {"c0": 0.0, "k0": 0.0, "kw": 150.0, "rho": 400.0, "sigma": 1.0, "n": 1.6}
    expected = along(x, damper("bouc_wen", usual))
    np.testing.assert_allclose(along(x, **{f"b{k}": 0.0 for k in range(2, 7)}), expected, rtol=1e-8, atol=1e-8)


def test_what_bounds_it_and_what_makes_energy_is_said() -> None:
    assert describe_limits(AsymmetricBoucWen(**NUMBERS)) == []
    bad = describe_limits(AsymmetricBoucWen(**(NUMBERS | {"b5": -1.5})))
    assert bad == ["it is not bounded for every motion: |b2 + b3 + b6| < 1 + b4 + b5 does not hold"]
    assert any(
        "make energy: |b2| + |b4| <= 1" in text
        for text in describe_limits(AsymmetricBoucWen(**(NUMBERS | {"b2": 1.2})))
    )
    assert part(NAME).not_tried


@pytest.mark.usefixtures("plain")
def test_within_its_limits_it_takes_work_from_rest_and_beyond_them_it_may_make_energy() -> None:
    """The work from rest, with numbers that keep to the rules and with some that do not."""
    rng = np.random.default_rng(3)
    for _ in range(4):
        b = dict(zip(("b2", "b3", "b4", "b5", "b6"), rng.uniform(-0.6, 0.6, 5), strict=True))
        while describe_limits(AsymmetricBoucWen(**(NUMBERS | b))):
            b = {key: 0.7 * value for key, value in b.items()}
        nodes = np.append(0.0, 0.004 * rng.standard_normal(20))
        x = np.interp(np.linspace(0.0, 20.0, 1001), np.arange(21.0), nodes)
        force = along(x, **b)
        assert np.min(np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(x))) >= -1e-9
    x = np.concatenate([np.linspace(0.02, 0.0185, 200), np.linspace(0.0185, 0.0225, 200)[1:]])
    force = along(x, b2=1.2, b3=-1.2, b4=0.0, b5=0.0, b6=0.0)  # bounded; the way back is longer than that out
    assert np.min(np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(x))) < -1e-3


def test_the_letters_of_the_source_are_refused_where_they_have_no_scale() -> None:
    for bad in ((0.0, 1.0, BETAS), (1.0, 0.0, BETAS), (1.0, 1.0, (0.0, *BETAS[1:]))):
        with pytest.raises(InputError, match="greater than 0"):
            from_printed(0.0, 0.0, bad[0], bad[1], 1.5, bad[2])


@pytest.mark.prove
def test_a_fit_of_six_sines_gives_the_numbers_back() -> None:
    assert_found_again(NAME, NUMBERS)
