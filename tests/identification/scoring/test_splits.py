"""Splits of records: who is fitted and who is predicted, without a fit."""

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.identification.scoring.splits import FITTED_SHARE, split_tasks
from dampyr.models import Damper
from dampyr.records import Record
from dampyr.records.checks.quality import motion_start

DAHL = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})


@pytest.fixture(scope="module")
def records() -> list[Record]:
    """Three at each of four inputs, the larger the slower, in no order."""
    listed = [
        sine(DAHL, 0.0, f"{u:g}V-{k}", 0.004 + 0.002 * k, 1.3 - 0.2 * k).replace(note="", voltage=u)
        for u in (0.0, 1.0, 2.0, 3.0)
        for k in range(3)
    ]
    return [listed[k] for k in np.random.default_rng(0).permutation(12)]


@pytest.mark.parametrize("split", ["record", "frequency", "amplitude"])
def test_the_folds_share_the_records_out(records: list[Record], split: str) -> None:
    tasks = split_tasks(records, split, folds=5)
    predicted = [target.record.name for task in tasks for target in task.predicted]
    assert sorted(predicted) == sorted(record.name for record in records)
    assert sorted(len(task.predicted) for task in tasks) == [2, 2, 2, 3, 3]
    for task in tasks:
        assert {r.name for r in task.fitted} | {t.record.name for t in task.predicted} == {r.name for r in records}
        assert len(task.fitted) + len(task.predicted) == len(records)


def test_each_random_part_has_some_of_every_input(records: list[Record]) -> None:
    for task in split_tasks(records, "record", folds=3, seed=7):
        assert {target.record.voltage for target in task.predicted} == {0.0, 1.0, 2.0, 3.0}


def test_folds_repeat_by_seed(records: list[Record]) -> None:
    one, same, other = (
        [[r.name for r in task.fitted] for task in split_tasks(records, "record", folds=3, seed=seed)]
        for seed in (1, 1, 2)
    )
    assert one == same != other


def test_parts_by_size_are_in_its_order(records: list[Record]) -> None:
    by_amplitude, by_frequency = (split_tasks(records, split, folds=3) for split in ("amplitude", "frequency"))
    assert [{t.record.name[-1] for t in task.predicted} for task in by_amplitude] == [{"0"}, {"1"}, {"2"}]
    assert [{t.record.name[-1] for t in task.predicted} for task in by_frequency] == [{"2"}, {"1"}, {"0"}]


def test_an_input_is_left_out_between_others(records: list[Record]) -> None:
    tasks = split_tasks(records, "input")
    assert [{t.record.voltage for t in task.predicted} for task in tasks] == [{1.0}, {2.0}]
    assert all(task.predicted[0].record.voltage not in {r.voltage for r in task.fitted} for task in tasks)


def test_in_time_the_first_part_of_each_motion_is_fitted(records: list[Record]) -> None:
    [task] = split_tasks(records, "time")
    for fitted, target in zip(task.fitted, task.predicted, strict=True):
        start, end = motion_start(target.record), target.record.time[-1]
        assert target.first == pytest.approx(start + FITTED_SHARE * (end - start))
        assert fitted.time[-1] <= target.first < fitted.time[-1] + 2 * fitted.dt
