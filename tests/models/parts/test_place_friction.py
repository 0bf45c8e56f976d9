"""Friction that depends on the place in the motion: its memory, its sign, its start, and what a fit finds."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.synthetic import sine
from tests.identification.tangent_campaign import campaign

from dampyr.identification import fit
from dampyr.models import Damper, compose

G, Y0, ELL, VF = 10.0, 0.005, 0.022, 0.002
NUMBERS = {"place_friction.g": G, "place_friction.y0": Y0, "place_friction.ell": ELL, "place_friction.vf": VF}


def friction(x: np.ndarray, v: np.ndarray, **changes: float) -> np.ndarray:
    numbers = NUMBERS | {f"place_friction.{key}": value for key, value in changes.items()}
    return Damper("place_friction", numbers).force(np.arange(len(x)) * 1.0, x, voltage=0.0, velocity=v)


def test_a_stroke_moves_the_place_as_the_closed_form() -> None:
    """z = 1 - exp(-x/ell) along a stroke outwards from rest, however few the samples."""
    x = np.array([0.0, 0.003, 0.02, 0.05])
    place = ELL * -np.expm1(-x / ELL)
    expected = G * ((place - Y0) / 0.01) ** 2
    assert friction(x, np.full(4, 1.0)) == pytest.approx(expected, rel=1e-12)


def test_a_long_memory_is_the_position_from_where_the_motion_began() -> None:
    x = 0.01 * np.sin(np.linspace(0.0, 20.0, 2001))
    v = np.where(np.cos(np.linspace(0.0, 20.0, 2001)) >= 0.0, 1.0, -1.0)
    force = friction(x, v, ell=1.0)
    assert force == pytest.approx(np.sign(v) * G * ((x - Y0) / 0.01) ** 2, abs=2.5)  # forgets 2 % over 20 mm


def test_it_only_dissipates() -> None:
    rng = np.random.default_rng(0)
    v = rng.standard_normal(20_000)
    x = np.cumsum(1e-4 * v)
    assert np.min(friction(x, 0.01 * v) * v) >= 0.0


def test_its_state_begins_at_rest_and_is_not_fitted() -> None:
    composition = compose("dahl + place_friction")
    assert [list(composition.states)[k] for k in composition.free_at_start] == ["dahl.w"]


@pytest.mark.prove
def test_its_numbers_are_found_and_do_not_follow_the_voltage() -> None:
    model = "hyperbolic_tangent + place_friction"
    values = NUMBERS | {"hyperbolic_tangent.c": 900.0, "hyperbolic_tangent.v0": 0.005, "hyperbolic_tangent.s": 0.0}
    made = []
    for voltage, ft in ((0.0, 50.0), (2.0, 300.0)):
        damper = Damper(model, values | {"hyperbolic_tangent.ft": ft})
        for amplitude, frequency in ((0.005, 2.0), (0.01, 1.0), (0.015, 0.5)):
            record = sine(damper, 0.0, f"{voltage:g}-{frequency:g}", amplitude=amplitude, frequency=frequency)
            made.append(replace(record, voltage=voltage))
    result = fit(made, model, fixed={"hyperbolic_tangent.s": 0.0})
    assert result.parameters["place_friction.g"] == pytest.approx(G, rel=0.01)
    assert result.parameters["place_friction.y0"] == pytest.approx(Y0, rel=0.01)
    assert result.parameters["place_friction.ell"] == pytest.approx(ELL, rel=0.01)


@pytest.mark.prove
def test_of_a_damper_without_it_the_friction_is_found_to_be_none() -> None:
    result = fit(campaign(), "hyperbolic_tangent + place_friction")
    assert result.parameters["place_friction.g"] < 0.2
    assert any(finding.sentence.startswith("place_friction.g stands at its limit") for finding in result.findings)
