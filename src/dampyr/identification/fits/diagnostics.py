"""Diagnostics in words: the notes of a fit, and findings, warnings and trends of its residuals.

A trend is Spearman's rank correlation of a record's relative residual with its frequency or stroke, among the records at one
input, and with the input over all. Many are tried, so one counts only below a p of ``chance`` over the number tried
(Bonferroni): of a hundred campaigns without any trend, five or fewer report one.
The thresholds are those of `dampyr.identification.fit_thresholds.FitThresholds`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dampyr.findings import Finding
from dampyr.identification.fit_thresholds import FitThresholds
from dampyr.identification.fits.residuals import RecordResidual, ResidualGroup, Residuals
from dampyr.identification.parameter_uncertainty.uncertainty import MIN_CYCLES, Uncertainty
from dampyr.identification.parameter_uncertainty.uncertainty import MIN_RECORDS as MIN_INTERVAL_RECORDS
from dampyr.identification.scoring.scoring_window import loop_work
from dampyr.identification.search.optimum import Optimum
from dampyr.identification.search.problem import Problem
from dampyr.identification.search.variable_projection import Outcome
from dampyr.input_kinds import INPUTS, at_input
from dampyr.phrases import counted, listing


@dataclass(frozen=True)
class Trend:
    """How the relative residual goes with ``quantity`` ("frequency", "stroke", "input"), at one input or over all (None).

    ``rank`` is Spearman's correlation, ``p`` its probability by chance, ``counts`` whether that is small enough given how
    many trends were tried; ``confounded`` is the rank correlation of frequency and stroke among the same records.
    """

    quantity: str
    input_value: float | None
    rank: float
    p: float
    records: int
    confounded: float
    counts: bool


def trends(residuals: Residuals) -> tuple[Trend, ...]:
    """All trends that the records allow to try: five records or more, their values not all the same."""
    tried = []
    for group in residuals.groups:
        members = [r for r in residuals.records if r.name in set(group.records)]
        tried += [(name, group.input_value, members) for name in ("frequency", "stroke")]
    tried.append(("input", None, list(residuals.records)))
    least = residuals.thresholds.trend_records
    correlations = [trend for name, u, members in tried if (trend := _correlate(name, u, members, least)) is not None]
    # Bonferroni: of so many tries together, not of each, a share of ``chance`` finds a trend where there is none
    limit = residuals.thresholds.chance / max(len(correlations), 1)
    return tuple(Trend(*trend, counts=trend[3] <= limit) for trend in correlations)


def _correlate(
    name: str, u: float | None, members: Sequence[RecordResidual], least: int
) -> tuple[str, float | None, float, float, int, float] | None:
    from scipy.stats import spearmanr

    x = np.array([r.input_value if name == "input" else getattr(r, name) for r in members])
    y = np.array([r.relative for r in members])
    other = np.array([r.stroke if name == "frequency" else r.frequency for r in members])
    seen = np.isfinite(x) & np.isfinite(y)
    if seen.sum() < least or np.ptp(x[seen]) == 0.0 or np.ptp(y[seen]) == 0.0:
        return None
    rank, p = spearmanr(x[seen], y[seen])
    both = seen & np.isfinite(other)
    bound = float("nan")
    if name != "input" and both.sum() > 2 and np.ptp(other[both]) > 0.0:
        bound = float(spearmanr(x[both], other[both])[0])
    return name, u, float(rank), float(p), int(seen.sum()), bound


def findings(residuals: Residuals) -> tuple[str, ...]:
    """What the residuals show, one sentence each, without its full stop."""
    return (
        _describe_size(residuals),
        *_compare_directions(residuals),
        _describe_memory(residuals),
        *_describe_repetition(residuals),
        *_describe_trends(residuals),
    )


def residual_findings(residuals: Residuals) -> list[Finding]:
    """What a reader must know before trusting the numbers: residuals that differ between the directions, and misfit.

    A misfit beyond noise is a note, as the verdict says how large it is.
    """
    concerns = [Finding("doubt", text) for text in (*_describe_shifts(residuals), *_describe_unevenness(residuals))]
    if residuals.misfits:
        concerns.append(
            Finding(
                "note",
                f"the model misses more than noise in {len(residuals.misfits)} of {len(residuals.records)} records: the "
                "intervals describe the fit (how far it would move with other records of the same kind) and need not hold "
                "the truth",
            )
        )
    return concerns


def _describe_size(residuals: Residuals) -> str:
    relative = float(np.median([r.relative for r in residuals.records]))
    return (
        f"the residual is {residuals.whole.rms:.3g} N rms, in the median record {100 * relative:.2g} % of the force's "
        "spread; the "
        f"differences of successive samples allow for {residuals.noise:.2g} N of noise at most"
    )


def _compare_directions(residuals: Residuals) -> list[str]:
    out, back = residuals.whole.sides["out"], residuals.whole.sides["in"]
    if not (np.isfinite(out.rms) and np.isfinite(back.rms)):
        return []
    high, low = max(out.rms, back.rms), min(out.rms, back.rms)
    if high <= residuals.thresholds.alike * low:
        pair = f"{out.rms:.3g} N rms when the damper is pulled, {back.rms:.3g} N when pushed"
        return [f"the residual is alike in both directions: {pair}"]
    way = "pulled" if out.rms > back.rms else "pushed"
    return [f"the residual is larger when the damper is {way}: {high:.3g} N against {low:.3g} N rms"]


def _describe_memory(residuals: Residuals) -> str:
    if residuals.effective >= residuals.thresholds.independent * residuals.samples:
        count = (
            f"{_format_count(residuals.samples)} samples, effective sample size {_format_count(residuals.effective)}"
        )
        return f"successive residuals are nearly independent: {count}"
    factor = np.sqrt(residuals.samples / residuals.effective)
    return (
        f"residuals are correlated over {residuals.correlation_time:.2g} s: {_format_count(residuals.samples)} samples, "
        f"effective sample size {_format_count(residuals.effective)} at most, which alone makes naive errors {factor:.2g} "
        "times too small"
    )


def _format_count(number: float) -> str:
    """Two digits are enough for an estimate, with a space between thousands."""
    rounded = number if isinstance(number, int) else float(f"{number:.2g}")
    return f"{rounded:,.0f}".replace(",", "\N{NO-BREAK SPACE}")


def _describe_repetition(residuals: Residuals) -> list[str]:
    shares = [r.repeats for r in residuals.records if np.isfinite(r.repeats)]
    if not shares:
        return []
    share = float(np.median(shares))
    if share < residuals.thresholds.repeated:
        return ["little of it repeats from cycle to cycle"]
    return [
        f"{100 * share:.0f} % of its variance (the median record) comes again in each cycle: that is the model's shape and "
        "not noise, and no number of samples averages it out"
    ]


def _describe_trends(residuals: Residuals) -> list[str]:
    tried = trends(residuals)
    counting = [trend for trend in tried if trend.counts]
    # of frequency and stroke that go together one sentence tells both
    in_one_sentence = {t.input_value for t in counting if t.quantity == "frequency" and _is_confounded(t, residuals)}
    messages = [
        _describe_trend(trend, residuals)
        for trend in counting
        if not (trend.quantity == "stroke" and trend.input_value in in_one_sentence)
    ]
    if not tried or messages:
        return messages
    causes = "input, frequency" if residuals.unit in INPUTS else "frequency"
    return [f"the residual has no trend beyond chance with {causes} or stroke ({len(tried)} rank correlations tried)"]


def _describe_trend(trend: Trend, residuals: Residuals) -> str:
    unit = residuals.unit
    way = "grows" if trend.rank > 0 else "falls"
    where = "" if trend.input_value is None else at_input(trend.input_value, unit, "g", "at ") + " " * (unit in INPUTS)
    word = INPUTS.get(unit, "input") if trend.quantity == "input" else trend.quantity
    text = f"{where}the residual relative to the force {way} with {word} "
    text += f"(rank correlation {signed(trend.rank)}, p = {trend.p:.1g})"
    if not _is_confounded(trend, residuals):
        return text
    other = "stroke" if trend.quantity == "frequency" else "frequency"
    return f"{text}, or with {other}: in these records the two go together ({signed(trend.confounded)})"


def _is_confounded(trend: Trend, residuals: Residuals) -> bool:
    return abs(trend.confounded) >= residuals.thresholds.confounded  # NaN is not


def signed(value: float) -> str:
    """A correlation with two decimals and a true minus sign."""
    return f"{value:.2f}".replace("-", "−")


def _describe_shifts(residuals: Residuals) -> list[str]:
    """Inputs at which the mean differs between the directions by more than ``shifted`` of the rms."""
    messages = []
    for group in residuals.groups:
        out, back = group.sides["out"].mean, group.sides["in"].mean
        if abs(out - back) > residuals.thresholds.shifted * group.rms > 0.0:
            where = at_input(group.input_value, residuals.unit, "g", "at ")
            messages.append(
                f"{where}{' ' * bool(where)}the residual's mean differs between the directions: "
                f"{_format_force(out)} when the damper is pulled, {_format_force(back)} when pushed"
            )
    return messages


def _format_force(value: float) -> str:
    return f"{value:.3g} N".replace("-", "−")


def _describe_unevenness(residuals: Residuals) -> list[str]:
    """Inputs at which the even part has more than ``uneven`` of the variance, and clearly more than chance would give it.

    That is ``uneven_by_chance`` times as much, or ``uneven_surely`` of it: a long memory makes large shares likely, but none so
    large.
    """
    limits = residuals.thresholds
    odd = [
        group
        for group in residuals.groups
        if _compute_even_share(group)
        > max(limits.uneven, min(limits.uneven_by_chance * group.chance, limits.uneven_surely))
    ]
    if not odd:
        return []
    shares = sorted(100 * _compute_even_share(g) for g in odd)
    span = f"{shares[0]:.0f} to {shares[-1]:.0f}" if len(shares) > 1 else f"{shares[0]:.0f}"
    inputs = ", ".join(f"{g.input_value:g}" for g in odd)
    where = f"at {inputs} {residuals.unit}, " if residuals.unit in INPUTS else ""
    return [
        f"{where}{span} % of the residual's variance does not change its sign with the "
        "direction: the damper "
        "(or its motion) is not the same when pulled and when pushed, and this model does not follow that"
    ]


def _compute_even_share(group: ResidualGroup) -> float:
    """Of the residual's variance that is even."""
    return (group.asymmetry / group.rms) ** 2 if group.rms > 0.0 else 0.0


