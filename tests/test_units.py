"""Units at the boundary, SI inside."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dampyr import units
from dampyr.errors import InputError
from dampyr.units import EVERYDAY, _by_pint

CONVERSIONS = [
    (12.4, "mm", "m", 0.0124),
    (-3.0, "cm", "m", -0.03),
    (1.0, "in", "m", 0.0254),
    (76.0, "mm/s", "m/s", 0.076),
    (2.5, "kN", "N", 2500.0),
    (1.0, "kgf", "N", 9.80665),
    (1.0, "g", "m/s^2", 9.80665),
    (1.0, "G", "m/s^2", 9.80665),
    (100.0, "Gal", "m/s^2", 1.0),
    (1.0, "cm/s²", "m/s^2", 0.01),
    (20.0, "µm", "m", 20e-6),
    (20.0, "µm", "m", 20e-6),
    (495.0, "mA", "A", 0.495),
    (2.0, "min", "s", 120.0),
    (10.0, "ms", "s", 0.01),
    (1.0, "N*s/mm", "N*s/m", 1000.0),
    (1.0, "N·s/mm", "N*s/m", 1000.0),
    (0.02, "1/mm", "1/m", 20.0),
    (981.0, "cm/s2", "m/s^2", 9.81),
    (1.0, "m/s2", "m/s^2", 1.0),
    (35.0, "%g", "m/s^2", 3.4323275),
    (5.0, "mg", "m/s^2", 0.04903325),
    (5.0, "mg", "kg", 5e-6),
    (2.0, "KN/m", "N/m", 2000.0),
    (2.0, "kN m2", "N m^2", 2000.0),
    (2.0, "kNs/m", "N s/m", 2000.0),
    (2.0, "kNm", "N m", 2000.0),
    (3.0, "MN s2/m", "kg", 3e6),
    (1.0, "cm4", "m^4", 1e-8),
    (1.0, "N/m³", "N/m^3", 1.0),
    (1.0, "lbm", "kg", 0.45359237),
    (1.0, "t", "kg", 1000.0),
    (1.0, "short_ton", "kg", 907.18474),
    (1.0, "long_ton", "kg", 1016.0469088),
    (1.0, "tf/m", "N/m", 9806.65),
]
PAIRS = sorted({(unit, si) for _, unit, si, _ in CONVERSIONS})
finite = st.floats(min_value=-1e9, max_value=1e9, allow_subnormal=False)


@pytest.mark.parametrize(("value", "unit", "si", "expected"), CONVERSIONS)
def test_known_conversions(value: float, unit: str, si: str, expected: float) -> None:
    assert units.to_si(value, unit, si) == pytest.approx(expected, rel=1e-14)


def test_g_is_the_gram_where_a_mass_is_meant() -> None:
    assert units.to_si(250.0, "g", "kg") == pytest.approx(0.25, rel=1e-14)


@pytest.mark.parametrize(
    ("unit", "si", "instead"),
    [("ton", "kg", "t, short_ton or long_ton"), ("tons", "kg", "short_ton"), ("ton/m", "kg/m", "long_ton"),
     ("tonf/m", "N/m", r"tf, short_ton\*g_0")],
)  # fmt: skip
def test_a_ton_is_asked_for_by_name(unit: str, si: str, instead: str) -> None:
    """It is 1000 kg to most structural engineers, and was 907.18474 kg without a word."""
    with pytest.raises(InputError, match=f"ton.? in the unit '{unit}' may be 1000 kg, .*write .*{instead}"):
        units.to_si(1.0, unit, si)


def test_a_shifted_scale() -> None:
    assert units.to_si(25.0, "degC", "kelvin") == pytest.approx(298.15, rel=1e-12)
    assert units.from_si(298.15, "degC", "kelvin") == pytest.approx(25.0, rel=1e-12)


@given(value=finite, pair=st.sampled_from(PAIRS))
def test_there_and_back(value: float, pair: tuple[str, str]) -> None:
    unit, si = pair
    there = units.to_si(value, unit, si)
    assert math.isclose(units.from_si(there, unit, si), value, rel_tol=1e-14, abs_tol=1e-300)


@given(values=st.lists(finite, max_size=8), pair=st.sampled_from(PAIRS))
def test_an_array_is_converted_like_its_numbers(values: list[float], pair: tuple[str, str]) -> None:
    unit, si = pair
    np.testing.assert_array_equal(units.to_si(values, unit, si), [units.to_si(v, unit, si) for v in values])


@given(value=finite)
def test_what_is_typed_is_what_is_meant(value: float) -> None:
    assert units.parse(f"{value!r} mm", "m") == pytest.approx(value / 1000, rel=1e-14, abs=1e-300)
    assert units.parse(repr(value), "m") == pytest.approx(value, rel=1e-14)


def test_a_typed_quantity_carries_no_noise() -> None:
    assert units.parse("12.4 mm", "m") == 0.0124
    assert units.parse("0.1 s", "s") == 0.1
    assert units.parse("12.4mm", "m") == units.parse("1.24e1mm", "m") == 0.0124
    assert units.parse("0.3g", "m/s^2") == pytest.approx(0.3 * 9.80665)
    assert units.parse(3, "V") == 3.0


@pytest.mark.parametrize("unit", ["millimetrs", "+", "mm mm mm x", "mm)"])
def test_an_unknown_unit_is_named(unit: str) -> None:
    with pytest.raises(InputError, match="unknown unit") as caught:
        units.to_si(1.0, unit, "m")
    assert repr(unit) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("unit", "si"), [("kg", "N"), ("V", "A"), ("mm", "m/s"), ("s", "m")])
def test_a_wrong_dimension_is_refused(unit: str, si: str) -> None:
    with pytest.raises(InputError, match="does not measure") as caught:
        units.to_si(1.0, unit, si)
    assert repr(unit) in str(caught.value)
    assert repr(si) in str(caught.value)


@pytest.mark.parametrize("text", ["", "mm", "12,4 mm", "twelve mm"])
def test_what_is_no_quantity_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="is not a quantity"):
        units.parse(text, "m")


@pytest.mark.parametrize(
    ("quantity", "good", "bad", "words"),
    [
        (units.Quantity("N", low=0), [0.0, 5.0], [-1e-12, math.nan, math.inf], "at least 0"),
        (units.Quantity("1/m", low=0, open_low=True), [1e-12], [0.0, -1.0], "greater than 0"),
        (units.Quantity("1", low=0.5, high=1), [0.5, 1.0], [0.4999, 1.0001], "at least 0.5 and at most 1"),
        (units.Quantity("s"), [-1e300, 0.0], [math.nan, -math.inf], "finite"),
    ],
)
def test_a_quantity_checks_its_range(quantity: units.Quantity, good: list[float], bad: list[float], words: str) -> None:
    for value in good:
        quantity.check("p", value)
    for value in bad:
        with pytest.raises(InputError, match=f"p = .* {quantity.unit} is not allowed; it must be {words}"):
            quantity.check("p", value)


@pytest.mark.parametrize(("pair", "factor"), EVERYDAY.items())
def test_everyday_units_are_those_of_pint(pair: tuple[str, str], factor: float) -> None:
    assert _by_pint(*pair) == pytest.approx((factor, 0.0), rel=1e-15)


def test_systems_of_units_agree_with_pint() -> None:
    written = {"in": "inch", "in/s": "inch/s", "in lbf": "inch lbf", "lbf/in": "lbf/inch", "lbf s/in": "lbf s/inch"}
    for unit in ("m", "m/s", "N", "J", "N/m", "N s/m", "Hz", "s", ""):
        for system in units.UNIT_SYSTEMS:
            name, factor = units.in_system(unit, system)
            if name == unit:
                assert factor == 1.0
            else:
                assert units.from_si(1.0, written.get(name, name), unit) == pytest.approx(factor, rel=1e-12)
    assert units.in_system("s", "mm-N") == ("s", 1.0)
    assert units.in_system("N/m", "SI") == ("N/m", 1.0)
    with pytest.raises(InputError, match="choose from mm-N, SI, in-lb"):
        units.in_system("m", "cgs")
