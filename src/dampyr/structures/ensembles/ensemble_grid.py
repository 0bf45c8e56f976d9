"""The cases of an ensemble: the outer product of buildings, dampers, inputs, motions and scales, checked and counted.

A *line* is one building with one placement at one input under one motion; its cases differ in the scale. Lines are numbered
through, the motion fastest, and a shard is a range of lines, so that the cases themselves are never listed.
"""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.findings import OF_DAMPER, Finding, handed_on
from dampyr.ground_motions import GroundMotion, followed_by_rest
from dampyr.input_kinds import NO_INPUT
from dampyr.options import takes
from dampyr.structures.batch.assemble import QUANTITIES
from dampyr.structures.batch.engine import can_run
from dampyr.structures.batch.gpu import missing
from dampyr.structures.batch.law_step import MAX_DELAY
from dampyr.structures.building import Building, Condensed
from dampyr.structures.building_options import EnsembleOptions
from dampyr.structures.control_laws import is_control_law, parts, spelled
from dampyr.structures.controller import design_controller
from dampyr.structures.floor_loads import refuse_loads
from dampyr.structures.sites import (
    Site,
    any_has_input,
    drawn_placements,
    input_of,
    installed,
    laws_of,
    make_sites,
    placement,
    places_and_dampers,
)
from dampyr.structures.supports import refuse_supports
from dampyr.units import in_si

Array = NDArray[np.float64]
# Of the longest step that the rule allows: with 0.4 of it the error was below 0.1 % in 6,000 random cases.
STEPS = {"fast": 1.0, "strict": 0.4}
# The same where dampers stretch in series, whose step counts to first order: 0.1 of it was good to 0.05 %; and where the memory
# of a part in series follows its velocity, which costs ten times as much: 0.1 was good to 0.18 %, 0.05 to 0.09 %.
STEPS_IN_SERIES = {"fast": 1.0, "strict": 0.1}
STEPS_WITH_MEMORY = {"fast": 0.1, "strict": 0.05}
CASES_PER_SHARD = 8192  # large enough that starting a shard costs little beside it
SHARDS, MIN_CASES, MIN_CASES_ONE_BY_ONE = 32, 2048, 8  # shards to share out, where each has so many cases or more
AXES = ("building", "damper", "input", "motion", "scale")


