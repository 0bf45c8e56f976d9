r"""What the records of a fit cannot separate, and the test that would.

*Pairs.* Two numbers whose effects on the force look alike on these motions trade against each other: in the information of the
records (the nuisances eliminated) their correlation r is beyond ``trading`` of the fit's thresholds, and each interval is
:math:`1/\sqrt{1 - r^2}` times as wide as if the other were known. The fit's clustered errors with and without the other say
the same from how the records scatter; of few records that is rough. For each pair, motions that the same drive could make are
tried: the information that the model expects from one more record of each, counted as the other records are, is added, and the
motion that narrows both intervals most is proposed.

*Amplitude and frequency* that go together leave open whether a residual, or a parameter, follows one or the other. *Voltage and
measurement session* cannot be told apart where every input was measured in a session of its own: what changed between two days
then looks like a law. *Not determined*: numbers without an error, at a limit, or of too few records.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from dampyr.identification.fits.diagnostics import signed
from dampyr.identification.fits.residuals import motion
from dampyr.identification.fits.result import Fit
from dampyr.identification.parameter_uncertainty.candidate_motions import (
    PEAK,
    CandidateMotion,
    candidate_motions,
    measure_reach,
)
from dampyr.identification.parameter_uncertainty.profile_likelihood import scaled_inverse
from dampyr.identification.parameter_uncertainty.uncertainty import MIN_RECORDS, uncertainty
from dampyr.identification.search.fit_data import Piece
from dampyr.identification.search.normal_equations import linearise, modelled_force
from dampyr.identification.search.optimum import Optimum
from dampyr.identification.search.problem import Problem, SearchPoint
from dampyr.input_kinds import INPUTS, NO_INPUT, at_input
from dampyr.phrases import counted, listing
from dampyr.records import Record
from dampyr.shown import Shown

Array = NDArray[np.float64]
MAX_PAIRS = 12  # that are looked into, the strongest first
WORTH = 0.9  # of the width that another record like those at hand would leave: less of a gain is not worth a new motion
SIMPLER = 1.1  # times the width of the best motion that a sine may leave and still be proposed
BEYOND = (2.0, 5.0)  # times the stroke: where nothing inside it determines a direction
SINGULAR = 1e-9  # of the largest eigenvalue of the scaled information: below it a direction is not determined
DETERMINED = 1e-6  # of it: above it a direction is determined, if not well
PART = 0.1  # of a direction's length: a number with less of it takes no part
MIN_TRIED = 4  # records of a rank correlation of amplitude and frequency
SESSION_FINDING = "input and session"
INPUTS_TRIED = 5  # at most, of which motions are tried where records at several inputs share numbers


@dataclass(frozen=True)
class Inseparable:
    """Something that the records cannot separate, or do not determine.

    ``kind`` is "pair", "not determined", "at a limit", "few records", "amplitude and frequency" or "input and session";
    ``labels`` the numbers of the fit it is about; ``words`` and ``test`` one sentence each without a full stop, ``brief``
    both in a line, ``numbers`` what they rest on.
    """

    kind: str
    labels: tuple[str, ...]
    words: str
    test: str
    brief: str
    numbers: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, repr=False)
class Identifiability(Shown):
    """Result of `identifiability`: what is ``inseparable``, worst first of each kind; none where everything is separated."""

    inseparable: tuple[Inseparable, ...]

    @property
    def lines(self) -> tuple[str, ...]:
        """A short line for each finding."""
        return tuple(finding.brief for finding in self.inseparable)


def identifiability(fit: Fit) -> Identifiability:
    """What the records of a fit cannot separate, how bad that is, and the test that would separate it.

    The correlations and widths are those of the fitted model; where the model misses the damper's behaviour they describe the
    model.
    """
    return Identifiability(
        (
            *_list_undetermined(fit),
            *_list_pairs(fit),
            *_compare_amplitude_with_frequency(fit),
            *_compare_input_with_session(fit),
        )
    )


# ----------------------------------------------------------------------------------------------------------------- numbers


def _list_undetermined(fit: Fit) -> list[Inseparable]:
    """Directions of each block that the records do not determine, numbers at limits, and numbers of few records."""
    labels, results = list(fit.parameters), list[Inseparable]()
    limits = [label for label, error in fit.stderr.items() if math.isnan(error)]
    if limits:
        names = f"{listing(limits, 4)} {'stands' if len(limits) == 1 else 'stand'} at the limit"
        test = "use a model without that part, or motions on which it acts"
        results.append(
            Inseparable("at a limit", tuple(limits), f"{names} of the allowed values", test, f"{names}: {test}")
        )
    for block in fit.optimum.blocks:
        own_labels = [labels[place] for place in block.places]
        if any(math.isinf(fit.stderr[label]) for label in own_labels):
            results += _list_directions(fit, block, own_labels)
    few = list(fit.within_records)
    if few:
        count = min(fit.within_records.values())
        by = f"{counted(count, 'record')} {'determines' if count == 1 else 'determine'}"
        text = f"how records differ is not known for {listing(few, 4)}, which {by}"
        unit = fit.problem.pieces[0].unit
        test = f"record {MIN_RECORDS} or more" + (f" at each {INPUTS[unit]}" if unit in INPUTS else "")
        brief = f"{by} {listing(few, 3)}: {test}"
        results.append(Inseparable("few records", tuple(few), text, test, brief, {"records": float(count)}))
    return results


def _list_directions(fit: Fit, block: Optimum, labels: list[str]) -> list[Inseparable]:
    """The directions without information, by the numbers that take part in them."""
    H = block.information
    scale = np.sqrt(np.maximum(np.diag(H), 0.0))
    alone = [
        k for k in range(len(labels)) if scale[k] <= math.sqrt(SINGULAR) * max(float(scale.max(initial=0.0)), 1e-300)
    ]
    results = [_describe_undetermined(fit, block, (labels[k],)) for k in alone]
    rest = [k for k in range(len(labels)) if k not in alone]
    if rest:
        unit = np.outer(scale[rest], scale[rest])
        values, vectors = np.linalg.eigh(H[np.ix_(rest, rest)] / unit)
        for value, direction in zip(values, vectors.T, strict=True):
            if value <= SINGULAR * float(values.max()):
                results.append(
                    _describe_undetermined(
                        fit, block, tuple(labels[rest[k]] for k in np.flatnonzero(np.abs(direction) > PART))
                    )
                )
    named = {label for finding in results for label in finding.labels}
    missing = [label for label in labels if math.isinf(fit.stderr[label]) and label not in named]
    if missing:
        text = f"{listing(missing, 4)} {'has' if len(missing) == 1 else 'have'} no error: too few cycles determine them"
        test = "record longer tests"
        results.append(Inseparable("not determined", tuple(missing), text, test, f"{text}: {test}"))
    return results


def _describe_undetermined(fit: Fit, block: Optimum, labels: tuple[str, ...]) -> Inseparable:
    """Numbers of which the records determine at most a combination, and the first motion that would determine them."""
    names = listing(list(labels), 4)
    combined = f"only a combination of {names} is determined"
    text = combined if len(labels) > 1 else f"the records do not determine {names}"
    places = [block.places.index(list(fit.parameters).index(label)) for label in labels]
    for beyond in (1.0, *BEYOND):
        (candidates,) = _weigh_candidates(fit.optimum, [block], beyond)
        shares = [_measure_determination(block.information + candidate.information, places) for candidate in candidates]
        best, share = max(zip(candidates, shares, strict=True), key=lambda pair: pair[1])
        if share > DETERMINED:
            more = "" if beyond == 1.0 else f", {beyond:g} times the stroke of these records,"
            at = f"{best.motion.in_words()}{at_input(best.input, block.problem.pieces[0].unit, 'g')}{more}"
            return Inseparable("not determined", labels, text, f"{at} would", f"{text}; test {at}")
    test = "none of the motions that were tried would: fix one of them (fixed=)"
    return Inseparable("not determined", labels, text, test, f"{text}; fix one of them")


def _measure_determination(information: Array, places: list[int]) -> float:
    """How well numbers are determined: the smallest eigenvalue of their scaled information, or its share where it is one."""
    d = np.sqrt(np.maximum(np.diag(information), 1e-300))
    if len(places) == 1:
        return float(d[places[0]] / d.max()) ** 2
    return float(np.linalg.eigvalsh((information / np.outer(d, d))[np.ix_(places, places)]).min())


def _list_pairs(fit: Fit) -> list[Inseparable]:
    """Pairs of numbers that trade against each other on these motions."""
    labels, pairs = list(fit.parameters), list[_Pair]()
    for block in fit.optimum.blocks:
        usable = [k for k, place in enumerate(block.places) if math.isfinite(fit.stderr[labels[place]])]
        r = _correlate(scaled_inverse(block.information[np.ix_(usable, usable)]))
        alike = [(i, j) for j in range(len(usable)) for i in range(j) if abs(r[i, j]) >= fit.thresholds.trading]
        pairs += [_Pair(block, usable, places, float(r[places])) for places in alike]
    pairs = sorted(pairs, key=lambda pair: -abs(pair.correlation))[:MAX_PAIRS]
    blocks = [block for block in fit.optimum.blocks if any(pair.block is block for pair in pairs)]
    candidates = dict(zip(blocks, _weigh_candidates(fit.optimum, blocks), strict=True))
    return [_describe_pair(fit, pair, candidates[pair.block]) for pair in pairs]


def _correlate(covariance: Array) -> Array:
    d = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    return np.asarray(covariance / np.outer(d, d))


@dataclass(frozen=True)
class _Pair:
    """Two numbers of a block, their ``places`` among the ``usable`` ones, which have an error, and their ``correlation``."""

    block: Optimum
    usable: list[int]
    places: tuple[int, int]
    correlation: float


def _describe_pair(fit: Fit, pair: _Pair, candidates: list[_Candidate]) -> Inseparable:
    labels, block, r = list(fit.parameters), pair.block, pair.correlation
    a, b = (pair.usable[place] for place in pair.places)
    places = block.places[a], block.places[b]
    first, second = (labels[place] for place in places)
    between = float(fit.correlation[places])
    held = tuple(k for k in range(len(block.places)) if k not in pair.usable)
    wider = [_measure_widening(fit, block, (*held, fixed), k) for k, fixed in ((a, b), (b, a))]
    alone = 1.0 / math.sqrt(max(1.0 - r**2, 1e-12))
    of_errors = f", {signed(between)} by the records' scatter" if math.isfinite(between) else ""
    text = (
        f"{first} and {second} trade against each other on these motions (correlation {signed(r)}{of_errors}): each interval "
        f"is {alone:.2g} times as wide as if the other were known ({wider[0]:.2g} and {wider[1]:.2g} times by this fit's "
        "errors)"
    )
    numbers = {
        "correlation": r,
        "correlation_of_errors": between,
        "wider": alone,
        f"wider {first}": wider[0],
        f"wider {second}": wider[1],
    }
    brief = f"{first} and {second}: correlation {signed(r)}, each interval {alone:.2g} times as wide as with the other known"
    best = _choose_test(pair, candidates)
    if best is None:
        test = "no motion that was tried within the stroke and speed of these records would do more than a repeat"
        return Inseparable("pair", (first, second), text, test, brief, numbers)
    candidate, after, narrower, repeated = best
    tried, u = candidate.motion, candidate.input
    at = tried.in_words() + at_input(u, block.problem.pieces[0].unit, "g")
    less, by_repeat = [f"{100 * (1 - width):.0f}" for width in narrower], f"{100 * (1 - repeated):.0f} %"
    test = (
        f"{at} would: correlation {signed(after)}, intervals narrower by {less[0]} and {less[1]} % ({by_repeat} by one more "
        "test like these)"
    )
    brief += f"; {at} would narrow them by {less[0]} and {less[1]} %"
    numbers |= {
        **({"input": u} if block.problem.pieces[0].unit != NO_INPUT else {}),
        "amplitude": tried.amplitude,
        "frequency": tried.frequency,
        "correlation_with_the_test": after,
        f"narrower {first}": narrower[0],
        f"narrower {second}": narrower[1],
        "narrower by a repeat": repeated,
    }
    return Inseparable("pair", (first, second), text, test, brief, numbers)


def _measure_widening(fit: Fit, block: Optimum, held: tuple[int, ...], k: int) -> float:
    """The fit's standard error of the number ``k`` of a block over what it would be with those ``held`` known."""
    alone = float(np.sqrt(uncertainty(block, held).covariance[k, k]))
    return fit.stderr[list(fit.parameters)[block.places[k]]] / alone if alone > 0.0 else math.nan


