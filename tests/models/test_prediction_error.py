"""The prediction error of a card: levels, draws, and what is said of a table that is wrong."""

from __future__ import annotations

import math
import tomllib
import warnings
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from dampyr.errors import DampyrWarning, FileError, InputError
from dampyr.identification import score, validate
from dampyr.models import Constant, Damper, Interpolation, Polynomial, available_parts
from dampyr.models.part import part
from dampyr.models.prediction_error import (
    HARMONICS,
    PredictionError,
    ShapeError,
    force_power,
    moved,
    phase_basis,
    residual_draw,
    square_root,
)
from dampyr.records import Record

ZEROS = (0.0,) * (2 * HARMONICS)
SHAPE = ShapeError(1.0, ZEROS, ZEROS, 0.0, 0.0, 0.0, 8)
LAWS = {
    "dahl.kx": Interpolation((0.0, 2.0), (800.0, 2000.0)),
    "dahl.kw": Interpolation((0.0, 2.0), (50.0, 300.0)),
    "dahl.rho": Constant(4000.0, 0.0, 2.0),
}


def level_direction(one: Damper) -> np.ndarray:
    """The change (m,) of a damper's coefficients with the logarithm of its level; the static offset has none."""
    static = one.composition.static
    powers = [
        0 if k in static else force_power(quantity.unit)
        for k, quantity in enumerate(one.composition.quantities.values())
    ]
    return np.concatenate(
        [power * np.array(law.coefficients) for power, law in zip(powers, one.all_laws.values(), strict=True)]
    )


def damper(**changes: object) -> Damper:
    error = PredictionError(
        record_sd=0.03,
        record_freedom=math.inf,
        session_sd=0.08,
        session_freedom=math.inf,
        session_source="stated in a test",
        freedom=math.inf,
        sessions=("one", "two"),
        directions=np.array([[800.0, 0.0, 50.0, 0.0, 0.0], [0.0, 2000.0, 0.0, 300.0, 0.0]]),
        session_levels=(0.02, -0.01),
        session_errors=(0.0, 0.0),
        shapes=(SHAPE,),
    )
    return Damper(
        "dahl", LAWS, covariance=np.diag([1.0, 1.0, 0.01, 0.01, 100.0]), prediction_error=replace(error, **changes)
    )  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("unit", "power"),
    [("N", 1), ("N s/m", 1), ("N/m", 1), ("kg", 1), ("m/N", -1), ("1/m", 0), ("", 0), ("m/s", 0), ("s", 0), ("1/s", 0)],
)
def test_a_parameter_goes_with_the_force_by_its_unit(unit: str, power: int) -> None:
    assert force_power(unit) == power


def values_of(name: str) -> dict[str, float]:
    """Ordinary values of a part's parameters."""
    values = {key: max(q.low if math.isfinite(q.low) else 0.0, 0.0) + 1e-3 for key, q in part(name).parameters.items()}
    values |= {key: v for key, v in {"c0": 900.0, "c": 900.0, "kx": 900.0, "kw": 80.0, "fc": 60.0, "fy": 60.0, "ft": 60.0,
                                     "n": 1.5, "sigma": 0.8, "rho": 3000.0, "k0": 500.0, "k1": 500.0, "f0": 90.0, "L": 0.1,
                                     "gamma": 1.2, "m": 2.0, "s": 5e-7, "sigma1": 50.0, "sigma2": 100.0, "e": 0.4, "vs": 0.01,
                                     "v0": 0.01, "vy": 0.01, "vh": 0.005, "vk": 0.01, "vc": 0.1, "r": 0.5, "kappa": 50.0,
                                     "tau": 0.005, "g": 1e-4}.items() if key in values}  # fmt: skip
    if name == "hyperbolic_tangent":
        values["s"] = 5.0
    return values