def notes(
    outcome: Outcome,
    uncertainty: Uncertainty,
    labels: list[str],
    within: Mapping[str, int],
    thresholds: FitThresholds,
) -> list[Finding]:
    """The notes of a fit: on the parameters (``within``: those of one or two records alone), on the motion, and on
    single records. What the numbers are not determined by is a doubt."""
    problem = outcome.optimum.problem
    doubts = [
        *_note_parameters(outcome, uncertainty, labels),
        *_note_motion(outcome.optimum, thresholds.sliding),
        *_note_resolution(problem, thresholds.resolved_steps),
    ]
    notes = [
        *_note_few_records(problem, uncertainty, labels, within, thresholds.few_cycles),
        *_note_twins(problem),
        *([problem.composition.not_for_buildings] if problem.composition.not_for_buildings else []),
        *_note_noisy_inputs(problem),
        *_note_smoothing(problem),
    ]
    return [*(Finding("doubt", text) for text in doubts), *(Finding("note", text) for text in notes)]


def _note_parameters(outcome: Outcome, uncertainty: Uncertainty, labels: list[str]) -> list[str]:
    limits = [c.quantity.range_in_words() for c in outcome.optimum.problem.columns for _ in range(c.size)]
    notes = [f"{labels[k]} stands at its limit ({limits[k]}); its error is not known" for k in outcome.at_limit]
    unidentifiable = [labels[k] for k in uncertainty.unidentifiable]
    if unidentifiable:
        notes.append(f"the records do not determine {', '.join(unidentifiable)} (infinite error)")
    if uncertainty.few:
        few = ", ".join(labels[k] for k in uncertainty.few)
        text = f"fewer than {MIN_CYCLES} cycles determine them; record more"
        notes.append(f"the errors of {few} are not known (infinite): {text}")
    errors = np.sqrt(np.diag(uncertainty.covariance))
    vague = [k for k in np.flatnonzero(errors > np.abs(outcome.point.theta)) if np.isfinite(errors[k])]
    if vague:
        notes.append(
            f"the error of {', '.join(labels[k] for k in vague)} is larger than the value: the records hardly determine it"
        )
    return notes


