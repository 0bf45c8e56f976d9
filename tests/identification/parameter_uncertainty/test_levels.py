"""Levels of records and of measurement sessions: estimated where sessions repeat, said to be unknown where they do not."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.special import stdtrit
from tests.identification.synthetic import sine

from dampyr.errors import InputError
from dampyr.identification import Fit, ScoreOptions, fit, prediction_band, score, validate
from dampyr.identification.parameter_uncertainty.levels import PRIOR_FREEDOM, PRIOR_SESSION, _estimate_spread
from dampyr.models import Damper, Interpolation
from dampyr.records import Record
from dampyr.show.descriptions import description_of

VOLTS = (0.0, 1.0, 2.0)
LAWS = {
    "dahl.kx": Interpolation(VOLTS, (800.0, 1500.0, 2500.0)),
    "dahl.kw": Interpolation(VOLTS, (50.0, 200.0, 380.0)),
    "dahl.rho": Interpolation(VOLTS, (4000.0, 2800.0, 1800.0)),
}


def campaign(levels: dict[str, float], each: int = 3, repeated: bool = True) -> list[Record]:
    """Noise-free sines; every session at every voltage, or one session a voltage, each with its level."""
    records = []
    for i, u in enumerate(VOLTS):
        for j, (session, level) in enumerate(levels.items()):
            if not repeated and i != j:
                continue
            for k in range(each):
                record = sine(
                    Damper("dahl", LAWS), u, f"{u:g}V-{session}-{k}", 0.004 + 0.002 * k, 1.2 - 0.2 * k, offset=90.0
                )
                force = 90.0 + level * (record.force - 90.0)
                records.append(record.replace(note="of a session", force=force, measurement_session=session))
    return records


@pytest.fixture(scope="module")
def repeated() -> Fit:
    return fit(campaign({"Monday": 1.0, "Tuesday": 0.9, "Friday": 1.08}), "dahl")


def test_the_level_of_every_record_is_that_of_its_session(repeated: Fit) -> None:
    levels = repeated.levels
    assert levels is not None
    assert levels.repeated
    mean = np.mean([1.0, 0.9, 1.08])
    for name, level in levels.level.items():
        true = {"Monday": 1.0, "Tuesday": 0.9, "Friday": 1.08}[levels.session[name]]
        assert level == pytest.approx(true / mean, rel=0.02)
    assert levels.sessions == ("Monday", "Tuesday", "Friday")


def test_repeated_sessions_give_their_spread(repeated: Fit) -> None:
    levels = repeated.levels
    assert levels is not None
    true = float(np.std(np.log([1.0, 0.9, 1.08]), ddof=1))
    assert levels.session_reml == pytest.approx(true, rel=0.1)
    assert levels.record_sd < 0.02
    assert math.isfinite(levels.session_freedom)
    assert "estimated from 3 sessions" in levels.words
    assert levels.settles == ""
    assert levels.words in map(str, repeated.findings)


@pytest.fixture(scope="module")
def apart() -> Fit:
    """Of one session a voltage."""
    return fit(campaign({"Monday": 1.0, "Tuesday": 0.9, "Friday": 1.08}, repeated=False), "dahl")


def test_a_session_a_voltage_is_said_to_be_unknown(apart: Fit) -> None:
    done = apart
    levels = done.levels
    assert levels is not None
    assert not levels.repeated
    assert levels.session_sd == PRIOR_SESSION
    assert math.isnan(levels.session_reml)
    [note] = [note for note in map(str, done.findings) if "cannot be told apart" in note]
    assert "no voltage was measured in two sessions" in note
    assert "8 %" in note
    assert "repeat one test" in note
    assert all(level == pytest.approx(1.0, abs=1e-6) for level in levels.level.values())


@pytest.mark.parametrize("prior", [0.02, pytest.param(0.15, marks=pytest.mark.prove)])
def test_a_card_with_another_prior_is_that_of_a_fit_with_it(prior: float) -> None:
    records = campaign({"Monday": 1.0, "Tuesday": 0.9, "Friday": 1.08}, repeated=False)
    gains = 1.0 + np.random.default_rng(2).normal(0.0, 0.03, len(records))
    records = [
        one.replace(note="a gain", force=90.0 + gain * (one.force - 90.0))
        for one, gain in zip(records, gains, strict=True)
    ]
    made, refitted = fit(records, "dahl").damper, fit(records, "dahl", session_prior=prior).damper
    assert made is not None
    assert refitted is not None
    stated, right = made.with_session_prior(prior).prediction_error, refitted.prediction_error
    assert stated is not None
    assert right is not None
    assert stated.session_source == right.session_source
    assert (stated.session_sd, stated.record_sd) == (right.session_sd, right.record_sd)
    np.testing.assert_allclose(stated.session_levels, right.session_levels, atol=1e-12)
    np.testing.assert_allclose(stated.session_errors, right.session_errors, rtol=1e-9)
    probe = records[0].replace(note="of another day", measurement_session="Sunday", name="probe")
    scored = score(made, probe, band=0.9, session_prior=prior).band
    assert scored is not None
    assert scored.peak == prediction_band(refitted, probe).peak
    assert scored.words.endswith(f"with a stated prior of {100 * prior:.3g} % between sessions")
    [line] = [
        row
        for name, row in description_of(validate(made, [probe], ScoreOptions(session_prior=prior))).rows
        if name == "bands"
    ]
    assert line.endswith(f"with a stated prior of {100 * prior:.3g} % between sessions")


def test_no_prior_is_stated_where_it_was_estimated_or_cannot_be_known(repeated: Fit) -> None:
    estimated = repeated.damper
    nothing = fit(campaign({"Monday": 1.0}), "dahl", session_prior=0.0).damper
    assert estimated is not None
    assert nothing is not None
    with pytest.raises(InputError, match="was estimated from sessions that repeat a test"):
        estimated.with_session_prior(0.05)
    with pytest.raises(InputError, match="a session_prior of 0, which cannot be undone"):
        nothing.with_session_prior(0.05)
    with pytest.raises(InputError, match="session_prior = 8 is not allowed"):
        ScoreOptions(session_prior=8.0)


def test_records_without_a_session_say_so() -> None:
    records = [record.replace(note="of none", measurement_session=None) for record in campaign({"Monday": 1.0})]
    levels = fit(records, "dahl", session_prior=0.05).levels
    assert levels is not None
    assert "do not say in which measurement session" in levels.words
    assert levels.session_sd == 0.05
    assert "measurement_session" in levels.settles


def test_one_session_for_all_says_so() -> None:
    levels = fit(campaign({"Monday": 1.0}), "dahl").levels
    assert levels is not None
    assert "all records are of one measurement session" in levels.words


def test_intervals_between_sessions_widen_what_a_factor_on_the_force_changes(apart: Fit) -> None:
    done = apart
    within, between = done.intervals(), done.intervals(between="sessions")
    for label, value in done.parameters.items():
        half = 0.5 * (between[label][1] - between[label][0])
        if ".rho" in label:  # no factor on the force changes it
            assert between[label] == pytest.approx(within[label], rel=1e-6)
        else:
            assert half == pytest.approx(1.96 * PRIOR_SESSION * value, rel=0.02)
    with pytest.raises(InputError, match="choose 'records' or 'sessions'"):
        done.intervals(between="days")


@pytest.mark.parametrize("freedom", [1.0, 2.0, 7.0, 30.0])
def test_no_interval_between_sessions_is_narrower_than_that_between_records(freedom: float) -> None:
    """Satterthwaite's degrees of freedom for a sum would make it so; the variances alone are in a closed form."""
    levels = fit(campaign({"Monday": 1.0, "Tuesday": 0.9, "Friday": 1.08}, repeated=False), "dahl").levels
    assert levels is not None
    moved = PRIOR_SESSION * float(np.linalg.norm(levels.by_session[:, 0]))
    for error in (0.01 * moved, 0.3 * moved, moved, 10.0 * moved):
        reach = levels.reach_between_sessions(0, error, freedom, 0.95)
        own = float(stdtrit(freedom, 0.975)) * error
        assert reach > own
        assert reach == pytest.approx(math.hypot(own, 1.959964 * moved), rel=1e-6)