def _choose_test(
    pair: _Pair, candidates: list[_Candidate]
) -> tuple[_Candidate, float, tuple[float, float], float] | None:
    """The test that narrows both intervals most: the correlation after it, what is left of both widths, and what one more
    record like those at hand leaves; None where it narrows them little more than that."""
    chosen, records = np.ix_(pair.usable, pair.usable), len(pair.block.problem.pieces)
    before = np.sqrt(np.diag(scaled_inverse(pair.block.information[chosen])))
    repeated = math.sqrt(records / (records + 1.0))
    best: tuple[float, _Candidate, float, tuple[float, float]] | None = None
    for candidate in candidates:
        after = scaled_inverse((pair.block.information + candidate.information)[chosen])
        left = (np.sqrt(np.diag(after)) / before)[list(pair.places)]
        score = float(np.sqrt(left[0] * left[1]))
        if candidate.motion.kind != "sine":  # every drive makes a sine
            score *= SIMPLER
        if best is None or score < best[0]:
            best = score, candidate, float(_correlate(after)[pair.places]), (float(left[0]), float(left[1]))
    if best is None or best[0] >= WORTH * repeated:
        return None
    return *best[1:], repeated


@dataclass(frozen=True)
class _Candidate:
    """A motion that could be tested at an ``input``, and the ``information`` (G, G) of one record of it on its block."""

    motion: CandidateMotion
    input: float
    information: Array


