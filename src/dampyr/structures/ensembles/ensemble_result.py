"""Result of an ensemble: the peaks of all cases, and the fragility curves of its limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from dampyr.findings import Finding, worst_first
from dampyr.origin import Origin
from dampyr.shown import Shown
from dampyr.structures.ensembles.ensemble_accuracy import doubts, under_laws
from dampyr.structures.ensembles.fragility import Fragility, fragility
from dampyr.structures.ensembles.peak_limits import limits_of
from dampyr.structures.ensembles.store import finding_of, origin_of, read_dataset


@dataclass(frozen=True, eq=False, repr=False)
class EnsembleResult(Shown):
    """Result of `ensemble`.

    ``dataset`` holds the peaks, an ``xarray.Dataset`` with dims (building, damper, input, motion, scale, ...), and ``curves``
    are the fragility curves over ``intensity``, one for each limit.
    """

    dataset: Any
    curves: tuple[Fragility, ...] = ()
    intensity: str = "pga"

    @property
    def origin(self) -> Origin:
        """That of the dampers' cards together; the responses are computed, whatever these rest on."""
        return origin_of(self.dataset)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is wrong or in doubt in the dampers, the accuracy and the cases; the worst first."""
        attributes = self.dataset.attrs
        outside = [attributes["outside"]] if attributes.get("outside") else []
        note = under_laws(attributes)
        return worst_first(
            map(finding_of, attributes.get("findings", ())),
            (Finding("doubt", sentence) for sentence in (*doubts(attributes), *outside)),
            (Finding("note", sentence) for sentence in (note,) if sentence),
        )

    def to_xarray(self) -> Any:
        """The peaks, the ``xarray.Dataset`` itself."""
        return self.dataset

    def evaluated(
        self, limits: Sequence[str] | str = (), height: float | None = None, intensity: str = "pga", seed: int = 1
    ) -> EnsembleResult:
        """The same peaks with the fragility curves of other limits; the arguments are those of `ensemble`."""
        texts = (limits,) if isinstance(limits, str) else tuple(limits)
        curves = tuple(
            fragility(self.dataset, limit.quantity, limit.value, intensity, height=limit.height, seed=seed)
            for limit in limits_of(texts, height)
        )
        return replace(self, curves=curves, intensity=intensity)


def read_ensemble(path: str | Path) -> EnsembleResult:
    """The peaks that an ensemble wrote with ``out=``; `EnsembleResult.evaluated` adds fragility curves.

    Raises :class:`~dampyr.errors.FileError` where the file is not an ensemble, or is not finished.
    """
    return EnsembleResult(read_dataset(path))
