"""What can be chosen for dampers in a building: in a response, and in an ensemble of many."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from dampyr.config import Choices
from dampyr.errors import InputError
from dampyr.options import Options, Terminal
from dampyr.structures.batch.assemble import QUANTITIES
from dampyr.structures.ensembles.peak_limits import Limit, limit_of, limits_of
from dampyr.units import Quantity

MIN_DRAWS = 20  # the 5 % and 95 % quantiles of fewer are their extremes


@dataclass(frozen=True)
class InstallationOptions(Options):
    """Options that responses and ensembles share: what is changed of every damper, and for how long the building moves on."""

    brace: Annotated[
        float | None, Quantity("N/m", low=0, open_low=True), "Stiffness of a brace in series with every damper"
    ] = None
    without: Annotated[
        tuple[str, ...],
        Terminal(metavar="PART"),
        "Parts that are left out of every damper, such as delay where it is that of the rig",
    ] = ()
    allow_extrapolation: Annotated[
        bool, "Take an input outside the range that a damper was calibrated on, with a warning"
    ] = False
    after: Annotated[
        float,
        Quantity("s", low=0),
        "Rest of the ground after the record; without it a building that still swings then may reach its peak later",
    ] = 0.0


@dataclass(frozen=True)
class RespondOptions(InstallationOptions):
    """Options of `respond`."""

    accuracy: Annotated[
        str | float,
        Choices(("strict", "fast")),
        Quantity("", low=0, high=1, open_low=True),
        "Largest relative change of a peak displacement or drift when the step is halved: strict is 2e-4, fast 1e-3",
    ] = "strict"
    step: Annotated[
        float | None,
        Quantity("s", low=0, open_low=True),
        "Compute once with this step, which must divide that of the motion and the period of every control law",
    ] = None
    draws: Annotated[
        int | None,
        Quantity("", low=MIN_DRAWS),
        "90 % intervals of the peaks of several cases, from so many dampers of the card's covariance",
    ] = None
    seed: Annotated[int, Quantity("", low=0), "Seed of the drawn dampers"] = 1

    def check(self) -> None:
        """Refuse intervals at a given step, as the drawn dampers have steps of their own."""
        if self.draws is not None and self.step is not None:
            raise InputError("draws and step exclude each other; leave one of them out")


@dataclass(frozen=True)
class EnsembleOptions(InstallationOptions):
    """Options of `ensemble`."""

    draws: Annotated[
        int | None, Quantity("", low=1), "In the place of every damper so many from its card's covariance"
    ] = None
    seed: Annotated[
        int, Quantity("", low=0), "Seed of the drawn dampers, of the bands of fragility curves and of synthetic motions"
    ] = 1
    seeds: Annotated[
        int | None,
        Quantity("", low=1),
        "So many runs of every damper, each with noise of its own in the sensors of control laws; drawn dampers have it anyway",
    ] = None
    limits: Annotated[
        tuple[str, ...],
        Terminal("--limit", "L"),
        "A fragility curve for each: 12mm or 1% of drift, 0.5g, or such as force=1kN",
    ] = ()
    height: Annotated[
        float | None, Quantity("m", low=0, open_low=True), "Height of the storeys, for limits in per cent of it"
    ] = None
    intensity: Annotated[
        str,
        Choices(
            {
                "pga": "peak ground acceleration",
                "sa": "spectral acceleration at the first period of the building",
                "scale": "factor of the motion",
            }
        ),
        "What fragility curves are over",
    ] = "pga"
    quantities: Annotated[
        tuple[str, ...],
        Choices(QUANTITIES),
        Terminal("--quantity", "|".join(QUANTITIES)),
        "Peaks that are returned, energy being what a damper took; fewer are faster",
    ] = QUANTITIES
    accuracy: Annotated[
        str,
        Choices({"fast": "2 % of each peak", "strict": "0.1 % of each peak"}),
        "Bound of the error of peak displacements and drifts; strict takes 2.5 times as long, and 10 times for dampers that "
        "stretch in series",
    ] = "fast"
    precision: Annotated[
        int,
        Choices({64: "64 bits", 32: "32 bits"}),
        "Bits of a number; 32 runs twice as fast and is good for about four digits",
    ] = 64
    device: Annotated[
        str,
        Choices({"cpu": "the processor", "gpu": "a graphics card with CUDA"}),
        "What computes: the processor, or a graphics card with CUDA (extra gpu; buildings of up to two floors)",
    ] = "cpu"

    def check(self) -> None:
        """Refuse limits that are none, and an ensemble without peaks."""
        for text in self.limits:
            limit_of(text)
        if self.seeds is not None and self.draws is not None:
            raise InputError(
                "seeds and draws exclude each other, as each drawn damper has noise of its own; leave one out"
            )
        if not self.quantities:
            raise InputError(f"quantities is empty; choose from {', '.join(QUANTITIES)}")

    def checked_limits(self) -> tuple[Limit, ...]:
        """The limits, of quantities that are computed; InputError for others, and where a height is missing or not needed."""
        limits = limits_of(self.limits, self.height)
        for limit in limits:
            if limit.quantity not in self.quantities:
                raise InputError(
                    f"there is a limit of {limit.quantity}, which is not among the quantities; add it, or leave the limit out"
                )
        return limits