QUICK = ("dahl", "spring")  # of the others each composition compiles


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[] if name in QUICK else [pytest.mark.prove])
        for name in available_parts()
        if name != "lag"
    ],
)
def test_a_level_multiplies_the_force_of_every_part(name: str) -> None:
    """True of any formula whose units are right, in series too: the static offset alone stays."""
    values = values_of(name)
    laws = {f"{name}.{key}": value for key, value in values.items()}
    base = "" if name == "dahl" else "dahl + "
    one = Damper(f"{base}{name}", laws | {"dahl.kx": 800.0, "dahl.kw": 50.0, "dahl.rho": 4000.0} if base else laws)
    t = np.linspace(0.0, 3.0, 900)
    x = 0.008 * np.sin(5.0 * t)
    static = sum(float(one.all_laws[key](0.0)) for key in one.all_laws if key == "offset.f0")
    force, stronger = (each.force(t, x, voltage=0.0) - static for each in (one, one.at_level(1.1)))
    np.testing.assert_allclose(stronger, 1.1 * force, atol=2e-7 * np.abs(force).max())
    np.testing.assert_allclose(
        one.coefficients + 1e-6 * level_direction(one), one.at_level(math.exp(1e-6)).coefficients, rtol=1e-9
    )


@pytest.mark.parametrize("level", [0.0, -1.0, math.nan])
def test_a_level_that_is_no_factor_is_refused(level: float) -> None:
    with pytest.raises(InputError, match="it must be greater than 0, 1 being the fitted one"):
        damper().at_level(level)


@pytest.mark.prove
def test_draws_have_the_levels_of_the_sessions_and_of_the_record_in_them() -> None:
    """ln of kw: twice the variance of a session (that of the fit and that to come), and that of a record."""
    drawn = damper().draws(4000, seed=1)  # the standard error of a spread is 1.1 %
    logs = np.log([one.coefficients[2:4] for one in drawn])
    np.testing.assert_allclose(np.std(logs, axis=0), math.sqrt(2 * 0.08**2 + 0.03**2), rtol=0.05)
    np.testing.assert_allclose(np.std([one.coefficients[4] for one in drawn]), 10.0, rtol=0.05)  # rho has no level
    assert np.corrcoef(logs.T)[0, 1] == pytest.approx((0.08**2 + 0.03**2) / (2 * 0.08**2 + 0.03**2), abs=0.05)
    plain = damper().draws(4000, seed=1, levels=False)
    np.testing.assert_allclose(np.std([one.coefficients for one in plain], axis=0), [1, 1, 0.1, 0.1, 10], rtol=0.05)


def test_draws_take_the_covariance_within_sessions_where_there_is_one(tmp_path: Path) -> None:
    small = damper(within_sessions=np.diag([1.0, 1.0, 0.01, 0.01, 1.0]))
    assert np.std([one.coefficients[4] for one in small.draws(500, seed=1)]) == pytest.approx(1.0, rel=0.1)
    again = Damper.load(small.save(tmp_path / "card.toml"))
    assert again.prediction_error is not None
    np.testing.assert_array_equal(again.prediction_error.within_sessions, np.diag([1.0, 1.0, 0.01, 0.01, 1.0]))
    assert small.on_brace(1e6).prediction_error.within_sessions.shape == (6, 6)  # type: ignore[union-attr]


@pytest.mark.parametrize("number", [600, pytest.param(4000, marks=pytest.mark.prove)])
def test_few_degrees_of_freedom_widen_the_draws(number: int) -> None:
    few = damper(session_freedom=3.0).draws(number, seed=2)
    many = damper().draws(number, seed=2)
    wide, narrow = (
        np.quantile([math.log(one.coefficients[2]) for one in each], 0.97) - math.log(50.0) for each in (few, many)
    )
    assert wide > 1.3 * narrow


def test_a_card_keeps_it(tmp_path: Path) -> None:
    path = damper().save(tmp_path / "card.toml")
    text = path.read_text()
    assert "# The level between measurement sessions is not known" in text or "inf" in text
    again = Damper.load(path)
    assert again.prediction_error is not None
    assert again.prediction_error.card() == damper().prediction_error.card()  # type: ignore[union-attr]
    assert again.save(tmp_path / "again.toml").read_text() == text
    assert tomllib.loads(text)["prediction_error"]["session_sd"] == 0.08


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("session_sd = 0.08", "session_sd = 8.0", "it must lie between 0 and 1 (0.08 is 8 %)"),
        ("record_sd = 0.03", "", "lacks 'record_sd'"),
        ("record_sd = 0.03", "record_sd = 0.03\nsd = 1", "has 'sd', which is unknown"),
        ('"two"', '"two", "three"', "one row of finite directions for each of its 3 sessions"),
        ("noise = 0.0", "noise = -1.0", "noise = -1 is not allowed"),
    ],
)
def test_a_table_that_is_wrong_is_a_sentence(tmp_path: Path, before: str, after: str, words: str) -> None:
    path = damper().save(tmp_path / "card.toml")
    text = path.read_text()
    assert before in text
    path.write_text(text.replace(before, after, 1))
    with pytest.raises(FileError) as caught:
        Damper.load(path)
    assert words in str(caught.value)