def explain_no_interval(count: int) -> str:
    """Why a number that only ``count`` records determine has no interval."""
    return f"between-record variance is not estimated from {counted(count, 'record')}"


def _note_few_records(
    problem: Problem, uncertainty: Uncertainty, labels: list[str], within: Mapping[str, int], least: int
) -> list[str]:
    """Errors that rest on the cycles of one or two records."""
    notes = []
    inputs = {round(float(np.mean(p.u)), 6) for p in problem.pieces}
    unit = problem.pieces[0].unit
    where = f" at {'this' if len(inputs) == 1 else 'each'} {INPUTS[unit]}" if unit in INPUTS else ""
    for count in sorted(set(within.values())):
        labels_of_count = [label for label in labels if within.get(label) == count]
        errors = "the errors" if len(labels_of_count) == len(labels) else f"the errors of {', '.join(labels_of_count)}"
        notes.append(
            f"{explain_no_interval(count)}: {errors} hold within these records only and give no 95 % interval; record "
            f"{MIN_INTERVAL_RECORDS} or more{where}"
        )
    few = min((int(uncertainty.counts[labels.index(label)]) for label in within), default=least)
    if few < least:
        notes.append(f"errors rest on {few} cycles only; they are rough")
    return notes


def _note_twins(problem: Problem) -> list[str]:
    """Parameters of which only the sum is seen, and which of them was held."""
    by_name = {c.name: c for c in problem.columns}
    return [
        f"{name} is held at 0, as {other} has the same effect and only their sum is seen; name it to free it"
        for name, other in problem.composition.twins.items()
        if by_name[name].fixed == 0.0 and by_name[other].size
    ]


