"""A planned motion that is slower or smaller than what was fitted is told with its share of the time."""

import numpy as np
import pytest

from dampyr.identification.fits.motion_coverage import list_motions_beyond, reversals
from dampyr.records import Record

DT = 0.002


def moving(x: np.ndarray, name: str = "motion") -> Record:
    t = DT * np.arange(x.size)
    return Record(t, x, 100.0 * np.tanh(np.gradient(x, t) / 0.01), voltage=0.0, name=name)


def sine(stroke: float, frequency: float, seconds: float = 10.0) -> np.ndarray:
    return 0.5 * stroke * np.sin(2 * np.pi * frequency * DT * np.arange(round(seconds / DT)))


def test_strokes_and_speeds_of_a_sine_are_those_of_its_definition() -> None:
    one = reversals(moving(sine(0.02, 0.5)))
    np.testing.assert_allclose(one.stroke, 0.02, rtol=1e-4)
    np.testing.assert_allclose(one.speed, 0.02 * 2 * 0.5, rtol=1e-3)  # two strokes a cycle
    assert one.duration.sum() == pytest.approx(9.0, abs=0.01)  # between the first and the last turning point


def test_a_motion_of_two_parts_is_told_by_the_share_of_the_small_one() -> None:
    fitted = [moving(sine(stroke, 1.0), f"{stroke}") for stroke in (0.010, 0.020)]
    planned = moving(np.concatenate([sine(0.012, 1.0, 6.0), sine(0.002, 1.0, 4.0)]), "quake")
    note = list_motions_beyond(fitted, [planned])["quake"]
    assert note.startswith("quake moves for 4")  # 40 % of the time, to half a cycle
    assert "smaller than all that was fitted (10 mm)" in note
    assert "record sines of about 2 mm peak to peak at 4 mm/s mean speed too" in note


def test_what_is_as_slow_but_not_small_is_told_too() -> None:
    note = list_motions_beyond([moving(sine(0.01, 2.0))], [moving(sine(0.02, 0.1, 40.0), "slow")])["slow"]
    assert "for 0 % of its time in reversals smaller" in note
    assert "for 100 % slower (40 mm/s)" in note


def test_motions_like_the_fitted_ones_and_records_at_rest_are_not_told() -> None:
    fitted = [moving(sine(0.010, 1.0))]
    at_rest = moving(np.zeros(500), "rest").replace(note="with a force", force=np.linspace(0.0, 1.0, 500))
    assert list_motions_beyond(fitted, [moving(sine(0.011, 1.1)), moving(sine(0.03, 0.5)), at_rest]) == {}
    assert list_motions_beyond([at_rest], fitted) == {}


def test_the_validation_run_of_the_campaign_is_like_its_sines(published_records, published_fit_records) -> None:
    planned = [r for r in published_records if r.role != "fit"]
    assert list_motions_beyond(published_fit_records, planned) == {}
