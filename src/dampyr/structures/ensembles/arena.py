r"""Which control law is better, and how sure that is: the laws of an ensemble against one another, case by case.

A case is one building, drawn damper (with its noise), motion and scale under every law, so that the comparison is paired. Of
laws A and B

.. math:: P(A < B) = \frac{1}{n} \sum_c \big[x_c(A) < x_c(B)\big] + \tfrac12 \big[x_c(A) = x_c(B)\big]

is the share of cases in which the criterion x, the largest peak of a quantity, is smaller under A. Cases of one motion or
of one drawn damper are no independent ones. The 90 % band is therefore that of a bootstrap that draws motions and dampers
anew, each by themselves and with replacement, which for two-way data is on the wide side ([Owen2007]_); and it reaches at
least as far as the 5 % bound :math:`0.05^{1/N}` of N motions (or dampers, where these are more) without an exception, as
a bootstrap cannot draw what did not happen. Where it holds 1/2, the laws are not told apart. With n motions half the band is
about :math:`h\sqrt{N/n}`, h being that with N. Two laws are told apart in 95 of 100 ensembles where P is two of these halves
from 1/2: one is the band's, the other the scatter of P itself. About :math:`n = N (2h/(P - 1/2))^2` motions are needed.

References
----------
.. [Owen2007] A. B. Owen, "The pigeonhole bootstrap", Annals of Applied Statistics 1(2), 386-411, 2007.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.findings import Finding, worst_first
from dampyr.origin import Origin
from dampyr.shown import Shown
from dampyr.structures.ensembles.ensemble_result import EnsembleResult
from dampyr.structures.ensembles.store import BARE
from dampyr.structures.time_history.peaks import peak_of_cases

Array = NDArray[np.float64]
REPEATS, BAND = 1000, (0.05, 0.95)
CRITERIA = ("drift", "displacement", "acceleration", "force", "stroke")


@dataclass(frozen=True, eq=False, repr=False)
class Arena(Shown):
    """What `arena` found.

    Attributes
    ----------
    names
        The inputs: control laws and constant ones, k.
    criterion, unit
        The quantity whose largest peak is to be small, and its unit.
    cases, motions, dampers
        How many cases each input had, of how many motions and drawn dampers.
    medians
        (k,) of the criterion.
    best, best_band
        (k,) share of the cases in which an input is the best of all, and its 90 % band (2, k).
    wins, wins_band
        (k, k) share of the cases in which the input of the row has the smaller criterion than that of the column, 1/2 for equal
        ones, and its 90 % band (2, k, k).
    needed
        (k, k) about how many motions would tell the two apart with a probability of 95 %, were their difference the one that
        is found and did the dampers grow with them: 0 where they are told apart, NaN where nothing says so.
    reason
        Why there is no band, or "".
    result
        The ensemble.
    """

    names: tuple[str, ...]
    criterion: str
    unit: str
    cases: int
    motions: int
    dampers: int
    medians: Array
    best: Array
    best_band: Array
    wins: Array
    wins_band: Array
    needed: Array
    reason: str
    result: EnsembleResult

    @property
    def winner(self) -> str | None:
        """The input that is told apart from every other one as the better; None where there is none."""
        k = len(self.names)
        ahead = [i for i in range(k) if all(self.wins_band[0, i, j] > 0.5 for j in range(k) if j != i)]
        return self.names[ahead[0]] if ahead else None

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Those of the ensemble, and why there is no band."""
        doubts = (Finding("doubt", f"no band: {self.reason}") for _ in range(bool(self.reason)))
        return worst_first(self.result.findings, doubts)

    @property
    def origin(self) -> Origin:
        """That of the dampers' cards."""
        return self.result.origin


def arena(result: EnsembleResult, criterion: str = "drift", seed: int = 1) -> Arena:
    """The inputs of an ensemble against one another, by the largest peak of a quantity.

    Parameters
    ----------
    result
        What `ensemble` or `read_ensemble` gave for two inputs or more: control laws, constant inputs, or both. Several motions
        are needed for bands; drawn dampers (``draws=``) or seeds of noise (``seeds=``) count as well. It may have been computed
        on a cluster, ``ensemble(..., executor=client, out="peaks.h5")``, and in several runs: the arena is the same.
    criterion
        "drift", "displacement", "acceleration", "force" or "stroke": the largest of all storeys, floors or dampers of a case.
        A case that grew without bound has an infinite one.
    seed
        That of the bootstrap.

    Raises
    ------
    InputError
        There are fewer than two inputs, or the ensemble has no such quantity.

    Examples
    --------
    >>> import dampyr as dp
    >>> S, damper = dp.structures, dp.studies.raminelli_2020.damper()
    >>> motions = [dp.ground_motions.kanai_tajimi(4.0, 0.02, seed=(7, k), pga=3.0) for k in range(1, 9)]
    >>> laws = [S.control_law(name, high=3.212, lag=0.01) for name in ("passive_on", "clipped_optimal")]
    >>> found = S.arena(S.ensemble(S.two_storey(), motions, damper, laws), "acceleration")
    >>> found.winner
    'clipped_optimal 0 to 3.212 V, lag 0.01 s'
    """
    if not isinstance(result, EnsembleResult):
        raise InputError(f"arena: result is a {type(result).__name__}; give what ensemble or read_ensemble gives")
    dataset = result.dataset
    if criterion not in CRITERIA:
        raise InputError(f"criterion = {criterion!r} is not known; choose from {', '.join(CRITERIA)}")
    if dataset.sizes["input"] < 2:
        raise InputError("there is one input, and an arena compares them; give two or more, such as two control laws")
    with_damper = np.flatnonzero(np.asarray(dataset.damper_name.values).astype(str) != BARE)
    if not with_damper.size:
        raise InputError("no case has a damper, so there is nothing that an input could change")
    x = peak_of_cases(dataset, criterion, "worst", None)[:, with_damper]
    x = np.where(np.isnan(x), np.inf, x)
    names = tuple(str(name) for name in dataset.input_name.values)
    return compared(x, names, criterion, str(dataset[criterion].attrs.get("units", "")), seed, result)


