"""Requests of the Building page, and the building, motions, damper and options that they mean."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from dampyr import ground_motions, registry, structures
from dampyr.console import safe_paths
from dampyr.console.dampers import CARDS
from dampyr.console.option_schemas import request_of
from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.ground_motions.motion_files import REGISTRY as FORMATS
from dampyr.ground_motions.synthetic import SYNTHETIC_DURATION, SYNTHETIC_PGA, synthetic_motions
from dampyr.models import Damper
from dampyr.structures import EnsembleOptions, RespondOptions
from dampyr.structures.control_laws import law_of
from dampyr.structures.sites import one_in_each
from dampyr.studies import THESIS, available_structures, load_structure

MOTIONS, STRUCTURES = "motions", "structures"
MOTION_SUFFIXES = tuple(suffix for _, module in registry.members(FORMATS) for suffix in module.SUFFIXES)

Positive = Annotated[float, Field(ge=1e-6, le=1e15, allow_inf_nan=False)]  # beyond, sums of squares overflow

# Of rest after the record, longer than the free vibration of any building: 60 s at a period of 2 s and 2 % of damping leave
# 1/40 of it; of drawn dampers, as each computes all cases again.
HIGHEST = {"after": 120, "draws": 100, "seed": 2**31}
LIMITS = {"limits": ("12mm",)}  # the page shows a fragility curve in any case


class Strict(BaseModel):
    """A part of a request; unknown fields are refused."""

    model_config = ConfigDict(extra="forbid")


class BuildingRequest(Strict):
    """The two-storey building of chapter 5, a shear building from the ground up, a published structure, or a file of the folder
    ``structures``."""

    kind: Literal["two_storey", "shear", "published", "file"] = "two_storey"
    name: str = Field(default="", max_length=200, description="Of a published structure, or of a file.")
    masses: list[Positive] = Field(default=[], max_length=40, description="kg, one per floor.")
    stiffnesses: list[Positive] = Field(default=[], max_length=40, description="N/m, one per storey.")
    damping: float = Field(default=0.03, ge=0, lt=1, description="Ratio, of all modes.")

    @property
    def title(self) -> str:
        """In words, for a list of jobs."""
        return self.name or self.kind.replace("_", "-")

    def file(self, data: Path) -> Path | None:
        """The structure's file in the data folder, where it is one."""
        return safe_paths.existing(data / STRUCTURES, self.name) if self.kind == "file" else None

    def building(self, data: Path) -> structures.Building:
        """As a `dampyr.structures.Building`."""
        if self.kind == "two_storey":
            return structures.two_storey()
        if self.kind == "published":
            return published_structure(self.name)
        if (path := self.file(data)) is not None:
            return structures.load(path)
        return structures.shear_building(self.masses, self.stiffnesses, damping_ratio=self.damping, method="modal")


def published_structure(name: str) -> structures.Building:
    """The published structure of this name; never a file of the server's folder."""
    if name not in (offered := available_structures()):
        raise InputError(f"{name!r} is not a published structure; choose from {', '.join(offered)}")
    return load_structure(name)


class MotionRequest(Strict):
    """El Centro 1940, a synthetic motion by its seed, or a file of the folder ``motions``; ``pga`` scales it."""

    kind: Literal["el_centro", "kanai_tajimi", "file"] = "el_centro"
    file: str = Field(default="", max_length=200)
    unit: Literal["", "g", "m/s^2", "cm/s^2"] = Field(default="", description="Of a file that does not state it.")
    seed: int = Field(default=1, ge=0, le=2**31)
    duration: float = Field(default=SYNTHETIC_DURATION, ge=1, le=200, description="s, of a synthetic motion.")
    pga: float | None = Field(
        default=None, gt=0, le=100, description="m/s2; by default as it is, and 0.3 g of a synthetic one."
    )

    def motion(self, data: Path) -> GroundMotion:
        """As a `dampyr.ground_motions.GroundMotion`; of several synthetic ones the first."""
        return self.motions(data, 1)[0]

    def motions(self, data: Path, count: int) -> list[GroundMotion]:
        """``count`` synthetic motions, or the one motion of another kind."""
        if self.kind == "kanai_tajimi":
            return synthetic_motions(count, self.seed, self.duration, self.pga or SYNTHETIC_PGA)
        if self.kind == "file":
            path = safe_paths.existing(data / MOTIONS, self.file)
            motion = ground_motions.read(path, units=self.unit or None)
        else:
            motion = ground_motions.el_centro()
        return [motion if self.pga is None else motion.scaled_to_pga(self.pga)]


class DamperRequest(Strict):
    """A card of the data folder (``cards/NAME.toml``) or a published set by its name; where one stands, each with the same
    input, and the inputs."""

    name: str = Field(default=THESIS, max_length=200)
    storeys: list[Annotated[int, Field(ge=1, le=40)]] = Field(default=[1], min_length=1, max_length=40)
    inputs: list[Annotated[float, Field(allow_inf_nan=False)]] = Field(default=[], max_length=6)
    laws: list[Annotated[str, Field(max_length=40)]] = Field(default=[], max_length=5)

    def placed(self, damper: Damper) -> dict[int, Damper]:
        """The damper in each of the storeys."""
        return one_in_each(damper, self.storeys)

    def inputs_by_kind(self, damper: Damper) -> dict[str, Any]:
        """The argument ``voltage`` or ``current`` of a response: the numbers, then the control laws; None where there is no
        input."""
        if not damper.has_input:
            if self.inputs or self.laws:
                raise InputError(f"{self.name} has no input, and inputs or control laws are given; leave them out")
            return {"voltage": [None]}
        if not self.inputs and not self.laws:
            raise InputError("no input and no control law is given; give one or more")
        laws = [law_of(text, damper) for text in self.laws]
        return {"voltage" if damper.input == "V" else "current": [*self.inputs, *laws]}


class ResponseRequest(request_of(RespondOptions, highest=HIGHEST), Strict):  # type: ignore[misc]
    """A building in an earthquake: without damper, and with one at each input."""

    building: BuildingRequest = BuildingRequest()
    motion: MotionRequest = MotionRequest()
    damper: DamperRequest = DamperRequest(inputs=[0.0, 1.98])


class EnsembleRequest(request_of(EnsembleOptions, usual=LIMITS, highest=HIGHEST), Strict):  # type: ignore[misc]
    """Many motions at many scales, without damper and with one at each input, and how likely limits are exceeded."""

    building: BuildingRequest = BuildingRequest()
    motion: MotionRequest = MotionRequest(kind="kanai_tajimi")
    damper: DamperRequest = DamperRequest(inputs=[0.0, 1.98])
    motions: int = Field(default=20, ge=1, le=400, description="How many synthetic motions; other kinds are one.")
    scales: list[Positive] = Field(default=[0.5, 1.0, 1.5, 2.0, 2.5, 3.0], min_length=1, max_length=40)

    def synthetic_or_one(self, data: Path) -> list[GroundMotion]:
        """The motions, synthetic ones by the seed of the ensemble."""
        return self.motion.model_copy(update={"seed": self.seed}).motions(data, self.motions)


def files_read(data: Path, request: ResponseRequest | EnsembleRequest) -> list[Path]:
    """The structure, the card and the motion of a request, where they are files of the data folder."""
    structure, damper, motion = request.building.file(data), request.damper.name, request.motion.file
    return [
        *([structure] if structure else []),
        *([data / damper] if damper.startswith(f"{CARDS}/") else []),
        *([data / MOTIONS / motion] if motion else []),
    ]
