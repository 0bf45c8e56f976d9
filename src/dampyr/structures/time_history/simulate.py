"""Simulation as one job: a building, a ground motion and a damper in, the responses at each of its inputs out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from dampyr import units
from dampyr.argument_kinds import BUILDING, MOTION, Argument, check_kinds
from dampyr.errors import InputError
from dampyr.findings import Finding, worst_first
from dampyr.ground_motions import GroundMotion
from dampyr.models import Damper
from dampyr.origin import Origin, combined
from dampyr.shown import Shown
from dampyr.structures.building import Building
from dampyr.structures.control_laws import control_law
from dampyr.structures.ensembles.ensemble import ensemble
from dampyr.structures.time_history.respond import respond
from dampyr.structures.time_history.response import Response
from dampyr.structures.time_history.step_size import ACCURACIES

BARE = "no damper"
MIN_DRAWS = 20  # the 5 % and 95 % quantiles of fewer are their extremes
INTERVAL = (0.05, 0.95)
INTERVAL_OF = {  # a quantity of `ensemble` -> its name in JSON
    "displacement": "peak_displacement_m", "drift": "peak_drift_m", "acceleration": "peak_acceleration_m_s2",
    "force": "peak_force_N", "energy": "energy_J",
}  # fmt: skip


@dataclass(frozen=True)
class SimulateOptions:
    """Options of `simulate`: one case per number in ``inputs`` and per control law in ``laws``.

    ``inputs`` are V or A, as the damper takes them; a law is written as in ``on_off`` or ``on_off:period=0.01,lag=5ms``
    (see `law_of`). The damper stands in storey ``place``, or between two floors (i, j), without the parts in ``without``,
    on a brace of stiffness ``brace`` in N/m where one is given. ``bare``: the building alone. After the record come ``after`` s
    of rest. With ``draws`` dampers of the card's covariance, levels of sessions and records included where the card has them,
    drawn by ``seed``, every case has 90 % intervals of its peaks. Raises
    :class:`~dampyr.errors.InputError` for a value that is not allowed.
    """

    inputs: tuple[float, ...] = ()
    laws: tuple[str, ...] = ()
    place: Any = 1
    brace: float | None = None
    without: tuple[str, ...] = ()
    accuracy: str = "strict"
    allow_extrapolation: bool = False
    after: float = 0.0
    bare: bool = False
    draws: int = 0
    seed: int = 1

    def __post_init__(self) -> None:
        if not self.bare:
            check_inputs(self.inputs, self.laws)
        elif self.inputs or self.laws:
            raise InputError("bare is the building alone, and takes no input and no control law; leave one of them out")
        if self.draws and not self.draws >= MIN_DRAWS:
            raise InputError(
                f"draws = {self.draws} is not allowed; give {MIN_DRAWS} or more for an interval, or 0 for none"
            )
        if self.draws and self.bare:
            raise InputError("draws are of a damper, and bare is the building alone; leave one of them out")
        if self.accuracy not in ACCURACIES:
            raise InputError(f"accuracy = {self.accuracy!r} is not allowed; choose {', '.join(ACCURACIES)}")


@dataclass(frozen=True, repr=False)
class Simulated(Shown):
    """Result of `simulate`: the cases by name, that without damper first; ``unit`` of the damper's input."""

    building: str
    motion: str
    unit: str
    cases: Mapping[str, Response]
    intervals: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """90 % intervals (2, floors) or (2, sites) of the peaks of each case with a damper, by the names of `as_dict`, SI units."""
    draws: int = 0

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


