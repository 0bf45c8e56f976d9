"""Requests for the next tests, and what they mean."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from dampyr import ground_motions
from dampyr.console import record_sources
from dampyr.console.building_schemas import published_structure
from dampyr.console.dampers import damper_of
from dampyr.console.option_schemas import request_of
from dampyr.errors import InputError
from dampyr.planning import Peak, PlanOptions
from dampyr.studies import THESIS


class ProposalRequest(request_of(PlanOptions)):  # type: ignore[misc]
    """What the next tests are to tell: from records, or from a damper (a card of the data folder or a published set; without
    one that of the rig), on a rig (the original one without a name).

    The goal "peak" is that of a published structure in El Centro 1940 with the damper in storey 1 at a voltage.
    """

    records: Annotated[list[str], Field(max_length=200, description="Keys of records.")] = []  # noqa: RUF012 (copied by pydantic)
    damper: str = Field(default="", max_length=200)
    rig: str = Field(default="", max_length=100)
    structure: str = Field(default=THESIS, max_length=200, description="Of the goal peak.")
    voltage: float | None = Field(default=None, allow_inf_nan=False, description="Of the goal peak, V.")
    of: Literal["drift", "displacement", "acceleration"] = "drift"

    @property
    def title(self) -> str:
        """In words, for a list of jobs."""
        return (
            f"tests from {f'{len(self.records)} records' if self.records else self.damper or 'the damper of the rig'}"
        )

    def evidence(self, data: Path) -> Any:
        """The records, the damper, or None for that of the rig."""
        if self.records and self.damper:
            raise InputError(
                "records and a damper are both chosen; a damper stands in place of records, so leave one out"
            )
        if self.records:
            return record_sources.read_all(data, self.records)
        return damper_of(data, self.damper) if self.damper else None

    def peak(self) -> Peak | None:
        """The peak that is planned for; None for the goal "parameters"."""
        if self.goal != "peak":
            return None
        if self.voltage is None:
            raise InputError("the goal peak needs the damper's voltage in the earthquake; enter it")
        return Peak(published_structure(self.structure), ground_motions.el_centro(), self.voltage, self.of)
