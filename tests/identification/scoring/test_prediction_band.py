"""Predictive bands: do they hold what they say, of records of another session, and is it the sessions that make them do so?"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.endurance import Endurance
from tests.identification.parameter_uncertainty.heated_records import heated
from tests.identification.test_coverage import TESTED, as_measured

from dampyr.errors import InputError
from dampyr.identification import Fit, ScoreOptions, fit, prediction_band, validate
from dampyr.identification.scoring.score import score
from dampyr.models import Damper
from dampyr.records import Record, read_campaign

SESSION = 0.08  # the spread of the sessions' levels in the simulated campaigns
SESSIONS = 5


def with_level(record: Record, level: float, session: str) -> Record:
    """The record as a session of this level gives it."""
    force = float(np.mean(record.force)) + level * (record.force - np.mean(record.force))
    return record.replace(note="of a session", force=force, measurement_session=session)


def campaign(seed: int, repeated: bool, each: int) -> Iterator[Record]:
    """Records with coloured noise and gains at four voltages: a session a voltage, or each session at every voltage."""
    rng = np.random.default_rng([seed, each, int(repeated)])
    levels = np.exp(SESSION * rng.standard_normal(SESSIONS))
    for i, u in enumerate(TESTED):
        for k in range(each):
            session = k % SESSIONS if repeated else i
            yield with_level(as_measured(u, f"{u:g}V-{k}", rng, 12.0), float(levels[session]), f"day {session}")


def unseen(seed: int) -> Record:
    """A record of a session that was not fitted."""
    rng = np.random.default_rng([seed, 99])
    level = math.exp(SESSION * rng.standard_normal())
    return with_level(as_measured(TESTED[seed % 4], "unseen", rng, 12.0), level, "another day")


def without_sessions(damper: Damper) -> Damper:
    """The damper as it was predicted before sessions counted."""
    assert damper.prediction_error is not None
    return replace(damper, prediction_error=replace(damper.prediction_error, session_sd=0.0, session_freedom=math.inf))


@pytest.mark.prove
@pytest.mark.endure
@pytest.mark.parametrize(
    "repeated", [pytest.param(False, marks=pytest.mark.by_hand), True], ids=["a session a voltage", "sessions repeat"]
)
@pytest.mark.parametrize("each", [6])
def test_bands_hold_the_peaks_of_another_session(each: int, repeated: bool, endurance: Endurance) -> None:
    campaigns = endurance.count(1000, part=80)
    peaks, energies, samples, before = [], [], [], []
    for seed in range(campaigns):
        done = fit(list(campaign(seed, repeated, each)), "dahl")
        assert done.damper is not None
        record = unseen(seed)
        band = prediction_band(done.damper, record, seed=seed)
        assert band.session is None
        assert band.energy is not None
        peaks.append(band.peak.holds)
        energies.append(band.energy.holds)
        samples.append(band.holds)
        before.append(prediction_band(without_sessions(done.damper), record, seed=seed).peak.holds)
    held, of_energy, of_samples, old = (100 * float(np.mean(each)) for each in (peaks, energies, samples, before))
    endurance.report(
        f"90 % bands of another session, {each} records a voltage, {'sessions repeat' if repeated else 'a session a voltage'}",
        0,
        f"{campaigns} campaigns: peaks {held:.1f} %, energies {of_energy:.1f} %, samples {of_samples:.1f} %; without levels of "
        f"sessions {old:.1f} % of the peaks",
    )
    slack = 0.0 if endurance.full else 200.0 * math.sqrt(0.9 * 0.1 / campaigns)  # two standard errors of the share
    assert 85.0 - slack <= held <= 95.0 + slack
    assert 85.0 - slack <= of_energy <= 95.0 + slack
    assert 84.0 - slack <= of_samples <= 96.0 + slack
    assert old < 75.0  # the same bands without sessions do not hold them


@pytest.mark.prove
@pytest.mark.endure
@pytest.mark.parametrize(
    "true",
    [SESSION, *(pytest.param(wrong * SESSION, marks=pytest.mark.by_hand) for wrong in (0.5, 2.0))],
    ids=lambda true: f"prior {0.08 / true:g} times the truth",
)
def test_bands_of_two_sessions_whose_records_heat_up(true: float, endurance: Endurance) -> None:
    """Four records a voltage, two of each of two sessions; the unseen one is of a third session."""
    campaigns = endurance.count(400, part=40)
    peaks, energies, samples, drifts = [], [], [], []
    for seed in range(campaigns):
        rng = np.random.default_rng([seed, 7])
        levels = np.exp(true * rng.standard_normal(3))
        records = [
            with_level(heated(as_measured(u, f"{u:g}V-{k}", rng, 12.0)), float(levels[k % 2]), f"day {k % 2}")
            for u in TESTED
            for k in range(4)
        ]
        done = fit(records, "dahl", session_prior=SESSION)
        assert done.damper is not None
        assert done.levels is not None
        record = heated(as_measured(TESTED[seed % 4], "unseen", rng, 12.0))
        band = prediction_band(done.damper, with_level(record, float(levels[2]), "another day"), seed=seed)
        assert band.energy is not None
        peaks.append(band.peak.holds)
        energies.append(band.energy.holds)
        samples.append(band.holds)
        drifts.append(done.levels.drift is not None)
    held, of_energy, of_samples, found = (100 * float(np.mean(each)) for each in (peaks, energies, samples, drifts))
    endurance.report(
        f"90 % bands of a third session, records that heat up by 10 %, prior {SESSION / true:g} times the truth",
        0,
        f"{campaigns} campaigns: peaks {held:.1f} %, energies {of_energy:.1f} %, samples {of_samples:.1f} %; drift found in "
        f"{found:.0f} %",
    )
    slack = 0.0 if endurance.full else 200.0 * math.sqrt(0.9 * 0.1 / campaigns)
    low, high = (85.0, 98.0) if true == SESSION else (78.0, 100.0)  # decision 67: two sessions promise no less
    assert found > 95.0 - slack
    for share in (held, of_energy, of_samples):
        assert low - slack <= share <= high + slack


def of_a_sensor(record: Record, noise: float, false: float = 0.0) -> Record:
    """With white noise of ``noise`` N, and a share of false samples that are off by 200 N."""
    rng = np.random.default_rng(list(record.name.encode()))
    off = np.where(rng.random(record.n) < false, rng.normal(0.0, 200.0, record.n), 0.0)
    return record.replace(note="of a sensor", force=record.force + rng.normal(0.0, noise, record.n) + off)


def test_false_samples_are_not_drawn_as_noise_of_the_sensor() -> None:
    """Two samples in a thousand that are 200 N off would be 9 N of white noise; 3 N are there."""
    whites = []
    for false in (0.0, 0.002):
        damper = fit([of_a_sensor(record, 3.0, false) for record in campaign(2, True, 3)], "dahl").damper
        assert damper is not None
        assert damper.prediction_error is not None
        whites.append([shape.white for shape in damper.prediction_error.shapes])
    np.testing.assert_allclose(whites[1], whites[0], rtol=0.5)


@pytest.mark.prove
def test_false_samples_in_the_fitted_records_spoil_no_band_of_clean_ones() -> None:
    """Two samples in a thousand. Drawn as white noise and maximised, they made the bands of 12 clean peaks hold 2."""
    new = [of_a_sensor(unseen(seed), 3.0) for seed in range(12)]
    whites, peaks = [], []
    for false in (0.0, 0.002):
        damper = fit([of_a_sensor(record, 3.0, false) for record in campaign(2, True, 5)], "dahl").damper
        assert damper is not None
        assert damper.prediction_error is not None
        bands = [prediction_band(damper, record, draws=100) for record in new]
        assert sum(band.peak.holds for band in bands) >= 9
        assert sum(band.energy is not None and band.energy.holds for band in bands) >= 9
        assert 0.8 < np.mean([band.holds for band in bands]) < 0.99
        whites.append([shape.white for shape in damper.prediction_error.shapes])
        peaks.append([(band.peak.low, band.peak.high) for band in bands])
    np.testing.assert_allclose(
        whites[1], whites[0], rtol=0.5
    )  # as 10 N: false samples within the residual itself remain
    np.testing.assert_allclose(peaks[1], peaks[0], rtol=0.12)  # the fit itself has moved a little


def test_the_peak_is_the_dampers_and_not_that_of_its_sensor(fitted: Fit) -> None:
    """Noise of 12 N, of which the largest of a record lies three standard deviations out, changes no peak by one of them."""
    assert fitted.damper is not None
    quiet, noisy = unseen(4), of_a_sensor(unseen(4), 12.0)
    one, other = (prediction_band(fitted.damper, record, draws=60) for record in (quiet, noisy))
    assert 0.5 * float(np.ptp(noisy.force) - np.ptp(quiet.force)) > 20.0
    assert other.peak.measured == pytest.approx(one.peak.measured, abs=12.0)
    error = fitted.damper.prediction_error
    assert error is not None
    loud = replace(error, shapes=tuple(replace(shape, white=0.3) for shape in error.shapes))
    sensor = prediction_band(replace(fitted.damper, prediction_error=loud), quiet, draws=60)
    assert (sensor.peak.low, sensor.peak.high) == (one.peak.low, one.peak.high)
    assert sensor.width > 1.5 * one.width  # what a sample may be has the sensor's noise


@pytest.fixture(scope="module")
def fitted() -> Fit:
    return fit(list(campaign(3, True, 5)), "dahl")


def test_a_band_is_the_same_twice_and_another_with_another_seed(fitted: Fit) -> None:
    assert fitted.damper is not None
    record = unseen(0)
    one, two, three = (prediction_band(fitted.damper, record, draws=40, seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.low, two.low)
    assert one.peak == two.peak
    assert not np.array_equal(one.low, three.low)


def test_a_wider_level_holds_more(fitted: Fit) -> None:
    assert fitted.damper is not None
    record = unseen(1)
    half, wide = (prediction_band(fitted.damper, record, level, draws=60) for level in (0.5, 0.95))
    assert half.holds < wide.holds
    assert half.width < wide.width
    assert half.peak.low > wide.peak.low
    assert half.peak.high < wide.peak.high


def test_a_record_of_a_fitted_session_has_a_narrower_band_about_its_level(fitted: Fit) -> None:
    assert fitted.damper is not None
    assert fitted.damper.prediction_error is not None
    error = fitted.damper.prediction_error
    k = int(np.argmax(error.session_levels))
    rng = np.random.default_rng(5)
    record = as_measured(1.98, "more", rng, 12.0)
    of_session = record.replace(note="fitted session", measurement_session=error.sessions[k])
    own, new = (prediction_band(fitted.damper, each, draws=200) for each in (of_session, record))
    assert (own.session, new.session) == (error.sessions[k], None)
    assert own.peak.high - own.peak.low < 0.8 * (new.peak.high - new.peak.low)
    assert 0.5 * (own.peak.high + own.peak.low) > 0.5 * (new.peak.high + new.peak.low)


def test_what_a_band_says_as_numbers_text_and_figure(fitted: Fit, tmp_path: Path) -> None:
    assert fitted.damper is not None
    record = unseen(2)
    band = prediction_band(fitted.damper, record, draws=40)
    assert set(band.as_dict()) == {"level", "holds", "width", "peak", "energy", "session", "prior"}
    assert "of a new session" in repr(band)
    inside = band.window.slice
    seen = (band.low <= record.force) & (record.force <= band.high)
    assert band.holds == float(np.mean(seen[inside]))
    axes = band.plot()
    assert axes[0].get_ylabel() == "force [N]"


def test_a_score_has_a_band_where_it_is_asked_for_one(fitted: Fit) -> None:
    assert fitted.damper is not None
    record = unseen(2)
    plain, with_band = score(fitted.damper, record), score(fitted.damper, record, band=0.9)
    assert plain.band is None
    assert "band" not in plain.as_dict()
    assert with_band.band is not None
    assert with_band.band.holds == prediction_band(fitted.damper, record, 0.9).holds
    assert replace(with_band, band=None) == plain
    printed = repr(with_band)
    assert "90 % band" in printed
    assert f"holds {100 * with_band.band.holds:.3g} % of the samples" in printed
    assert f"width ± {100 * with_band.band.width:.3g} % of the mean force" in printed
    assert with_band.as_dict()["band"] == with_band.band.as_dict()
    with pytest.raises(InputError, match="has no prediction error"):
        score(replace(fitted.damper, prediction_error=None), record, band=0.9)


@pytest.mark.parametrize("level", [0.0, 1.0, 90.0])
def test_a_level_that_is_no_share_is_refused(fitted: Fit, level: float) -> None:
    assert fitted.damper is not None
    with pytest.raises(InputError, match=r"it must lie between 0 and 1, such as 0\.9 for 90 %"):
        prediction_band(fitted.damper, unseen(0), level)
    with pytest.raises(InputError, match=r"it must lie between 0 and 1"):
        score(fitted.damper, unseen(0), band=level)
    with pytest.raises(InputError):
        ScoreOptions(band=level)


def test_a_card_of_before_has_scores_and_no_bands(fitted: Fit) -> None:
    assert fitted.damper is not None
    old = replace(fitted.damper, prediction_error=None)
    with pytest.raises(InputError, match="has no prediction error"):
        prediction_band(old, unseen(0))
    result = validate(old, [unseen(0)])
    assert result.bands == {}
    assert "no prediction error" in result.no_band
    assert "no_band" in result.as_dict()


def test_a_fit_of_any_finite_covariance_has_bands(fitted: Fit) -> None:
    """Half of the twelve numbers would be below zero in most draws, of which none was admissible."""
    assert fitted.damper is not None
    assert fitted.damper.prediction_error is not None
    wide = replace(
        fitted.damper,
        covariance=np.diag((1e3 * fitted.damper.coefficients) ** 2),
        prediction_error=replace(fitted.damper.prediction_error, within_sessions=None),
    )
    result = validate(wide, [unseen(0)])
    assert result.no_band == ""
    assert result.bands["unseen"].holds > 0.9


def test_the_relevelled_score_takes_the_level_from_the_first_cycles(fitted: Fit) -> None:
    assert fitted.damper is not None
    rng = np.random.default_rng(8)
    record = as_measured(0.8712, "a", rng, 20.0)
    weak = with_level(record, 0.85, "weak")
    one, other = score(fitted.damper, record), score(fitted.damper, weak)
    assert other.level == pytest.approx(0.85 * one.level, rel=1e-6)
    assert other.relevelled_l1 == pytest.approx(one.relevelled_l1, rel=1e-6)
    assert other.l1 > 1.3 * other.relevelled_l1


def test_a_motion_that_does_not_repeat_gives_its_level_by_its_first_fifth(fitted: Fit) -> None:
    assert fitted.damper is not None
    rng = np.random.default_rng(9)
    t = np.arange(0.0, 20.0, 0.01)
    x = 1e-3 * np.cumsum(np.convolve(rng.normal(size=t.size), np.hanning(60), "same")) / 60
    x = 0.01 * x / np.abs(x).max()
    v = np.gradient(x, t)
    force = 1.2 * fitted.damper.force(t, x, voltage=1.98, velocity=v)
    one = score(fitted.damper, Record(t, x, force, velocity=v, voltage=1.98, name="random"))
    assert one.level == pytest.approx(1.2, rel=1e-3)
    assert one.relevelled_l1 < 0.01


@pytest.mark.prove
def test_the_published_campaign_beside_its_relevelled_errors(campaign_folder: Path) -> None:
    """Five-fold and leave-voltage errors of Dahl (11.92 and 11.09 % at d63df51, too), and with the level of each
    record's first cycles."""
    from dampyr.identification.scoring.validation import cross_validate

    records = read_campaign(campaign_folder)
    by_record, by_input = (cross_validate(records, "dahl", split) for split in ("record", "input"))
    assert by_record.error <= 0.11921
    assert by_input.error <= 0.11095
    assert by_record.relevelled < by_record.error
    assert by_input.relevelled < by_input.error
    [vali] = read_campaign(campaign_folder, role="validation")
    damper = fit(records, "dahl").damper
    assert damper is not None
    band = prediction_band(damper, vali)
    assert band.holds > 0.85
    assert band.peak.holds
    assert band.energy is not None
    assert band.energy.holds
