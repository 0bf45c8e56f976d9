"""The result of an ensemble: its curves are those of its peaks, its findings those of its attributes."""

import json
from pathlib import Path

import numpy as np
import pytest
from tests.structures.ensembles.known_peaks import drawn, made

from dampyr.errors import FileError
from dampyr.findings import Finding
from dampyr.structures import fragility, read_ensemble
from dampyr.structures.ensembles.ensemble_result import EnsembleResult


def test_its_curves_are_the_fragilities_of_its_peaks() -> None:
    result = EnsembleResult(made(drawn(12))).evaluated("1.2 m", intensity="scale", seed=4)
    assert [curve.limit for curve in result.curves] == [1.2]
    assert result.intensity == "scale"
    for curve in result.curves:
        alone = fragility(result.dataset, "drift", curve.limit, "scale", seed=4)
        assert curve.curves[0].theta == alone.curves[0].theta
        np.testing.assert_array_equal(curve.curves[0].draws, alone.curves[0].draws)
    assert result.evaluated().curves == ()


def test_its_findings_are_of_the_dampers_the_accuracy_and_the_cases_with_the_worst_first() -> None:
    dataset = made(drawn(3))
    of_damper = Finding("note", "the fit is of one record", source="the damper's fit")
    wrong = Finding("wrong", "the force has no sign")
    dataset.attrs.update(
        accuracy="fast", error_estimate=0.03, unbounded=2, outside="a stroke leaves its range",
        findings=[json.dumps(of_damper.as_dict()), "from a file of before", json.dumps(wrong.as_dict())],
    )  # fmt: skip
    found = EnsembleResult(dataset).findings
    assert [finding.severity for finding in found] == ["wrong", "doubt", "doubt", "doubt", "doubt", "note"]
    assert found[0] == wrong
    assert found[-1] == of_damper
    words = " | ".join(finding.words for finding in found)
    for part in (
        "changed by up to 3 %",
        "2 cases grew without bound",
        "a stroke leaves its range",
        "from a file of before",
    ):
        assert part in words
    dataset.attrs.update(error_estimate=0.01, unbounded=0, outside="", findings=[])
    assert EnsembleResult(dataset).findings == ()


def test_what_is_no_ensemble_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "e.h5").write_text("no", encoding="utf-8")
    with pytest.raises(FileError, match=r"e\.h5"):
        read_ensemble(tmp_path / "e.h5")
