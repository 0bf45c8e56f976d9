"""Voltage laws: values, ranges, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.models.exponent_of_bouc_wen import of_exponent

from dampyr.errors import InputError
from dampyr.models import Constant, Damper, Interpolation, Polynomial, WithTemperature
from dampyr.models.damper import Law
from dampyr.models.laws import from_card, look_up, polynomial_table
from dampyr.units import OPEN_MARGIN

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


# a limit that a law misses by rounding


JUST_BELOW = float(np.nextafter(1.0, 0.0))


@pytest.mark.parametrize(
    "law",
    [
        Constant(JUST_BELOW, 0.0, 3.0),
        Interpolation((0.0, 1.0, 3.0), (JUST_BELOW, 1.0 - 1e-8, 1.5)),
        Polynomial((1.3, (JUST_BELOW - 1.3) / 3.0), 0.0, 3.0),
        WithTemperature(Constant(1.0, 0.0, 3.0), Constant(JUST_BELOW, 0.0, 3.0), (20.0, 40.0)),
        WithTemperature(Polynomial((1.0, 0.1), 0.0, 3.0), Polynomial((JUST_BELOW, 0.0), 0.0, 3.0), (20.0, 40.0)),
    ],
)
def test_every_kind_of_law_is_put_on_a_limit_that_it_misses_by_rounding(law: Law, tmp_path: Path) -> None:
    damper = of_exponent(law)
    again = Damper.load(damper.save(tmp_path / "card.toml"))
    assert again.all_laws == damper.all_laws
    for temperature in np.linspace(20.0, 40.0, 21):  # means of two values at a limit
        for one in (damper.at_temperature(temperature), again.at_temperature(temperature)):
            assert one.values(np.linspace(0.0, 3.0, 31))[:, -1].min() >= 1.0
            assert min(one.at_level(0.9).all_laws["bouc_wen.n"].extremes()) >= 1.0
    t = np.linspace(0.0, 1.0, 101)
    x = 0.01 * np.sin(2 * np.pi * t)
    plain = of_exponent(Constant(1.0, 0.0, 3.0)).force(t, x, voltage=0.0)
    if law.kind == "constant":
        np.testing.assert_array_equal(damper.force(t, x, voltage=0.0), plain)


def test_what_is_farther_beyond_a_limit_is_refused_with_all_its_digits() -> None:
    with pytest.raises(InputError, match=r"n between 0 and 3 V = 0\.9999998 .* not allowed; it must be at least 1 and"):
        of_exponent(Constant(0.9999998, 0.0, 3.0))
    with pytest.raises(InputError, match=r"n between 0 and 3 V = 0\.97 "):
        of_exponent(Polynomial((1.0, -0.01), 0.0, 3.0))


def test_a_limit_that_must_not_be_reached_is_missed_by_rounding_too() -> None:
    positive = Polynomial((300.0, -100.0 - 1e-12), 0.0, 3.0)
    damper = Damper("dahl", {"dahl.kx": 1.0, "dahl.kw": positive, "dahl.rho": 900.0})
    assert 0.5 * OPEN_MARGIN < damper.values(3.0)[1] < 2.0 * OPEN_MARGIN
    with pytest.raises(InputError, match=r"kw between 0 and 3 V = 0 N is not allowed; it must be greater than 0"):
        Damper("dahl", {"dahl.kx": 1.0, "dahl.kw": Polynomial((300.0, -100.0), 0.0, 3.0), "dahl.rho": 900.0})
