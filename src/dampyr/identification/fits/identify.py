"""Identification as one job: the records in, a fit, its validations and the damper's card out.

The command line and the console both call `identify`; a choice that they offer (models, losses, splits) comes from `choices`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from multiprocessing import get_context
from typing import Any

from dampyr.argument_kinds import RECORDS, Argument, check_kinds
from dampyr.errors import InputError
from dampyr.findings import Finding, handed_on, worst_first
from dampyr.identification.fits.fit import Fit, fit
from dampyr.identification.fits.motion_coverage import beyond_the_fitted
from dampyr.identification.model_choice.leaderboard import BUDGET, Cut, Leaderboard, leaderboard
from dampyr.identification.model_choice.screening import held_in
from dampyr.identification.parameter_uncertainty.identifiability import Identifiability, identifiability
from dampyr.identification.parameter_uncertainty.levels import PRIOR_SESSION
from dampyr.identification.parameter_uncertainty.specimens import Specimens, fit_specimens
from dampyr.identification.scoring.score import Score, score
from dampyr.identification.scoring.scoring_window import SETTLING, check_settling, scorable
from dampyr.identification.scoring.splits import PARTS, split_tasks
from dampyr.identification.scoring.validation import Validation, cross_validate
from dampyr.identification.search.fit_data import WEIGHTINGS
from dampyr.identification.search.robust import LOSSES, check_loss
from dampyr.models import Damper, available_parts, compose
from dampyr.models.part import part
from dampyr.models.prediction_error import check_prior
from dampyr.origin import Origin, check_one_kind
from dampyr.records import Record, nominal_inputs
from dampyr.records.conditioning.velocity import check_bandwidth
from dampyr.shown import Shown

Progress = Callable[[str, float], None]

SPLITS = (*PARTS, "time")
HALF_WAY = 20.0  # steps after which a fit's progress stands at one half: most fits take 10 to 40

LOSS_WORDS = {
    "squares": "least squares",
    "huber": "Huber: robust against outliers",
    "l1": "L1: robust against outliers",
}
WEIGHTING_WORDS = {
    "records": "every record the same, however long",
    "samples": "every sample the same: long records count more",
}
SPLIT_WORDS = {
    "record": "random parts of the records",
    "input": "one input left out at a time, except the outer ones",
    "frequency": "parts in the order of frequency",
    "amplitude": "parts in the order of stroke",
    "waveform": "one kind of motion left out",
    "time": "the last 40 % of every motion",
}


@dataclass(frozen=True)
class IdentifyOptions:
    """Options of `identify`; without a ``model`` every model of the catalogue is tried, or those in ``tried``.

    ``predict`` names the splits to cross-validate by; the others are those of `dampyr.identification.fit`; ``budget``,
    ``nested`` and ``seconds`` are those of `dampyr.identification.leaderboard`. Raises :class:`~dampyr.errors.InputError` for
    a value that is not allowed.
    """

    model: str | None = None
    tried: tuple[str, ...] = ()
    laws: str | Mapping[str, str] | None = None
    fixed: Mapping[str, float] = field(default_factory=dict)
    bandwidth: float | None = None
    predict: tuple[str, ...] = ()
    loss: str = "squares"
    nuisances: tuple[str, ...] = ("offset", "state")
    tied: Mapping[str, str] | None = None
    starts: int = 1
    weighting: str = "records"
    settling: float = SETTLING
    budget: float | None = BUDGET
    nested: bool = False
    seconds: float | None = None
    session_prior: float = PRIOR_SESSION
    mixed_origins: bool = False

    def __post_init__(self) -> None:
        check_loss(self.loss)
        check_settling(self.settling)
        check_prior(self.session_prior)
        if self.weighting not in WEIGHTINGS:
            raise InputError(f"{self.weighting!r} is an unknown weighting; choose {' or '.join(WEIGHTINGS)}")
        for split in self.predict:
            if split not in SPLITS:
                raise InputError(f"{split!r} is not a split; choose {', '.join(SPLITS)}")
        if self.model is None and (self.fixed or self.tied):
            raise InputError(
                "fixed and tied parameters need a model: without one every model is tried; name one, such as dahl"
            )
        if self.model is not None and self.tried:
            raise InputError(
                "the models to try and a model exclude each other; name the models to try, or the one to fit"
            )
        for model in (self.model, *self.tried):
            if model is not None:
                compose(model)
        if self.budget is not None and not self.budget > 0:
            raise InputError(f"budget = {self.budget:g} s is not allowed; give work above 0")
        if self.seconds is not None and not self.seconds > 0:
            raise InputError(f"seconds = {self.seconds:g} is not allowed; give a time above 0")
        if self.starts < 1:
            raise InputError(f"starts = {self.starts} is not allowed; give 1 or more")

    @property
    def of_fit(self) -> dict[str, Any]:
        """The options of every `fit`."""
        shared = (
            "laws", "fixed", "bandwidth", "loss", "nuisances", "tied", "starts", "weighting", "settling", "session_prior",
            "mixed_origins",
        )  # fmt: skip
        return {name: getattr(self, name) for name in shared}


@dataclass(frozen=True, repr=False)
class Identified(Shown):
    """Result of `identify`: the ``fit``, its ``validations``, the ``board`` of models where none was named.

    ``predicted`` holds the scores of the records of the role "validation", or why one could not be predicted; ``beyond`` says
    which of them move more slowly or in smaller reversals than what was fitted (`dampyr.identification.fits.motion_coverage`).
    """

    fit: Fit
    validations: tuple[Validation, ...]
    board: Leaderboard | None
    predicted: Mapping[str, Score | str]
    validation_records: tuple[Record, ...] = ()
    beyond: Mapping[str, str] = field(default_factory=dict)

    @property
    def origin(self) -> Origin:
        """That of the fitted records."""
        return self.fit.origin

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """Those of the fit and of the records that were predicted, and which of these go beyond the fitted motions."""
        beyond = (Finding("doubt", words) for words in self.beyond.values())
        return worst_first(self.fit.findings, handed_on(self.validation_records), beyond)

    @property
    def damper(self) -> Damper | None:
        """The damper whose card is saved; its provenance says why its model was chosen. None where the fit made none."""
        if self.fit.damper is None or self.board is None:
            return self.fit.damper
        return replace(self.fit.damper, provenance=dict(self.fit.damper.provenance) | reasons_of_choice(self.board))

    @cached_property
    def identifiability(self) -> Identifiability:
        """What the fitted records cannot separate, and the test that would."""
        return identifiability(self.fit)

    @property
    def card(self) -> Damper:
        """The `damper`, or an :class:`~dampyr.errors.InputError` that says why there is none."""
        if self.damper is None:
            raise InputError(f"no card was written: {self.fit.reason}")
        return self.damper


def choices() -> dict[str, Any]:
    """Allowed values of the options: models, add-ons, and losses, weightings and splits with their words."""
    return {
        "models": [name for name in available_parts() if not part(name).add_on],
        "add_ons": [name for name in available_parts() if part(name).add_on],
        "losses": {name: LOSS_WORDS.get(name, name) for name in LOSSES},
        "weightings": {name: WEIGHTING_WORDS.get(name, name) for name in WEIGHTINGS},
        "splits": {name: SPLIT_WORDS.get(name, name) for name in SPLITS},
    }


def identify(
    records: Sequence[Record],
    options: IdentifyOptions | None = None,
    progress: Progress | None = None,
    workers: int = 1,
) -> Identified:
    """Identify a damper from records: fit a model, or the one that predicts best, and validate it.

    Measured inputs that are constant but for noise count as constants (`dampyr.records.nominal_inputs`). Records of the role
    "validation" are not fitted but predicted. ``progress`` is called with a stage and the fraction of it that is done;
    ``workers`` processes share the trials where every model is tried. A model that pairs two parts holds the parameters that
    one leaves to the other, as in the leaderboard, unless ``fixed``, ``laws`` or ``tied`` name them.

    Raises :class:`~dampyr.errors.InputError` for records or options that cannot be used, before anything is fitted; and
    `dampyr.identification.model_choice.leaderboard.Cut`, with what was finished, where a limit in seconds ended the search for
    a model.
    """
    check_kinds("identify", Argument("records", records, (Record,), RECORDS, several=True))
    options = options or IdentifyOptions()
    tell = progress or (lambda stage, done: None)
    nominal = nominal_inputs(records)
    fitted = [record for record in nominal if record.role != "validation"]
    others = [record for record in nominal if record.role == "validation"]
    check_records(fitted, others, options)
    board = None if options.model else _ranked(fitted, options, tell, workers)
    if board is not None and board.cut:
        raise Cut(board)
    beyond = beyond_the_fitted(fitted, others)
    fit_result, validations = _fitted(fitted, options, board, tell)
    return Identified(
        fit_result, validations, board, _predicted(fit_result, others, options.settling), tuple(others), beyond
    )


def identify_each(records: Sequence[Record], options: IdentifyOptions, progress: Progress | None = None) -> list[Fit]:
    """A fit of ``options.model`` to each record by itself."""
    if options.model is None:
        raise InputError("fits of single records need a model: without it every model is tried; name one, such as dahl")
    tell = progress or (lambda stage, done: None)
    nominal = nominal_inputs(records)
    _check_bandwidth(nominal, options)
    fits = []
    for k, record in enumerate(nominal):
        tell("identifying", k / len(nominal))
        fits.append(fit(options.model, record, **_held(options, options.model)))
    tell("identifying", 1.0)
    return fits


def identify_by_specimen(
    records: Sequence[Record], options: IdentifyOptions, progress: Progress | None = None
) -> Specimens:
    """Fits of ``options.model`` to the records of each specimen, and mean and spread over these: see `fit_specimens`.

    Inputs that agree between specimens but for noise count as one (`dampyr.records.nominal_inputs`); records of the role
    "validation" are left out.
    """
    if options.model is None:
        raise InputError("fits by specimen need a model: without it every model is tried; name one, such as dahl")
    nominal = nominal_inputs(records)
    fitted = [record for record in nominal if record.role != "validation"]
    _check_bandwidth(fitted, options)
    return fit_specimens(options.model, fitted, progress=progress, **_held(options, options.model))


def check_records(fitted: Sequence[Record], others: Sequence[Record], options: IdentifyOptions) -> None:
    """Refuse records that the options cannot be used on, before minutes of fitting."""
    if not fitted:
        what = "only validation records are chosen, and these are never fitted; choose" if others else "there are no"
        raise InputError(f"{what} {'some that are for fits' if others else 'records to fit; give one or more'}")
    if not options.mixed_origins:
        check_one_kind(fitted)
    if options.predict or options.model is None:
        scorable(fitted, options.settling)
    for split in options.predict:
        split_tasks(fitted, split)
    _check_bandwidth(fitted, options)


def reasons_of_choice(board: Leaderboard) -> dict[str, str]:
    """Why a model was chosen, for the provenance of a card: its error, and the runner-up with its own."""
    error, count, best = 100 * board.winner.error, len(board.screened), board.best
    words = f"the lowest validation error, {error:.3g} %, of {count} models"
    if board.winner is not best:
        words = (
            f"the simplest within one standard error of the lowest validation error of {count} models: "
            f"{error:.3g} %, against {100 * best.error:.3g} ± {100 * best.standard_error:.2g} % of {best.model}"
        )
    reasons = {"chosen": words}
    if board.runner_up:
        reasons["runner-up"] = f"{board.runner_up.model}, {100 * board.runner_up.error:.3g} %"
    return reasons


def _ranked(records: list[Record], options: IdentifyOptions, tell: Progress, workers: int) -> Leaderboard:
    with _executor(workers) as executor:
        models = list(options.tried) or None
        return leaderboard(
            records,
            models,
            executor=executor,
            progress=tell,
            budget=options.budget,
            nested=options.nested,
            seconds=options.seconds,
            **options.of_fit,
        )


@contextmanager
def _executor(workers: int) -> Iterator[Executor | None]:
    if workers <= 1:
        yield None
        return
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as executor:
        yield executor


def _fitted(
    records: list[Record], options: IdentifyOptions, board: Leaderboard | None, tell: Progress
) -> tuple[Fit, tuple[Validation, ...]]:
    """The fit to all records, and the validations by the splits that are named; of a leaderboard the winner's."""
    model = board.winner.model if board else options.model
    assert model is not None
    of_fit = _held(options, model) | ({"bandwidth": board.bandwidth} if board else {})
    fit_result = board.winner.fit if board else None
    if fit_result is None:
        tell("identifying", 0.0)
        fit_result = fit(
            model, records, **of_fit, progress=lambda step, _: tell("identifying", step / (step + HALF_WAY))
        )
        tell("identifying", 1.0)
    validations = list(board.winner.validations) if board else []
    for split in options.predict:
        if all(one.split != split for one in validations):

            def share(done: float, split: str = split) -> None:
                tell(f"predicting by {split}", done)

            validations.append(cross_validate(model, records, split, progress=share, **of_fit))
    return fit_result, tuple(validations)


def _held(options: IdentifyOptions, model: str) -> dict[str, Any]:
    """The options of `fit`, with what a pair of parts within ``model`` holds unless an option names it."""
    laws = options.laws if isinstance(options.laws, Mapping) else {}
    named = {*options.fixed, *laws, *(options.tied or {}), *(options.tied or {}).values()}
    held = {name: value for name, value in held_in(model).items() if name not in named}
    return options.of_fit | {"fixed": held | dict(options.fixed)}


def _check_bandwidth(records: Sequence[Record], options: IdentifyOptions) -> None:
    if options.bandwidth is not None:
        check_bandwidth(records, options.bandwidth)


def _predicted(fit_result: Fit, records: Sequence[Record], settling: float) -> dict[str, Score | str]:
    """How well the damper predicts validation records, or why it cannot."""
    if fit_result.damper is None:
        return {}
    scores: dict[str, Score | str] = {}
    for record in records:
        try:
            scores[record.name] = score(fit_result.damper, record, settling)
        except InputError as problem:
            scores[record.name] = str(problem)
    return scores
