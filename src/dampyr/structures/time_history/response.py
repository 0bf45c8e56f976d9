"""Response of a building to a ground motion: histories at the samples of the motion, peaks and energies."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.findings import Finding, as_dicts, worst_first
from dampyr.ground_motions import end_in_words
from dampyr.origin import NOT_STATED, Origin
from dampyr.representation import Representation, Summary, Table, data_frame, extent, listing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from dampyr.figures.style import Axis

Array = NDArray[np.float64]
FEW = 4  # dampers that a short text lists one by one


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

    sensed: Array  # (N, D, 5): signal, stroke, rate, force, and the decision
    other: (
        Array  # (N, D): what the law could have decided, had it sensed all as far off as in the run at twice the step
    )
    taken: Array  # (N, D): which of these are decisions; False where a site has no law, or one that decides less often

    def others(self) -> Array | None:
        """Each decision that could have been another, taken so; NaN for the others, and None where there is no such one."""
        hanging = self.taken & (self.other != self.sensed[:, :, 4])
        return np.where(hanging, self.other, np.nan) if hanging.any() else None

    @property
    def count(self) -> int:
        """How many decisions there are of all laws."""
        return int(self.taken.sum())


@dataclass(frozen=True, eq=False)
class Run:
    """One integration through a ground motion, and its error estimates where the step was halved."""

    out: Output
    step: float
    tolerance: float | None = None
    changes: Mapping[str, float] = field(default_factory=dict)  # by quantity, see `Response.error_estimates`
    reason: str = ""
    decisions: Decisions | None = None

    @property
    def error(self) -> float | None:
        """The largest relative change of a peak of displacement or drift; None where the step was not halved."""
        return max(self.changes["displacement"], self.changes["drift"]) if self.changes else None


@dataclass(frozen=True, eq=False, repr=False)
class Energy(Representation):
    """Energies [J] in coordinates relative to the ground, (samples,) each; ``dampers`` is (sites, samples).

    ``residual`` = input - kinetic - strain - viscous - dampers; it is the error of the balance and falls
    with the step.
    """

    input: Array
    kinetic: Array
    strain: Array
    viscous: Array
    dampers: Array

    def _summary(self) -> Summary:
        shares = [("input", self.input), ("dampers", self.damper), ("viscous", self.viscous)]
        rows = [("samples", str(len(self.input)))]
        rows += [(name, f"{float(values[-1]):.4g} J at the end") for name, values in shares]
        rows += [
            ("strain", "peak " + extent(np.max(self.strain), "J")),
            ("kinetic", "peak " + extent(np.max(self.kinetic), "J")),
        ]
        return "Energy", [*rows, ("residual", extent(self.residual, "J"))]

    @property
    def damper(self) -> Array:
        """What all dampers took together, (samples,)."""
        return self.dampers.sum(axis=0)

    @property
    def residual(self) -> Array:
        """What does not add up, (samples,)."""
        return self.input - self.kinetic - self.strain - self.viscous - self.damper


@dataclass(frozen=True)
class ResponsePlots:
    """Each method draws one figure and returns its matplotlib axes ``(k,)``."""

    response: Response

    def history(self, quantity: str = "displacement") -> Any:
        """A quantity of every floor, storey or damper over time.

        ``displacement``, ``velocity``, ``acceleration``, ``drift``, ``force``, ``stroke`` or ``input``.
        """
        from dampyr.figures import style
        from dampyr.figures.building import building_response

        axes, r = _plot_axes(), self.response
        if quantity not in axes or not len(getattr(r, quantity)):
            there = [name for name in axes if len(getattr(r, name))]
            raise InputError(f"{quantity!r} is no history of this response; choose from {', '.join(there)}")
        if quantity in ("force", "stroke", "input"):
            names = list(r.sites)
        elif quantity == "drift":
            names = [f"storey {k}" for k in range(1, len(r.floors) + 1)]
        else:
            names = [f"floor {name}" for name in r.floors]
        cases = dict(zip(names, getattr(r, quantity), strict=True))
        return style.in_pyplot(building_response, r.time, cases, axis=axes[quantity], origin=r.origin)

    def peaks(self) -> Any:
        """Peak displacement, drift and acceleration by floor."""
        from dampyr.figures import style
        from dampyr.figures.peaks import peaks_by_floor

        r, axes = self.response, _plot_axes()
        panels = [axes["displacement"], axes["drift"], axes["acceleration"]]
        values = (r.peak_displacement, r.peak_drift, r.peak_acceleration)
        cases = {r.title or "response": values}
        return style.in_pyplot(peaks_by_floor, list(r.floors), cases, axes=panels, origin=r.origin)

    def energy(self) -> Any:
        """Energies over time: kinetic, strain, viscous and dampers, stacked, and what the ground put in."""
        from dampyr.figures import style
        from dampyr.figures.energy import energy_over_time

        e = self.response.energy
        shares = {"viscous": e.viscous, "strain": e.strain, "kinetic": e.kinetic}
        if len(e.dampers):
            shares = {"dampers": e.damper} | shares
        return style.in_pyplot(energy_over_time, self.response.time, shares, e.input, origin=self.response.origin)


def errors_in_words(responses: Iterable[Response]) -> str:
    """The largest change of each quantity on halving the step among responses; empty where no step was halved."""
    judged = [r for r in responses if r.error_estimate is not None]
    if not judged:
        return ""

    def largest(name: str) -> float | None:
        return max((r.error_estimates[name] for r in judged if name in r.error_estimates), default=None)

    words = [f"{100 * max(r.error_estimate or 0.0 for r in judged):.2g} % of a peak of displacement or drift"]
    for name in ("acceleration", "base_shear", "force"):
        if (value := largest(name)) is not None:
            words.append(f"{100 * value:.2g} % of {name.replace('_', ' ')}")
    laws = [r for r in judged if any(r.laws)]
    if laws:
        units = "/".join(sorted({unit for r in laws for unit in r.input_units}))
        words.append(f"{max(r.error_estimates['mean_input'] for r in laws):.2g} {units} of a mean input")
    return f"{', '.join(words)} at most, by halving the step"


def _plot_axes() -> dict[str, Axis]:
    from dampyr.figures import style
    from dampyr.figures.style import Axis

    return {
        "displacement": style.DISPLACEMENT,
        "velocity": style.VELOCITY,
        "acceleration": style.ACCELERATION,
        "drift": Axis("drift", "mm", 1e3),
        "force": Axis("damper force", "N"),
        "stroke": Axis("stroke", "mm", 1e3),
        "input": Axis("input", "V or A"),
    }


@dataclass(frozen=True, eq=False, repr=False)
class Response(Representation):
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
    inputs: tuple[float | None, ...]  # (N,) V or A; None where a law sets it
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
    input_units: tuple[str, ...] = ()  # (N,) "V" or "A"
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

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is wrong or in doubt in the dampers and in the response, the worst first."""
        return worst_first(self.of_dampers, (Finding("doubt", words) for words in self.doubts))

    @property
    def plot(self) -> ResponsePlots:
        """Figures: ``response.plot.history("drift")``, ``.peaks()`` and ``.energy()``, each giving matplotlib axes."""
        return ResponsePlots(self)

    def to_dataframe(self) -> Any:
        """The peaks as a ``pandas.DataFrame``, one row a floor and the storey below it."""
        table = {
            "peak_displacement_m": self.peak_displacement,
            "peak_drift_m": self.peak_drift,
            "peak_acceleration_m_per_s2": self.peak_acceleration,
        }
        return data_frame(table, self.floors, "floor")

    def _small_figure(self) -> Figure:
        from dampyr.figures.building import building_response

        return building_response(self.time, {f"floor {self.floors[-1]}": self.displacement[-1]})

    def _table(self) -> Table:
        rows = [
            [str(name), float(1e3 * x), float(1e3 * d), float(a)]
            for name, x, d, a in zip(self.floors, self.peak_displacement, self.peak_drift, self.peak_acceleration)
        ]
        return ("floor", "peak displacement [mm]", "peak drift of its storey [mm]", "peak acceleration [m/s²]"), rows

    def _summary(self) -> Summary:
        def peaks(values: Array, factor: float, unit: str) -> str:
            return listing([f"{factor * v:.4g}" for v in values], 6) + f" {unit}"

        rows = [
            ("time", f"{len(self.time)} samples, {self.time[-1]:.4g} s; {self.scheme}, step {1e3 * self.step:.4g} ms")
        ]
        rows.append(("end", end_in_words(self.after)))
        dampers = list(zip(self.sites, self.inputs, self.laws, self.input_units))
        rows += [("damper", f"{site}, {law or f'{value:g} {unit}'}") for site, value, law, unit in dampers[:FEW]]
        if len(dampers) > FEW:
            rows.append(("", f"and {len(dampers) - FEW} more dampers"))
        rows += [
            ("displacement", "peak " + peaks(self.peak_displacement, 1e3, "mm")),
            ("drift", "peak " + peaks(self.peak_drift, 1e3, "mm")),
            ("acceleration", "peak " + peaks(self.peak_acceleration, 1.0, "m/s²")),
        ]
        if len(self.sites):
            rows.append(("damper force", "peak " + peaks(self.peak_force, 1.0, "N")))
        if self.error_estimate is not None:
            rows.append(("error", self.error_in_words))
        if self.truncation is not None:
            rows.append(("reduced", self.truncation.in_words()))
        return f"Response {self.title!r}" if self.title else "Response", rows

    @property
    def error_in_words(self) -> str:
        """What the peaks and the mean input changed by when the step was halved; empty where it was given."""
        return errors_in_words([self])

    def to_xarray(self) -> Any:
        """The histories and peaks as an ``xarray.Dataset`` with dims time, floor, storey and damper;
        units in ``attrs``."""
        import xarray

        data = {k: (dims.split(), np.asarray(getattr(self, k)), {"units": unit}) for k, (dims, unit) in _UNITS.items()}
        units = set(self.input_units)
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
            "damper_input_unit": ("damper", np.array(self.input_units, dtype=str)),
        }
        return xarray.Dataset(data, coords=coordinates, attrs=self._attributes())

    def as_dict(self) -> dict[str, Any]:
        """The peaks and how they were computed, ready for JSON, as ``dampyr simulate --json`` writes them."""
        return {
            "peak_displacement_m": self.peak_displacement.tolist(),
            "peak_drift_m": self.peak_drift.tolist(),
            "peak_acceleration_m_s2": self.peak_acceleration.tolist(),
            "peak_base_shear_N": self.peak_base_shear,
            "peak_force_N": self.peak_force.tolist(),
            "damper_origin": self.origin.as_dict(),
            "findings": as_dicts(self.findings),
            "sites": list(self.sites),
            "laws": list(self.laws),
            "mean_input": self.mean_input.tolist(),
            "scheme": self.scheme,
            "step_s": self.step,
            "error_estimate": self.error_estimate,
            "error_estimates": dict(self.error_estimates),
            "converged": self.converged,
            "reason": self.reason,
            "after_s": self.after,
            **self.truncation_as_dict(),
        }

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