def test_the_directions_follow_the_coefficients() -> None:
    one = damper()
    assert one.prediction_error is not None
    with pytest.raises(InputError, match="directions have 5 columns; the laws have 4"):
        replace(one, laws=one.all_laws | {"dahl.kw": 50.0}, covariance=np.eye(4))
    with pytest.raises(InputError, match="needs the covariance"):
        replace(one, covariance=None)
    with pytest.raises(InputError, match="within_sessions must be a finite matrix of 5 rows"):
        damper(within_sessions=np.eye(4))
    braced = one.on_brace(1e6)
    assert braced.prediction_error is not None
    assert braced.prediction_error.directions[:, -1].tolist() == [0.0, 0.0]
    assert braced.without("compliance").prediction_error.card() == one.prediction_error.card()  # type: ignore[union-attr]


def test_the_noise_of_a_draw_has_its_size_and_its_memory() -> None:
    t = np.arange(0.0, 400.0, 0.01)
    basis = phase_basis(t, np.sin(5.0 * t), 5.0 * np.cos(5.0 * t))
    shape = replace(SHAPE, noise=0.05, noise_time=0.2, white=0.02)
    noise, white = residual_draw(basis, 0.01, shape, np.random.default_rng(1))
    assert np.std(noise) == pytest.approx(0.05, rel=0.07)
    assert np.std(white) == pytest.approx(0.02, rel=0.05)
    lag = float(np.mean(noise[20:] * noise[:-20]))
    assert lag == pytest.approx(0.05**2 * math.exp(-1.0), rel=0.1)
    assert lfilter([1.0], [1.0, 0.0], noise)[3] == noise[3]


def test_the_shape_of_a_draw_repeats_with_the_motion_and_shrinks_with_it() -> None:
    t = np.arange(0.0, 8.0, 0.01)
    x, v = np.sin(2 * np.pi * t), 2 * np.pi * np.cos(2 * np.pi * t)
    shape = replace(SHAPE, shape_mean=(0.1, 0.0, 0.0, 0.05, *ZEROS[4:]), records=1_000_000)
    drawn, _ = residual_draw(phase_basis(t, x, v), 0.01, shape, np.random.default_rng(1))
    np.testing.assert_allclose(
        drawn[100:200], drawn[300:400], atol=0.02
    )  # a line through eight cycles of a sine is not quite flat
    assert np.ptp(drawn) == pytest.approx(0.2, rel=0.5)
    half = np.where(t < 4.0, 1.0, 0.5)
    smaller, _ = residual_draw(phase_basis(t, half * x, half * v), 0.01, shape, np.random.default_rng(1))
    assert np.ptp(smaller[450:650]) == pytest.approx(0.5 * np.ptp(smaller[150:350]), rel=0.1)


def test_the_band_of_a_path_is_about_the_force_and_narrower_for_a_fitted_session() -> None:
    one, t = damper(), np.arange(0.0, 4.0, 0.01)
    x = 0.008 * np.sin(5.0 * t)
    force = one.force(t, x, voltage=1.0)
    low, high = one.band(t, x, voltage=1.0, seed=3)
    assert np.all(low <= high)
    large = np.abs(force) > 0.7 * np.abs(force).max()
    assert np.all((low < force)[large] & (force < high)[large])
    # two sessions' levels and a record's: 1.645 sqrt(2 0.08^2 + 0.03^2) = 19 % at 0 and 2 V, a little less half way
    half = 0.5 * np.median((high - low)[large] / np.abs(force[large]))
    assert half == pytest.approx(0.17, abs=0.03)
    near, far = one.band(t, x, voltage=1.0, session="one", seed=3)
    assert 0.5 * np.median((far - near)[large] / np.abs(force[large])) == pytest.approx(1.645 * 0.03, rel=0.25)
    with pytest.raises(
        InputError, match="'three' is not a session that the damper was fitted on; choose from one, two"
    ):
        one.band(t, x, voltage=1.0, session="three")
    with pytest.raises(InputError, match="level = 90 is not allowed"):
        one.band(t, x, voltage=1.0, level=90.0)
    with pytest.raises(InputError, match="has no prediction error"):
        replace(one, prediction_error=None).band(t, x, voltage=1.0)


