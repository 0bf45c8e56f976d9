r"""Shards of an ensemble: the cases of each sorted into blocks that an engine runs together.

The step is that of the rule (`dampyr.structures.time_history.step_size`) with :math:`\omega_s h \le 1`; 0.4 of it where the
accuracy is "strict", and less where dampers stretch in series (`dampyr.structures.ensembles.ensemble_grid`). The error is
measured: of every kind of case in a shard one block is run again with half the step, of the cases that are hardest and of
others at random. Hardest are those whose floors or storeys move least beside their others, as a stuck damper lets them, and
the weakest motions on the stiffest dampers.

Every block of a precision is equally wide (64 or 128 histories), filled or not, and a history does not depend on its
neighbours: the numbers are the same however the work is divided.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, replace
from functools import partial
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.structures.batch import bouc_wen_branchless
from dampyr.structures.batch.assemble import SITES_WRITTEN_OUT
from dampyr.structures.batch.engine import Engine, control_of, engine
from dampyr.structures.batch.gpu import engine as gpu_engine
from dampyr.structures.batch.lane_inverse import sizes_of
from dampyr.structures.batch.law_step import pieces_of, values_of
from dampyr.structures.building import Building, Condensed
from dampyr.structures.ensembles.ensemble_accuracy import BOUNDS
from dampyr.structures.ensembles.ensemble_grid import STEPS, STEPS_IN_SERIES, STEPS_WITH_MEMORY, Cases, runs_in_blocks
from dampyr.structures.sites import Site, calibrated_displacements, connections, laws_of
from dampyr.structures.time_history.kernel_run import runner
from dampyr.structures.time_history.modal_coordinates import refinements
from dampyr.structures.time_history.response import Integration, relative_change
from dampyr.structures.time_history.step_size import (
    ACCURACIES,
    difference_slopes,
    halve_under_laws,
    largest_step,
    largest_stiffness,
    steps_per_sample,
)

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
STEP_UNDER_LAWS = {"fast": 2.5e-3, "strict": 1.25e-3}  # s, at most: what a decision changes lies between two nodes
LIMIT = 1.0  # of omega h: fast stays below 0.1 % of the peak in the standard suite with it
JUDGED = ("displacement", "drift")
BIASED = ("drift", "acceleration", "force")  # whose mean change with the step is told under control laws
LEFT_OUT = {"displacement": "truncation", "drift": "truncation", "acceleration": "truncation_acceleration",
            "force": "truncation_force"}  # fmt: skip
# Peaks above both of these are held to a bound: smaller ones are of no consequence, and of a floor that a stuck damper locks
# the relative error has none that a fixed step could hold.
MOVING, MOVING_SHARE = 1e-4, 0.01  # m; of the largest of the case
SEED = 15  # of the choice of the cases that are judged; any
AT_LIMIT = 1.01  # times the calibrated displacement: what rounding and peaks between samples add is none
JUDGED_ONE_BY_ONE = 4  # at most, of the cases of a kind that no engine can run: each costs two more


@dataclass
class Shard:
    """Result of shard ``number``: ``values`` quantity -> (lines, scales, width), NaN where a building has no such storey.

    ``error`` is the largest relative change of a peak on halving the step, among ``judged`` cases, twice that where the step
    counts to first order; ``moving`` the same of peaks above 0.1 mm and 1 % of the largest of the case; ``unbounded`` counts
    cases that grew without bound; ``general`` counts those that no engine can run, ``unconverged`` those under control laws
    whose step could not be made short enough. ``truncation`` is the largest relative change of a peak displacement or drift
    of reduced structures beside half as many coordinates, among the judged cases, -1 where there is none;
    ``truncation_acceleration`` and ``truncation_force`` are those of accelerations and forces. ``calibrated`` counts the
    cases of which a damper's card states the displacement that it was calibrated on, ``beyond`` those of them that leave it,
    by up to ``beyond_times``. Under control laws ``judged_under_laws`` cases were judged; in ``flipped`` of them half the
    step changes a peak by more than the bound, and ``bias_drift``, ``bias_acceleration`` and ``bias_force`` sum up the
    relative changes, ``square_drift`` ... their squares.
    """

    number: int
    lines: range
    values: dict[str, Array]
    error: float = 0.0
    judged: int = 0
    unbounded: int = 0
    general: int = 0
    moving: float = 0.0
    unconverged: int = 0
    truncation: float = -1.0
    truncation_acceleration: float = -1.0
    truncation_force: float = -1.0
    calibrated: int = 0
    beyond: int = 0
    beyond_times: float = 0.0
    judged_under_laws: int = 0
    flipped: int = 0
    bias_drift: float = 0.0
    bias_acceleration: float = 0.0
    bias_force: float = 0.0
    square_drift: float = 0.0
    square_acceleration: float = 0.0
    square_force: float = 0.0


def run_shard(number: int, shards: int, cases: Cases) -> Shard:
    """Shard ``number`` of ``shards``: a pure function of its arguments, for any process on any machine."""
    lines = cases.lines_of(number, shards)
    empty = {q: np.full((len(lines), len(cases.scales), cases.width(q)), np.nan) for q in cases.quantities}
    shard = Shard(number, lines, empty)
    for kind, members in _kinds(cases, lines).items():
        if kind[-1] is None:
            _one_by_one(cases, members, shard)
        else:
            _in_blocks(cases, kind, members, shard)
    if "stroke" in shard.values:
        _count_beyond(cases, shard)
    return shard


def _count_beyond(cases: Cases, shard: Shard) -> None:
    """Count the cases in which a stroke leaves the displacement that its damper was calibrated on."""
    _, placements, _, _ = np.unravel_index(np.array(shard.lines, dtype=np.int64), cases.shape[:-1])
    for k, placed in enumerate(cases.placements):
        limits = np.array(calibrated_displacements(placed))
        if np.any(np.isfinite(limits)):
            strokes = shard.values["stroke"][placements == k, :, : len(limits)]
            times = np.max(np.nan_to_num(strokes, nan=np.inf) / limits, axis=-1)
            shard.calibrated += times.size
            shard.beyond += int(np.sum(times > AT_LIMIT))
            shard.beyond_times = max(shard.beyond_times, float(np.max(times, initial=0.0, where=np.isfinite(times))))


@dataclass(frozen=True, eq=False)
class Member:
    """A line of a shard: where its values go, its sites and its motion."""

    row: int
    building: int
    sites: tuple[Site, ...]
    motion: int
    m: int
    stiffness: float  # 1/s2, the largest of the dampers at rest over the mass that each moves


def _kinds(cases: Cases, lines: range) -> dict[tuple[Any, ...], list[Member]]:
    """The lines by what one engine can run; the last of a key is None where no engine can."""
    groups: dict[tuple[Any, ...], list[Member]] = {}
    cached: dict[tuple[int, int, int], tuple[tuple[Site, ...], tuple[Any, ...], float, float]] = {}
    slopes_of: dict[tuple[Any, ...], Array] = {}  # which the seed of a law's noise does not change
    for row, number in enumerate(lines):
        b, d, u, k = cases.line(number)
        if (b, d, u) not in cached:
            sites = tuple(map(_without_zero_delay, cases.sites_of(b, d, u)))
            laws = tuple(
                (replace(site.law, seed=0), pieces_of(site.damper), sizes_of(site.law, site.damper))
                if site.law
                else None
                for site in sites
            )
            same = (*(id(site.damper) for site in sites), u, laws)
            if same not in slopes_of:
                slopes_of[same] = difference_slopes(sites)
            slopes = slopes_of[same]
            building = refinements(cases.buildings[b], connections(cases.buildings[b], sites))[0]
            step = largest_step(building, sites, slopes, LIMIT)
            if not laws_of(sites):
                step *= _share(cases.accuracy, sites)
            elif runs_in_blocks(sites):  # one by one the step is halved
                step = min(step * _share(cases.accuracy, sites), STEP_UNDER_LAWS[cases.accuracy])
            cached[b, d, u] = sites, laws, step, largest_stiffness(building, sites, slopes)
        sites, laws, step, stiffness = cached[b, d, u]
        dt = cases.motions[k].dt
        m = steps_per_sample(dt, step, sites)
        compositions = tuple(site.composition for site in sites)
        rows = tuple(map(tuple, connections(cases.buildings[b], sites).tolist()))
        branchless = cases.device == "cpu" and bouc_wen_branchless.is_vectorisable(
            (site.composition, site.values) for site in sites
        )
        key = (b, rows, compositions, dt, branchless, laws, m if runs_in_blocks(sites) else None)
        groups.setdefault(key, []).append(Member(row, b, sites, k, m, stiffness))
    return groups


def _share(accuracy: str, sites: tuple[Site, ...]) -> float:
    """The step as a share of the rule's."""
    series = [site.composition for site in sites if site.composition.in_series]
    if any(part.follows_velocity for composition in series for part in composition.parts):
        return STEPS_WITH_MEMORY[accuracy]
    return STEPS_IN_SERIES[accuracy] if series else STEPS[accuracy]


