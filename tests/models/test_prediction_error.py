"""The prediction error of a card: levels, draws, and what is said of a table that is wrong."""

from __future__ import annotations

import math
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from dampyr.errors import FileError, InputError
from dampyr.models import Constant, Damper, Interpolation, available_parts, part
from dampyr.models.prediction_error import (
    HARMONICS,
    PredictionError,
    ShapeError,
    force_power,
    level_direction,
    phase_basis,
    residual_draw,
)

ZEROS = (0.0,) * (2 * HARMONICS)
SHAPE = ShapeError(1.0, ZEROS, ZEROS, 0.0, 0.0, 0.0, 8)
LAWS = {
    "dahl.kx": Interpolation((0.0, 2.0), (800.0, 2000.0)),
    "dahl.kw": Interpolation((0.0, 2.0), (50.0, 300.0)),
    "dahl.rho": Constant(4000.0, 0.0, 2.0),
}


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
    values = {key: max(q.low if math.isfinite(q.low) else 0.0, 0.0) + 1e-3 for key, q in part(name).parameters.items()}
    values |= {key: v for key, v in {"c0": 900.0, "c": 900.0, "kx": 900.0, "kw": 80.0, "fc": 60.0, "fy": 60.0, "ft": 60.0,
                                     "n": 1.5, "sigma": 0.8, "rho": 3000.0, "k0": 500.0, "k1": 500.0, "f0": 90.0, "L": 0.1,
                                     "gamma": 1.2, "m": 2.0, "s": 5e-7, "sigma1": 50.0, "sigma2": 100.0, "e": 0.4, "vs": 0.01,
                                     "v0": 0.01, "vy": 0.01, "vh": 0.005, "vk": 0.01, "vc": 0.1, "r": 0.5, "kappa": 50.0,
                                     "tau": 0.005, "g": 1e-4}.items() if key in values}  # fmt: skip
    if name == "hyperbolic_tangent":
        values["s"] = 5.0
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


def test_draws_have_the_levels_of_the_sessions_and_of_the_record_in_them() -> None:
    """ln of kw: twice the variance of a session (that of the fit and that to come), and that of a record."""
    drawn = damper().draws(4000, seed=1)
    logs = np.log([one.coefficients[2:4] for one in drawn])
    np.testing.assert_allclose(np.std(logs, axis=0), math.sqrt(2 * 0.08**2 + 0.03**2), rtol=0.05)
    np.testing.assert_allclose(np.std([one.coefficients[4] for one in drawn]), 10.0, rtol=0.05)  # rho has no level
    assert np.corrcoef(logs.T)[0, 1] == pytest.approx((0.08**2 + 0.03**2) / (2 * 0.08**2 + 0.03**2), abs=0.05)
    plain = damper().draws(4000, seed=1, levels=False)
    np.testing.assert_allclose(np.std([one.coefficients for one in plain], axis=0), [1, 1, 0.1, 0.1, 10], rtol=0.05)


def test_draws_take_the_covariance_within_sessions_where_there_is_one(tmp_path: Path) -> None:
    small = damper(within_sessions=np.diag([1.0, 1.0, 0.01, 0.01, 1.0]))
    assert np.std([one.coefficients[4] for one in small.draws(2000, seed=1)]) == pytest.approx(1.0, rel=0.1)
    again = Damper.load(small.save(tmp_path / "card.toml"))
    assert again.prediction_error is not None
    np.testing.assert_array_equal(again.prediction_error.within_sessions, np.diag([1.0, 1.0, 0.01, 0.01, 1.0]))
    assert small.on_brace(1e6).prediction_error.within_sessions.shape == (6, 6)  # type: ignore[union-attr]


def test_few_degrees_of_freedom_widen_the_draws() -> None:
    few = damper(session_freedom=3.0).draws(4000, seed=2)
    many = damper().draws(4000, seed=2)
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
    noise = residual_draw(basis, 0.01, shape, np.random.default_rng(1))
    assert np.std(noise) == pytest.approx(math.hypot(0.05, 0.02), rel=0.05)
    lag = float(np.mean(noise[20:] * noise[:-20]))
    assert lag == pytest.approx(0.05**2 * math.exp(-1.0), rel=0.1)
    assert lfilter([1.0], [1.0, 0.0], noise)[3] == noise[3]


def test_the_shape_of_a_draw_repeats_with_the_motion_and_shrinks_with_it() -> None:
    t = np.arange(0.0, 8.0, 0.01)
    x, v = np.sin(2 * np.pi * t), 2 * np.pi * np.cos(2 * np.pi * t)
    shape = replace(SHAPE, shape_mean=(0.1, 0.0, 0.0, 0.05, *ZEROS[4:]), records=1_000_000)
    drawn = residual_draw(phase_basis(t, x, v), 0.01, shape, np.random.default_rng(1))
    np.testing.assert_allclose(
        drawn[100:200], drawn[300:400], atol=0.02
    )  # a line through eight cycles of a sine is not quite flat
    assert np.ptp(drawn) == pytest.approx(0.2, rel=0.5)
    half = np.where(t < 4.0, 1.0, 0.5)
    smaller = residual_draw(phase_basis(t, half * x, half * v), 0.01, shape, np.random.default_rng(1))
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
    with pytest.raises(InputError, match="'three' is no session that the damper was fitted on; choose from one, two"):
        one.band(t, x, voltage=1.0, session="three")
    with pytest.raises(InputError, match="level = 90 is not allowed"):
        one.band(t, x, voltage=1.0, level=90.0)
    with pytest.raises(InputError, match="has no prediction error"):
        replace(one, prediction_error=None).band(t, x, voltage=1.0)
