"""Splits of records into those that are fitted and those that are predicted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from dampyr.errors import InputError
from dampyr.records import Record, measure
from dampyr.records.checks.quality import motion_start
from dampyr.records.cycle_analysis.waveform import waveform

FITTED_SHARE = 0.6  # of the motion: enough cycles on both sides of the cut


@dataclass(frozen=True)
class Target:
    """A record that is predicted: where ``first`` is set, only from this time on, in s."""

    record: Record
    first: float | None = None


@dataclass(frozen=True)
class FoldTask:
    """One fold: fit these, predict those."""

    fitted: tuple[Record, ...]
    predicted: tuple[Target, ...]


def split_tasks(records: Sequence[Record], split: str, folds: int = 5, seed: int = 0) -> list[FoldTask]:
    """The folds of a split: see `dampyr.identification.cross_validate`."""
    if split != "time" and split not in PARTS:
        raise InputError(f"{split!r} is an unknown split; choose {', '.join([*PARTS, 'time'])}")
    listed = list(records)
    if split == "time":
        return [_split_time(listed)]
    return [_leave_out(listed, part) for part in PARTS[split](listed, folds, seed)]


def _leave_out(records: list[Record], part: list[int]) -> FoldTask:
    held = set(part)
    rest = tuple(record for k, record in enumerate(records) if k not in held)
    return FoldTask(rest, tuple(Target(records[k]) for k in part))


def _split_time(records: list[Record]) -> FoldTask:
    """Every record's first part is fitted and its last part predicted."""
    cuts = []
    for record in records:
        start, end = motion_start(record), float(record.time[-1])
        cuts.append(start + FITTED_SHARE * (end - start))
    fitted = tuple(record.until(cut) for record, cut in zip(records, cuts, strict=True))
    return FoldTask(fitted, tuple(Target(record, cut) for record, cut in zip(records, cuts, strict=True)))


def _check_folds(records: list[Record], folds: int) -> None:
    if not 2 <= folds <= len(records):
        raise InputError(f"{folds} folds of {len(records)} records: give at least 2 folds and as many records")


def _split_by_record(records: list[Record], folds: int, seed: int) -> list[list[int]]:
    """Random parts; the records of each input are distributed in turn, so that no part holds all of one."""
    _check_folds(records, folds)
    shuffled = np.random.default_rng(seed).permutation(len(records))
    order = sorted((int(i) for i in shuffled), key=lambda i: records[i].input_value or 0.0)
    return [sorted(order[k::folds]) for k in range(folds)]


def _split_by_input(records: list[Record], folds: int, seed: int) -> list[list[int]]:
    values = [record.input_value for record in records]
    distinct = sorted({v for v in values if v is not None})
    if len(distinct) < 3:
        raise InputError(f"leaving an input out needs three or more; the records have {len(distinct)}")
    return [[k for k, v in enumerate(values) if v == u] for u in distinct[1:-1]]


def _split_by_frequency(records: list[Record], folds: int, seed: int) -> list[list[int]]:
    return _split_in_order(records, folds, [measure(record).frequency_hz for record in records])


def _split_by_amplitude(records: list[Record], folds: int, seed: int) -> list[list[int]]:
    return _split_in_order(records, folds, [measure(record).peak_to_peak_m for record in records])


def _split_in_order(records: list[Record], folds: int, size: list[float]) -> list[list[int]]:
    _check_folds(records, folds)
    return [[int(i) for i in part] for part in np.array_split(np.argsort(size, kind="stable"), folds)]


def _split_by_waveform(records: list[Record], folds: int, seed: int) -> list[list[int]]:
    kinds = [waveform(record) for record in records]
    distinct = sorted(set(kinds))
    if len(distinct) < 2:
        raise InputError(f"leaving a waveform out needs two kinds of motion; all records are of the kind {distinct[0]}")
    return [[k for k, kind in enumerate(kinds) if kind == left_out] for left_out in distinct]


#: which records each fold predicts
PARTS: dict[str, Callable[[list[Record], int, int], list[list[int]]]] = {
    "record": _split_by_record,
    "input": _split_by_input,
    "frequency": _split_by_frequency,
    "amplitude": _split_by_amplitude,
    "waveform": _split_by_waveform,
}