def _weigh_candidates(optimum: Optimum, blocks: Sequence[Optimum], beyond: float = 1.0) -> list[list[_Candidate]]:
    """The tests that could be made for each of some blocks, linearised all together.

    A record of each counts as those at hand do, its nuisances are eliminated. ``beyond`` as in `candidate_motions`.
    """
    tests = [(block, tried, u) for block in blocks for tried, u in _list_motions_and_inputs(block.problem, beyond)]
    pieces = [_make_piece(block.problem, tried, u) for block, tried, u in tests]
    if not pieces:
        return []
    problem = replace(optimum.problem, pieces=pieces)
    start = SearchPoint(optimum.point.theta, np.zeros((len(pieces), problem.locals)))
    forces = [modelled_force(problem, start, r) for r in range(len(pieces))]
    spreads = [float(np.std(force)) for force in forces]
    usable = [r for r, spread in enumerate(spreads) if math.isfinite(spread) and spread > 0.0]
    information = np.zeros((len(pieces), problem.size, problem.size))
    if usable:
        weighted = [
            replace(pieces[r], force=forces[r], spread=spreads[r], weight=pieces[r].weight / spreads[r]) for r in usable
        ]
        start = SearchPoint(start.theta, start.local[usable])
        information[usable] = linearise(replace(problem, pieces=weighted), start).reduced.by_record
    candidates: dict[Optimum, list[_Candidate]] = {block: [] for block in blocks}
    for (block, tried, u), added in zip(tests, information, strict=True):
        candidates[block].append(_Candidate(tried, u, added[np.ix_(block.places, block.places)]))
    return list(candidates.values())


