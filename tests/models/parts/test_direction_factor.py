# The definition: the force of the other parts times 1 + e tanh(v/v0); Dixon (2007), The Shock Absorber Handbook.
"""The factor by direction: on which parts it is, its derivatives where parts share them, its exports, and what a fit finds."""

import shutil

import numpy as np
import pytest
from tests.invariants.test_every_part import agree_with_differences, path, run_c
from tests.models.parts.found_again import six_sines

from dampyr.errors import InputError
from dampyr.identification import fit
from dampyr.models import Damper, compose
from dampyr.models.path_integration import along

DAHL = {"dahl.kx": 700.0, "dahl.kw": 100.0, "dahl.rho": 1500.0}
FACTOR = {"direction_factor.e": 0.3, "direction_factor.v0": 0.01}
SPRING = {"spring.k0": 900.0}
NAMES = "dahl + direction_factor + spring"


def one(laws: dict[str, float]) -> Damper:
    return Damper(list(dict.fromkeys(key.partition(".")[0] for key in laws)), laws)


@pytest.mark.usefixtures("plain")
def test_it_multiplies_the_other_parts_but_offset_and_inertia_wherever_it_stands() -> None:
    t, x, v = path(60)
    apart = {"offset.f0": 40.0, "inertia.m": 3.0}
    usual = one(DAHL | SPRING).force(t, x, voltage=0.0, velocity=v) * (1.0 + 0.3 * np.tanh(v / 0.01))
    added = one(apart).force(t, x, voltage=0.0, velocity=v)
    for laws in (DAHL | FACTOR | SPRING | apart, FACTOR | apart | DAHL | SPRING):
        np.testing.assert_allclose(one(laws).force(t, x, voltage=0.0, velocity=v), usual + added, rtol=1e-12, atol=1e-9)


@pytest.mark.usefixtures("plain")
def test_its_derivatives_are_the_derivatives_though_two_parts_share_them() -> None:
    agree_with_differences(NAMES, np.array([*DAHL.values(), *FACTOR.values(), 900.0]), np.array([0.2]))


def test_two_sites_of_a_building_may_have_the_same_part_with_and_without_it() -> None:
    from dampyr.models.codegen.composition import text_of

    text = text_of((compose("dahl"), compose("dahl + direction_factor")))
    assert "def dahl_force(" in text
    assert "def dahl_force_by_direction_factor(" in text


def test_it_is_refused_in_series_and_alone() -> None:
    with pytest.raises(InputError, match="direction_factor cannot stand with an element in series"):
        compose("dahl + direction_factor + compliance")
    with pytest.raises(InputError, match="makes no force"):
        compose("direction_factor")


def test_a_spring_about_a_place_off_the_middle_makes_energy_with_it() -> None:
    """Why it is not for a building."""
    s = np.linspace(0.0, 2 * np.pi, 401)
    x, v = -0.005 + 0.001 * np.sin(s), 0.001 * np.cos(s)
    force = np.array([900.0 * at * (1.0 + 0.3 * np.tanh(u / 1e-4)) for at, u in zip(x, v, strict=True)])
    np.testing.assert_allclose(
        along(compose("spring + direction_factor"), s, x, v, np.array([900.0, 0.3, 1e-4])), force, rtol=1e-12
    )
    assert np.trapezoid(force, x) < -1e-3
    assert "Do not use it for a building" in (compose(NAMES).parts[1].module.__doc__ or "")
    assert "direction_factor is not for a building" in compose(NAMES).not_for_buildings


@pytest.mark.prove
def test_c_walks_the_same_path(tmp_path) -> None:
    if shutil.which("gcc") is None:
        pytest.skip("gcc is missing: the C export cannot be compiled")
    t, x, v = path()
    damper = one(DAHL | FACTOR | SPRING)
    np.testing.assert_allclose(run_c(damper, tmp_path, t, x, v), damper.force(t, x, voltage=0.0, velocity=v), rtol=1e-9)


@pytest.mark.prove
def test_a_fit_of_six_sines_gives_the_numbers_back() -> None:
    """The sums of products of a fit come from the step of many samples at once, where the shared columns add up."""
    truth = DAHL | SPRING | FACTOR
    result = fit(six_sines(one(truth)), NAMES)
    assert result.converged, result.reason
    for key, value in truth.items():
        assert result.parameters[key] == pytest.approx(value, rel=0.01), key
    assert max(score.l1 for score in result.scores.values()) < 1e-3
