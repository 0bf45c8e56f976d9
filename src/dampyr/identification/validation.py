"""How well a model predicts records that it was not fitted on.

The records are split into folds; each fold is predicted by a damper that was fitted on the others. From a scored record only
the offset is taken, and every score says what the damper was fitted on.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dampyr.errors import DampyrWarning, InputError
from dampyr.identification.fit import fit
from dampyr.identification.score import Score, score
from dampyr.models import Damper
from dampyr.records import Record, measure

SPLITS = ("record", "input", "frequency", "amplitude")


@dataclass(frozen=True)
class Fold:
    """One part of the split: what was fitted, what was predicted, and how well (nothing where the fit gave no damper).

    ``outside`` says which predicted records go beyond what the fitted ones covered, and by how much.
    """

    fitted_on: tuple[str, ...]
    scores: dict[str, Score]
    converged: bool
    reason: str
    outside: dict[str, str]


@dataclass(frozen=True)
class Validation:
    """All folds of one split."""

    split: str
    folds: tuple[Fold, ...]

    @property
    def scores(self) -> dict[str, Score]:
        """Every predicted record's score."""
        return {name: one for fold in self.folds for name, one in fold.scores.items()}

    @property
    def failed(self) -> dict[str, str]:
        """The folds that gave no damper: the first record that was to be predicted -> the reason."""
        return {fold.fitted_on[0]: fold.reason for fold in self.folds if not fold.scores}


def cross_validate(
    model: str,
    records: Sequence[Record],
    split: str = "record",
    folds: int = 5,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
    **options: Any,
) -> Validation:
    """Predict every record by a damper that never saw it.

    Parameters
    ----------
    model, options
        as in `dampyr.identification.fit`.
    split
        ``"record"``: ``folds`` random parts by ``seed``; ``"input"``: one voltage (or current) left out at a time, the lowest
        and the highest excepted, which would be extrapolated; ``"frequency"`` or ``"amplitude"``: ``folds`` parts in the
        order of the measured frequency or stroke, so that the outer ones are predicted beyond what was fitted.
    progress
        called with the fraction done.

    Raises :class:`~dampyr.errors.InputError` for an unknown split, fewer records than folds, or fewer than three inputs.
    """
    listed = list(records)
    parts = _parts(listed, split, folds, seed)
    done = []
    for k, part in enumerate(parts):
        if progress:
            progress(k / len(parts))
        done.append(_fold(model, listed, part, options))
    if progress:
        progress(1.0)
    return Validation(split, tuple(done))


def _fold(model: str, records: list[Record], part: list[int], options: dict[str, Any]) -> Fold:
    held = set(part)
    rest = [record for k, record in enumerate(records) if k not in held]
    found = fit(model, rest, **options)
    scores: dict[str, Score] = {}
    outside: dict[str, str] = {}
    if found.damper is not None:
        for record in (records[k] for k in part):
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always", DampyrWarning)
                scores[record.name] = _predicted(found.damper, record)
            if told:
                outside[record.name] = "; ".join(str(w.message) for w in told)
    return Fold(tuple(r.name for r in rest), scores, found.converged, found.reason, outside)


def _predicted(damper: Damper, record: Record) -> Score:
    low, high = damper.range
    u = record.input_value
    return score(damper, record, allow_extrapolation=u is not None and not low <= u <= high)


def _parts(records: list[Record], split: str, folds: int, seed: int) -> list[list[int]]:
    """Which records each fold predicts."""
    if split not in SPLITS:
        raise InputError(f"{split!r} is no split; choose {', '.join(SPLITS)}")
    if split == "input":
        return _by_input(records)
    if not 2 <= folds <= len(records):
        raise InputError(f"{folds} folds of {len(records)} records: give at least 2 folds and as many records")
    if split == "record":
        order = np.random.default_rng(seed).permutation(len(records))
        return [sorted(int(i) for i in order[k::folds]) for k in range(folds)]
    size = [_size(record, split) for record in records]
    return [[int(i) for i in part] for part in np.array_split(np.argsort(size, kind="stable"), folds)]


def _size(record: Record, split: str) -> float:
    found = measure(record)
    return found.frequency_hz if split == "frequency" else found.peak_to_peak_m


def _by_input(records: list[Record]) -> list[list[int]]:
    values = [record.input_value for record in records]
    known = sorted({v for v in values if v is not None})
    if len(known) < 3:
        raise InputError(f"leaving an input out needs three or more; the records have {len(known)}")
    return [[k for k, v in enumerate(values) if v == u] for u in known[1:-1]]
