r"""A search over constant inputs, control laws with their gains, and places of the damper: which is best, and how sure that is.

Every candidate, an input at a place, runs under some of the motions, and those are ranked by the mean of the logarithm of the
criterion x, the largest peak of a case. The best of many is in part the luckiest: its rank says less on other motions. So the
first ones run once more under the other motions, which had no say in the choice, with other noise in their sensors, and there

.. math:: r_j = \exp \overline{\log x_j - \log x_1}

says how much worse than the first the others are, with the 90 % band of a bootstrap over motions and dampers ([Owen2007]_ of
`dampyr.structures.ensembles.arena`). The first stays the first: choosing anew there would bring the luck back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError
from dampyr.findings import Finding, worst_first
from dampyr.ground_motions import GroundMotion
from dampyr.models import Damper
from dampyr.options import takes
from dampyr.origin import Origin
from dampyr.shown import Shown
from dampyr.structures.building import Building
from dampyr.structures.building_options import EnsembleOptions
from dampyr.structures.control_laws import is_control_law
from dampyr.structures.ensembles.arena import BAND, CRITERIA, Arena, bootstrap_weights, compared
from dampyr.structures.ensembles.ensemble import Progress, ensemble
from dampyr.structures.ensembles.ensemble_result import EnsembleResult
from dampyr.structures.ensembles.ensemble_workers import Workers
from dampyr.structures.sensor_noise import MAX_SEED
from dampyr.structures.time_history.peaks import peak_of_cases

Array = NDArray[np.float64]
LEAST_MOTIONS = 4  # two to choose by, two to judge on
OTHER_NOISE = 7_654_321  # is added to the seeds of laws under the motions that judge


@dataclass(frozen=True, eq=False, repr=False)
class ControlSearch(Shown):
    """What `search_control` found.

    Attributes
    ----------
    names
        Of all candidates (k,), as they were ranked, the best first.
    criterion, unit
        The quantity whose largest peak is to be small, and its unit.
    chosen_by, judged_on
        The names of the motions by which the candidates were ranked, and of the others.
    ranked
        (k,) exp of the mean log criterion under the motions of ``chosen_by``.
    judged
        (f,) the same of the first f candidates under those of ``judged_on``.
    ratio, ratio_band
        (f,) of each of these the criterion over that of the first one under the motions that judge, and its 90 % band (2, f).
    arena
        The f candidates against one another under the motions that judge.
    choosing
        The ensemble by which they were ranked.
    """

    names: tuple[str, ...]
    criterion: str
    unit: str
    chosen_by: tuple[str, ...]
    judged_on: tuple[str, ...]
    ranked: Array
    judged: Array
    ratio: Array
    ratio_band: Array
    arena: Arena
    choosing: EnsembleResult

    @property
    def best(self) -> str:
        """The candidate that ranked first."""
        return self.names[0]

    @property
    def apart(self) -> tuple[bool, ...]:
        """Of each candidate that was judged whether it is told apart from the first as the worse one; the first is not."""
        return tuple(bool(low > 1.0) for low in self.ratio_band[0])

    @property
    def beaten(self) -> bool:
        """Whether a candidate is told apart from the first as the better one, so that the choice was luck."""
        return bool(np.any(self.ratio_band[1] < 1.0))

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Those of both ensembles, and whether the choice did not hold."""
        luck = (
            "under motions that had no say in the choice another candidate is better than the first; give more motions"
        )
        doubts = (Finding("doubt", luck) for _ in range(self.beaten))
        return worst_first(dict.fromkeys((*self.choosing.findings, *self.arena.findings)), doubts)

    @property
    def origin(self) -> Origin:
        """That of the dampers' cards."""
        return self.choosing.origin


