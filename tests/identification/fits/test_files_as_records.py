"""Files and folders in the place of records: what is read, and what is said where nothing is."""

from pathlib import Path

import numpy as np
import pytest

import dampyr as dp
from dampyr.errors import InputError, MissingData
from dampyr.identification import FitOptions, accept, compare_method, fit, fit_specimens, validate
from dampyr.identification.model_choice.leaderboard import leaderboard
from dampyr.identification.scoring.validation import cross_validate
from dampyr.records import Record, read_records

DAMPER = dp.studies.raminelli_2020.damper()


def measured(name: str, frequency: float, voltage: float = 1.98, **more: object) -> Record:
    t = np.linspace(0.0, 4.0, 801)
    x = 0.008 * np.sin(2 * np.pi * frequency * t)
    force = DAMPER.force(t, x, voltage=voltage) + np.random.default_rng(len(name)).normal(0.0, 2.0, t.size)
    return Record(t, x, force, voltage=voltage, name=name, **more)  # type: ignore[arg-type]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two tests to be fitted and one to be predicted."""
    made = tmp_path / "tests"
    made.mkdir()
    for record in (measured("a", 1.0), measured("bb", 1.3), measured("ccc", 0.7, role="validation")):
        dp.records.write(record, made / f"{record.name}.h5")
    return made


def test_one_call_from_a_file_to_a_fit(folder: Path) -> None:
    path = folder / "a.h5"
    one = dp.fit(path, "dahl")
    assert one.parameters == dp.fit(str(path), "dahl").parameters == dp.fit(dp.read(path), "dahl").parameters
    assert one.records[0].source_file is not None


def test_a_folder_is_fitted_and_its_validation_records_are_predicted(folder: Path) -> None:
    whole = fit(folder, "dahl")
    assert [record.name for record in whole.records] == ["a", "bb"]
    assert list(whole.predicted) == ["ccc"]
    assert whole.parameters == fit([folder / "a.h5", folder / "bb.h5"], "dahl").parameters


def test_each_call_that_takes_records_takes_files(folder: Path) -> None:
    files = [folder / f"{name}.h5" for name in ("a", "bb", "ccc")]
    read = [dp.read(path) for path in files]
    scores = [{name: one.l1 for name, one in validate(DAMPER, given).scores.items()} for given in (folder, read)]
    assert scores[0] == scores[1]
    assert accept(files[0], DAMPER).verdict == accept(read[0], DAMPER).verdict == "passed"
    assert dp.records.cycles(folder).records[0].cycles[-1].energy == dp.records.cycles(read[0]).cycles[-1].energy
    rows = [compare_method(given[0], "plastic-region").results[0].numbers for given in (files, read)]
    assert rows[0] == rows[1]
    parts = FitOptions(folds=2)
    folds = [cross_validate(given, "dahl", "record", parts).folds for given in (folder, read[:2])]
    assert [list(fold.scores) for fold in folds[0]] == [list(fold.scores) for fold in folds[1]]
    for call in (lambda: leaderboard(files), lambda: fit_specimens(files, "dahl")):
        with pytest.raises(InputError) as problem:
            call()
        assert "give" in str(problem.value) or "names" in str(problem.value)


def test_what_is_not_there_is_said_before_anything_is_fitted(tmp_path: Path) -> None:
    with pytest.raises(MissingData, match=r"nothing\.csv: there is no such file; check the path"):
        dp.fit("nothing.csv", "dahl")
    with pytest.raises(InputError, match="records come first"):
        dp.fit("dahl", measured("a", 1.0))  # type: ignore[arg-type]
    with pytest.raises(InputError, match="no records in an empty list; name files, or a folder with records"):
        read_records([])
    with pytest.raises(InputError, match="give records, or the path of a file or of a folder of them"):
        dp.fit(np.zeros(3), "dahl")  # type: ignore[arg-type]
