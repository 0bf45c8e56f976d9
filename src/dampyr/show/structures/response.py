"""What the response of a building shows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.findings import as_dicts
from dampyr.ground_motions.cutting import end_in_words
from dampyr.input_kinds import NO_INPUT
from dampyr.phrases import extent, listing
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.building import building_response
from dampyr.show.figures.energy import energy_over_time
from dampyr.show.figures.peaks import peaks_by_floor
from dampyr.show.plots import Plots, plots
from dampyr.show.structures.floor_loads import loads_in_words
from dampyr.show.table import Cell, Table
from dampyr.structures.time_history.response import Energy, Response

Array = NDArray[np.float64]
FEW = 4  # dampers that a short text lists one by one
AXES = {
    "displacement": style.DISPLACEMENT,
    "velocity": style.VELOCITY,
    "acceleration": style.ACCELERATION,
    "drift": style.Axis("drift", "mm", 1e3),
    "force": style.Axis("damper force", "N"),
    "stroke": style.Axis("stroke", "mm", 1e3),
    "input": style.Axis("input", "V or A"),
}
PEAK_AXES = [AXES["displacement"], AXES["drift"], AXES["acceleration"]]


@describe.register
def describe_energy(energy: Energy) -> Description:
    """What came in and was taken by the end, the peaks of strain and kinetic energy, and the residual."""
    shares = [("input", energy.input), ("dampers", energy.damper), ("viscous", energy.viscous)]
    return Description(
        "Energy",
        [
            ("samples", str(len(energy.input))),
            *((name, f"{float(values[-1]):.4g} J at the end") for name, values in shares),
            ("strain", "peak " + extent(np.max(energy.strain), "J")),
            ("kinetic", "peak " + extent(np.max(energy.kinetic), "J")),
            ("residual", extent(energy.residual, "J")),
        ],
    )


@describe.register
def describe_response(response: Response) -> Description:
    """Time, dampers and peaks, the peaks of each floor, and the displacement of the highest."""
    r = response
    rows = [
        ("time", f"{len(r.time)} samples, {r.time[-1]:.4g} s; {r.scheme}, step {1e3 * r.step:.4g} ms"),
        ("end", end_in_words(r.after)),
    ]
    dampers = list(zip(r.sites, r.inputs, r.laws, r.input_units))
    for site, value, law, unit in dampers[:FEW]:
        rows.append(("damper", site if unit == NO_INPUT else f"{site}, {law or f'{value:g} {unit}'}"))
    if len(dampers) > FEW:
        rows.append(("", f"and {len(dampers) - FEW} more dampers"))
    rows += [
        ("displacement", _peaks(r.peak_displacement, 1e3, "mm")),
        ("drift", _peaks(r.peak_drift, 1e3, "mm")),
        ("acceleration", _peaks(r.peak_acceleration, 1.0, "m/s²")),
    ]
    if r.loads is not None:
        rows.append(("loads", loads_in_words(r.loads)))
    if r.supports:
        rows.append(("supports", supports_in_words(r)))
    if len(r.sites):
        rows.append(("damper force", _peaks(r.peak_force, 1.0, "N")))
    if r.error_estimate is not None:
        rows.append(("error", errors_in_words([r])))
    if r.truncation is not None:
        rows.append(("reduced", r.truncation.in_words()))
    return Description(
        f"Response {r.title!r}" if r.title else "Response",
        rows,
        tables=[lambda: _table(response)],
        figure=lambda: building_response(r.time, {f"floor {r.floors[-1]}": r.displacement[-1]}),
        data=lambda: _numbers(response),
        frame=lambda: _columns(response),
    )


def supports_in_words(response: Response) -> str:
    """The supports of a structure that has several, and how hard they move."""
    peaks = np.max(np.abs(response.support_acceleration), axis=1)
    return ", ".join(f"{name} peak {peak:.4g} m/s²" for name, peak in zip(response.supports, peaks, strict=True))


def _peaks(values: Array, factor: float, unit: str) -> str:
    return f"peak {listing([f'{factor * v:.4g}' for v in values], 6)} {unit}"


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
        units = "/".join(sorted({unit for r in laws for unit in r.input_units if unit != NO_INPUT}))
        words.append(f"{max(r.error_estimates['mean_input'] for r in laws):.2g} {units} of a mean input")
    return f"{', '.join(words)} at most, by halving the step"


def _table(response: Response) -> Table:
    return Table(
        ("floor", "peak displacement", "peak drift of its storey", "peak acceleration"),
        floor_rows(response),
        ("", "mm", "mm", "m/s²"),
        caption="Peaks of each floor.",
    )


def floor_rows(response: Response) -> list[list[Cell]]:
    """The name of each floor, its peak displacement in mm, the drift of the storey below it, and its peak acceleration."""
    r = response
    return [
        [str(name), float(1e3 * x), float(1e3 * d), float(a)]
        for name, x, d, a in zip(r.floors, r.peak_displacement, r.peak_drift, r.peak_acceleration)
    ]


def _numbers(response: Response) -> dict[str, Any]:
    """The peaks and how they were computed, ready for JSON, as ``dampyr simulate --json`` writes them."""
    r = response
    return {
        "peak_displacement_m": r.peak_displacement.tolist(),
        "peak_drift_m": r.peak_drift.tolist(),
        "peak_acceleration_m_s2": r.peak_acceleration.tolist(),
        "peak_base_shear_N": r.peak_base_shear,
        "peak_force_N": r.peak_force.tolist(),
        "damper_origin": r.origin.as_dict(),
        "findings": as_dicts(r.findings),
        "sites": list(r.sites),
        **({"laws": list(r.laws), "mean_input": r.mean_input.tolist()} if r.has_input or not r.sites else {}),
        "scheme": r.scheme,
        "step_s": r.step,
        "error_estimate": r.error_estimate,
        "error_estimates": dict(r.error_estimates),
        "converged": r.converged,
        "reason": r.reason,
        "after_s": r.after,
        **r.truncation_as_dict(),
        **r.loads_as_dict(),
    }


def _columns(response: Response) -> DataFrameColumns:
    """The peaks, one row a floor and the storey below it."""
    columns = {
        "peak_displacement_m": response.peak_displacement,
        "peak_drift_m": response.peak_drift,
        "peak_acceleration_m_per_s2": response.peak_acceleration,
    }
    return DataFrameColumns(columns, response.floors, "floor")


@dataclass(frozen=True)
class ResponsePlots(Plots):
    """``response.plot.history("drift")``, ``.peaks()`` and ``.energy()``."""

    result: Response

    def history(self, quantity: str = "displacement") -> Any:
        """A quantity of every floor, storey or damper over time.

        ``displacement``, ``velocity``, ``acceleration``, ``drift``, ``force``, ``stroke`` or ``input``.
        """
        r = self.result
        if quantity not in AXES or not len(getattr(r, quantity)) or (quantity == "input" and not r.has_input):
            histories = [name for name in AXES if len(getattr(r, name)) and (name != "input" or r.has_input)]
            raise InputError(f"this response has no history of {quantity!r}; choose from {', '.join(histories)}")
        if quantity in ("force", "stroke", "input"):
            names = list(r.sites)
        elif quantity == "drift":
            names = [f"storey {k}" for k in range(1, len(r.floors) + 1)]
        else:
            names = [f"floor {name}" for name in r.floors]
        cases = dict(zip(names, getattr(r, quantity), strict=True))
        return style.in_pyplot(building_response, r.time, cases, axis=AXES[quantity], origin=r.origin)

    def peaks(self) -> Any:
        """Peak displacement, drift and acceleration by floor."""
        r = self.result
        cases = {r.title or "response": (r.peak_displacement, r.peak_drift, r.peak_acceleration)}
        return style.in_pyplot(peaks_by_floor, list(r.floors), cases, axes=PEAK_AXES, origin=r.origin)

    def energy(self) -> Any:
        """Energies over time: kinetic, strain, viscous and dampers, stacked, and what the ground put in."""
        e = self.result.energy
        shares = {"viscous": e.viscous, "strain": e.strain, "kinetic": e.kinetic}
        if len(e.dampers):
            shares = {"dampers": e.damper} | shares
        return style.in_pyplot(energy_over_time, self.result.time, shares, e.input, origin=self.result.origin)


plots.register(Response, ResponsePlots)
