r"""Shards of an ensemble: the cases of each sorted into blocks that an engine runs together.

The step is that of the rule (`dampyr.structures.step_size`) with :math:`\omega_s h \le 1`; 0.4 of it where the accuracy is
"strict". The error is measured: the first block of every kind of case in a shard is run again with half the step.

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
from dampyr.structures.batch.engine import Engine, can_run, engine
from dampyr.structures.batch.gpu import engine as gpu_engine
from dampyr.structures.building import Building
from dampyr.structures.ensemble_grid import STEPS, Cases
from dampyr.structures.kernel_run import runner
from dampyr.structures.response import Run
from dampyr.structures.sites import Site, connections, laws_of
from dampyr.structures.step_size import (
    ACCURACIES,
    difference_slopes,
    halve_until_converged,
    largest_step,
    steps_per_sample,
)

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
LIMIT = 1.0  # of omega h: fast stays below 0.1 % of the peak in the standard suite with it
MAX_STEP_COUNT = 1_000_000  # of a case under control laws: seconds, as there are many cases
JUDGED = ("displacement", "drift")


@dataclass
class Shard:
    """Result of shard ``number``: ``values`` quantity -> (lines, scales, width), NaN where a building has no such storey.

    ``error`` is the largest relative change of a peak on halving the step, among ``judged`` cases; ``unbounded`` counts
    cases that grew without bound; ``general`` counts those that no engine can run.
    """

    number: int
    lines: range
    values: dict[str, Array]
    error: float = 0.0
    judged: int = 0
    unbounded: int = 0
    general: int = 0


def run_shard(shard: int, shards: int, cases: Cases) -> Shard:
    """Shard number ``shard`` of ``shards``: a pure function of its arguments, for any process on any machine."""
    lines = cases.lines_of(shard, shards)
    empty = {q: np.full((len(lines), len(cases.scales), cases.width(q)), np.nan) for q in cases.quantities}
    done = Shard(shard, lines, empty)
    for kind, members in _kinds(cases, lines).items():
        if kind[-1] is None:
            _one_by_one(cases, members, done)
        else:
            _in_blocks(cases, kind, members, done)
    return done


@dataclass(frozen=True, eq=False)
class Member:
    """A line of a shard: where its values go, its sites and its motion."""

    row: int
    building: int
    sites: tuple[Site, ...]
    motion: int
    m: int


def _kinds(cases: Cases, lines: range) -> dict[tuple[Any, ...], list[Member]]:
    """The lines by what one engine can run; the last of a key is None where no engine can."""
    groups: dict[tuple[Any, ...], list[Member]] = {}
    cached: dict[tuple[int, int, int], tuple[tuple[Site, ...], float]] = {}
    for row, number in enumerate(lines):
        b, d, u, k = cases.line(number)
        if (b, d, u) not in cached:
            sites = tuple(map(_without_zero_delay, cases.sites_of(b, d, u)))
            share = 1.0 if laws_of(sites) else STEPS[cases.accuracy]  # under laws the step is halved
            rule = largest_step(cases.buildings[b], sites, difference_slopes(sites), LIMIT)
            cached[b, d, u] = sites, share * rule
        sites, step = cached[b, d, u]
        dt = cases.motions[k].dt
        m = steps_per_sample(dt, step, sites)
        compositions = tuple(site.composition for site in sites)
        rows = tuple(map(tuple, connections(cases.buildings[b], sites).tolist()))
        branchless = cases.device == "cpu" and bouc_wen_branchless.is_vectorisable(
            (site.composition, site.values) for site in sites
        )
        key = (b, rows, compositions, dt, branchless, m if can_run(compositions) and not laws_of(sites) else None)
        groups.setdefault(key, []).append(Member(row, b, sites, k, m))
    return groups


def _without_zero_delay(site: Site) -> Site:
    """The site without a delay of 0 s, which a ring of past forces cannot represent."""
    k = site.composition.delay
    if k is None or site.delay > 0:
        return site
    return replace(site, damper=site.damper.without("delay"), values=np.delete(site.values, k))


def _in_blocks(cases: Cases, kind: tuple[Any, ...], members: list[Member], done: Shard) -> None:
    m, scales = kind[-1], len(cases.scales)
    made = _made(cases, kind, members[0].sites, m)
    inputs = Inputs.of(cases, sorted(members, key=lambda member: cases.motions[member.motion].n))
    for first in range(0, len(members) * scales, made.max_histories):
        who, scale = np.divmod(np.arange(first, min(first + made.max_histories, len(members) * scales)), scales)
        peaks = inputs.run(made, who, cases.scales[scale])
        _store(inputs.rows[who], scale, peaks, done)
        if first == 0:
            few, finer = slice(made.text.block_width), _made(cases, kind, members[0].sites, 2 * m)
            _judge({q: v[few] for q, v in peaks.items()}, inputs.run(finer, who[few], cases.scales[scale[few]]), done)


@dataclass(frozen=True, eq=False)
class Inputs:
    """Inputs of an engine for members of one kind, a row for a member."""

    rows: Integers
    motions: list[Array]
    values: list[Array]
    rest: Array
    delays: Array

    @classmethod
    def of(cls, cases: Cases, members: list[Member]) -> Inputs:
        """Members in their order."""
        count, rest_forces = len(members[0].sites), {id(member.sites): _rest(member.sites) for member in members}
        return cls(
            np.array([member.row for member in members]),
            [cases.motions[member.motion].acceleration for member in members],
            [np.array([member.sites[d].values for member in members]) for d in range(count)],
            np.array([rest_forces[id(member.sites)] for member in members]),
            np.array([[site.delay for site in member.sites] for member in members]),
        )

    def run(self, made: Engine, who: Integers, scales: Array) -> dict[str, Array]:
        """The peaks of members ``who``, each under its motion times its scale."""
        motions = [self.motions[k] for k in who]
        return made.run(motions, [v[who] for v in self.values], self.rest[who], self.delays[who], scales)


_ENGINES: OrderedDict[tuple[Any, ...], Engine] = OrderedDict()
MAX_ENGINES, _LOCK = 64, Lock()


def _made(cases: Cases, kind: tuple[Any, ...], sites: tuple[Site, ...], m: int) -> Engine:
    """The engine of a kind of cases with m steps per sample; this process caches the latest ones."""
    building, compositions, dt, branchless = cases.buildings[kind[0]], kind[2], kind[3], kind[4]
    matrices = tuple(a.tobytes() for a in (building.M, building.C, building.K, building.influence))
    key = (matrices, kind[1], compositions, dt, m, cases.quantities, cases.precision, cases.device, branchless)
    with _LOCK:
        if key not in _ENGINES:
            make = gpu_engine if cases.device == "gpu" else engine
            rows = connections(building, sites)
            _ENGINES[key] = make(building, rows, compositions, dt, m, cases.quantities, cases.precision, branchless)
            while len(_ENGINES) > MAX_ENGINES:
                _ENGINES.popitem(last=False)
        return _ENGINES[key]


def _rest(sites: tuple[Site, ...]) -> Array:
    """The forces of the dampers at rest."""
    from dampyr.models.path_integration import along

    t, still = np.array([0.0, 1e-3]), np.zeros(2)
    return np.array([along(site.composition, t, still, still, site.values)[0] for site in sites])


def _store(rows: Integers, scales: Integers, peaks: dict[str, Array], done: Shard) -> None:
    good = np.all([np.isfinite(values).all(axis=1) for values in peaks.values()], axis=0)
    done.unbounded += int(np.sum(~good))
    for quantity, values in peaks.items():
        values[~good] = np.nan
        done.values[quantity][rows, scales, : values.shape[1]] = values


def _judge(coarse: dict[str, Array], fine: dict[str, Array], done: Shard) -> None:
    """Measure the error of a block by one of half the step."""
    for quantity in JUDGED:
        if quantity in coarse:
            gap = np.abs(coarse[quantity] / fine[quantity] - 1.0)
            done.error = max(done.error, float(np.nanmax(gap, initial=0.0)))
            done.judged += len(gap) if quantity == JUDGED[0] or JUDGED[0] not in coarse else 0


def _one_by_one(cases: Cases, members: list[Member], done: Shard) -> None:
    """Cases that no engine can run, by the kernel of `respond`."""
    for number, member in enumerate(members):
        building, motion = cases.buildings[member.building], cases.motions[member.motion]
        run = runner(building, motion, member.sites)
        for s, scale in enumerate(cases.scales):
            once = partial(run, scale=scale)
            try:
                if laws_of(member.sites):
                    made = _halved(once, motion, member.m, cases.accuracy, done)
                else:
                    made = once(member.m)
            except InputError:
                done.unbounded += 1
                continue
            peaks = _peaks(made.out, member.sites, building)
            _store(np.array([member.row]), np.array([s]), {q: peaks[q] for q in cases.quantities if q in peaks}, done)
            done.general += 1
            if number == 0 and s == 0 and not laws_of(member.sites):
                _judge(peaks, _peaks(once(2 * member.m).out, member.sites, building), done)


def _halved(once: Any, motion: Any, m: int, accuracy: str, done: Shard) -> Run:
    """A case under control laws, its step halved until the peaks stop changing: where a decision falls the other way the
    response is another one, so that no step chosen beforehand is small enough for all cases."""
    made = halve_until_converged(once, motion, ACCURACIES[accuracy], m, MAX_STEP_COUNT)
    done.error, done.judged = max(done.error, made.error or 0.0), done.judged + 1
    return made


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