@takes(EnsembleOptions)
def search_control(
    building: Building,
    motions: Sequence[GroundMotion],
    damper: Damper,
    voltage: Any = None,
    places: Sequence[Any] = (1,),
    scales: ArrayLike = 1.0,
    criterion: str = "drift",
    finalists: int = 5,
    executor: Workers | None = None,
    options: EnsembleOptions | None = None,
    *,
    current: Any = None,
    out: str | Path | None = None,
    progress: Progress | None = None,
    **keywords: Any,
) -> ControlSearch:
    """The best of many inputs of a damper at many places, chosen by some of the motions and judged on the others.

    Parameters
    ----------
    building
        the building.
    motions
        four or more; every second one of them, in a random order, is kept for judging.
    damper
        the damper, which stands at one place at a time.
    voltage, current
        the inputs to choose from: constant ones [V], [A] and control laws; laws of several gains are several
        (`dampyr.structures.control_laws_of` makes them).
    places
        where the damper may stand: a storey, or two floors such as (0, 2).
    scales
        factors of the motions, one or a list.
    criterion
        "drift", "displacement", "acceleration", "force" or "stroke": the largest of all storeys, floors or dampers of a case.
    finalists
        how many of the candidates, the best first, are judged; 2 or more.
    executor, options, progress
        as in `dampyr.structures.ensemble`, whose options count for both ensembles; ``seed`` parts the motions, too.
    out
        a folder for the files of both ensembles; a search that was interrupted goes on from them.

    Raises
    ------
    InputError
        There is only one candidate, or there are fewer than four motions, or an argument is wrong.

    Examples
    --------
    >>> import dampyr as dp
    >>> S, damper = dp.structures, dp.studies.raminelli_2020.damper()
    >>> motions = [dp.ground_motions.kanai_tajimi(4.0, 0.02, seed=(7, k), pga=3.0) for k in range(1, 13)]
    >>> found = S.search_control(S.two_storey(), motions, damper, [0.0, 1.0, 2.0, 3.0], places=[1, 2])
    >>> found.best
    '2 V, storey 1'
    """
    chosen = EnsembleOptions.of("search_control", options, keywords)
    if criterion not in CRITERIA:
        raise InputError(f"criterion = {criterion!r} is not known; choose from {', '.join(CRITERIA)}")
    listed = list(motions)
    if len(listed) < LEAST_MOTIONS:
        raise InputError(
            f"a search needs {LEAST_MOTIONS} motions or more, as those that choose may not judge; {len(listed)} given"
        )
    if isinstance(finalists, bool) or finalists != int(finalists) or finalists < 2:
        raise InputError(f"finalists = {finalists!r} is not allowed; it must be a whole number of at least 2")
    if not len(places):
        raise InputError("places is empty; give storeys or pairs of floors, such as places=[1, (0, 2)]")
    kind, inputs = ("voltage", voltage) if current is None else ("current", current)
    if voltage is not None and current is not None:
        raise InputError("voltage and current are both given; a damper takes one of them")
    inputs = list(inputs) if isinstance(inputs, list | tuple | np.ndarray) else [inputs]
    if len(places) * len(inputs) < 2:
        raise InputError("there is one candidate, and a search chooses among several; give more inputs or places")
    quantities = tuple(dict.fromkeys((*chosen.quantities, criterion)))
    chosen = replace(chosen, quantities=quantities)
    order = np.random.default_rng(chosen.seed).permutation(len(listed))
    to_choose, to_judge = ([listed[k] for k in sorted(order[first::2])] for first in (0, 1))
    folder = None if out is None else Path(out)
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)

    def run(some: list[GroundMotion], where: list[Any], what: list[Any], name: str) -> EnsembleResult:
        return ensemble(
            building, some, [{place: damper} for place in where], scales=scales, executor=executor, options=chosen,
            out=None if folder is None else folder / f"{name}.h5", progress=progress, **{kind: what},
        )  # fmt: skip

    ranking = run(to_choose, list(places), inputs, "choosing")
    x, names = _cases(ranking, criterion, building, list(places))
    size = _mean_log(x)
    first = np.argsort(size, kind="stable")
    count = min(int(finalists), len(names))
    judges = run(
        to_judge,
        [places[k] for k in sorted({int(c) // len(inputs) for c in first[:count]})],
        [_with_other_noise(inputs[k]) for k in sorted({int(c) % len(inputs) for c in first[:count]})],
        f"judging_{count}",
    )
    at, of_input = (
        sorted({int(f(c)) for c in first[:count]}) for f in (lambda c: c // len(inputs), lambda c: c % len(inputs))
    )
    every, _ = _cases(judges, criterion, building, [places[k] for k in at])
    columns = [
        at.index(int(c) // len(inputs)) * len(of_input) + of_input.index(int(c) % len(inputs)) for c in first[:count]
    ]
    y = every[:, :, columns]
    ratio, band = _ratios(y, chosen.seed)
    ordered = tuple(names[k] for k in first)
    unit = str(ranking.dataset[criterion].attrs.get("units", ""))
    return ControlSearch(
        names=ordered,
        criterion=criterion,
        unit=unit,
        chosen_by=tuple(motion.name for motion in to_choose),
        judged_on=tuple(motion.name for motion in to_judge),
        ranked=np.exp(size[first]),
        judged=np.exp(_mean_log(y)),
        ratio=ratio,
        ratio_band=band,
        arena=compared(y, ordered[:count], criterion, unit, chosen.seed, judges),
        choosing=ranking,
    )


def _with_other_noise(value: Any) -> Any:
    """The same law with noise of its own, where its sensors have some."""
    noisy = is_control_law(value) and any(sensor.noise > 0.0 for _, sensor in value.sensors)
    return replace(value, seed=(value.seed + OTHER_NOISE) % (MAX_SEED + 1)) if noisy else value


def _cases(result: EnsembleResult, criterion: str, building: Building, places: list[Any]) -> tuple[Array, list[str]]:
    """The criterion (1, drawn dampers, candidates, motions, scales), the inputs of a place after one another; their names."""
    x = peak_of_cases(result.dataset, criterion, "worst", None)
    x = np.where(np.isnan(x), np.inf, x)
    buildings, dampers, inputs, motions, scales = x.shape
    by_place = x.reshape(buildings, len(places), dampers // len(places), inputs, motions, scales)
    inputs_named = [str(name) for name in result.dataset.input_name.values]
    labels = [building.place_label(place) for place in places]
    names = [f"{name}, {label}" for label in labels for name in inputs_named]
    return np.moveaxis(by_place, 1, 2).reshape(buildings, dampers // len(places), -1, motions, scales), names


def _logs(x: Array) -> Array:
    return np.asarray(np.log(np.clip(x, 1e-300, 1e300)))  # a case that grew without bound counts, and is comparable


def _mean_log(x: Array) -> Array:
    """(candidates,) the mean logarithm."""
    return np.asarray(_logs(x).mean(axis=(0, 1, 3, 4)))


def _ratios(x: Array, seed: int) -> tuple[Array, Array]:
    """(f,) of each candidate the mean ratio to the first, and its band (2, f)."""
    gaps = np.moveaxis(_logs(x).mean(axis=(0, 4)), 1, 0)  # (f, dampers, motions)
    gaps = gaps - gaps[:1]
    of_dampers, of_motions = bootstrap_weights(seed, *gaps.shape[1:])
    drawn = np.array([np.sum((of_dampers @ gap) * of_motions, axis=1) for gap in gaps])
    return np.exp(gaps.mean(axis=(1, 2))), np.exp(np.quantile(drawn, BAND, axis=1))