@dataclass(frozen=True, eq=False)
class Cases:
    """Checked cases of an ensemble; ``kind`` says whether inputs are a "voltage" or a "current", or that there are "none"."""

    buildings: tuple[Building, ...]
    placements: tuple[Mapping[Any, Any], ...]
    inputs: tuple[Any, ...]  # each a number, a control law, or None without dampers or without an input
    motions: tuple[GroundMotion, ...]
    scales: Array
    kind: str = "voltage"
    accuracy: str = "fast"
    quantities: tuple[str, ...] = QUANTITIES
    precision: int = 64
    allow_extrapolation: bool = False
    device: str = "cpu"
    seeds: tuple[
        int, ...
    ] = ()  # what is added to the seeds of control laws' noise, of each placement; none for no such thing
    after: float = 0.0  # s of rest, which the motions have at their ends already

    @property
    def shape(self) -> tuple[int, int, int, int, int]:
        """How many of each, in the order of `AXES`."""
        return len(self.buildings), len(self.placements), len(self.inputs), len(self.motions), len(self.scales)

    @property
    def lines(self) -> int:
        """How many lines there are."""
        return int(np.prod(self.shape[:-1]))

    @property
    def size(self) -> int:
        """How many cases there are."""
        return self.lines * len(self.scales)

    @property
    def floors(self) -> int:
        """The most floors of a building."""
        return max(building.n_floors for building in self.buildings)

    @cached_property
    def sites(self) -> int:
        """The most dampers of a placement."""
        return max(len(places_and_dampers(placement)) for placement in self.placements)

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """What is wrong or in doubt in the dampers, each once."""
        dampers = (damper for placement in self.placements for _, damper in places_and_dampers(placement))
        return handed_on(dampers, OF_DAMPER)

    def width(self, quantity: str) -> int:
        """How many values of a quantity a case has."""
        return self.sites if quantity in ("force", "stroke", "energy") else self.floors

    def line(self, number: int) -> tuple[int, int, int, int]:
        """(building, damper, input, motion) of a line."""
        return tuple(int(k) for k in np.unravel_index(number, self.shape[:-1]))  # type: ignore[return-value]

    def shards(self) -> int:
        """Into how many pieces the work is cut by default: so many that cores end together, each worth its start."""
        if self.device == "gpu":
            return min(self.lines, -(-self.size // (8 * CASES_PER_SHARD)))
        under_laws = any(map(is_control_law, self.inputs))
        # draws of one damper run alike, so one of each composition is looked at
        placed = {
            tuple((place, damper.composition) for place, damper in places_and_dampers(placement)): d
            for d, placement in enumerate(self.placements)
        }
        slow = under_laws and not all(
            runs_in_blocks(self.sites_of(0, d, u)) for d in placed.values() for u in range(self.shape[2])
        )
        min_cases = MIN_CASES_ONE_BY_ONE if slow else MIN_CASES
        return min(self.lines, max(-(-self.size // CASES_PER_SHARD), min(SHARDS, self.size // min_cases)))

    def lines_of(self, shard: int, shards: int) -> range:
        """The lines of one of ``shards`` pieces."""
        if not 0 <= shard < shards:
            raise InputError(f"shard {shard} of {shards} does not exist; count from 0 to {shards - 1}")
        return range(self.lines * shard // shards, self.lines * (shard + 1) // shards)

    def sites_of(self, building: int, damper: int, at: int) -> tuple[Site, ...]:
        """The dampers of a placement at an input, checked."""
        given = self.inputs[at]
        if self.seeds and is_control_law(given):
            given = replace(given, seed=given.seed + self.seeds[damper])
        keyword = {self.kind: given} if self.placements[damper] else {}
        voltage, current = keyword.get("voltage"), keyword.get("current")
        return make_sites(self.buildings[building], self.placements[damper], voltage, current, self.allow_extrapolation)

    @property
    def other_version(self) -> str:
        """What else a file with another digest may be, in words: the formulas of control laws are in the digest."""
        under_laws = any(map(is_control_law, self.inputs))
        return (
            ", or one whose control laws another version computed (it can be read, not continued)" if under_laws else ""
        )

    @cached_property
    def digest(self) -> str:
        """A hash of all that decides the numbers."""
        parts = [
            [(b.M, b.C, b.K, b.influence, *_left_out(b), *_storeys(b)) for b in self.buildings],
            [_plain(p) for p in self.placements],
            tuple(spelled(u) if is_control_law(u) else u for u in self.inputs),
            [(m.acceleration, m.dt) for m in self.motions],
            self.scales,
            (self.kind, self.accuracy, self.quantities, self.precision, self.device),
            *([self.seeds] if any(self.seeds) and any(map(is_control_law, self.inputs)) else []),
        ]
        return hashlib.sha256(pickle.dumps(parts, protocol=5)).hexdigest()[:16]


def runs_in_blocks(sites: tuple[Site, ...]) -> bool:
    """Whether an engine can run these sites: under laws without a delay of the damper, and with short ones of the sensors."""
    if not can_run([site.composition for site in sites]):
        return False
    late = (sensor.delay for law in laws_of(sites) for _, sensor in law.sensors)
    return not laws_of(sites) or (not any(site.delay > 0 for site in sites) and max(late, default=0) <= MAX_DELAY)


def _left_out(building: Building) -> tuple[Any, ...]:
    """What decides the numbers of a reduced structure besides its own matrices."""
    whole = building.whole if isinstance(building, Condensed) and not building.exact else None
    return () if whole is None else (whole.M, whole.C, whole.K, whole.influence, whole.retained)


def _storeys(building: Building) -> tuple[int, ...]:
    """What each storey stands on, where floors do not stand one on the other."""
    return () if building.is_stack else building.floors_below


def _plain(placement: Mapping[Any, Any]) -> list[Any]:
    """A placement as texts and numbers, for the digest."""
    return [(where, damper.input, repr(damper.all_laws)) for where, damper in places_and_dampers(placement)]


@takes(EnsembleOptions)
def cases(
    buildings: Building | Sequence[Building],
    motions: GroundMotion | Sequence[GroundMotion],
    dampers: Any = None,
    voltage: Any = None,
    scales: ArrayLike = 1.0,
    options: EnsembleOptions | None = None,
    *,
    current: Any = None,
    **keywords: Any,
) -> Cases:
    """The cases of an ensemble, for `write_part`; the arguments are those of `dampyr.structures.ensemble`.

    Raises :class:`~dampyr.errors.InputError` for what is wrong with them.
    """
    refuse_loads("ensemble", keywords)
    chosen = EnsembleOptions.of("ensemble", options, keywords)
    refuse_supports("ensemble", *(buildings if isinstance(buildings, list | tuple) else [buildings]))
    kind, inputs = input_of(voltage, current)
    placements = [placement(entry) for entry in _list(dampers)]
    kind, inputs = _of_passive_dampers(placements, kind, inputs)
    if (draws := chosen.draws) is not None:
        drawn = (drawn_placements(placed, draws, chosen.seed) if placed else [placed] for placed in placements)
        placements = [placed for several in drawn for placed in several]
    seeds = _noise_seeds(placements, chosen)
    if chosen.seeds is not None:
        placements = [placed for placed in placements for _ in range(chosen.seeds if placed else 1)]
    grid = Cases(
        _several("buildings", buildings, Building),
        tuple(installed(placed, chosen) for placed in placements),
        (None,) if inputs is None else _inputs(kind, inputs),
        tuple(followed_by_rest(motion, chosen.after) for motion in _several("motions", motions, GroundMotion)),
        np.array(_numbers("scales", scales)),
        kind,
        chosen.accuracy,
        tuple(quantity for quantity in QUANTITIES if quantity in chosen.quantities),
        chosen.precision,
        chosen.allow_extrapolation,
        chosen.device,
        seeds,
        chosen.after,
    )
    _check(grid)
    return grid


def _noise_seeds(placements: Sequence[Mapping[Any, Any]], options: EnsembleOptions) -> tuple[int, ...]:
    """What is added to the seeds of laws, of each placement: each of several seeds, or of the draws of a damper, its own."""
    if options.seeds is not None:
        return tuple(k for placed in placements for k in range(options.seeds if placed else 1))
    if options.draws is not None:
        return tuple(k % options.draws for k in range(len(placements))) if len(placements) > 1 else ()
    return ()


def _of_passive_dampers(placements: Sequence[Mapping[Any, Any]], kind: str, inputs: Any) -> tuple[str, Any]:
    """The kind and the inputs: none where no damper has an input. Some placements with one and some without are refused."""
    with_input = {any_has_input(placed) for placed in placements if placed}
    if with_input != {False}:
        if len(with_input) == 2:
            raise InputError(
                "some of the dampers have an input and others none, and every damper is to run at every input; run the two "
                "kinds in ensembles of their own"
            )
        return kind, inputs
    given = inputs is not None and not (isinstance(inputs, list | tuple) and all(value is None for value in inputs))
    if given and any(map(is_control_law, inputs if isinstance(inputs, list | tuple) else [inputs])):
        raise InputError(f"a control law sets the input of a damper, and these have none; leave {kind}= out")
    if given:
        raise InputError(f"{kind}= is given, but the dampers have no input; leave it out")
    return NO_INPUT, None


def _check(grid: Cases) -> None:
    laws = [u for u in grid.inputs if is_control_law(u)]
    if grid.device == "gpu" and laws:
        raise InputError("device = 'gpu' runs constant inputs only; run control laws with device = 'cpu'")
    if grid.device == "gpu" and (why := missing()):
        raise InputError(f"device = 'gpu': {why}")
    for b in range(len(grid.buildings)):
        for d in range(len(grid.placements)):
            for u in range(
                len(grid.inputs) if b == 0 else 1
            ):  # an input's range is the damper's, whatever the building
                grid.sites_of(b, d, u)
    places = {place for placed in grid.placements for place, _ in places_and_dampers(placed)}
    for law in laws:  # it must have a design wherever a damper stands, and decide at the ends of steps of every motion
        for building in grid.buildings:
            for place in places:
                design_controller(law, building, building.connection(place)[None], 0)
        for dt in {motion.dt for motion in grid.motions}:
            parts((law,), dt)


def _list(dampers: Any) -> list[Any]:
    if isinstance(dampers, list | tuple):
        if not dampers:
            raise InputError("dampers is empty; give dampers or placements, or leave it out for the bare building")
        return list(dampers)
    return [dampers]


def _several(name: str, values: Any, kind: type) -> tuple[Any, ...]:
    listed = tuple(values) if isinstance(values, Iterable) and not isinstance(values, kind) else (values,)
    wrong = next((entry for entry in listed if not isinstance(entry, kind)), None)
    if wrong is not None or not listed:
        what = f"holds a {type(wrong).__name__}" if listed else "is empty"
        raise InputError(f"{name} {what}; give one {kind.__name__} or a list of them")
    return listed


def _inputs(name: str, values: Any) -> tuple[Any, ...]:
    """Numbers and control laws, one or a list, in their order."""
    listed, unit = (
        list(values) if isinstance(values, list | tuple) else [values],
        {"voltage": "V", "current": "A"}[name],
    )
    if not any(is_control_law(value) for value in listed):
        return _numbers(name, values, unit)
    return tuple(u for value in listed for u in ((value,) if is_control_law(value) else _numbers(name, value, unit)))


def _numbers(name: str, numbers: ArrayLike, unit: str = "dimensionless") -> tuple[float, ...]:
    values = np.atleast_1d(np.asarray(in_si(numbers, unit, name), dtype=float))
    if values.ndim != 1 or not values.size or not np.all(np.isfinite(values)):
        raise InputError(f"{name} = {numbers!r} must be finite numbers, one or a list")
    return tuple(float(v) for v in values)
