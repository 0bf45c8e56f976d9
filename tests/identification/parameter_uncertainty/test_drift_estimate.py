"""The level that drifts with the energy which a record dissipates: found, told, and in the bands of a damper."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.identification.parameter_uncertainty.heated_records import RATE, TIME_CONSTANT, heated
from tests.identification.test_coverage import TESTED, as_measured

from dampyr.errors import InputError
from dampyr.identification import Fit, FitThresholds, fit, prediction_band
from dampyr.models import Damper
from dampyr.models.level_drift import LevelDrift, energy_within
from dampyr.records import Record


def records(seed: int, rate: float = RATE, seconds: float = 12.0) -> list[Record]:
    """Four records at each of four voltages, each from a cold damper."""
    rng = np.random.default_rng([seed, 5])
    cold = [as_measured(u, f"{u:g}V-{k}", rng, seconds) for u in TESTED for k in range(4)]
    return [heated(record, rate) for record in cold]


@pytest.fixture(scope="module")
def weakening() -> Fit:
    return fit(records(1), "dahl")


def test_a_level_that_falls_with_the_energy_is_found_with_its_rate_and_time_constant(weakening: Fit) -> None:
    assert weakening.levels is not None
    drift = weakening.levels.drift
    assert drift is not None
    # the time constant is one of six, and a rate goes with it
    assert drift.rate == pytest.approx(RATE, rel=0.2)
    assert TIME_CONSTANT / 3.5 < drift.time_constant < TIME_CONSTANT * 3.5
    assert drift.rate_error < 0.1 * abs(RATE)
    [said] = [f for f in weakening.findings if "with the energy" in f.words]
    assert said.severity == "doubt"
    assert "the level falls with the energy that a record dissipates: by" in said.words


def test_a_rising_level_rises() -> None:
    found = fit(records(2, -RATE), "dahl").levels
    assert found is not None
    assert found.drift is not None
    assert found.drift.rate == pytest.approx(-RATE, rel=0.4)  # with a time constant that is not the nearest
    assert "the level rises" in found.drift.words


@pytest.mark.parametrize("seed", range(3))
def test_records_of_other_levels_and_strokes_that_do_not_heat_up_have_no_drift(seed: int) -> None:
    done = fit(records(seed, 0.0), "dahl")
    assert done.levels is not None
    assert done.levels.drift is None
    assert not [f for f in done.findings if "with the energy" in f.words]


@pytest.mark.prove
@pytest.mark.endure
def test_a_drift_is_seldom_found_where_there_is_none(endurance) -> None:  # type: ignore[no-untyped-def]
    campaigns = endurance.count(400, part=20)
    found = sum(fit(records(1000 + seed, 0.0), "dahl").levels.drift is not None for seed in range(campaigns))  # type: ignore[union-attr]
    endurance.report(
        "a level that drifts with the energy, where none does", 0, f"{campaigns} campaigns: told in {found}"
    )
    assert found <= (0.03 * campaigns if endurance.full else 2)


def test_records_that_differ_less_than_their_spread_are_told_apart_by_their_energy(weakening: Fit) -> None:
    """Records of large strokes are weaker in the mean; that is the drift's, and not a spread of records."""
    assert weakening.levels is not None
    means = [math.exp(y) for y in np.log(list(weakening.levels.level.values()))]
    assert np.std(np.log(means)) > 0.02
    assert weakening.levels.record_sd < 0.04  # the gains of the records have 3 %


@pytest.mark.prove
def test_the_published_campaign_shows_no_drift(campaign_folder: Path) -> None:
    from dampyr.records import read_campaign

    found = fit(read_campaign(campaign_folder), "dahl").levels
    assert found is not None
    assert found.drift is None


def test_what_counts_as_a_doubt_is_a_threshold(weakening: Fit) -> None:
    lenient = fit(list(weakening.records), "dahl", thresholds=FitThresholds(level_drift=0.5))
    [said] = [f for f in lenient.findings if "with the energy" in f.words]
    assert said.severity == "note"


def test_a_band_follows_the_drift_of_a_record_longer_than_the_fitted_ones(weakening: Fit) -> None:
    """An unseen record of three times the length ends far weaker than any that was fitted."""
    assert weakening.damper is not None
    assert weakening.damper.prediction_error is not None
    long = heated(as_measured(3.212, "long", np.random.default_rng(3), 36.0))
    error = weakening.damper.prediction_error
    blind = replace(weakening.damper, prediction_error=replace(error, drift=None))
    early, late = slice(300, 900), slice(long.n - 600, long.n)

    def change(damper: Damper) -> float:
        """Of the measured force against the middle of the band, from early in the record to its end."""
        band = prediction_band(damper, long)
        of = [np.polyfit(0.5 * (band.low + band.high)[part], band.measured[part], 1)[0] for part in (early, late)]
        return of[1] / of[0]

    assert change(weakening.damper) == pytest.approx(1.0, abs=0.05)
    assert change(blind) < 0.9


def test_a_card_keeps_the_drift(weakening: Fit, tmp_path: Path) -> None:
    assert weakening.damper is not None
    weakening.damper.save(tmp_path / "card.json")
    loaded = Damper.load(tmp_path / "card.json")
    assert loaded.prediction_error is not None
    assert loaded.prediction_error.drift == weakening.damper.prediction_error.drift  # type: ignore[union-attr]
    assert [s.energy for s in loaded.prediction_error.shapes] == [
        s.energy
        for s in weakening.damper.prediction_error.shapes  # type: ignore[union-attr]
    ]


def test_energy_within_is_that_of_a_first_order_cooling() -> None:
    t = np.arange(0.0, 20.0, 1e-3)
    np.testing.assert_allclose(energy_within(np.full(t.size, 5.0), 1e-3, math.inf)[-1], 5.0 * 20.0, rtol=1e-9)
    exact = 5.0 * 4.0 * (1.0 - np.exp(-t / 4.0))
    np.testing.assert_allclose(energy_within(np.full(t.size, 5.0), 1e-3, 4.0), exact, atol=0.01)


def test_the_drifting_force_dissipates_less_itself() -> None:
    """Against the differential equation of the energy, whose force is the drifting one."""
    drift = LevelDrift(-0.01, 0.0, 10.0, 30.0, 50.0)
    t = np.arange(0.0, 10.0, 1e-3)
    force, v = 300.0 * np.sign(np.cos(9.0 * t)), 0.08 * np.cos(9.0 * t)

    def cold(s: float) -> float:
        return 300.0 * abs(0.08 * math.cos(9.0 * s))

    solved = solve_ivp(
        lambda s, h: cold(s) * np.exp(-0.01 * (h - 20.0)) - h / 30.0,
        (0.0, 10.0),
        [0.0],
        t_eval=t,
        max_step=5e-3,
        rtol=1e-8,
    )
    exact = force * np.exp(-0.01 * (solved.y[0] - 20.0))
    np.testing.assert_allclose(drift.applied(force, v, 1e-3, 20.0, -0.01), exact, atol=0.003 * 300.0)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"rate": math.nan}, "rate = nan"),
        ({"rate_error": -1.0}, "rate_error = -1"),
        ({"freedom": 0.0}, "freedom = 0"),
        ({"time_constant": 0.0}, "time_constant = 0"),
        ({"energy": -2.0}, "energy = -2"),
    ],
)
def test_a_number_that_no_drift_has_is_refused(change: dict[str, float], said: str) -> None:
    good = {"rate": -1e-3, "rate_error": 1e-4, "freedom": 5.0, "time_constant": 30.0, "energy": 70.0}
    with pytest.raises(InputError, match=said):
        LevelDrift(**(good | change))
