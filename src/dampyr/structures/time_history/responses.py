"""Responses of a building at several inputs of its dampers, and without them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from dampyr.errors import InputError
from dampyr.findings import Finding, worst_first
from dampyr.origin import Origin, combined
from dampyr.shown import Shown
from dampyr.structures.time_history.response import Response

INTERVAL = (0.05, 0.95)
INTERVAL_OF = {  # a quantity of `ensemble` -> its name in JSON
    "displacement": "peak_displacement_m", "drift": "peak_drift_m", "acceleration": "peak_acceleration_m_s2",
    "force": "peak_force_N", "energy": "energy_J",
}  # fmt: skip


@dataclass(frozen=True, repr=False)
class Responses(Shown):
    """Responses at several inputs: the cases by name, that without damper first; ``unit`` of the inputs of the dampers."""

    building: str
    motion: str
    unit: str
    cases: Mapping[str, Response]
    intervals: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """90 % intervals (2, floors) or (2, sites) of the peaks of each case with a damper, by the names of `as_dict`, SI units."""
    draws: int = 0

    def __getitem__(self, name: str) -> Response:
        """The response of the case of this name."""
        if name not in self.cases:
            raise InputError(f"{name!r} is not a case; choose from {', '.join(map(repr, self.cases))}")
        return self.cases[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.cases)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Those of all cases, the worst first; what is not said of every case with a damper has its case as the source."""
        cases = {name: response for name, response in self.cases.items() if response.sites} or self.cases
        shared = [
            finding
            for finding in next(iter(cases.values())).findings
            if all(finding in response.findings for response in cases.values())
        ]
        return worst_first(
            shared,
            (
                replace(finding, source=finding.source or name)
                for name, response in self.cases.items()
                for finding in response.findings
                if finding not in shared
            ),
        )

    @property
    def origin(self) -> Origin:
        """That of the damper's card; a response is computed, whatever it rests on."""
        return combined(response.origin for response in self.cases.values() if response.sites)

    def peaks_by_floor(self) -> tuple[list[str], dict[str, tuple[Any, Any, Any]]]:
        """The floors, and for each case its peaks of displacement m, drift m and acceleration m/s2."""
        first = next(iter(self.cases.values()))
        peaks = {name: (r.peak_displacement, r.peak_drift, r.peak_acceleration) for name, r in self.cases.items()}
        return list(first.floors), peaks

    @property
    def title(self) -> str:
        """Building and motion."""
        return f"{self.building}, {self.motion}"
