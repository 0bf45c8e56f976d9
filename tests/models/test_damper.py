"""Dampers: forces along paths, ranges, cards, draws."""

from pathlib import Path

import numpy as np
import pytest
from tests.models.dahl_of_chapter_4 import T, X, published

from dampyr.errors import DampyrWarning, ExtrapolationWarning, InputError, RangeError
from dampyr.models import Damper, Interpolation
from dampyr.models.parts import Compliance, Dahl, Spring


def test_at_gives_the_model_at_one_voltage() -> None:
    model = published().at(1.98)
    assert model.kx == pytest.approx(802.0 + 493.1 * 1.98 + 34.2 * 1.98**2 + 85.5 * 1.98**3)
    several = Damper("dahl + spring", {"dahl.kx": 1.0, "dahl.kw": 2.0, "dahl.rho": 3.0, "spring.k0": 4.0}).at(0.0)
    assert [type(m).__name__ for m in several] == ["Dahl", "Spring"]


def test_a_damper_of_part_objects_is_that_of_their_names_and_numbers() -> None:
    laws = {"dahl.kx": 800.0, "dahl.kw": 50.0, "dahl.rho": 900.0, "spring.k0": 200.0}
    by_name = Damper("dahl + spring", laws)
    by_part = Damper([Dahl(kx=800.0, kw=50.0, rho=900.0), Spring(k0=200.0)])
    assert by_part.parts == ("dahl", "spring")
    assert by_part.all_laws == by_name.all_laws
    np.testing.assert_array_equal(by_part.force(T, X, voltage=0.0), by_name.force(T, X, voltage=0.0))
    assert Damper(by_part.at(0.0)).all_laws == by_name.all_laws
    assert Damper(Dahl(800.0, 50.0, 900.0)).parts == ("dahl",)


def test_names_with_laws_and_part_objects_go_together() -> None:
    damper = Damper(["dahl", Compliance(s=1e-7)], published().laws)
    assert damper.parts == ("dahl", "compliance")
    assert damper.range == (0.0, 3.212)
    assert damper.at(1.98)[1] == Compliance(s=1e-7)


def test_a_part_that_is_none_says_what_to_give() -> None:
    with pytest.raises(
        InputError, match=r"3.5 is not a part of a damper; give names such as 'dahl' or objects such as Dahl"
    ):
        Damper([Dahl(kx=800.0, kw=50.0, rho=900.0), 3.5])
    with pytest.raises(InputError, match=r"Dahl is a class without numbers; give Dahl\(kx=..., kw=..., rho=...\)"):
        Damper([Dahl])
    with pytest.raises(InputError, match=r"spring.k0 is given twice, by its part and in laws; leave it out of laws"):
        Damper([Dahl(kx=800.0, kw=50.0, rho=900.0), Spring(k0=200.0)], {"spring.k0": 3.0})
    with pytest.raises(InputError, match="the part 'spring' is given twice"):
        Damper([Spring(k0=1.0), Spring(k0=2.0)])
    with pytest.raises(InputError, match=r"dahl lacks a law for dahl\.kw, dahl\.kx, dahl\.rho"):
        Damper("dahl")
    assert (
        Damper("dahl", {"kx": 1.0, "kw": 2.0, "rho": 3.0}).laws
        == Damper("dahl", {"dahl.kx": 1.0, "dahl.kw": 2.0, "dahl.rho": 3.0}).laws
    )
    with pytest.raises(InputError, match=r"kx, .* is given twice|given twice among kx, dahl\.kx"):
        Damper("dahl", {"kx": 1.0, "dahl.kx": 1.0, "kw": 2.0, "rho": 3.0})
    with pytest.raises(
        InputError, match=r"v0 is a parameter of several parts; write bingham\.v0 or hyperbolic_tangent\.v0"
    ):
        Damper("bingham + hyperbolic_tangent", {"v0": 1.0})
    with pytest.raises(ImportError, match="cannot import name 'Dall'"):
        from dampyr.models.parts import Dall  # noqa: F401


def test_outside_the_calibrated_range_is_an_error_unless_allowed_by_name() -> None:
    with pytest.raises(RangeError, match=r"3\.6 V is outside the calibrated range 0 to 3\.212 V"):
        published().force(T, X, voltage=3.6)
    with pytest.warns(ExtrapolationWarning, match="extrapolated"):
        force = published().force(T, X, voltage=3.6, allow_extrapolation=True)
    assert np.all(np.isfinite(force))


def test_extrapolation_to_where_rho_is_negative_is_refused_even_when_allowed() -> None:
    with pytest.warns(ExtrapolationWarning), pytest.raises(InputError, match=r"dahl\.rho at 3\.8 V"):
        published().force(T, X, voltage=3.8, allow_extrapolation=True)


def test_the_wrong_input_is_refused() -> None:
    with pytest.raises(InputError, match="pass voltage="):
        published().force(T, X, current=0.5)
    with pytest.raises(InputError, match="needs its voltage"):
        published().force(T, X)
    amperes = published(input="A")
    with pytest.raises(InputError, match="pass current="):
        amperes.force(T, X, voltage=0.5)
    assert np.all(np.isfinite(amperes.force(T, X, current=0.5)))