def compared(x: Array, names: tuple[str, ...], criterion: str, unit: str, seed: int, result: EnsembleResult) -> Arena:
    """The arena of the criterion x (buildings, dampers, inputs, motions, scales), whose inputs have these names."""
    dampers, motions = x.shape[1], x.shape[3]
    ahead, first = _pairs(x), _firsts(x)
    weights = bootstrap_weights(seed, dampers, motions)
    wins, wins_band = _share(ahead, weights)
    best, best_band = _share(first, weights)
    reason = (
        "" if motions > 1 or dampers > 1 else "there is one motion and one damper; give more motions, draws or seeds"
    )
    if reason:
        wins_band, best_band = np.full_like(wins_band, np.nan), np.full_like(best_band, np.nan)
    return Arena(
        names,
        criterion,
        unit,
        int(x[:, :, 0].size),
        motions,
        dampers,
        np.array([float(np.median(x[:, :, u])) for u in range(len(names))]),
        best,
        best_band,
        wins,
        wins_band,
        _needed(wins, wins_band, motions),
        reason,
        result,
    )


def _pairs(x: Array) -> Array:
    """(k, k, dampers, motions): the share of buildings and scales in which the first input has the smaller criterion."""
    k = x.shape[2]
    ahead = np.zeros((k, k, x.shape[1], x.shape[3]))
    for i in range(k):
        for j in range(i):
            less, equal = x[:, :, i] < x[:, :, j], x[:, :, i] == x[:, :, j]
            ahead[i, j] = (less + 0.5 * equal).mean(axis=(0, 3))
            ahead[j, i] = 1.0 - ahead[i, j]
        ahead[i, i] = 0.5
    return ahead


def _firsts(x: Array) -> Array:
    """(k, dampers, motions): the share of buildings and scales in which an input is the best, shared by equal ones."""
    least = x == x.min(axis=2, keepdims=True)
    share = least / least.sum(axis=2, keepdims=True)
    return np.moveaxis(share.mean(axis=(0, 4)), 1, 0)


def bootstrap_weights(seed: int, dampers: int, motions: int) -> tuple[Array, Array]:
    """How often each damper and each motion is drawn in every repeat of the bootstrap, as shares."""
    return _weights(np.random.default_rng(seed), dampers), _weights(np.random.default_rng(seed + 1), motions)


def _weights(rng: np.random.Generator, count: int) -> Array:
    """(repeats, count): how often each of ``count`` is drawn with replacement, as a share; each once where there is one."""
    return rng.multinomial(count, np.full(count, 1.0 / count), size=REPEATS) / count


def _share(of_cases: Array, weights: tuple[Array, Array]) -> tuple[Array, Array]:
    """The mean over the last two axes, dampers and motions, and its 90 % band."""
    shape = of_cases.shape[:-2]
    flat = of_cases.reshape(-1, *of_cases.shape[-2:])
    bands = np.zeros((2, len(flat)))
    always = BAND[0] ** (1.0 / max(of_cases.shape[-2:]))  # so much is sure of what happened each time
    for k, case in enumerate(flat):
        drawn = np.sum((weights[0] @ case) * weights[1], axis=1)
        low, high = np.quantile(drawn, BAND)
        bands[:, k] = min(low, always), max(high, 1.0 - always)
    return of_cases.mean(axis=(-2, -1)), bands.reshape(2, *shape)


def _needed(wins: Array, band: Array, motions: int) -> Array:
    """About how many motions would tell two inputs apart 95 times of 100; 0 where they are, NaN where they cannot be."""
    half, off = 0.5 * (band[1] - band[0]), np.abs(wins - 0.5)
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.ceil(motions * (2.0 * half / off) ** 2)
    told = (band[0] > 0.5) | (band[1] < 0.5)
    needed = np.where(told, 0.0, np.where(np.isfinite(needed), np.maximum(needed, motions + 1), math.nan))
    np.fill_diagonal(needed, math.nan)
    return np.asarray(needed)