COMPOSITIONS = (
    *(
        name if name in ("dahl", "bouc_wen", "lugre") else f"dahl + {name}"
        for name in available_parts()
        if name != "dahl"
    ),
    "modified_bouc_wen + lag",
    "hyperbolic_tangent + compliance + spring + delay",
    "hysteretic_biviscous + spring + compliance + offset",
)


def limited(model: str, kind: str, at_limit: bool) -> Damper:
    """A damper over 0 to 2 V, its parameters ordinary or, where they may be, at the lower end of the allowed values."""
    laws: dict[str, object] = {}
    for name in model.split(" + "):
        for key, value in values_of(name).items():
            q = part(name).parameters[key]
            value = q.low if at_limit and math.isfinite(q.low) and not q.open_low else value
            laws[f"{name}.{key}"] = (
                Interpolation((0.0, 1.0, 2.0), (value, value + 0.1 * abs(value), value + 0.2 * abs(value)))
                if kind == "interpolation" and name != "lag"
                else Polynomial((value, -0.4 * (value - max(q.low, 0.0)), 0.1 * value, 0.01 * value), 0.0, 2.0)
                if kind == "polynomial" and name != "lag"
                else Constant(value, 0.0, 2.0)
            )
    return Damper(model, laws)  # type: ignore[arg-type]


def with_covariance(one: Damper, size: float) -> Damper:
    """With errors of ``size`` times the coefficients, correlated, and the levels of a session."""
    scale = size * (np.abs(one.coefficients) + 1e-3 * (one.coefficients == 0.0))
    root = scale[:, None] * np.random.default_rng(5).standard_normal((scale.size, scale.size)) / math.sqrt(scale.size)
    error = damper().prediction_error
    assert error is not None
    directions = np.array([level_direction(one)] * 2)
    return replace(one, covariance=root @ root.T, prediction_error=replace(error, directions=directions))


#: a model of each kind; the kernels of the others take long to compile
OF_EACH_KIND = {"dahl + sigmoid", "bouc_wen", "lugre", "dahl + place_friction", "dahl + triple_pendulum"}
#: of the others each takes a second
BRIEF = ((COMPOSITIONS[-3], "polynomial", False), (COMPOSITIONS[-2], "interpolation", True))


