"""Scores against hand-made errors."""

import numpy as np
import pytest
from tests.identification.synthetic import DAHL, sine

from dampyr.errors import InputError
from dampyr.identification import score
from dampyr.identification.scoring.score import compare
from dampyr.models import Constant, Damper
from dampyr.records import Record


def square(n: int = 800) -> Record:
    """A force of +-100 N about 40 N over a triangle of motion."""
    t = np.arange(n) * 0.01
    x = 0.01 * np.abs((t % 2.0) - 1.0)
    return Record(t, x, np.where((t % 2.0) < 1.0, 140.0, -60.0), voltage=0.0, name="square")


def test_the_truth_scores_zero_whatever_the_offset() -> None:
    score_result = score(DAHL, sine(DAHL, 0.0, offset=555.0))
    assert score_result.l1 < 1e-9
    assert score_result.r2 == pytest.approx(1.0)
    assert score_result.offset == pytest.approx(555.0)
    assert score_result.energy == pytest.approx(0.0, abs=1e-9)


def test_every_ratio_of_a_known_error() -> None:
    record = square()
    error = np.where(np.arange(record.n) % 2 == 0, 10.0, -10.0)
    score_result = compare(record, record.force + error, window=(0.0, 7.99))
    assert score_result.l1 == pytest.approx(0.10)
    assert score_result.nrmse == pytest.approx(0.10)
    assert score_result.r2 == pytest.approx(0.99)
    assert score_result.pointwise == pytest.approx(0.10)
    assert score_result.peak_force == pytest.approx(0.10)


def test_a_constant_error_is_the_offset() -> None:
    record = square()
    score_result = compare(record, record.force - 25.0, window=(0.0, 7.99))
    assert score_result.l1 == pytest.approx(0.0, abs=1e-12)
    assert score_result.offset == pytest.approx(25.0)


def test_energy_of_a_scaled_force() -> None:
    record = sine(DAHL, 0.0)
    score_result = compare(record, 1.2 * (record.force - 120.0))
    assert score_result.energy == pytest.approx(0.2, rel=1e-6)


def test_the_wrong_input_is_refused() -> None:
    record = sine(DAHL, 0.0).replace(note="", voltage=None, current=0.2)
    over_voltage = Damper("dahl", {**DAHL.laws, "dahl.kx": Constant(900.0, 0.0, 3.0)})
    with pytest.raises(InputError, match="pass voltage="):
        score(over_voltage, record)


def test_the_force_is_measured_from_the_middle_of_its_range() -> None:
    t = np.arange(800) * 0.01
    force = np.where((t % 2.0) < 0.5, 100.0, -50.0)
    record = Record(t, 0.01 * np.sin(np.pi * t), force, voltage=0.0, name="uneven")
    error = np.where(np.arange(record.n) % 2 == 0, 7.5, -7.5)
    score_result = compare(record, force + error, window=(0.0, 7.99))
    assert score_result.l1 == pytest.approx(7.5 / 75.0)
    assert score_result.pointwise == pytest.approx(7.5 / 75.0)


@pytest.mark.parametrize("false_samples", [1, 4])
def test_false_samples_of_the_load_cell_do_not_improve_the_score(false_samples: int) -> None:
    record = sine(DAHL, 0.0)
    model = 0.85 * (record.force - 120.0)
    spoilt = np.array(record.force)
    spoilt[600 : 600 + 50 * false_samples : 50] += 2.0 * np.ptp(record.force)
    worse = record.replace(note="false samples", force=spoilt)
    before, after = compare(record, model), compare(worse, model)
    assert before.l1 == pytest.approx(compare(record, model, centre="midrange").l1, rel=0.02)
    assert after.l1 > before.l1
    assert after.nrmse > before.nrmse
    assert compare(worse, model, centre="midrange").l1 < 0.9 * before.l1  # the definition to the letter
