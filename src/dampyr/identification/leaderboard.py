r"""Leaderboard of models: every model of the catalogue, bare and with add-ons, ranked by what it predicts unseen.

First each model is *screened* on a few shortened records (`dampyr.identification.screening`): bare, then with the add-on that
lowers its error most, then with the next, as long as that lowers it by 2 % and the model is within 15 % of the best. Then the
best few are fitted and validated on all records. The validation error is

.. math:: E = \tfrac34 E_\text{record} + \tfrac14 E_\text{input}

the mean L1 ratio of records that were left out, and of whole inputs that were left out (where there are three or more;
else the first alone), every input counting the same: a damper is used between the inputs of its tests. Leaving an input out
doubles the gap that a law must bridge, which makes a smooth law's error four times as large, hence the quarter.

Akaike's and Schwarz's criteria are :math:`n \ln(S/N) + 2k` and :math:`n \ln(S/N) + k \ln n` with k parameters of the
damper, the weighted sum of squares S over N samples, and n the effective number of samples, residuals being correlated: that of
the winner for all.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from dampyr.errors import DampyrWarning, InputError
from dampyr.identification import parallel
from dampyr.identification.fit import Fit, fit
from dampyr.identification.screening import (
    PAIRS,
    Screened,
    chosen_bandwidth,
    held_in,
    screen_all,
    screening_set,
    validation_error,
    validations_of,
)
from dampyr.identification.validation import Validation
from dampyr.models import available_parts, part
from dampyr.records import Record, check_bandwidth
from dampyr.representation import Representation, Summary, Table, counted, data_frame, listing, percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ADD_ONS = ("spring", "delay", "lag", "compliance")
FINAL_STEPS = 300  # of a finalist's fits: more than the default, as no start is chosen by hand
FINALISTS = 5  # each costs a fit and two cross-validations of all records
MIN_RECORDS = 5  # records: as many as parts that are left out in turn

#: what `Leaderboard.as_dict` says of an entry
ENTRY_KEYS = (
    "model", "error", "l1", "nrmse", "pointwise", "energy", "unseen_input", "parameters", "aic", "bic", "seconds",
    "converged", "reason",
)  # fmt: skip


@dataclass(frozen=True, repr=False)
class Entry(Representation):
    """A finalist. ``error`` is what the ranking goes by; ``l1``, ``nrmse``, ``pointwise`` and ``energy`` (its size) are means
    over records that were left out, ``unseen_input`` the mean L1 ratio over inputs that were left out (NaN where there are
    fewer than three). ``seconds`` is the time of the fit to all records. ``fit`` is None where it made no damper."""

    model: str
    error: float
    l1: float
    nrmse: float
    pointwise: float
    energy: float
    unseen_input: float
    parameters: int
    seconds: float
    converged: bool
    reason: str
    validations: tuple[Validation, ...] = field(repr=False)
    fit: Fit | None = field(repr=False)
    aic: float = float("nan")
    bic: float = float("nan")

    def _summary(self) -> Summary:
        return f"Entry {self.model!r}", [
            ("error", f"{percent(self.error)}, L1 {percent(self.l1)}, of unseen inputs {percent(self.unseen_input)}"),
            ("NRMSE", f"{percent(self.nrmse)}, pointwise {percent(self.pointwise)}, energy {percent(self.energy)}"),
            ("fit", f"{counted(self.parameters, 'parameter')}, {self.seconds:.3g} s; {self.reason}"),
            ("criteria", f"AIC {self.aic:.6g}, BIC {self.bic:.6g}"),
        ]


@dataclass(frozen=True, repr=False)
class Leaderboard(Representation):
    """The finalists by rising validation error, what was screened before, and what was chosen for all."""

    entries: tuple[Entry, ...]
    screened: tuple[Screened, ...]
    bandwidth: float | None
    left_out: tuple[str, ...]
    seconds: float

    def plot(self) -> Any:
        """The validation error of every screened model, bare and with add-ons; the matplotlib axes ``(1,)``."""
        from dampyr.figures import style
        from dampyr.figures.leaderboard import leaderboard_figure

        return style.in_pyplot(leaderboard_figure, *self.screened_errors())

    def to_dataframe(self) -> Any:
        """The finalists as a ``pandas.DataFrame``, the best first; errors are ratios, ``seconds`` s."""
        keys = [key for key in ENTRY_KEYS if key != "model"]
        columns = {key: [getattr(entry, key) for entry in self.entries] for key in keys}
        return data_frame(columns, [entry.model for entry in self.entries], "model")

    def screened_errors(self) -> tuple[list[str], list[float], list[float]]:
        """Each screened model with its add-ons in lines below it, its error bare, and its error with them."""
        models = [
            one.best.model.replace(one.base, one.base + "\n", 1).replace("\n + ", "\n+ ").rstrip("\n")
            for one in self.screened
        ]
        return models, [one.bare.error for one in self.screened], [one.best.error for one in self.screened]

    def _small_figure(self) -> Figure | None:
        from dampyr.figures.leaderboard import leaderboard_figure

        return leaderboard_figure(*self.screened_errors()) if self.screened else None

    def _summary(self) -> Summary:
        rows = [("winner", f"{self.winner.model}, validation error {percent(self.winner.error)}")]
        if self.runner_up:
            rows.append(("runner-up", f"{self.runner_up.model}, {percent(self.runner_up.error)}"))
        trials = sum(len(one.trials) for one in self.screened)
        rows += [
            (
                "screened",
                f"{counted(len(self.screened), 'model')}, {counted(trials, 'composition')}, {self.seconds:.3g} s",
            ),
            ("velocity", self.velocity),
        ]
        if self.left_out:
            rows.append(("left out", listing(self.left_out, 2)))
        return f"Leaderboard of {counted(len(self.entries), 'finalist')}", rows

    def _table(self) -> Table:
        heads = (
            "model",
            "error [%]",
            "L1 [%]",
            "unseen input [%]",
            "NRMSE [%]",
            "parameters",
            "AIC",
            "BIC",
            "time [s]",
        )
        rows = [
            [
                e.model,
                *(100 * v for v in (e.error, e.l1, e.unseen_input, e.nrmse)),
                e.parameters,
                e.aic,
                e.bic,
                e.seconds,
            ]
            for e in self.entries
        ]
        return heads, rows

    @property
    def velocity(self) -> str:
        """Which velocity was used, in words."""
        if self.bandwidth is not None:
            return f"derived with {self.bandwidth:g} Hz"
        fitted = self.winner.fit.records if self.winner.fit else ()
        derived = any(record.velocity is None for record in fitted)
        return "as recorded, or derived with each record's own bandwidth" if derived else "as recorded"

    @property
    def winner(self) -> Entry:
        """The lowest validation error."""
        return self.entries[0]

    @property
    def runner_up(self) -> Entry | None:
        """The next one."""
        return self.entries[1] if len(self.entries) > 1 else None

    def as_dict(self) -> dict[str, Any]:
        """The ranking and the screening for `dampyr.to_json`, without the fits and validations of the entries."""
        return {
            "entries": [{key: getattr(entry, key) for key in ENTRY_KEYS} for entry in self.entries],
            "screened": self.screened,
            "bandwidth_hz": self.bandwidth,
            "left_out": self.left_out,
            "seconds": self.seconds,
        }


def leaderboard(
    records: Sequence[Record],
    models: Sequence[str] | None = None,
    add_ons: Sequence[str] = ADD_ONS,
    finalists: int = FINALISTS,
    seed: int = 0,
    executor: Executor | None = None,
    progress: Callable[[str, float], None] | None = None,
    **options: Any,
) -> Leaderboard:
    """Rank models by what they predict of records that they were not fitted on.

    Parameters
    ----------
    records
        five or more, at one input or several.
    models
        compositions to begin from; None takes every model of the catalogue that is no add-on, and the pairs of `PAIRS`.
    add_ons
        tried in addition, greedily.
    finalists
        how many are validated on all records.
    executor
        runs the trials, such as ``ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn"))``; None runs them one
        after the other. The result is the same. Forked processes are refused: in trials they crashed after compiled code
        had run in the process that they came from.
    progress
        called with what is being done and the fraction done.
    options
        of `dampyr.identification.fit`, for every fit. ``bandwidth`` is chosen by a probe where it is not given: as recorded, or
        derived from the displacement with 15 times the highest test frequency (each record with its own where no bandwidth
        serves all).

    Raises :class:`~dampyr.errors.InputError` for fewer than five records, or where no model could be fitted.
    """
    parallel.refuse_forks(executor)
    listed = [r for r in records if r.role != "validation"]
    unknown = [r.name for r in listed if r.input is None]
    if unknown:
        raise InputError(f"{unknown[0]}: its voltage is not known; read it with voltage= (or current=)")
    check_count(len(listed))
    begun = time.perf_counter()
    report = progress or (lambda what, done: None)
    bandwidth = options.pop("bandwidth", None)
    if bandwidth is not None:
        check_bandwidth(listed, bandwidth)
    report("choosing the velocity", 0.0)
    if bandwidth is None:
        bandwidth = chosen_bandwidth(listed, options)
    small = screening_set(listed, bandwidth)  # with its velocity, so that no trial derives it from thinned samples
    allowed, left_out = _allowed(add_ons, listed)
    bases = list(models) if models else [*(name for name in available_parts() if not part(name).add_on), *PAIRS]
    screened = screen_all(bases, small, allowed, seed, options, executor, lambda done: report("screening models", done))
    best = sorted((s.best for s in screened if np.isfinite(s.best.error)), key=lambda one: one.error)
    if not best:
        raise InputError(f"no model could be fitted; the first failed: {screened[0].bare.reason}")
    finals = [partial(judge, one.model, listed, seed, options | {"bandwidth": bandwidth}) for one in best[:finalists]]
    entries = parallel.run_all(finals, executor, lambda done: report("validating the best", done))
    ranked = with_criteria(sorted(entries, key=lambda one: (one.error, one.model)))
    return Leaderboard(tuple(ranked), tuple(screened), bandwidth, left_out, time.perf_counter() - begun)


def check_count(records: int) -> None:
    """Refuse too few records to choose a model by: each of five parts is to be predicted from the others."""
    if records < MIN_RECORDS:
        raise InputError(f"a leaderboard needs five records or more to fit, not {records}; name a model instead")


def _allowed(add_ons: Sequence[str], records: Sequence[Record]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The add-ons that these records can identify, and why others are left out."""
    varies = any(isinstance(r.voltage if r.input == "V" else r.current, np.ndarray) for r in records)
    if "lag" in add_ons and not varies:
        remaining = tuple(a for a in add_ons if a != "lag")
        return remaining, ("lag was not tried: the input is constant in every record, so nothing lags",)
    return tuple(add_ons), ()