@pytest.mark.parametrize(
    ("model", "kind", "at_limit"),
    [
        pytest.param(
            *case,
            marks=[]
            if case in BRIEF
            else pytest.mark.prove
            if case[0] in OF_EACH_KIND or case[1:] == ("polynomial", True)
            else pytest.mark.by_hand,
        )
        for case in product(COMPOSITIONS, ("constant", "interpolation", "polynomial"), (False, True))
    ],
)
def test_every_covariance_gives_draws_of_every_model(model: str, kind: str, at_limit: bool) -> None:
    """A damper refuses what is not allowed, so that every one that is made is admissible."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        one = limited(model, kind, at_limit)
        for size in (1e-3, 1.0, 1e3):
            wide = with_covariance(one, size)
            for levels in (False, True):
                drawn = wide.draws(5, seed=1, levels=levels)
                assert len(drawn) == 5
                assert all(np.all(np.isfinite(each.coefficients)) for each in drawn)
            again = wide.draws(5, seed=1)
            np.testing.assert_array_equal([each.coefficients for each in drawn], [each.coefficients for each in again])


def test_small_errors_are_drawn_as_the_normal_distribution_has_them() -> None:
    """A change loses its third order: of a hundredth of the way to the limit 2e-4 of itself, at two standard errors."""
    errors = np.array([8.0, 20.0, 0.5, 3.0, 40.0])
    one = replace(damper(), prediction_error=None, covariance=np.diag(errors**2))
    normal = errors * np.random.default_rng(3).standard_normal((500, 5))
    drawn = np.array([each.coefficients for each in one.draws(500, seed=3)]) - one.coefficients
    np.testing.assert_allclose(drawn, normal, rtol=1e-3)
    np.testing.assert_allclose(drawn.mean(axis=0) / errors, normal.mean(axis=0) / errors, atol=1e-3)
    np.testing.assert_allclose(np.cov((drawn / errors).T), np.cov((normal / errors).T), atol=2e-3)


def test_a_covariance_of_very_different_units_keeps_its_small_numbers() -> None:
    """1/m beside m/N: the rounding of the one's variance, 1e-10, is far above the other's, 1e-16."""
    rng = np.random.default_rng(2)
    scale = np.array([1e3, 20.0, 2.0, 1e-8])
    correlation = np.corrcoef(rng.standard_normal((4, 30)))
    covariance = correlation * np.outer(scale, scale)
    root = square_root(covariance)
    np.testing.assert_allclose(root @ root.T, covariance, rtol=1e-12)


def test_a_change_goes_towards_a_limit_as_far_as_it_can() -> None:
    """The closed form of one parameter, downwards and upwards; at the limit only the other way is open."""
    one = Damper("spring + dahl", {"spring.k0": 0.0, "dahl.kx": 100.0, "dahl.kw": 50.0, "dahl.rho": 4000.0})
    change = np.array([-7.0, -300.0, 20.0, -4000.0])
    expected = [-7.0, 100.0 - 300.0 / math.sqrt(10.0), 70.0, 4000.0 * (1.0 - math.sqrt(0.5))]
    np.testing.assert_allclose(moved(one, change).coefficients, expected, rtol=1e-12)
    at = one.with_coefficients([0.0, 0.0, 50.0, 4000.0])
    assert [moved(at, np.array([0.0, d, 0.0, 0.0])).coefficients[1] for d in (-5.0, 5.0)] == [0.0, 5.0]


@pytest.mark.prove
def test_the_medians_of_wide_draws_are_the_fitted_numbers() -> None:
    one = Damper("spring + dahl", {"spring.k0": 0.0, "dahl.kx": 100.0, "dahl.kw": 50.0, "dahl.rho": 4000.0})
    wide = replace(one, covariance=np.diag([1.0, 1e6, 1e4, 1e8]))
    medians = np.median([each.coefficients for each in wide.draws(4001, 1)], axis=0)
    np.testing.assert_allclose(medians[1:], one.coefficients[1:], rtol=0.25)


@pytest.mark.parametrize(
    "model",
    [
        model
        if model == "dahl + spring"
        else pytest.param(model, marks=pytest.mark.prove if model in OF_EACH_KIND else pytest.mark.by_hand)
        for model in COMPOSITIONS
        if "hardening" not in model
    ],
)
def test_every_model_has_bands_and_scores_with_any_covariance(model: str) -> None:
    t = np.linspace(0.0, 4.0, 801)
    x = 0.008 * np.sin(2 * np.pi * t)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        one = with_covariance(limited(model, "interpolation", at_limit=False), 1.0)
        record = Record(t, x, one.force(t, x, voltage=1.0), voltage=1.0, name="a")
        scored = score(one, record, band=0.9)
        assert scored.band is not None
        assert np.all(np.isfinite(scored.band.low) & np.isfinite(scored.band.high))
        validated = validate(one, [record])
        assert validated.no_band == ""


def test_where_some_draws_have_no_limit_there_is_no_band_and_the_reason_is_told() -> None:
    """Hardening numbers that end in infinity along the record, among draws of a damper that does not."""
    laws = {"c0": 900.0, "k0": 500.0, "kw": 80.0, "rho": 100.0, "h": 0.2, "n": 1.5}
    one = Damper("hardening_bouc_wen", {f"hardening_bouc_wen.{key}": Constant(v, 0.0, 2.0) for key, v in laws.items()})
    t = np.linspace(0.0, 4.0, 801)
    x = 0.008 * np.sin(2 * np.pi * t)
    record = Record(t, x, one.force(t, x, voltage=1.0), voltage=1.0, name="a")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        validated = validate(with_covariance(one, 1.0), [record])
    assert validated.bands == {}
    assert "the force is infinite at" in validated.no_band
    assert validate(with_covariance(one, 1e-4), [record]).no_band == ""