def _note_motion(optimum: Optimum, sliding: float) -> list[str]:
    """Friction that never comes near its limit: only the slope of the loop is seen, the product of kw and rho."""
    problem = optimum.problem
    stroke = max(float(np.ptp(piece.x)) for piece in problem.pieces)
    notes = []
    values = dict(zip((c.name for c in problem.columns), optimum.point.of(problem), strict=True))
    for part in problem.composition.parts:
        if not {"kw", "rho"} <= set(part.parameters) or values[f"{part.name}.rho"].size == 0:
            continue
        reach = float(np.max(values[f"{part.name}.rho"])) * stroke
        if reach < sliding:
            notes.append(
                f"{part.name}: the motion never leaves pre-sliding (rho times the stroke is {reach:.2g}, sliding needs "
                f"{sliding:g} or more): kw and rho are known only as a product; use larger amplitudes"
            )
    return notes


def _note_resolution(problem: Problem, least: int) -> list[str]:
    notes = []
    for piece in problem.pieces:
        levels = np.unique(piece.x).size
        if levels < least:
            notes.append(
                f"{piece.name}: the displacement takes only {levels} values over {1e3 * float(np.ptp(piece.x)):.3g} mm; its "
                f"resolution hides the loop, so use an amplitude of {least} steps or more"
            )
    return notes


def _note_noisy_inputs(problem: Problem) -> list[str]:
    """Inputs that vary and have noise: where the laws end, and what the noise beyond counts as."""
    noisy = [(piece, piece.commanded) for piece in problem.pieces if piece.commanded is not None]
    if not noisy:
        return []
    unit, word = problem.pieces[0].unit, INPUTS[problem.pieces[0].unit]
    inputs = np.concatenate([np.ravel(piece.levels) for piece in problem.pieces])
    source = "plateaus" if all(command.plateaus for _, command in noisy) else "levels of the smoothed channel"
    return [
        f"the {word} of {listing([piece.name for piece, _ in noisy], 3)} varies and has noise (up to "
        f"{max(command.noise for _, command in noisy):.2g} {unit} rms): the laws end at the lowest and the highest of its "
        f"{source}, {inputs.min():.4g} and {inputs.max():.4g} {unit}, and what noise reaches beyond a record's ends counts as "
        "the end"
    ]


def _note_smoothing(problem: Problem) -> list[str]:
    """Moving averages that the records still hold: on the force they are put on the model's, on the motion they do harm."""
    forces = [piece.name for piece in problem.pieces if piece.average is not None]
    motions = [piece for piece in problem.pieces if piece.smoothed_motion > 0.0]
    notes = []
    if forces:
        notes.append(
            f"the measured force of {listing(forces, 3)} is smoothed, so the model's force goes through the same moving "
            "average before it is compared"
        )
    if motions:
        widest = max(piece.smoothed_motion for piece in motions)
        notes.append(
            f"the displacement of {listing([piece.name for piece in motions], 3)} is smoothed (over up to {widest:.3g} s) and "
            "that is not undone: the model runs on a motion that is less sharp than what the damper felt"
        )
    return notes


def explain_trouble(outcome: Outcome) -> str:
    """Why the numbers are no damper although the search has ended; empty where they are one."""
    problem = outcome.optimum.problem
    positive = np.concatenate([np.full(c.size, c.quantity.linear and c.quantity.low == 0) for c in problem.columns])
    friction = set(map(int, np.flatnonzero(positive)))
    if (
        friction
        and friction <= set(outcome.at_limit)
        and all(loop_work(piece.force, piece.x) < 0 for piece in problem.pieces)
    ):
        return (
            "every friction stands at its limit 0, because the loops create energy: the force sign is inverted; invert it "
            "where the records are read"
        )
    return ""
