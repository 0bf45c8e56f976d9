"""Validation of a card as one job: a damper and records in, scores of its predictions out."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dampyr.errors import InputError
from dampyr.identification.score import SETTLING, Array, Score, compare, prediction
from dampyr.models import Damper
from dampyr.records import Record, nominal_inputs, write_comparison
from dampyr.records.comparison import check_free, file_name
from dampyr.to_json import plain


@dataclass(frozen=True)
class ValidateOptions:
    """Options of `validate`: ``settling`` s after the motion starts are not scored."""

    settling: float = SETTLING
    allow_extrapolation: bool = False

    def __post_init__(self) -> None:
        if not (math.isfinite(self.settling) and self.settling >= 0.0):
            raise InputError(f"settling = {self.settling:g} s is not allowed; it must be finite and at least 0")


@dataclass(frozen=True)
class Validated:
    """Result of `validate`: the scores by record, and the predicted forces in N, without the records' offsets."""

    card: str
    damper: Damper
    records: tuple[Record, ...]
    scores: Mapping[str, Score]
    forces: Mapping[str, Array]

    @property
    def fitted_on(self) -> set[str]:
        """The names of the records that the damper was fitted on, by its card."""
        return {name.strip() for name in self.damper.provenance.get("records", "").split(",")}

    @property
    def by_input(self) -> list[dict[str, Any]]:
        """Number of records, mean and worst L1 of each input, in rising order."""
        groups: dict[float | None, list[float]] = {}
        for record in self.records:
            groups.setdefault(record.input_value, []).append(self.scores[record.name].l1)
        order = sorted(groups, key=lambda u: math.inf if u is None else u)
        return [
            {
                "input": u,
                "records": len(groups[u]),
                "mean_l1": sum(groups[u]) / len(groups[u]),
                "worst_l1": max(groups[u]),
            }
            for u in order
        ]

    def as_dict(self) -> dict[str, Any]:
        """All results for JSON, SI units."""
        scores = {name: one.as_dict() | {"fitted_on": name in self.fitted_on} for name, one in self.scores.items()}
        return dict(plain({"card": self.card, "scores": scores, "by_input": self.by_input}))

    def write_forces(self, folder: Path) -> list[Path]:
        """Write NAME.csv with the measured and the predicted force of each record; other people's files are not replaced."""
        folder.mkdir(parents=True, exist_ok=True)
        for record in self.records:
            check_free(folder / file_name(record))
        return [
            write_comparison(r, self.forces[r.name], folder / file_name(r), offset=self.scores[r.name].offset)
            for r in self.records
        ]


def validate(
    damper: Damper,
    records: Sequence[Record],
    options: ValidateOptions | None = None,
    card: str = "the damper",
    progress: Callable[[str, float], None] | None = None,
) -> Validated:
    """Score a damper on records that it predicts in a free run; only the offset is taken from each record.

    Measured inputs that are constant but for noise count as constants, those close to an end of the calibrated range as that
    end. ``card`` is what the damper is called. Raises :class:`~dampyr.errors.InputError` where two records have one name, and
    where an input lies outside of the calibrated range unless extrapolation is allowed.
    """
    options = options or ValidateOptions()
    if not records:
        raise InputError("there are no records to validate by; give one or more")
    nominal = tuple(nominal_inputs(records, damper.range))
    name, count = Counter(record.name for record in nominal).most_common(1)[0]
    if count > 1:
        raise InputError(
            f"{count} records are called {name!r}; rename the files of all but one, or validate them one by one"
        )
    forces = {}
    for k, record in enumerate(nominal):
        if progress:
            progress("predicting", k / len(nominal))
        forces[record.name] = prediction(damper, record, options.allow_extrapolation)
    scores = {r.name: compare(r, forces[r.name], options.settling) for r in nominal}
    return Validated(card, damper, nominal, scores, forces)