def _list_motions_and_inputs(problem: Problem, beyond: float) -> list[tuple[CandidateMotion, float]]:
    """Motions and inputs that are tried for a block."""
    inputs = sorted({round(float(np.mean(piece.u)), 6) for piece in problem.pieces})
    if len(inputs) > INPUTS_TRIED:
        inputs = [inputs[k] for k in np.unique(np.linspace(0, len(inputs) - 1, INPUTS_TRIED).round().astype(int))]
    exact = {round(float(np.mean(piece.u)), 6): piece.u for piece in problem.pieces if not np.ndim(piece.u)}
    motions = list(candidate_motions(measure_reach(problem.pieces), beyond))
    return [(tried, float(exact.get(u, u))) for u in inputs for tried in motions]


def _make_piece(problem: Problem, motion: CandidateMotion, u: float) -> Piece:
    """A motion as a record of a block whose force spreads by 1 N, with the median weight of the block's records."""
    n = motion.t.size
    whole = float(np.median([np.mean(piece.weight**2) * piece.spread**2 * piece.count for piece in problem.pieces]))
    return Piece(
        name="candidate",
        t=motion.t,
        x=motion.x,
        v=motion.v,
        force=np.zeros(n),
        u=u,
        weight=np.array([math.sqrt(whole / n)]),
        spread=1.0,
        cycle=np.zeros(n, dtype=np.int64),
        unit=problem.pieces[0].unit,
        temperature=float(np.mean([piece.temperature for piece in problem.pieces])),
    )


