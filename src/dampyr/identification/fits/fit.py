"""Identification as one job: `fit` takes records, fits a model or chooses one, and predicts what was not fitted."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from typing import Any

import numpy as np

from dampyr.argument_kinds import RECORDS, Argument, check_kinds
from dampyr.errors import InputError
from dampyr.findings import Finding
from dampyr.identification.fits.fit_options import BUDGET, FitOptions
from dampyr.identification.fits.least_squares import check_fittable, fit_model, read_and_check
from dampyr.identification.fits.motion_coverage import list_motions_beyond
from dampyr.identification.fits.result import Fit
from dampyr.identification.model_choice.channel_delay import list_channel_delays
from dampyr.identification.model_choice.leaderboard import Leaderboard, leaderboard
from dampyr.identification.model_choice.missing_effect import list_missing_effects, rank_effects
from dampyr.identification.model_choice.parameter_laws import hold_pairs, with_constant
from dampyr.identification.scoring.score import score_or_reason
from dampyr.identification.scoring.scoring_window import list_unscorable
from dampyr.identification.scoring.splits import split_tasks
from dampyr.identification.scoring.validation import Validation, cross_validate
from dampyr.models import Damper, compose
from dampyr.models.codegen.composition import Composition
from dampyr.models.part import part
from dampyr.options import takes
from dampyr.origin import check_one_kind
from dampyr.phrases import counted
from dampyr.records import Record, nominal_inputs
from dampyr.records.conditioning.velocity import check_bandwidth
from dampyr.records.files.campaign_folder import RecordsOrPaths, as_records

Progress = Callable[[str, float], None]

HALF_WAY = 20.0  # steps after which a fit's progress stands at one half: most fits take 10 to 40


@takes(FitOptions)
def fit(
    records: RecordsOrPaths,
    model: str | Composition | Damper | None = None,
    options: FitOptions | None = None,
    progress: Progress | None = None,
    executor: Executor | None = None,
    **keywords: Any,
) -> Fit:
    """Identify a damper from records by least squares over their whole motion, and predict what was not fitted.

    Measured inputs that are constant but for noise count as constants (`dampyr.records.nominal_inputs`). Every record has an
    offset of its force and initial states of its own; its residual counts over the standard deviation of its force. Records of
    the role "validation" are not fitted but predicted (``predicted`` of the result).

    Parameters
    ----------
    records
        one record, or several for a joint fit; or the files or folders that hold them (`dampyr.records.read_records`, which
        takes what a file does not say itself).
    model
        parts of the catalogue, such as ``"dahl"`` or ``"dahl + spring + delay"``, or a damper of the same make. Without it
        the model is chosen that best predicts records and inputs that it was not fitted on, which takes minutes
        (`dampyr.identification.Leaderboard`; ``leaderboard`` of the result). Of parts of which only the sum is seen, such as
        the dashpots of ``"dahl + hyperbolic_tangent"``, all but the first are held at 0, unless ``laws``, ``fixed`` or
        ``tied`` name them, and ``findings`` say so.
    options
        the further arguments as one object; those that are given by name take their places. Besides those below,
        ``thresholds`` (`dampyr.identification.fit_thresholds.FitThresholds`) say from which value on something is a finding.
    progress
        called with what is being done, and the fraction of it that is done.
    executor
        shares the trials of a choice of models among processes, such as
        ``ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn"))``; the result is the same to the last digit.

    Returns
    -------
    Fit
        also where the search did not converge: ``converged`` and ``reason`` say so. Where the model misses more than
        ``thresholds.unexplained`` of the force (L1 ratio), ``findings`` say which effect may be missing: those of
        `dampyr.identification.model_choice.missing_effect` are tried, which takes a second, or half a minute where the models
        are compiled first. Where the force was sampled later or earlier than the displacement, they say by how much
        (`dampyr.identification.model_choice.channel_delay`).

    Raises
    ------
    InputError
        a record without input, without motion, with a constant force, or of mixed inputs; simulated records among others; an
        unknown name or law; a bandwidth that a record's samples do not carry; all before anything is fitted.
    SearchTimedOut
        ``seconds`` ended the search for a model (`dampyr.identification.model_choice.leaderboard`); ``board`` is what was
        finished.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> damper = dp.studies.raminelli_2020.damper()
    >>> t = np.linspace(0.0, 4.0, 801)
    >>> x = 0.008 * np.sin(2 * np.pi * t)
    >>> record = dp.records.Record(t, x, damper.force(t, x, voltage=1.98), voltage=1.98)
    >>> fit = dp.identification.fit(record, "dahl")
    >>> fit.converged, {name: float(f"{value:.4g}") for name, value in fit.parameters.items()}
    (True, {'dahl.kx': 2576.0, 'dahl.kw': 380.6, 'dahl.rho': 13530.0})
    """
    if model is None:
        records = as_records(records)
        check_kinds("fit", Argument("records", records, (Record,), RECORDS, several=True))
    else:
        records = read_and_check("fit", records, model)
    chosen = FitOptions.of("fit", options, keywords)
    chosen.check_of_model(model)
    nominal = nominal_inputs(records)
    fitted = [record for record in nominal if record.role != "validation"]
    others = [record for record in nominal if record.role == "validation"]
    check_records(fitted, others, model, chosen)
    beyond = list_motions_beyond(fitted, others, chosen.thresholds)
    tell = progress or (lambda stage, done: None)
    board = None
    if model is None:
        if progress is None:
            print(_announce_search(fitted, chosen), file=sys.stderr)
        board = leaderboard(fitted, chosen, executor, progress)
        model, chosen = board.winner.model, replace(chosen, bandwidth=board.bandwidth, models=())
        chosen = with_constant(chosen, board.winner.constant)
    chosen = hold_pairs(chosen, model)
    result = board.winner.fit if board else None
    if result is None:
        tell("identifying", 0.0)
        result = fit_model(model, fitted, chosen, lambda step, _: tell("identifying", step / (step + HALF_WAY)))
        tell("identifying", 1.0)
    tell("scoring the fit", 0.0)
    remarks = [*_explain_misfit(result, chosen, board is not None, tell), *(_mind_called_parts(board) if board else [])]
    result = replace(result, remarks=(*result.remarks, *remarks))
    damper = result.damper
    return replace(
        result,
        leaderboard=board,
        validations=_validate_splits(fitted, model, chosen, board, tell),
        predicted={} if damper is None else {r.name: score_or_reason(damper, r, chosen.settling) for r in others},
        validation_records=tuple(others),
        beyond=beyond,
    )


def _explain_misfit(result: Fit, options: FitOptions, chosen: bool, tell: Progress) -> list[Finding]:
    """What may be missing where a fit misses more than `FitThresholds.unexplained` of the force, and delays of its channels."""
    limit, rough = options.thresholds.unexplained, 0.0
    delays = list_channel_delays(result, options)
    # of all that was fitted, in a hundredth of the time of the scores: a fit that is so good by it is good by them
    for piece, rest in zip(result.problem.pieces, result.optimum.residuals, strict=True):
        force = piece.force[piece.comparable]
        size = float(np.mean(np.abs(force - np.mean(force))))
        rough = max(rough, float(np.mean(np.abs(rest))) / size if size > 0.0 else math.inf)
    if rough <= 0.3 * limit or np.mean([score.l1 for score in result.scores.values()]) <= limit:
        return [delay.finding for delay in delays]
    effects = list_missing_effects(result, options, chosen, lambda done: tell("looking for what is missing", done))
    of_records = [effect for effect in effects if not np.isfinite(effect.l1)]
    return [effect.finding for effect in of_records or rank_effects([*delays, *effects])[:1]]


def _mind_called_parts(board: Leaderboard) -> list[Finding]:
    """Why a part that was chosen unnamed is usually tried by name only."""
    chosen = compose(board.winner.model).names
    return [
        Finding("doubt", f"{found.name} was chosen without being named; mind that {part(found.name).not_tried}")
        for found in board.called
        if found.name in chosen
    ]


def check_records(
    fitted: Sequence[Record], others: Sequence[Record], model: str | Composition | Damper | None, options: FitOptions
) -> None:
    """Refuse records that the options cannot be used on, before minutes of fitting."""
    if not fitted:
        if others:
            raise InputError(
                "only validation records are chosen, and these are never fitted; choose some that are for fits"
            )
        raise InputError("there are no records to fit; give one or more")
    check_fittable(fitted)
    if not options.mixed_origins:
        check_one_kind(fitted)
    if options.predict or model is None:
        list_unscorable(fitted, options.settling)
    for split in options.predict:
        split_tasks(fitted, split, options.folds, options.seed)
    if options.bandwidth is not None:
        check_bandwidth(fitted, options.bandwidth)


def _announce_search(records: Sequence[Record], options: FitOptions) -> str:
    """What a fit without a model is about to do, and how long it takes, for a caller who watches no progress."""
    models = counted(len(options.models), "model") if options.models else "every model of the catalogue"
    work = BUDGET if options.budget is None else options.budget
    return (
        f"dampyr: no model is named, so {models} will be tried, with add-ons, on {counted(len(records), 'record')}, to choose "
        f"what predicts best: up to about {work / 60:.0f} min of one core. Name a model to fit that one alone, as in "
        "fit(records, 'dahl'); progress= shows how far the search is, executor= shares it among processes."
    )


def _validate_splits(
    records: list[Record],
    model: str | Composition | Damper,
    options: FitOptions,
    board: Leaderboard | None,
    tell: Progress,
) -> tuple[Validation, ...]:
    """The validations by the splits that are named; of a leaderboard those of the winner too."""
    validations = list(board.winner.validations) if board else []
    for split in options.predict:
        if all(validation.split != split for validation in validations):

            def report(done: float, split: str = split) -> None:
                tell(f"predicting by {split}", done)

            validations.append(cross_validate(records, model, split, options, report))
    return tuple(validations)
