"""Voltage laws: values, ranges, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dampyr.errors import InputError
from dampyr.models import Constant, Damper, Interpolation, Polynomial
from dampyr.models.laws import from_card, look_up, polynomial_table

VALUES = st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=6)


def test_a_polynomial_is_in_rising_powers() -> None:
    law = Polynomial((1.0, 2.0, 3.0), 0.0, 2.0)
    assert law(2.0) == 1.0 + 4.0 + 12.0


def test_extremes_of_a_polynomial_lie_inside_too() -> None:
    low, high = Polynomial((0.0, -4.0, 1.0), 0.0, 5.0).extremes()
    assert low == pytest.approx(-4.0)
    assert high == pytest.approx(5.0)


@given(VALUES)
def test_interpolation_meets_its_values_and_never_leaves_them(values: list[float]) -> None:
    knots = tuple(np.arange(len(values)) * 0.7)
    law = Interpolation(knots, tuple(values))
    np.testing.assert_allclose(law(np.array(knots)), values, atol=1e-9)
    between = law(np.linspace(knots[0], knots[-1], 101))
    piece = np.minimum((np.linspace(0, len(values) - 1, 101)).astype(int), len(values) - 2)
    low = np.minimum(np.array(values)[piece], np.array(values)[piece + 1])
    high = np.maximum(np.array(values)[piece], np.array(values)[piece + 1])
    assert np.all(between >= low - 1e-9 * (1 + np.abs(low)))
    assert np.all(between <= high + 1e-9 * (1 + np.abs(high)))


@pytest.mark.parametrize(
    "law", [Constant(3.0, 0.0, 2.0), Polynomial((1.0, 0.1), 0.0, 3.0), Interpolation((0.0, 1.0), (2.0, 3.0))]
)
def test_a_law_survives_its_card(law: object) -> None:
    assert from_card(law.card()) == law


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"kind": "spline"}, "unknown law 'spline'"),
        ({"kind": "constant", "range": [0, 1]}, "lacks 'value'"),
        ({"kind": "polynomial", "coefficients": ["a"], "range": [0, 1]}, "not a number"),
        ({"kind": "polynomial", "coefficients": [1.0], "range": [2, 1]}, "not a range"),
        ({"kind": "interpolation", "knots": [0, 0], "values": [1, 2]}, "must rise"),
        ({"kind": "interpolation", "knots": [0], "values": [1]}, "two or more knots"),
    ],
)
def test_a_wrong_card_says_what_is_wrong(table: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        from_card(table)


def test_a_law_that_lets_rho_reach_zero_inside_its_range_is_refused() -> None:
    rho = Polynomial((42745.0, -39038.0, 17881.0, -2836.8), 0.0, 3.8)
    with pytest.raises(InputError, match=r"dahl\.rho between 0 and 3\.8 V .* greater than 0"):
        Damper("dahl", {"dahl.kx": 800.0, "dahl.kw": 50.0, "dahl.rho": rho})


def test_a_law_that_lets_kw_reach_zero_is_refused() -> None:
    with pytest.raises(InputError, match=r"dahl\.kw"):
        Damper("dahl", {"dahl.kx": 800.0, "dahl.kw": Polynomial((50.0, -25.0), 0.0, 2.0), "dahl.rho": 1e4})


def test_a_table_gives_what_the_laws_give():
    laws = {
        "dahl.kx": Constant(800.0, 0.0, 3.0),
        "dahl.kw": Interpolation((0.0, 0.9, 2.0, 3.0), (50.0, 210.0, 380.0, 560.0)),
        "dahl.rho": Polynomial((42745.0, -39038.0, 17881.0, -2836.8), 0.0, 3.0),
        "offset.f0": 120.0,
    }
    damper = Damper("dahl + offset", laws)
    knots, coefficients = polynomial_table(damper)
    out = np.zeros(4)
    for u in [0.0, 0.9, 2.0, 3.0, *np.linspace(0.0, 3.0, 61)]:
        look_up(knots, coefficients, u, out)
        assert out == pytest.approx(damper.values(u), rel=1e-12)
    look_up(*polynomial_table(damper, static=False), 1.0, out)
    assert out[3] == 0.0
    look_up(knots, coefficients, 3.4, out)  # beyond the range the last piece goes on
    assert out[1] == pytest.approx(float(damper.all_laws["dahl.kw"](3.4)), rel=1e-12)
