"""What a damper shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.input_kinds import INPUTS, input_arguments, input_text
from dampyr.models.damper import RANGES, Damper
from dampyr.models.prediction_error import session_words
from dampyr.phrases import extent, listing
from dampyr.show.descriptions import Description, describe
from dampyr.show.figures import style
from dampyr.show.figures.laws import LawPanel, parameters_against_input
from dampyr.show.figures.loops import loops
from dampyr.show.plots import Plots, plots
from dampyr.show.table import Table
from dampyr.units import for_people

Array = NDArray[np.float64]
SHOWN = 6  # parameters that a short text lists one by one
COLUMNS = 5  # inputs of a table where no law has knots
CURVE = 200  # inputs of a law's curve in a figure
SINE = (0.010, 1.0)  # m, Hz: the motion of a loop where no calibrated range says another one
PER_CYCLE = 720  # samples of a loop: every half degree
SETTLE = 3  # cycles before the one that is drawn, so that the unknown past is forgotten


@describe.register
def describe_damper(damper: Damper) -> Description:
    """The calibrated ranges, the extents of the parameters and what is stated of their errors; its loops on a sine."""
    quantities = damper.composition.quantities
    rows = [] if damper.has_input else [("input", "none")]
    if damper.needs_input:
        rows = [(INPUTS[damper.input], f"calibrated at {extent(damper.range, damper.input)}")]
    elif damper.has_input:
        rows = [("input", "none: holds at every input")]
    for name, law in list(damper.all_laws.items())[:SHOWN]:
        unit, factor = for_people(quantities[name].unit)
        rows.append((name, extent(law.extremes(), unit, factor) + ("" if law.kind == "constant" else f", {law.kind}")))
    if len(damper.laws) > SHOWN:
        rows.append(("", f"and {len(damper.laws) - SHOWN} more parameters"))
    spans = [extent(span, *for_people(RANGES[name])) for name, span in damper.ranges.items() if name in RANGES]
    if spans:
        rows.append(("motion", "calibrated at " + listing(spans)))
    without = damper.covariance is None
    rows.append(("errors", "not known" if without else f"covariance of {len(damper.coefficients)} coefficients"))
    if damper.prediction_error is not None:
        rows.append(("sessions", session_words(damper.prediction_error)))
    if damper.composition.not_for_buildings:
        rows.append(("buildings", damper.composition.not_for_buildings))
    if "records" in damper.provenance:
        rows.append(("fitted to", listing(str(damper.provenance["records"]).split(", "), 3)))
    return Description(
        f"Damper {str(damper.composition)!r}",
        rows,
        tables=[lambda: _parameters(damper)],
        figure=lambda: loops(*DamperPlots(damper).steady_cycle()),
    )


def _parameters(damper: Damper) -> Table:
    """One row a parameter, one column an input: the knots of the laws, or inputs over the calibrated range."""
    knots = sorted({u for law in damper.all_laws.values() for u in getattr(law, "knots", ())})
    low, high = damper.range
    inputs = np.array([u for u in knots if low <= u <= high] or np.unique(np.linspace(low, high, COLUMNS)))
    units = [for_people(damper.composition.quantities[name].unit) for name in damper.laws]
    values = damper.at_mean_temperature.values(inputs).T * np.array([factor for _, factor in units])[:, None]
    return Table(
        ("parameter", "unit", *(input_text(u, damper.input) or "value" for u in inputs)),
        [[name, unit or "1", *row.tolist()] for name, (unit, _), row in zip(damper.laws, units, values, strict=True)],
    )


@dataclass(frozen=True)
class DamperPlots(Plots):
    """``damper.plot.loops()``, with its defaults what ``damper.plot()`` draws, and ``damper.plot.laws()``."""

    result: Damper

    def loops(
        self, inputs: Sequence[float] | None = None, amplitude: float | None = None, frequency: float | None = None
    ) -> Any:
        """Force over displacement and over velocity on a sine, for each of ``inputs`` in V or A, as the damper takes them.

        ``inputs`` are by default both ends of the calibrated range and its middle; ``amplitude`` [m] and ``frequency`` [Hz]
        reach the calibrated displacement and velocity, or are 10 mm and 1 Hz where the damper has no such range. The fourth
        cycle is drawn.
        """
        return style.in_pyplot(loops, *self.steady_cycle(inputs, amplitude, frequency), origin=self.result.origin)

    def laws(self) -> Any:
        """Each parameter over the input, with the calibrated range."""
        damper, (low, high) = self.result, self.result.range
        inputs = np.linspace(low, high, CURVE)
        panels = []
        for name, law in damper.at_mean_temperature.all_laws.items():
            unit, factor = for_people(damper.composition.quantities[name].unit)
            values = np.asarray(law(inputs), dtype=float)
            curve, point = ((inputs, values), None) if low < high else (None, (inputs[:1], values[:1]))
            panels.append(LawPanel(style.Axis(name, unit or "1", factor), curve=curve, points=point))
        axis = style.input_axis(damper.input)
        span = (low, high) if low < high else None
        return style.in_pyplot(parameters_against_input, panels, span, axis, origin=damper.origin)

    def steady_cycle(
        self, inputs: Sequence[float] | None = None, amplitude: float | None = None, frequency: float | None = None
    ) -> tuple[Array, Array, None, dict[str, Array]]:
        """Displacement m, velocity m/s, None for what was measured, and the force N of each input: what `loops` draws."""
        damper, (low, high) = self.result.at_mean_temperature, self.result.range
        levels = (
            sorted({low, 0.5 * (low + high), high}) if inputs is None else [float(u) for u in np.atleast_1d(inputs)]
        )
        stroke = damper.ranges.get("displacement", (0.0, SINE[0]))[1] if amplitude is None else amplitude
        if frequency is None:
            frequency = damper.ranges["velocity"][1] / (2 * np.pi * stroke) if "velocity" in damper.ranges else SINE[1]
        for name, value, unit in (("amplitude", stroke, "m"), ("frequency", frequency, "Hz")):
            if not (np.isfinite(value) and value > 0.0):
                raise InputError(f"{name} = {value:g} {unit} is not allowed; it must be greater than 0")
        phase = 2 * np.pi * np.arange((SETTLE + 1) * PER_CYCLE + 1) / PER_CYCLE
        t, x = phase / (2 * np.pi * frequency), stroke * np.sin(phase)
        v = 2 * np.pi * frequency * stroke * np.cos(phase)
        last = slice(SETTLE * PER_CYCLE, None)
        forces = {}
        for u in levels:
            name = input_text(u, damper.input) or "damper"
            forces[name] = damper.force(t, x, **input_arguments(damper.input, u), velocity=v)[last]
        return x[last], v[last], None, forces


plots.register(Damper, DamperPlots)