def simulate(
    building: Building,
    motion: GroundMotion,
    damper: Damper | None,
    options: SimulateOptions,
    progress: Callable[[str, float], None] | None = None,
) -> Simulated:
    """The response of a building to a ground motion without a damper, then with it at each input and under each law.

    ``damper`` is None where ``options.bare`` is set, and a damper else.
    ``progress`` is called with a stage and the fraction that is done.
    """
    check_kinds(
        "simulate",
        Argument("building", building, (Building,), BUILDING),
        Argument("motion", motion, (GroundMotion,), MOTION),
    )
    tell = progress or (lambda stage, done: None)
    if (damper is None) is not options.bare:
        raise InputError("a damper is given with bare = True, or none without it; give one of the two")
    if damper is None:
        tell("without damper", 0.0)
        cases = {BARE: respond(building, motion, accuracy=options.accuracy, after=options.after)}
        return Simulated(building.name, motion.name, "", cases)
    fitted = installed(damper, options.without, options.brace)
    inputs = all_inputs(fitted, options.inputs, options.laws)
    kind = "voltage" if fitted.input == "V" else "current"
    tell("without damper", 0.0)
    cases = {BARE: respond(building, motion, accuracy=options.accuracy, after=options.after)}
    for k, u in enumerate(inputs, start=1):
        tell(f"case {k + 1} of {len(inputs) + 1}", k / (len(inputs) + 1))
        given: dict[str, Any] = {kind: u, "allow_extrapolation": options.allow_extrapolation, "after": options.after}
        response = respond(building, motion, {options.place: fitted}, accuracy=options.accuracy, **given)
        cases[response.laws[0] or f"{u:g} {fitted.input}"] = response
    intervals = {}
    if options.draws:
        tell(f"{options.draws} drawn dampers", len(inputs) / (len(inputs) + 1))
        names = [name for name in cases if name != BARE]
        intervals = dict(zip(names, peak_intervals(building, motion, damper, options, inputs), strict=True))
    return Simulated(building.name, motion.name, fitted.input, cases, intervals, options.draws)


def peak_intervals(
    building: Building, motion: GroundMotion, damper: Damper, options: SimulateOptions, inputs: list[Any]
) -> list[dict[str, Any]]:
    """The 90 % intervals of the peaks at each input, of drawn dampers: a dictionary of (2, ...) arrays for each."""
    drawn = damper.draws(options.draws, options.seed)
    placements = [{options.place: installed(one, options.without, options.brace)} for one in drawn]
    peaks = ensemble(
        building,
        motion,
        placements,
        inputs if damper.input == "V" else None,
        currents=inputs if damper.input == "A" else None,
        accuracy="strict" if options.accuracy == "strict" else "fast",
        quantities=tuple(INTERVAL_OF),
        allow_extrapolation=options.allow_extrapolation,
        after=options.after,
    )
    made = []
    for k in range(len(inputs)):
        each = peaks.isel(building=0, input=k, motion=0, scale=0)
        made.append({name: np.quantile(each[key].values, INTERVAL, axis=0) for key, name in INTERVAL_OF.items()})
    return made


def installed(damper: Damper, without: tuple[str, ...] = (), brace: float | None = None) -> Damper:
    """The damper less some of its parts, on a brace where its stiffness in N/m is given."""
    rest = damper.without(*without)
    return rest if brace is None else rest.on_brace(brace)


def all_inputs(damper: Damper, inputs: tuple[float, ...], laws: tuple[str, ...]) -> list[Any]:
    """The constant inputs, then the control laws."""
    return [*inputs, *(law_of(text, damper) for text in laws)]


def check_inputs(inputs: tuple[float, ...], laws: tuple[str, ...]) -> None:
    """Refuse a request that has neither an input nor a law."""
    if not inputs and not laws:
        raise InputError("no input and no control law is given; give one or more")


def law_of(text: str, damper: Damper) -> Any:
    """The control law written as ``on_off:lag=10ms,high=3``, over the damper's calibrated range unless it gives low and high.

    Several weights are parted by slashes, ``lyapunov:weights=1/2/3/4``.
    """
    name, _, rest = text.partition(":")
    low, high = damper.range
    settings: dict[str, Any] = {"low": low, "high": high}
    for part in rest.split(",") if rest else []:
        key, equals, value = (word.strip() for word in part.partition("="))
        if not equals:
            raise InputError(
                f"control law {text!r}: {part!r} is not a setting; write it as in on_off:period=0.01,lag=0.005"
            )
        settings[key] = value.split("/") if key == "weights" else _number(key, value)
    return control_law(name, **settings)


def _number(key: str, value: str) -> Any:
    """A number in SI units, or for a time one with its unit, ``5ms``; what is neither is left to the law to refuse."""
    try:
        return float(value)
    except ValueError:
        return units.parse(value, "s") if key in ("period", "lag") else value