# ----------------------------------------------------------------------------------------------------------------- design


def _compare_amplitude_with_frequency(fit: Fit) -> list[Inseparable]:
    """The inputs at which amplitude and frequency of the records go together."""
    from scipy.stats import spearmanr

    groups: dict[float, list[tuple[float, float]]] = {}
    for record in fit.records:
        stroke, frequency = motion(record)
        if math.isfinite(frequency):
            groups.setdefault(_round_input(record), []).append((0.5 * stroke, frequency))
    bound: dict[float, float] = {}
    for u, sizes in groups.items():
        table = np.log(np.array(sizes))
        if len(sizes) >= MIN_TRIED and np.all(np.ptp(table, axis=0) > 0.0):
            r = float(spearmanr(table[:, 0], table[:, 1])[0])
            if abs(r) >= fit.thresholds.confounded:
                bound[u] = r
    if not bound:
        return []
    unit, worst = fit.problem.pieces[0].unit, max(bound, key=lambda u: abs(bound[u]))
    tested = np.array(groups[worst])
    # The smallest stroke at the lowest frequency is slower than anything that was tested, so the drive can make it.
    frequency = float(tested[:, 1].min() if bound[worst] < 0.0 else tested[:, 1].max())
    amplitude = float(tested[:, 0].min())
    more = np.vstack((tested, [[amplitude, frequency]] * 2))
    after = float(spearmanr(more[:, 0], more[:, 1])[0])
    where = f"{listing([f'{u:.4g}' for u in sorted(bound)], 8)} {unit}"
    rank = f"rank correlation {signed(bound[worst])}"
    text = (
        f"amplitude and frequency go together at {where} ({rank} at {worst:.4g} {unit}): what looks like an effect of one may "
        "be an effect of the other"
    )
    at = f"a sine of ±{1e3 * amplitude:.3g} mm, {frequency:.3g} Hz, at {worst:.4g} {unit}"
    edge = "lowest" if bound[worst] < 0.0 else "highest"
    test = (
        f"tests off that line would, such as two of {at} (the smallest stroke at the {edge} frequency; rank correlation "
        f"{signed(after)} with them)"
    )
    brief = f"amplitude and frequency at {where}: {rank}; test {at}"
    numbers = {
        "correlation": bound[worst],
        "input": worst,
        "amplitude": amplitude,
        "frequency": frequency,
        "correlation_with_the_test": after,
    }
    return [Inseparable("amplitude and frequency", (), text, test, brief, numbers)]


