"""What a building job is asked for, and the building, motions, damper and inputs that are meant."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from dampyr import ground_motions, models, structures, studies
from dampyr.console import safe_paths
from dampyr.console.cards import CARDS
from dampyr.errors import InputError
from dampyr.studies import THESIS
from dampyr.units import STANDARD_GRAVITY

MOTIONS = "motions"
MOTION_SUFFIXES = (".at2", ".csv", ".txt", ".dat", ".mat")
DT = 0.01

Positive = Annotated[float, Field(ge=1e-6, le=1e15, allow_inf_nan=False)]  # beyond, sums of squares overflow


class Strict(BaseModel):
    """A part of a question; what is not known is refused."""

    model_config = ConfigDict(extra="forbid")


class BuildingAsked(Strict):
    """The two-storey building of chapter 5, or a shear building from the ground up."""

    kind: Literal["two_storey", "shear"] = "two_storey"
    masses: list[Positive] = Field(default=[], max_length=40, description="kg, one per floor.")
    stiffnesses: list[Positive] = Field(default=[], max_length=40, description="N/m, one per storey.")
    damping: float = Field(default=0.03, ge=0, lt=1, description="Ratio, of all modes.")

    def building(self) -> Any:
        """As a `dampyr.structures.Building`."""
        if self.kind == "two_storey":
            return structures.two_storey()
        return structures.shear_building(self.masses, self.stiffnesses, damping_ratio=self.damping, method="modal")


class MotionAsked(Strict):
    """El Centro 1940, a synthetic motion by its seed, or a file of the folder ``motions``; ``pga`` scales it."""

    kind: Literal["el_centro", "kanai_tajimi", "file"] = "el_centro"
    file: str = Field(default="", max_length=200)
    unit: Literal["", "g", "m/s^2", "cm/s^2"] = Field(default="", description="Of a file that does not say it.")
    seed: int = Field(default=1, ge=0, le=2**31)
    duration: float = Field(default=20.0, ge=1, le=200, description="s, of a synthetic motion.")
    pga: float | None = Field(
        default=None, gt=0, le=100, description="m/s2; by default as it is, and 0.3 g of a synthetic one."
    )

    def motion(self, data: Path, seed: Any = None) -> Any:
        """As a `dampyr.ground_motions.GroundMotion`."""
        if self.kind == "kanai_tajimi":
            return ground_motions.kanai_tajimi(
                self.duration, DT, self.seed if seed is None else seed, pga=self.pga or 0.3 * STANDARD_GRAVITY
            )
        if self.kind == "file":
            path = safe_paths.existing(data / MOTIONS, self.file)
            ground_motion = ground_motions.read(path, units=self.unit or None)
        else:
            ground_motion = ground_motions.el_centro()
        return ground_motion if self.pga is None else ground_motion.scaled_to_pga(self.pga)


class DamperAsked(Strict):
    """A card of the data folder (``cards/NAME.toml``) or a published set by its name; where it stands, and its inputs."""

    name: str = Field(default=THESIS, max_length=200)
    storey: int = Field(default=1, ge=1, le=40)
    inputs: list[Annotated[float, Field(allow_inf_nan=False)]] = Field(default=[], max_length=6)
    laws: list[Annotated[str, Field(max_length=40)]] = Field(default=[], max_length=5)
    allow_extrapolation: bool = False

    def damper(self, data: Path) -> Any:
        """As a `dampyr.models.Damper`."""
        if self.name.startswith(f"{CARDS}/"):
            return models.Damper.load(safe_paths.existing(data, self.name))
        return studies.published_damper(self.name)

    def all_inputs(self, damper: Any) -> list[Any]:
        """The constant inputs, then the control laws over the calibrated range."""
        low, high = damper.range
        inputs = [*self.inputs, *(structures.control_law(law, low=low, high=high) for law in self.laws)]
        if not inputs:
            raise InputError("no input and no control law is given; give one or more")
        return inputs

    def word(self, damper: Any) -> str:
        """The argument that takes its input."""
        return "voltage" if damper.input == "V" else "current"


class ResponseAsked(Strict):
    """A building in an earthquake: without damper, and with one at each input."""

    building: BuildingAsked = BuildingAsked()
    motion: MotionAsked = MotionAsked()
    damper: DamperAsked = DamperAsked(inputs=[0.0, 1.98])


class EnsembleAsked(Strict):
    """Many motions at many scales, and how likely a limit is exceeded."""

    building: BuildingAsked = BuildingAsked()
    motion: MotionAsked = MotionAsked(kind="kanai_tajimi")
    damper: DamperAsked = DamperAsked(inputs=[0.0, 1.98])
    motions: int = Field(default=20, ge=1, le=400, description="How many synthetic motions; other kinds are one.")
    scales: list[Positive] = Field(default=[0.5, 1.0, 1.5, 2.0, 2.5, 3.0], min_length=1, max_length=40)
    quantity: Literal["drift", "acceleration"] = "drift"
    limit: Positive = Field(default=0.012, description="m of drift, or m/s2.")
    seed: int = Field(default=1, ge=0, le=2**31)
