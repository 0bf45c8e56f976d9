"""A damper on records that it predicts: scores, forces, sums by input, and which records it was fitted on."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.identification.synthetic import DAHL, sine

from dampyr.errors import InputError
from dampyr.identification import ScoreOptions, score, validate
from dampyr.models import Constant, Damper
from dampyr.records import Record

OVER = Damper("dahl", {"dahl.kx": Constant(900.0, 0.0, 2.0), "dahl.kw": 70.0, "dahl.rho": 2500.0})


def stronger(share: float, voltage: float, name: str) -> Record:
    """A record whose force about its offset is ``share`` times that of the damper."""
    record = sine(DAHL, 0.0, name, offset=0.0)
    return record.replace(note="stronger", force=share * record.force + 100.0, voltage=voltage)


RECORDS = [stronger(1.0, 2.0, "a"), stronger(1.2, 0.0, "b"), stronger(1.1, 0.0, "c")]


def test_scores_and_forces_are_those_of_a_free_run() -> None:
    result = validate(OVER, RECORDS)
    assert list(result.scores) == ["a", "b", "c"]
    for record in RECORDS:
        assert result.scores[record.name].l1 == pytest.approx(score(OVER, record).l1, rel=1e-12, abs=1e-12)
        run = OVER.force(record.time, record.displacement, voltage=record.voltage, velocity=record.velocity)
        np.testing.assert_allclose(result.forces[record.name], run, atol=1e-9)
    measured, predicted = result.measured_and_predicted("a")
    assert measured.name == "a"
    np.testing.assert_allclose(predicted, measured.force, atol=1e-6)
    with pytest.raises(InputError, match="'d' is not among the records; choose from a, b, c"):
        result.measured_and_predicted("d")


def test_a_factor_on_the_force_is_the_misfit() -> None:
    """The whole of the force is 1.2 times the model's: the L1 ratio is 1 - 1/1.2."""
    result = validate(OVER, RECORDS)
    assert [result.scores[name].l1 for name in "abc"] == pytest.approx([0.0, 1 - 1 / 1.2, 1 - 1 / 1.1], abs=1e-3)
    assert result.relevelled_l1 == pytest.approx(0.0, abs=1e-3)


def test_inputs_are_summed_up_in_rising_order() -> None:
    low, high = validate(OVER, RECORDS).by_input
    assert (low["input"], low["records"], high["input"], high["records"]) == (0.0, 2, 2.0, 1)
    assert low["mean_l1"] == pytest.approx(0.5 * (2 - 1 / 1.2 - 1 / 1.1), abs=1e-3)
    assert low["worst_l1"] == pytest.approx(1 - 1 / 1.2, abs=1e-3)


def test_the_card_tells_by_names_which_records_were_fitted() -> None:
    card = replace(OVER, provenance={"records": "a, c"})
    assert validate(card, RECORDS).fitted_on == {"a": True, "b": False, "c": True}
    assert validate(OVER, RECORDS).fitted_on == {"a": None, "b": None, "c": None}
    assert validate(replace(OVER, provenance={"records": "12 records"}), RECORDS).fitted_on["a"] is None


def test_forces_are_written_beside_nothing_of_others(tmp_path: Path) -> None:
    result = validate(OVER, RECORDS[:1])
    [path] = result.write_forces(tmp_path)
    assert path.name == "a.csv"
    (tmp_path / "a.csv").write_text("notes of another")
    with pytest.raises(InputError, match=r"a\.csv"):
        result.write_forces(tmp_path)
    assert (tmp_path / "a.csv").read_text() == "notes of another"


def test_progress_names_the_work_and_bands_are_left_out_with_a_reason() -> None:
    heard: list[tuple[str, float]] = []
    result = validate(OVER, RECORDS, progress=lambda stage, done: heard.append((stage, done)))
    assert heard == [("predicting", pytest.approx(k / 3)) for k in range(3)]
    assert result.bands == {}
    assert "no prediction error" in result.no_band
    assert validate(OVER, RECORDS, ScoreOptions(band=None)).no_band == ""


def test_wrong_calls_say_what_is_wrong() -> None:
    with pytest.raises(InputError, match="there are no records to validate by"):
        validate(OVER, [])
    with pytest.raises(InputError, match="2 records are called 'a'"):
        validate(OVER, [RECORDS[0], RECORDS[0]])
    with pytest.raises(InputError, match=r"settling = -1 s is not allowed"):
        validate(OVER, RECORDS, settling=-1.0)