def _without_zero_delay(site: Site) -> Site:
    """The site without a delay of 0 s, which a ring of past forces cannot represent."""
    k = site.composition.delay
    if k is None or site.delay > 0:
        return site
    return replace(site, damper=site.damper.without("delay"), values=np.delete(site.values, k))


def _in_blocks(cases: Cases, kind: tuple[Any, ...], members: list[Member], shard: Shard) -> None:
    m, scales = kind[-1], len(cases.scales)
    block_engine = _engine_of(cases, kind, members[0].sites, m)
    inputs = Inputs.of(cases, sorted(members, key=lambda member: cases.motions[member.motion].n))
    for first in range(0, len(members) * scales, block_engine.max_histories):
        who, scale = np.divmod(np.arange(first, min(first + block_engine.max_histories, len(members) * scales)), scales)
        peaks = inputs.run(block_engine, who, cases.scales[scale])
        _store(inputs.rows[who], scale, peaks, shard)
    if any(quantity in shard.values for quantity in JUDGED):
        if laws_of(members[0].sites):
            who, scale = _at_random(cases, inputs, block_engine.text.block_width, shard)
            finer = inputs.run(_engine_of(cases, kind, members[0].sites, 2 * m), who, cases.scales[scale])
            _judge_under_laws(cases, inputs.rows[who], scale, finer, shard)
        else:
            who, scale = _hardest_and_random(cases, inputs, block_engine.text.block_width, shard)
            coarse = {
                q: shard.values[q][inputs.rows[who], scale, : cases.buildings[kind[0]].n_floors]
                for q in JUDGED
                if q in shard.values
            }
            finer = inputs.run(_engine_of(cases, kind, members[0].sites, 2 * m), who, cases.scales[scale])
            _judge(coarse, finer, shard, any(composition.in_series for composition in kind[2]))
        whole, half = refinements(cases.buildings[kind[0]], np.array(kind[1]).reshape(-1, cases.buildings[kind[0]].n))
        if whole is not cases.buildings[kind[0]]:
            peaks = inputs.run(block_engine, who, cases.scales[scale])
            fewer = None
            if half is not None:
                fewer = inputs.run(_engine_of(cases, kind, members[0].sites, m, half), who, cases.scales[scale])
            _judge_truncation(fewer, peaks, whole, shard)