def test_a_motion_beyond_the_calibration_warns_and_names_the_limit() -> None:
    damper = published(ranges={"displacement": (0.0, 0.005)})
    with pytest.warns(DampyrWarning, match=r"displacement reaches 0\.01 m; .* up to 0\.005 m"):
        damper.force(T, X, voltage=0.0)


def test_draws_follow_the_covariance_are_admissible_and_repeat() -> None:
    laws = {"dahl.kx": 800.0, "dahl.kw": 50.0, "dahl.rho": 900.0}
    covariance = np.diag([30.0**2, 2.0**2, 600.0**2])
    damper = Damper("dahl", laws, covariance=covariance)
    draws = damper.draws(400, seed=3)
    numbers = np.array([d.coefficients for d in draws])
    assert np.all(numbers > 0)
    assert np.std(numbers[:, 0]) == pytest.approx(30.0, rel=0.15)
    np.testing.assert_array_equal(numbers, [d.coefficients for d in damper.draws(400, seed=3)])
    assert not np.array_equal(numbers[0], damper.draws(1, seed=4)[0].coefficients)


def test_nothing_is_drawn_from_an_infinite_variance() -> None:
    with pytest.raises(InputError, match="no covariance"):
        published().draws(1, seed=0)
    laws = {"dahl.kx": 800.0, "dahl.kw": 50.0, "dahl.rho": 900.0}
    with pytest.raises(InputError, match="the variance of a coefficient is infinite: the records do not determine it"):
        Damper("dahl", laws, covariance=np.diag([1.0, 1.0, np.inf])).draws(1, seed=0)


def test_without_takes_a_part_and_its_errors_away() -> None:
    laws = {"dahl.kx": 800.0, "dahl.kw": 50.0, "dahl.rho": 900.0, "delay.tau": 0.01, "spring.k0": 3.0}
    full = Damper("dahl + delay + spring", laws, covariance=np.diag([1.0, 2.0, 3.0, 4.0, 5.0]))
    less = full.without("delay")
    assert less.parts == ("dahl", "spring")
    np.testing.assert_array_equal(np.diag(less.covariance), [1.0, 2.0, 3.0, 5.0])
    with pytest.raises(InputError, match="not a part"):
        full.without("offset")


def test_draws_that_hold_within_the_records_only_say_so_once_and_for_the_parts_that_are_left(tmp_path: Path) -> None:
    laws = {"dahl.kx": 800.0, "dahl.kw": 50.0, "dahl.rho": 900.0, "delay.tau": 0.01}
    few = Damper(
        "dahl + delay", laws, covariance=np.diag([1.0, 1.0, 1.0, 1e-6]), within_records=("dahl.kw", "delay.tau")
    )
    few = Damper.load(few.save(tmp_path / "card.toml"))
    with pytest.warns(
        DampyrWarning, match=r"the draws of dahl\.kw, delay\.tau hold within the fitted records only"
    ) as caught:
        few.draws(3, seed=1)
    assert len(caught) == 1
    assert few.without("delay").within_records == few.without("delay").on_brace(1e6).within_records == ("dahl.kw",)


def test_static_forces_can_be_left_out() -> None:
    laws = {"dahl.kx": 800.0, "dahl.kw": 50.0, "dahl.rho": 900.0, "offset.f0": 120.0}
    values = Damper("dahl + offset", laws).values(0.0, static=False)
    np.testing.assert_array_equal(values, [800.0, 50.0, 900.0, 0.0])


def test_laws_of_different_ranges_share_the_narrower() -> None:
    laws = {"dahl.kx": Interpolation((0.0, 3.0), (1.0, 2.0)), "dahl.kw": Interpolation((0.5, 2.0), (1.0, 2.0))}
    assert Damper("dahl", laws | {"dahl.rho": 900.0}).range == (0.5, 2.0)


def test_values_at_inputs_are_a_law_and_what_is_none_says_what_may_be_given() -> None:
    damper = Damper("dahl", {"kx": {0.0: 900.0, 2.0: "3000 N s/m"}, "kw": 200.0, "rho": 9000.0})
    assert damper.range == (0.0, 2.0)
    assert [damper.at(u).kx for u in (0.0, 2.0)] == [900.0, 3000.0]
    with pytest.raises(InputError, match=r"dahl.kx = \[1, 2\] is not a law; give a number, values at inputs such as"):
        Damper("dahl", {"kx": [1, 2], "kw": 200.0, "rho": 9000.0})


@pytest.mark.parametrize(
    ("parts", "laws", "words"),
    [
        ("dahl", {"dahl.kx": 1.0}, r"lacks a law for dahl\.kw, dahl\.rho"),
        ("dahl", {"dahl.kx": 1.0, "dahl.kw": 1.0, "dahl.rho": 1.0, "dahl.q": 1.0}, r"dahl\.q is not a parameter"),
        ("dahl", {"dahl.kx": 1.0, "dahl.kw": 1.0, "dahl.rho": 0.0}, r"dahl\.rho .* greater than 0"),
        ("dahll", {}, "did you mean 'dahl'"),
        ("dahl + dahl", {}, "is given twice"),
        ("delay", {"delay.tau": 0.1}, "makes no force"),
    ],
)
def test_wrong_dampers_are_refused(parts: str, laws: dict[str, float], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Damper(parts, laws)