def _compare_input_with_session(fit: Fit) -> list[Inseparable]:
    """Inputs that share no measurement session, directly or through others."""
    unit, kind = fit.problem.pieces[0].unit, SESSION_FINDING
    if unit == NO_INPUT:
        return []
    word = INPUTS[unit]
    fitted = zip(fit.records, fit.problem.pieces, strict=True)
    records = [record for record, piece in fitted if not np.ndim(piece.u)]
    inputs = sorted({_round_input(record) for record in records})
    if len(inputs) < 2:
        return []
    labels = tuple(label for label in fit.parameters if " @ " in label)
    apart = f"{word} and measurement session cannot be told apart"
    like_a_law = f"would look like a law of the {word}"
    silent = [record for record in records if record.measurement_session is None]
    if silent:
        low, high = inputs[0], inputs[-1]
        without = f"{len(silent)} of {len(records)} records name no session"
        text = f"{apart}: {without}, so what changed between days {like_a_law}"
        sentinel = f"{_choose_sentinel([record for record in records if _round_input(record) == low])} ({low:g} {unit})"
        repeat = f"repeat {sentinel} in the session of {high:g} {unit}"
        test = f"state the session of each record (measurement_session); where each {word} has a session of its own, {repeat}"
        brief = f"{word} and session: {without}; state it, and {repeat}"
        return [
            Inseparable(kind, labels, text, test, brief, {"inputs": float(len(inputs)), "without": float(len(silent))})
        ]
    parts = _connect(records)
    if len(parts) < 2:
        return []
    named = [f"{listing([f'{u:g}' for u in sorted(us)], 4)} {unit} in {listing(sorted(ss), 3)}" for us, ss in parts]
    shown = listing(named, 3)
    text = f"{apart}: {shown}; what changed between these sessions {like_a_law}"
    at, session = max(parts[0][0]), sorted(parts[1][1])[0]
    sentinel = f"{_choose_sentinel([record for record in records if _round_input(record) == at])} ({at:g} {unit})"
    more = ", and one test in each of the others" if len(parts) > 2 else ""
    test = f"repeat {sentinel} in session {session}{more}"
    numbers = {"inputs": float(len(inputs)), "parts": float(len(parts))}
    return [Inseparable(kind, labels, text, test, f"{word} and session: {shown}; {test}", numbers)]


def _round_input(record: Record) -> float:
    """The input of a record, without rounding errors."""
    return round(record.input_value or 0.0, 6)


def _choose_sentinel(records: Sequence[Record]) -> str:
    """The record in the middle of its input's speeds: neither the slowest nor the fastest says most of a level."""
    speeds = [float(np.quantile(np.abs(np.gradient(record.displacement, record.time)), PEAK)) for record in records]
    return records[int(np.argsort(speeds)[len(speeds) // 2])].name


def _connect(records: Sequence[Record]) -> list[tuple[set[float], set[str]]]:
    """Groups of inputs and sessions that are joined by records, by the lowest input."""
    parts: list[tuple[set[float], set[str]]] = []
    for record in records:
        u, session = _round_input(record), str(record.measurement_session)
        joined = [part for part in parts if u in part[0] or session in part[1]]
        inputs = {u}.union(*(part[0] for part in joined))
        sessions = {session}.union(*(part[1] for part in joined))
        parts = [*(part for part in parts if part not in joined), (inputs, sessions)]
    return sorted(parts, key=lambda part: min(part[0]))