def judge(model: str, records: list[Record], seed: int, options: dict[str, Any]) -> Entry:
    """One finalist on all records."""
    options = options | {"steps": FINAL_STEPS}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        validations = validations_of(model, records, min(5, len(records)), seed, options)
        begun = time.perf_counter()
        fit_result = fit(model, records, **options | {"fixed": held_in(model)})
    seconds = time.perf_counter() - begun
    scores = list(validations[0].scores.values())

    def mean(key: str) -> float:
        values = np.array([abs(getattr(one, key)) for one in scores])
        return float(np.nanmean(values)) if np.any(np.isfinite(values)) else float("nan")

    return Entry(
        model=model,
        error=validation_error(validations) if fit_result.damper is not None else float("inf"),
        l1=validations[0].error,
        nrmse=mean("nrmse"),
        pointwise=mean("pointwise"),
        energy=mean("energy"),
        unseen_input=validations[1].error if len(validations) > 1 else float("nan"),
        parameters=len(fit_result.parameters),
        seconds=seconds,
        converged=fit_result.converged,
        reason=fit_result.reason,
        validations=tuple(validations),
        fit=fit_result,
    )


def with_criteria(entries: list[Entry]) -> list[Entry]:
    """The entries with Akaike's and Schwarz's criteria, n being the effective samples of the first."""
    first = entries[0].fit
    if first is None:
        return entries
    n = first.residuals.effective
    done = []
    for one in entries:
        assert one.fit is not None
        samples = sum(p.t.size for p in one.fit.problem.pieces)
        fitted = n * float(np.log(2.0 * one.fit.outcome.cost / samples))
        aic, bic = fitted + 2.0 * one.parameters, fitted + one.parameters * float(np.log(n))
        done.append(replace(one, aic=aic, bic=bic))
    return done
