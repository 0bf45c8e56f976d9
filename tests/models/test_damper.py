"""Dampers: forces along paths, ranges, cards, draws."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import DampyrWarning, ExtrapolationWarning, FileError, InputError, MissingData, RangeError
from dampyr.models import Damper, Interpolation, Polynomial, compose
from dampyr.models.parts import Compliance, Dahl, Spring
from dampyr.models.parts.bouc_wen import BoucWen, from_printed

T = np.linspace(0.0, 2.0, 1001)
X = 0.01 * np.sin(2 * np.pi * T)
V = 0.02 * np.pi * np.cos(2 * np.pi * T)


def published(**changes: object) -> Damper:
    """The cubics (4.6)-(4.8)."""
    laws = {
        "dahl.kx": Polynomial((802.0, 493.1, 34.2, 85.5), 0.0, 3.212),
        "dahl.kw": Polynomial((50.237, 201.92, -24.866, 3.6157), 0.0, 3.212),
        "dahl.rho": Polynomial((42745.0, -39038.0, 17881.0, -2836.8), 0.0, 3.212),
    }
    return Damper("dahl", laws, **changes)


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


def test_a_voltage_that_does_not_vary_is_the_same_as_a_number() -> None:
    damper = published()
    one = damper.force(T, X, voltage=1.5, velocity=V)
    np.testing.assert_array_equal(damper.force(T, X, voltage=np.full(T.size, 1.5), velocity=V), one)


def test_a_voltage_that_steps_changes_the_force_at_once_and_the_state_along_the_path() -> None:
    damper = published()
    u = np.where(T < 1.0, 0.0, 3.0)
    force = damper.force(T, X, voltage=u, velocity=V)
    np.testing.assert_allclose(force[T < 1.0], damper.force(T, X, voltage=0.0, velocity=V)[T < 1.0])
    late = damper.force(T, X, voltage=3.0, velocity=V)
    np.testing.assert_allclose(force[-200:], late[-200:], rtol=1e-6)


@pytest.mark.prove
def test_the_parts_of_a_composition_add_up_in_any_order() -> None:
    laws = {"dahl.kx": 800.0, "dahl.kw": 50.0, "dahl.rho": 9000.0, "spring.k0": 700.0}
    laws |= {"hyperbolic_tangent.c": 10.0, "hyperbolic_tangent.ft": 80.0}
    laws |= {"hyperbolic_tangent.v0": 0.01, "hyperbolic_tangent.s": 0.3}
    names = ("dahl", "spring", "hyperbolic_tangent")
    alone = sum(
        Damper(n, {k: v for k, v in laws.items() if k.startswith(n + ".")}).force(T, X, voltage=0.0, velocity=V)
        for n in names
    )
    for order in itertools.permutations(names):
        np.testing.assert_allclose(Damper(order, laws).force(T, X, voltage=0.0, velocity=V), alone, rtol=1e-12)


def test_a_delay_shifts_the_whole_force() -> None:
    laws = {"dahl.kx": 800.0, "dahl.kw": 50.0, "dahl.rho": 9000.0}
    plain = Damper("dahl", laws).force(T, X, voltage=0.0, velocity=V)
    late = Damper("dahl + delay", laws | {"delay.tau": 0.020}).force(T, X, voltage=0.0, velocity=V)
    np.testing.assert_allclose(late[10:], plain[:-10], rtol=1e-9)
    np.testing.assert_allclose(late[:10], plain[0])


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


@pytest.mark.parametrize(
    ("t", "x", "words"),
    [
        (T, X[:-1], "same length"),
        (T[::-1], X, "t must rise"),
        (T, np.where(T > 1.0, np.nan, X), "finite"),
        (T.reshape(7, -1), X.reshape(7, -1), "two vectors"),
    ],
)
def test_a_wrong_path_is_refused(t: np.ndarray, x: np.ndarray, words: str) -> None:
    with pytest.raises(InputError, match=words):
        published().force(t, x, voltage=0.0)


def test_a_wrong_initial_state_is_refused() -> None:
    with pytest.raises(InputError, match=r"dahl\.w = 1\.5 must lie between -1 and 1"):
        published().force(T, X, voltage=0.0, state0=[1.5])
    with pytest.raises(InputError, match="has 2 values"):
        published().force(T, X, voltage=0.0, state0=[0.0, 0.0])


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


def test_bouc_wen_checks_its_shape() -> None:
    with pytest.raises(InputError, match="sigma"):
        BoucWen(1.0, 1.0, 1.0, 1.0, 0.0, 1.0)
    with pytest.warns(DampyrWarning, match="not dissipative on every path"):
        BoucWen(1.0, 1.0, 1.0, 1.0, 0.3, 1.0)
    laws = {"bouc_wen.c0": 1.0, "bouc_wen.k0": 0.0, "bouc_wen.kw": 9.0, "bouc_wen.rho": 100.0, "bouc_wen.n": 1.0}
    with pytest.warns(DampyrWarning, match=r"bouc_wen\.sigma .* = 0\.3 is below 0\.5"):
        Damper("bouc_wen", laws | {"bouc_wen.sigma": Polynomial((0.6, -0.1), 0.0, 3.0)})
    with pytest.raises(InputError, match="makes energy"):
        from_printed(0.0, 0.0, 1.0, 1.0, beta=3.0, gamma=-1.0, n=1.5)
    with pytest.raises(InputError, match="without bound"):
        from_printed(0.0, 0.0, 1.0, 1.0, beta=-3.0, gamma=1.0, n=1.5)


def test_a_card_comes_back_to_the_last_bit(tmp_path: Path) -> None:
    damper = published(
        covariance=np.diag(np.linspace(0.1, 1.2, 12)) / 3.0,
        ranges={"displacement": (0.0, 0.0194), "velocity": (0.0, 0.076)},
        bandwidth=12.5,
        provenance={"records": "ensaio1.1, ensaio2.1"},
    )
    again = Damper.load(damper.save(tmp_path / "card.toml"))
    assert again.all_laws == damper.all_laws
    assert again.ranges == damper.ranges
    assert (again.bandwidth, again.input, again.provenance) == (12.5, "V", damper.provenance)
    np.testing.assert_array_equal(again.covariance, damper.covariance)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("schema = 1", "schema = 2", "schema 2 is not supported"),
        ('unit = "N s/m"', 'unit = "N s/mm"', "a card holds 'N s/m'"),
        ('kind = "polynomial"', 'kind = "magic"', "unknown law"),
        ("schema = 1", "schema = ", "not a TOML file"),
        ('input = "V"', 'input = "W"', "'V' or 'A'"),
        ("42745.0", "-42745.0", "greater than 0"),
        ("[damper]", "[dumper]", "lacks 'damper'"),
        ("[damper]", "[covariance]\nwithin_records_only = 3\n[damper]", "= 3 is not allowed; give a list of names"),
    ],
)
def test_a_broken_card_is_refused_by_name(tmp_path: Path, old: str, new: str, words: str) -> None:
    path = published().save(tmp_path / "card.toml")
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(FileError, match=words) as caught:
        Damper.load(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value).replace("\n", "", 0) or "TOML" in str(caught.value)


def test_a_missing_card_says_how_to_make_one(tmp_path: Path) -> None:
    with pytest.raises(MissingData, match="dampyr identify"):
        Damper.load(tmp_path / "none.toml")


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


def test_a_composition_can_be_read() -> None:
    text = compose("dahl + spring").source()
    assert "def advance_0(s, x0, x1, v0, v1, dt, p):" in text
    compile(text, "<test>", "exec")


def test_values_at_inputs_are_a_law_and_what_is_none_says_what_may_be_given() -> None:
    damper = Damper("dahl", {"kx": {0.0: 900.0, 2.0: "3000 N s/m"}, "kw": 200.0, "rho": 9000.0})
    assert damper.range == (0.0, 2.0)
    assert [damper.at(u).kx for u in (0.0, 2.0)] == [900.0, 3000.0]
    with pytest.raises(InputError, match=r"dahl.kx = \[1, 2\] is not a law; give a number, values at inputs such as"):
        Damper("dahl", {"kx": [1, 2], "kw": 200.0, "rho": 9000.0})