def test_the_direction_of_a_session_is_the_change_of_a_fit_to_stronger_records() -> None:
    """Against a second fit, to records of which those of one session are 1 % stronger."""
    levels = {"Monday": 1.0, "Tuesday": 1.0, "Friday": 1.0}
    one = fit(campaign(levels), "dahl")
    other = fit(campaign(levels | {"Tuesday": 1.01}), "dahl")
    assert one.levels is not None
    change = np.array(list(other.parameters.values())) - np.array(list(one.parameters.values()))
    k = one.levels.sessions.index("Tuesday")
    size = np.abs(np.array(list(one.parameters.values())))
    np.testing.assert_allclose(math.log(1.01) * one.levels.by_session[k] / size, change / size, atol=2e-4)


@pytest.mark.parametrize("prior", [-0.1, 1.5, math.nan])
def test_a_prior_that_is_no_spread_is_refused(prior: float) -> None:
    with pytest.raises(InputError, match=r"session_prior = .* must be at least 0 and at most 1; 0\.1 is 10 %"):
        fit(campaign({"Monday": 1.0}), "dahl", session_prior=prior)


def test_the_spread_of_balanced_levels_is_that_of_the_analysis_of_variance() -> None:
    """REML of a balanced design has a closed form: mean squares between and within (Searle, Casella and McCulloch 1992)."""
    rng = np.random.default_rng(3)
    sessions, each = 12, 6
    members = np.repeat(np.eye(sessions), each, axis=0)
    y = members @ rng.normal(0.0, 0.08, sessions) + rng.normal(0.0, 0.03, sessions * each)
    y -= y.mean()
    shown = np.eye(y.size) - 1.0 / y.size
    groups = y.reshape(sessions, each)
    within = float(np.sum((groups - groups.mean(axis=1, keepdims=True)) ** 2) / (sessions * (each - 1)))
    between = float(each * np.sum(groups.mean(axis=1) ** 2) / (sessions - 1))
    spread = _estimate_spread(y, shown, members, True, PRIOR_SESSION)
    assert spread.session_reml == pytest.approx(
        math.sqrt((between - within) / each), rel=0.05
    )  # the grid's step is 9 %
    assert spread.record_sd == pytest.approx(math.sqrt(within), rel=0.05)
    assert spread.session_sd == pytest.approx(spread.session_reml, rel=0.15)
    assert 6.0 < spread.session_freedom < 16.0