def _hardest_and_random(cases: Cases, inputs: Inputs, count: int, shard: Shard) -> tuple[Integers, Integers]:
    """Up to ``count`` members and scales of a kind, a quarter each: those whose least floor or storey moves least beside its
    largest; the same, but at most one of each member; the weakest motions on the stiffest dampers; and any, at random."""
    members, scales = len(inputs.rows), len(cases.scales)
    size = members * scales
    if size <= count:
        who, scale = np.divmod(np.arange(size), scales)
        return who, scale
    quantity = next(quantity for quantity in JUDGED if quantity in shard.values)
    peaks = np.nan_to_num(
        shard.values[quantity][inputs.rows], nan=np.inf
    )  # of cases without bound, and storeys that are not
    largest = np.max(peaks, axis=2, initial=0.0, where=np.isfinite(peaks))
    locked = np.min(peaks, axis=2) / np.maximum(largest, 1e-300)
    one_of_each_member = np.full(locked.shape, np.inf)
    best = (np.arange(members), np.argmin(locked, axis=1))
    one_of_each_member[best] = locked[best]
    weak = np.outer(inputs.strengths / inputs.stiffnesses, np.abs(cases.scales))
    chosen: list[int] = []
    for rank in (locked, one_of_each_member, weak):
        order = np.argsort(rank.ravel(), kind="stable")
        chosen += order[~np.isin(order, chosen)][: count // 4].tolist()
    others = np.setdiff1d(np.arange(size), chosen)
    random = np.random.default_rng((SEED, shard.number)).choice(others, count - len(chosen), replace=False)
    who, scale = np.divmod(np.concatenate([chosen, random]).astype(np.int64), scales)
    return who, scale


def _values(site: Site) -> Array:
    """What a site brings to an engine: its parameters, and under a law what these follow."""
    if site.law is None:
        return site.values
    return values_of(site.damper, site.values, site.law, pieces_of(site.damper))


@dataclass(frozen=True, eq=False)
class Inputs:
    """Inputs of an engine for members of one kind, a row for a member."""

    rows: Integers
    motions: list[Array]
    values: list[Array]
    rest: Array
    delays: Array
    strengths: Array  # m/s2, the peaks of the motions
    stiffnesses: Array  # 1/s2, of the members

    @classmethod
    def of(cls, cases: Cases, members: list[Member]) -> Inputs:
        """Members in their order."""
        different = {id(member.sites): member.sites for member in members}
        rest_forces = {key: _rest(sites) for key, sites in different.items()}
        values = {key: [_values(site) for site in sites] for key, sites in different.items()}
        return cls(
            np.array([member.row for member in members]),
            [cases.motions[member.motion].acceleration for member in members],
            [np.array([values[id(member.sites)][d] for member in members]) for d in range(len(members[0].sites))],
            np.array([rest_forces[id(member.sites)] for member in members]),
            np.array([[site.delay for site in member.sites] for member in members]),
            np.array([cases.motions[member.motion].pga for member in members]),
            np.array([member.stiffness for member in members]),
        )

    def run(self, block_engine: Engine, who: Integers, scales: Array) -> dict[str, Array]:
        """The peaks of members ``who``, each under its motion times its scale."""
        motions = [self.motions[k] for k in who]
        return block_engine.run(motions, [v[who] for v in self.values], self.rest[who], self.delays[who], scales)


_ENGINES: OrderedDict[tuple[Any, ...], Engine] = OrderedDict()
MAX_ENGINES, _LOCK = 64, Lock()


def _engine_of(
    cases: Cases, kind: tuple[Any, ...], sites: tuple[Site, ...], m: int, building: Building | None = None
) -> Engine:
    """The engine of a kind of cases with m steps per sample, of the ``building`` that responses take unless one is given; this
    process caches the latest ones."""
    compositions, dt, branchless, laws = kind[2], kind[3], kind[4], kind[5]
    if building is None:
        whole = cases.buildings[kind[0]]
        building = refinements(whole, connections(whole, sites))[0]
    ground = building.ground_terms()[0]
    matrices = tuple(a.tobytes() for a in (building.M, building.C, building.K, building.influence, ground))
    key = (
        matrices,
        building.floors_below,
        kind[1],
        compositions,
        dt,
        m,
        cases.quantities,
        cases.precision,
        cases.device,
        branchless,
        laws,
    )
    with _LOCK:
        if key not in _ENGINES:
            make = gpu_engine if cases.device == "gpu" and len(sites) <= SITES_WRITTEN_OUT else engine
            rows = connections(building, sites)
            controls = (
                control_of(building, rows, d, site.law, site.damper, dt, m) if site.law else None
                for d, site in enumerate(sites)
            )
            more = {"controls": tuple(controls)} if laws_of(sites) else {}  # which a graphics card does not take
            _ENGINES[key] = make(
                building, rows, compositions, dt, m, cases.quantities, cases.precision, branchless, **more
            )
            while len(_ENGINES) > MAX_ENGINES:
                _ENGINES.popitem(last=False)
        return _ENGINES[key]


def _rest(sites: tuple[Site, ...]) -> Array:
    """The forces of the dampers at rest."""
    from dampyr.models.path_integration import along

    t, still = np.array([0.0, 1e-3]), np.zeros(2)
    return np.array([along(site.composition, t, still, still, site.values)[0] for site in sites])


def _store(rows: Integers, scales: Integers, peaks: dict[str, Array], shard: Shard) -> None:
    good = np.all([np.isfinite(values).all(axis=1) for values in peaks.values()], axis=0)
    shard.unbounded += int(np.sum(~good))
    for quantity, values in peaks.items():
        values[~good] = np.nan
        shard.values[quantity][rows, scales, : values.shape[1]] = values


def _judge(coarse: dict[str, Array], fine: dict[str, Array], shard: Shard, first_order: bool) -> None:
    """Measure the error of cases by half the step: halving leaves a sixteenth of it, or half of it."""
    for quantity in JUDGED:
        if quantity in coarse:
            size = np.abs(fine[quantity])
            with np.errstate(invalid="ignore", divide="ignore"):
                gap = np.abs(coarse[quantity] / fine[quantity] - 1.0) * (2.0 if first_order else 1.0)
            gap[~np.isfinite(gap)] = 0.0  # a case without bound, or a floor that never moves
            moving = (size > MOVING) & (size > MOVING_SHARE * size.max(axis=1, keepdims=True))
            shard.error = max(shard.error, float(np.max(gap, initial=0.0)))
            shard.moving = max(shard.moving, float(np.max(gap, initial=0.0, where=moving)))
            shard.judged += len(gap) if quantity == JUDGED[0] or JUDGED[0] not in coarse else 0


def _at_random(cases: Cases, inputs: Inputs, count: int, shard: Shard) -> tuple[Integers, Integers]:
    """Up to ``count`` members and scales of a kind."""
    size, scales = len(inputs.rows) * len(cases.scales), len(cases.scales)
    chosen = np.random.default_rng((SEED, shard.number)).choice(size, min(size, count), replace=False)
    who, scale = np.divmod(np.sort(chosen), scales)
    return who, scale


def _judge_under_laws(cases: Cases, rows: Integers, scale: Integers, fine: dict[str, Array], shard: Shard) -> None:
    """Measure what half the step changes where a decision may fall the other way: in how many cases a peak changes by more than
    the bound of the accuracy, and by how much the peaks of all change in the mean."""
    flipped = np.zeros(len(rows), dtype=bool)
    for quantity in ("displacement", *BIASED):
        if quantity not in fine:
            continue
        size_of = np.abs(fine[quantity])
        moving = (size_of > (MOVING if quantity in JUDGED else 0.0)) & (
            size_of > MOVING_SHARE * size_of.max(axis=1, keepdims=True)
        )
        coarse = shard.values[quantity][rows, scale, : size_of.shape[1]]
        with np.errstate(invalid="ignore", divide="ignore"):
            change = np.where(moving & np.isfinite(coarse), coarse / fine[quantity] - 1.0, 0.0)
        if quantity in JUDGED:
            flipped |= np.any(np.abs(change) > BOUNDS[cases.accuracy], axis=1)
        if quantity in BIASED:
            means = change.mean(axis=1)
            for name, total in ((f"bias_{quantity}", means.sum()), (f"square_{quantity}", np.sum(means**2))):
                setattr(shard, name, getattr(shard, name) + float(total))
    shard.judged_under_laws += len(rows)
    shard.flipped += int(flipped.sum())


def _judge_truncation(
    fewer: dict[str, Array] | None, peaks: dict[str, Array], building: Building, shard: Shard
) -> None:
    """Measure what reduced structures leave out by cases with half as many coordinates; without them it is nothing where the
    ``building`` is exact, and infinite where it is not known."""
    for quantity, name in LEFT_OUT.items():
        if fewer is None and quantity in peaks:
            exact = isinstance(building, Condensed) and building.exact
            setattr(shard, name, max(getattr(shard, name), 0.0 if exact else np.inf))
        elif fewer is not None and quantity in peaks:
            good = np.isfinite(fewer[quantity]).all(axis=1) & np.isfinite(peaks[quantity]).all(axis=1)
            changes = map(relative_change, fewer[quantity][good], peaks[quantity][good])
            setattr(shard, name, max(getattr(shard, name), *changes, 0.0))


def _one_by_one(cases: Cases, members: list[Member], shard: Shard) -> None:
    """Cases that no engine can run, by the kernel of `respond`."""
    count = min(JUDGED_ONE_BY_ONE, len(members))
    judged = set(np.random.default_rng((SEED, shard.number)).choice(len(members), count, replace=False).tolist())
    weakest = int(np.argmin(np.abs(cases.scales)))
    for number, member in enumerate(members):
        whole, motion = cases.buildings[member.building], cases.motions[member.motion]
        building, half = refinements(whole, connections(whole, member.sites))
        run = runner(building, motion, member.sites)
        for s, scale in enumerate(cases.scales):
            once = partial(run, scale=scale)
            try:
                if laws_of(member.sites):
                    run_of_case = _halved(once, motion, member.m, cases.accuracy, shard)
                else:
                    run_of_case = once(member.m)
            except InputError:
                shard.unbounded += 1
                continue
            peaks = _peaks(run_of_case.out, member.sites, building)
            _store(np.array([member.row]), np.array([s]), {q: peaks[q] for q in cases.quantities if q in peaks}, shard)
            shard.general += 1
            if number in judged and s == weakest and not laws_of(member.sites):
                series = any(site.composition.in_series for site in member.sites)
                _judge(peaks, _peaks(once(2 * member.m).out, member.sites, building), shard, series)
            if number in judged and s == weakest and building is not whole:
                fewer = None
                if half is not None:
                    other = runner(half, motion, member.sites)(round(motion.dt / run_of_case.step), scale=scale)
                    fewer = _peaks(other.out, member.sites, half)
                _judge_truncation(fewer, peaks, building, shard)


def _halved(once: Any, motion: Any, m: int, accuracy: str, shard: Shard) -> Integration:
    """A case under control laws, its step halved until the peaks stop changing: where a decision falls the other way the
    response is another one, so that no step chosen beforehand is small enough for all cases."""
    integration = halve_under_laws(once, motion, ACCURACIES[accuracy], m)
    shard.unconverged += bool(integration.reason)
    shard.error, shard.moving = max(shard.error, integration.error or 0.0), max(shard.moving, integration.error or 0.0)
    shard.judged += 1
    return integration


def _peaks(out: Any, sites: tuple[Site, ...], building: Building) -> dict[str, Array]:
    peaks = {
        "displacement": out.displacement_peak,
        "drift": out.drift_peak,
        "acceleration": out.acceleration_peak,
        "force": out.force_peak,
        "stroke": np.abs(out.state[:, : building.n] @ connections(building, sites).T).max(axis=0, initial=0.0),
        "energy": out.work[-1, 2:],
    }
    return {quantity: np.array(values)[None] for quantity, values in peaks.items()}
