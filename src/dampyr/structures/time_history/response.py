"""Response of a building to a ground motion and loads: histories at the samples of the motion, peaks and energies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dampyr.findings import Finding, worst_first
from dampyr.input_kinds import NO_INPUT, unit_of
from dampyr.origin import NOT_STATED, Origin
from dampyr.shown import Shown
from dampyr.structures.floor_loads import FloorLoads

Array = NDArray[np.float64]


_UNITS = {
    "ground_acceleration": ("time", "m/s^2"),
    "displacement": ("floor time", "m"),
    "velocity": ("floor time", "m/s"),
    "acceleration": ("floor time", "m/s^2"),
    "drift": ("storey time", "m"),
    "base_shear": ("time", "N"),
    "force": ("damper time", "N"),
    "input": ("damper time", ""),
    "stroke": ("damper time", "m"),
    "peak_displacement": ("floor", "m"),
    "peak_drift": ("storey", "m"),
    "peak_acceleration": ("floor", "m/s^2"),
    "peak_base_shear": ("", "N"),
    "peak_force": ("damper", "N"),
    "mean_input": ("damper", ""),
}  # name -> dims, unit


OF_INPUTS = ("damper_law", "damper_input_unit")  # coordinates that say what sets the dampers' inputs


class Output(NamedTuple):
    """Histories and peaks as they are computed; a row per sample of the ground motion."""

    state: Any  # (samples, 2n)
    acceleration: Any  # (samples, n), absolute
    force: Any  # (samples, N)
    input: Any  # (samples, N) V or A, that of the force
    mean_input: Any  # (N,) V or A, over all steps
    work: Any  # (samples, 2 + N): input, viscous, each damper
    displacement_peak: Any  # (n,)
    drift_peak: Any  # (n,)
    acceleration_peak: Any  # (n,)
    shear_peak: Any  # (1,)
    force_peak: Any  # (N,)
    rest_slopes: Any  # (N, 2): dF/dx and dF/dv at rest
    misfit: Any  # (3,): steps not solved to the tolerance, the largest relative misfit, iterations in all

    @property
    def peaks(self) -> dict[str, Any]:
        """The peaks by the names of their quantities."""
        return {
            "displacement": self.displacement_peak,
            "drift": self.drift_peak,
            "acceleration": self.acceleration_peak,
            "base_shear": self.shear_peak,
            "force": self.force_peak,
        }

    def of_floors(self, count: int) -> Output:
        """The peaks of the floors alone, the first ``count`` coordinates; histories stay those of all."""
        names = ("displacement_peak", "drift_peak", "acceleration_peak")
        return self._replace(**{name: getattr(self, name)[:count] for name in names})


def output(samples: int, n: int, sites: int) -> Output:
    """An output of zeros."""
    return Output(
        state=np.zeros((samples, 2 * n)),
        acceleration=np.zeros((samples, n)),
        force=np.zeros((samples, sites)),
        input=np.zeros((samples, sites)),
        mean_input=np.zeros(sites),
        work=np.zeros((samples, 2 + sites)),
        displacement_peak=np.zeros(n),
        drift_peak=np.zeros(n),
        acceleration_peak=np.zeros(n),
        shear_peak=np.zeros(1),
        force_peak=np.zeros(sites),
        rest_slopes=np.zeros((sites, 2)),
        misfit=np.zeros(3),
    )


def relative_change(values: Array, reference: Array) -> float:
    """The largest change (k,) of ``values`` against ``reference``, relative; 0 where there are none."""
    # a peak that is nothing beside the largest has no relative change
    size = np.maximum(np.abs(reference), 1e-9 * np.max(np.abs(reference), initial=0.0) + 1e-300)
    return float(np.max(np.abs(values - reference) / size, initial=0.0))


class Truncation(NamedTuple):
    """What a reduced structure leaves out: the largest relative change of each kind of peak.

    The response has ``coordinates`` for the ``degrees`` of freedom of the structure, and is compared with ``judge``, which is
    "" where nothing is left out. ``force`` is that of the dampers.
    """

    coordinates: int
    degrees: int
    judge: str = ""
    displacement: float = 0.0
    drift: float = 0.0
    acceleration: float = 0.0
    base_shear: float = 0.0
    force: float = 0.0

    @property
    def errors(self) -> dict[str, float]:
        """The changes by name."""
        return {name: getattr(self, name) for name in ("displacement", "drift", "acceleration", "base_shear", "force")}

    def in_words(self) -> str:
        """As a part of a sentence."""
        size = f"{self.coordinates} coordinates for {self.degrees} degrees of freedom"
        if not self.judge:
            return f"{size}, which leave nothing out"
        names = (
            ("displacements", self.displacement),
            ("drifts", self.drift),
            ("accelerations", self.acceleration),
            ("base shear", self.base_shear),
            *((("damper forces", self.force),) if "with the dampers" in self.judge else ()),
        )
        changes = ", ".join(f"{name} {100 * value:.2g} %" for name, value in names)
        if np.isnan(self.displacement):
            return f"{size}, judged by {self.judge}"
        return f"{size}; beside {self.judge}, peaks differ by at most: {changes}"


@dataclass(frozen=True, eq=False)
class Decisions:
    """What the laws of a run sensed and decided, at each of their D instants."""

    sensed: Array  # (N, D, A + 1): the arguments of the law, and the decision
    other: Array  # (N, D): what the law could have decided, had all been as far off as in the run at twice the step
    taken: Array  # (N, D): which of these are decisions; False where a site has no law, or one that decides less often

    def others(self) -> Array | None:
        """Each decision that could have been another, taken so; NaN for the others, and None where there is no such one."""
        hanging = self.taken & (self.other != self.sensed[:, :, -1])
        return np.where(hanging, self.other, np.nan) if hanging.any() else None

    @property
    def count(self) -> int:
        """How many decisions there are of all laws."""
        return int(self.taken.sum())


@dataclass(frozen=True, eq=False)
class Integration:
    """One integration through a ground motion, and its error estimates where the step was halved."""

    out: Output
    step: float
    tolerance: float | None = None
    changes: Mapping[str, float] = field(default_factory=dict)  # by quantity, see `Response.error_estimates`
    reason: str = ""
    decisions: Decisions | None = None
    reasons: tuple[dict[str, float], ...] = ()  # as `Response.wanted_forces`

    @property
    def error(self) -> float | None:
        """The largest relative change of a peak of displacement or drift; None where the step was not halved."""
        return max(self.changes["displacement"], self.changes["drift"]) if self.changes else None


@dataclass(frozen=True, eq=False, repr=False)
class Energy(Shown):
    """Energies [J] in coordinates relative to the ground, (samples,) each; ``dampers`` is (sites, samples).

    ``residual`` = input - kinetic - strain - viscous - dampers; it is the error of the balance and falls
    with the step.
    """

    input: Array
    kinetic: Array
    strain: Array
    viscous: Array
    dampers: Array

    @property
    def damper(self) -> Array:
        """What all dampers took together, (samples,)."""
        return self.dampers.sum(axis=0)

    @property
    def residual(self) -> Array:
        """What does not add up, (samples,)."""
        return self.input - self.kinetic - self.strain - self.viscous - self.damper


@dataclass(frozen=True, eq=False, repr=False)
class Response(Shown):
    """The response of a building with n floors and N damper sites, T samples.

    Histories stand at the samples of the ground motion. Peaks of displacement and drift are those of the
    motion itself, between samples too; peaks of acceleration, base shear and force are the largest at the
    half steps.
    """

    time: Array  # (T,) s
    ground_acceleration: Array  # (T,) m/s2
    displacement: Array  # (n, T) m, relative to the ground
    velocity: Array  # (n, T) m/s, relative to the ground
    acceleration: Array  # (n, T) m/s2, absolute
    drift: Array  # (n, T) m, storey 1 first
    base_shear: Array  # (T,) N that springs, dashpots and dampers hand to the ground, signed as displacement
    force: Array  # (N, T) N, as applied; positive opposes positive velocity
    stroke: Array  # (N, T) m, what each site's floors move apart
    # V or A at the coil (N, T), as the force of the same sample was made; a jump at a sample acts from there on. Laws decide
    # more often than a motion has samples, so its mean is no mean over time: that is ``mean_input``.
    input: Array
    peak_displacement: Array  # (n,) m
    peak_drift: Array  # (n,) m
    peak_acceleration: Array  # (n,) m/s2, absolute
    peak_base_shear: float  # N
    peak_force: Array  # (N,) N
    energy: Energy
    storeys: tuple[int, ...]  # (N,) where the sites are; 0 for one that joins other floors than a storey does
    inputs: tuple[float | None, ...]  # (N,) V or A; None where a law sets it, and where there is none
    floors: tuple[str, ...]
    scheme: str  # "linear" (no damper), "exact path" or "general"
    step: float  # s
    # the change of a peak of displacement and drift on halving the step that was asked for; None where the step was given
    accuracy: float | None
    error_estimate: (
        float | None
    )  # the largest relative change of a peak of displacement or drift in the last halving; None where the step was given
    converged: bool
    reason: str
    title: str = ""
    sites: tuple[str, ...] = ()  # (N,) where the sites are, such as "storey 1" and "0-2"
    laws: tuple[str, ...] = ()  # (N,) what sets the inputs, in words; empty where they are constant
    input_units: tuple[str, ...] = ()  # (N,) "V", "A" or "none"
    mean_input: Array = field(default_factory=lambda: np.zeros(0))  # (N,) V or A at the coil, the mean over time
    after: float = 0.0  # s of rest after the record, at the end of the arrays
    # The same change of every quantity: "displacement", "drift", "acceleration", "base_shear", "force" (of the peaks, relative)
    # and "mean_input" (V or A). Only the first two were halved for; the others may be larger. Empty where the step was given.
    error_estimates: Mapping[str, float] = field(default_factory=dict)
    origin: Origin = NOT_STATED  # of the dampers' cards together: a response is computed, whatever they rest on
    of_dampers: tuple[Finding, ...] = ()  # what is wrong or in doubt in the dampers
    # an accuracy that was not reached, a damper that gave energy, calibrated limits that the motion leaves, in words
    doubts: tuple[str, ...] = ()
    truncation: Truncation | None = None  # what a reduced structure leaves out; None where nothing is left out
    # (N,) of a law that asks for a force: the share of its decisions that were "met", and of those that were not by what kept
    # them from it (`dampyr.models.inverse`); {} of others
    wanted_forces: tuple[Mapping[str, float], ...] = ()
    loads: FloorLoads | None = None  # forces on the floors, as given; None without any
    # of a structure on several supports, whose displacements and velocities are relative to what the supports alone would make
    # of it: their names, and their accelerations (S, T) m/s2; the ground's are 0 then
    supports: tuple[str, ...] = ()
    support_acceleration: Array = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def shaken(self) -> bool:
        """Whether the ground moves: not under loads alone, nor where several supports do in its place."""
        return bool(self.ground_acceleration.any()) or not (self.loads or self.supports)

    @property
    def load_forces(self) -> Array:
        """The forces of the loads (k, T) N at the samples, a row for each floor in the order of ``loads.forces``."""
        return np.zeros((0, len(self.time))) if self.loads is None else self.loads.at(self.time).T

    def loads_as_dict(self) -> dict[str, Any]:
        """What loads and supports there are, for JSON; nothing without any."""
        entry: dict[str, Any] = {}
        if self.loads is not None:
            entry["loads"] = self.loads.as_dict()
        if self.supports:
            peaks = np.max(np.abs(self.support_acceleration), axis=1)
            entry["peak_support_acceleration_m_s2"] = dict(zip(self.supports, peaks.tolist(), strict=True))
        return entry

    @property
    def has_input(self) -> bool:
        """Whether a damper has an input, a voltage or a current."""
        return any(kind != NO_INPUT for kind in self.input_units)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is wrong or in doubt in the dampers and in the response, the worst first."""
        return worst_first(self.of_dampers, (Finding("doubt", sentence) for sentence in self.doubts))

    def to_xarray(self) -> Any:
        """The histories and peaks as an ``xarray.Dataset`` with dims time, floor, storey and damper;
        units in ``attrs``."""
        import xarray

        data = {k: (dims.split(), np.asarray(getattr(self, k)), {"units": unit}) for k, (dims, unit) in _UNITS.items()}
        units = set(self.input_units) - {NO_INPUT}
        unit = units.pop() if len(units) == 1 else "V or A"
        data["input"][2]["units"] = data["mean_input"][2]["units"] = unit
        for part in ("input", "kinetic", "strain", "viscous", "damper", "residual"):
            data[f"energy_{part}"] = (["time"], getattr(self.energy, part), {"units": "J"})
        count = len(self.storeys)
        coordinates = {
            "time": ("time", self.time, {"units": "s"}),
            "floor": list(self.floors),
            "storey": np.arange(1, len(self.floors) + 1),
            "damper": np.arange(1, count + 1),
            "damper_site": ("damper", np.array(self.sites, dtype=str)),
            "damper_storey": ("damper", np.array(self.storeys, dtype=int)),
            "damper_law": ("damper", np.array(self.laws, dtype=str)),
            "damper_input_unit": ("damper", np.array([unit_of(kind) for kind in self.input_units], dtype=str)),
        }
        if self.loads is not None:
            coordinates["loaded_floor"] = list(self.loads.forces)
            data["floor_load"] = (["loaded_floor", "time"], self.load_forces, {"units": "N"})
        if self.supports:
            coordinates["support"] = list(self.supports)
            data["support_acceleration"] = (["support", "time"], self.support_acceleration, {"units": "m/s^2"})
        if count and not self.has_input:
            data = {name: entry for name, entry in data.items() if name not in ("input", "mean_input")}
            coordinates = {name: entry for name, entry in coordinates.items() if name not in OF_INPUTS}
        return xarray.Dataset(data, coords=coordinates, attrs=self._attributes())

    def truncation_as_dict(self) -> dict[str, Any]:
        """What the reduced structure leaves out, for JSON; nothing where nothing is left out."""
        if self.truncation is None:
            return {}
        changes = {f"truncation_error_{name}": value for name, value in self.truncation.errors.items()}
        return changes | {"truncation_judged_by": self.truncation.judge}

    def _attributes(self) -> dict[str, Any]:
        attributes = {
            "scheme": self.scheme,
            "step_s": self.step,
            "converged": int(self.converged),
            "title": self.title,
            "damper_origin": self.origin.as_json(),
            "after_s": self.after,
        }
        if self.findings:  # not every format of files takes an empty list
            attributes["findings"] = list(map(str, self.findings))
        if self.error_estimate is not None:
            attributes["error_estimate"] = self.error_estimate
        attributes |= {f"error_estimate_{name}": value for name, value in self.error_estimates.items()}
        if self.reason:
            attributes["reason"] = self.reason
        return attributes | self.truncation_as_dict()