def test_gains_of_the_records_leave_the_levels_as_they_are() -> None:
    records = campaign({"Monday": 1.0, "Tuesday": 0.9, "Friday": 1.08})
    done = fit(records, "dahl", nuisances=("offset", "state", "gain"))
    assert done.levels is not None
    assert done.levels.session_reml == pytest.approx(float(np.std(np.log([1.0, 0.9, 1.08]), ddof=1)), rel=0.2)


def test_a_varying_input_counts_at_every_input_that_it_passes() -> None:
    damper = Damper("dahl", LAWS)
    records = []
    for session, level in (("Monday", 1.0), ("Tuesday", 0.9), ("Friday", 1.1)):
        for k in range(3):
            t = np.arange(0.0, 8.0, 0.005)
            u = 1.0 + np.sin(0.7 * t + k)
            x = 0.006 * np.sin(2 * np.pi * (0.8 + 0.2 * k) * t)
            v = np.gradient(x, t)
            force = level * damper.force(t, x, voltage=u, velocity=v)
            records.append(
                Record(t, x, force, velocity=v, voltage=u, name=f"{session}-{k}", measurement_session=session)
            )
    levels = fit(records, "dahl", laws="polynomial:2").levels
    assert levels is not None
    assert levels.repeated
    assert levels.session_reml == pytest.approx(0.1, abs=0.05)


@pytest.mark.prove
def test_the_published_campaign_is_told_that_level_and_voltage_cannot_be_told_apart(published_fit: Fit) -> None:
    done = published_fit
    assert any(
        "level and voltage cannot be told apart" in note and "0.8712 V" in note for note in map(str, done.findings)
    )
    assert done.damper is not None
    assert done.damper.prediction_error is not None
    assert not done.damper.prediction_error.session_estimated


@pytest.mark.parametrize(("true", "low", "high"), [(0.04, 99.0, 100.0), (0.08, 95.5, 97.5), (0.16, 81.0, 84.5)])
def test_what_two_sessions_and_a_prior_can_promise_of_a_third(true: float, low: float, high: float) -> None:
    """90 % intervals of the level of a third session, prior 8 %: why bands of two sessions hold more than they say."""
    rng, prior, record, draws = np.random.default_rng(0), 0.08, 0.03, 100_000
    levels = true * rng.standard_normal((draws, 3))
    contrast = (levels[:, 0] - levels[:, 1]) / math.sqrt(2.0) + record * rng.standard_normal(draws) / math.sqrt(8.0)
    scale = (PRIOR_FREEDOM * prior**2 + np.maximum(contrast**2 - record**2 / 8.0, 0.0)) / (PRIOR_FREEDOM + 1.0)
    reach = np.hypot(stdtrit(PRIOR_FREEDOM + 1.0, 0.95) * np.sqrt(1.5 * scale), 1.7 * record)
    error = levels[:, 2] - levels[:, :2].mean(axis=1) + record * rng.standard_normal(draws)
    assert low < 100.0 * np.mean(np.abs(error) < reach) < high
