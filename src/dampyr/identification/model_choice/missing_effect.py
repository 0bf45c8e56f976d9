r"""What a model may lack that misses most of the force: one thing is added, changed or taken off at a time, and fitted again.

Tried are effects of the damper (free play, delay, gas, asymmetry, a power law, a bleed, a series compliance, inertia), of its
input (a law that saturates), of heat, and of the measurement (a saturated channel, a channel in another unit, a velocity that
is not the derivative of the displacement). Each is fitted to the records, and the one with the lowest mean L1 ratio is
proposed where that is at most `WORTH` of the error without it; of those that are as good, within `ALIKE`, the one with the
fewest numbers. A channel that is cut off for `MUCH` of the samples comes first: what is not in the file no model brings back.

Heat is looked for in the *level* of each cycle, :math:`g_k = \sum F m / \sum m^2` with the modelled force m, against the energy
E that the record has dissipated by then: :math:`\ln g_k = a - h\,(1 - e^{-E/E_0})`, with a, h and E0 of each record's own, as
what surrounds a damper cools it at another rate in each test. Forces that differ between the directions are the add-on
`direction_factor` of the same model (behind a stretch factors on its force, found in turn with its numbers), besides the part
`asymmetric`, which has no memory.
"""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import DampyrWarning, InputError
from dampyr.findings import Finding
from dampyr.identification.fits.fit_options import FitOptions
from dampyr.identification.fits.least_squares import fit_model
from dampyr.identification.fits.result import Fit
from dampyr.identification.model_choice.screening import screening_set
from dampyr.models import compose
from dampyr.phrases import rounded
from dampyr.records import Record, cycle_bounds
from dampyr.records.checks.overview import work
from dampyr.records.checks.quality import quality

Array = NDArray[np.float64]
WORTH = 0.6  # of the error: an effect that leaves more is not what is missing
ALIKE = 1.25  # times the lowest error, and 0.01 more: models so near are told apart by the number of their parameters
MUCH = 0.1  # of the samples at an extreme: a channel that is cut off there
STEPS = 40  # of each fit
STARTS = 3  # of a model with a part more: a gap has several places that a search ends at
MAX_SAMPLES = 2000  # of a record in which heat is looked for, which needs all of its length
MIN_CYCLES = 4  # of a record whose level may drift
DRIFT = 0.1  # of the logarithm of the level: less is no cause of a large misfit
MOST_DRIFT = 4.0  # of it: fifty times
TURNS = 3  # of factors and numbers, which settle one after the other
VELOCITY_FACTOR = 1.2  # times the derivative of the displacement: a velocity that is not that
UNIT_FACTOR = 3.0  # times what the other records make one expect: a record whose channel may be in another unit
#: factors between units of one quantity that files hold under one name
UNITS = {
    "force": {"kN": 1e3, "kgf": 9.80665, "lbf": 4.4482216},
    "displacement": {"mm": 1e-3, "in": 0.0254, "cm": 1e-2},
}
FACTOR = "direction_factor"
ADDED = {
    "free_play": "a free play (backlash) in series is missing",
    "delay": "a delay between force and motion is missing",
    "compliance": "a compliance in series is missing",
    "gas_spring": "the force of a gas spring is missing",
    "spring": "the force of a spring is missing",
    "inertia": "the inertia of a moving mass is missing",
    "asymmetric": "the force differs between extension and compression",
    "power_law": "the force rises with a power of the velocity",
    "hyperbolic_tangent": "a friction that rises smoothly with the velocity is missing",
}
BLEED = "a bleed past the gap is missing"
INSTEAD = {
    "asymmetric": ADDED["asymmetric"],
    "power_law": ADDED["power_law"],
    "power_law + compliance": ADDED["power_law"],
    "shutting_bleed": BLEED,
    "shutting_bleed + compliance": BLEED,
    "hysteretic_biviscous": BLEED,
}


@dataclass(frozen=True)
class MissingEffect:
    """What a fit that misses its records may lack, ``cause``, and what to do about it, ``repair``.

    ``l1`` is the mean L1 ratio with it (NaN where that cannot be tried), ``without`` that of the model as it is; ``numbers``
    counts the parameters of the model with it. ``model`` is what to fit where that is all, empty where records or laws change.
    ``records`` are those that it is about, none where it is about all.
    """

    cause: str
    repair: str
    l1: float
    without: float
    numbers: int = 0
    records: tuple[str, ...] = ()
    model: str = ""

    @property
    def finding(self) -> Finding:
        """The same as a finding."""
        gain = (
            f"; the misfit is then {_percent(self.l1)} and not {_percent(self.without)}" if np.isfinite(self.l1) else ""
        )
        return Finding("doubt", f"perhaps {self.cause}: {self.repair}{gain}", self.records)


def _percent(ratio: float) -> str:
    return f"{rounded(100 * ratio, 2)} %"


def list_missing_effects(
    fit: Fit, options: FitOptions, chosen: bool = False, progress: Callable[[float], None] | None = None
) -> tuple[MissingEffect, ...]:
    """What would lower the misfit of a fit most, the best first; empty where nothing that was tried is worth it.

    ``options`` are those of the fit; after their ``seconds`` no further trial begins. Of a model that was ``chosen`` from all,
    no other model is tried. ``progress`` is called with the fraction done.
    """
    deadline = math.inf if options.seconds is None else time.monotonic() + options.seconds
    model = " + ".join(fit.problem.composition.names)
    records = list(fit.records)
    small = screening_set(records, options.bandwidth)
    tried = replace(options, bandwidth=None, budget=None, steps=STEPS, starts=1)
    usual = _error(model, small, tried)
    if usual is None:
        return ()
    without = usual[0]
    trials: list[Trial] = [
        *_plan_channels(records, small, model, tried),
        *_plan_law(small, model, tried),
        partial(_try_heat, fit, model, tried),
        partial(_try_directions, fit, model, tried),
        *([] if chosen else _plan_models(small, model, tried)),
    ]
    found = []
    for k, trial in enumerate(trials):
        if time.monotonic() > deadline:
            break
        effect = trial(without)
        found += [effect] if effect is not None else []
        if progress is not None:
            progress((k + 1) / len(trials))
    # a recorded velocity is not what was fitted where it is derived with a bandwidth
    velocities = [] if options.bandwidth else _list_other_velocities(records, without)
    return (*_list_saturated(records, without), *velocities, *rank_effects(found))


def rank_effects(effects: Sequence[MissingEffect]) -> list[MissingEffect]:
    """Those that are worth it: first the simplest of the best, then the others by their errors, each cause once."""
    worth = sorted((e for e in effects if e.l1 <= WORTH * e.without), key=lambda e: (e.l1, e.numbers))
    if not worth:
        return []
    near = [e for e in worth if e.l1 <= ALIKE * worth[0].l1 + 0.01]

    def simplicity(effect: MissingEffect) -> tuple[int, float]:
        return effect.numbers, effect.l1

    first = min(near, key=simplicity)
    # of the same cause a part does more than factors on the force
    first = min((e for e in near if e.model and e.cause == first.cause), key=simplicity, default=first)
    ranked = [first, *(e for e in worth if e is not first)]
    return [e for k, e in enumerate(ranked) if all(e.cause != other.cause for other in ranked[:k])]


def _fit(model: str, records: Sequence[Record], options: FitOptions) -> Fit | None:
    """A fit, or None where there is none."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DampyrWarning)  # of a model that is only tried
            return fit_model(model, records, options)
    except (InputError, np.linalg.LinAlgError, FloatingPointError):
        return None


def _mean_l1(fit: Fit) -> float:
    return float(np.mean([score.l1 for score in fit.scores.values()]))


def _error(model: str, records: Sequence[Record], options: FitOptions) -> tuple[float, int] | None:
    """The mean L1 ratio of the records that a model is fitted to, and the number of its parameters; None without a fit."""
    result = _fit(model, records, options)
    if result is None or not np.isfinite(error := _mean_l1(result)):
        return None
    return error, len(result.parameters)


Trial = Callable[[float], MissingEffect | None]


def _try(
    cause: str,
    model: str,
    records: Sequence[Record],
    options: FitOptions,
    without: float,
    repair: str = "",
    about: tuple[str, ...] = (),
) -> MissingEffect | None:
    """What a fit gives; the repair is to fit that model where there is no other."""
    result = _error(model, records, options)
    if result is None:
        return None
    l1, numbers = result
    return MissingEffect(cause, repair or f"fit {model}", l1, without, numbers, about, "" if repair else model)


def _plan_models(small: Sequence[Record], model: str, options: FitOptions) -> Iterator[Trial]:
    """The model with one part more, and others in its place."""
    parts = compose(model).names
    options = replace(options, starts=STARTS)
    apart = replace(options, laws=None if isinstance(options.laws, Mapping) else options.laws, fixed={}, tied={})
    for name, cause in ADDED.items():
        if name not in parts:
            yield partial(_try, cause, f"{model} + {name}", small, options)
    for other, cause in INSTEAD.items():
        if set(compose(other).names) != set(parts):
            yield partial(_try, cause, other, small, apart)


def _plan_law(small: Sequence[Record], model: str, options: FitOptions) -> Iterator[Trial]:
    """The same model with numbers of its own at each input, where its laws were told."""
    inputs = {round(float(record.input_value or 0.0), 9) for record in small}
    if options.laws is not None and len(inputs) > 2:
        cause = "the numbers do not follow the law over the input, as where the force saturates"
        repair = "fit without a law, by interpolation between the inputs"
        yield partial(_try, cause, model, small, replace(options, laws=None), repair=repair)


def _list_saturated(records: Sequence[Record], without: float) -> list[MissingEffect]:
    """The channels that stand at their extreme for much of a record."""
    found = []
    for channel in ("force", "displacement"):
        share = {r.name: quality(r).saturated.get(channel, 0) / r.n for r in records}
        names = tuple(name for name, part in share.items() if part >= MUCH)
        if names:
            most = max(share.values())
            cause = (
                f"the {channel} is cut off (a saturated channel): it stands at its extreme for up to {_percent(most)}"
            )
            found.append(MissingEffect(cause, "measure again with a wider range", math.nan, without, 0, names))
    return found


def _plan_channels(
    records: Sequence[Record], small: Sequence[Record], model: str, options: FitOptions
) -> Iterator[Trial]:
    """The records with a channel in another unit, or with the other sign."""
    for (channel, unit, factor), names in _list_suspects(records).items():
        scaled = [_scale(r, channel, factor) if r.name in names else r for r in small]
        cause, repair = f"the {channel} has the other sign", f"turn the sign of the {channel} round"
        if unit:
            cause, repair = f"the {channel} is in another unit than that of the others", f"read it in {unit}"
            if factor not in UNITS[channel].values():
                repair = f"it is not in {unit}; read it in {'N' if channel == 'force' else 'm'}"
        yield partial(_try, cause, model, scaled, options, repair=repair, about=names)


def _scale(record: Record, channel: str, factor: float) -> Record:
    changes: dict[str, Any] = {channel: factor * getattr(record, channel)}
    if channel == "displacement" and record.velocity is not None:
        changes["velocity"] = factor * record.velocity
    return record.replace(note=f"{channel} times {factor:g}", **changes)


def _list_other_velocities(records: Sequence[Record], without: float) -> list[MissingEffect]:
    """The records whose velocity is some other factor of the displacement's derivative than 1."""
    factors = {}
    for record in records:
        if record.velocity is not None:
            slope = np.gradient(record.displacement, record.time)
            factor = float(slope @ record.velocity) / max(float(slope @ slope), 1e-300)
            if not 1.0 / VELOCITY_FACTOR < factor < VELOCITY_FACTOR:
                factors[record.name] = factor
    if not factors:
        return []
    least, most = min(factors.values()), max(factors.values())
    size = rounded(most, 3) if most - least < 0.05 * abs(most) else f"{rounded(least, 3)} to {rounded(most, 3)}"
    cause = f"the velocity is in another unit, or not that of the displacement: it is {size} times its derivative"
    repair = "state the units, or derive it from the displacement (--bandwidth)"
    return [MissingEffect(cause, repair, math.nan, without, 0, tuple(factors))]


def _list_suspects(records: Sequence[Record]) -> dict[tuple[str, str, float], tuple[str, ...]]:
    """The records by channel, unit and factor that would put them among the others at their input; the sign has no unit."""
    suspects: dict[tuple[str, str, float], tuple[str, ...]] = {}
    by_input: dict[float, list[Record]] = {}
    for record in records:
        by_input.setdefault(round(float(record.input_value or 0.0), 9), []).append(record)
        if work(record) < 0.0:
            suspects["force", "", -1.0] = (*suspects.get(("force", "", -1.0), ()), record.name)
    for members in by_input.values():
        for channel, units in UNITS.items():
            sizes = np.log([max(float(np.std(getattr(r, channel))), 1e-300) for r in members])
            for k, record in enumerate(members):
                others = np.delete(sizes, k)
                if others.size == 0 or abs(distance := float(sizes[k] - np.median(others))) < math.log(UNIT_FACTOR):
                    continue
                factors = [(name, f) for name, size in units.items() for f in (size, 1.0 / size)]
                unit, factor = min(factors, key=lambda pair: abs(distance + math.log(pair[1])))
                if abs(distance + math.log(factor)) < 0.5 * abs(distance):
                    suspects[channel, unit, factor] = (*suspects.get((channel, unit, factor), ()), record.name)
    return suspects


def _try_heat(fit: Fit, model: str, options: FitOptions, _: float) -> MissingEffect | None:
    """A level that falls or rises with the energy that a record has dissipated, which needs the whole records."""
    from scipy.integrate import cumulative_trapezoid

    corrected, ends, spent = [], [], []
    for record, force in zip(fit.records, fit.whole_forces, strict=True):
        dissipated = np.maximum.accumulate(cumulative_trapezoid(record.force, record.displacement, initial=0.0))
        h, scale = _fit_drift(record, force, dissipated)
        drift = np.exp(-h * (1.0 - np.exp(-dissipated / scale)))
        corrected.append(record.replace(note="levelled by the energy", force=record.force / drift))
        ends.append(float(drift[-1]))
        spent.append(float(dissipated[-1]))
    if abs(math.log(end := float(np.median(ends)))) < DRIFT:
        return None
    result, without = (_error(model, [_thinned(r) for r in rs], options) for rs in (corrected, fit.records))
    if result is None or without is None:
        return None
    energy = f"{np.median(spent):.3g} J"
    cause = f"the damper heats up: its force goes to {_percent(end)} of that at first while it dissipates {energy}"
    repair = "let it cool between shorter tests, or fit their beginnings (--crop)"
    return MissingEffect(cause, repair, result[0], without[0], result[1] + 2 * len(corrected))


def _thinned(record: Record) -> Record:
    return record.thinned(max(1, record.n // MAX_SAMPLES))


def _fit_drift(record: Record, modelled: Array, energy: Array) -> tuple[float, float]:
    """h and E0 of a record's level by the energy; h is 0 where they take less than half of the variance of its cycles."""
    means, levels = [], []
    for first, last in cycle_bounds(record):
        m, f = (
            modelled[first:last] - modelled[first:last].mean(),
            record.force[first:last] - record.force[first:last].mean(),
        )
        if (product := float(m @ f)) > 0.0:
            means.append(float(energy[first:last].mean()))
            levels.append(math.log(product / float(m @ m)))
    if len(means) < MIN_CYCLES or np.ptp(means) <= 0.0:
        return 0.0, 1.0
    at, rest = np.array(means), np.array(levels) - np.mean(levels)
    best = 0.5 * float(rest @ rest), 0.0, 1.0
    for scale in map(float, np.ptp(at) * np.geomspace(0.05, 20.0, 25)):
        shape = np.exp(-at / scale)
        shape -= shape.mean()
        h = float(shape @ rest) / max(float(shape @ shape), 1e-300)
        if abs(h * math.expm1(-float(energy[-1]) / scale)) > MOST_DRIFT:
            continue  # a straight line through few cycles, far beyond them
        best = min(best, (float(np.sum((rest - h * shape) ** 2)), h, scale))
    return best[1:]


def _try_directions(fit: Fit, model: str, options: FitOptions, _: float) -> MissingEffect | None:
    """The part `direction_factor` on a model with memory. Where that cannot stand (behind a stretch) or `asymmetric` does more,
    a factor on the force in each direction, found in turn with its numbers."""
    records = [_thinned(record) for record in fit.records]
    composition = compose(model)
    if composition.n_states and not composition.in_series and FACTOR not in composition.names:
        same_records = _error(model, records, options)
        if same_records is None:
            return None
        return _try(ADDED["asymmetric"], f"{model} + {FACTOR}", records, options, same_records[0])
    usual = result = _fit(model, records, options)
    out = back = 1.0
    for _turn in range(TURNS):
        if result is None:
            return None
        pulled = [np.gradient(record.displacement, record.time) > 0.0 for record in records]
        modelled = [f - result.nuisances[r.name].offset for f, r in zip(result.whole_forces, records, strict=True)]
        columns = [np.column_stack((m * p, m * ~p)) for m, p in zip(modelled, pulled, strict=True)]
        # less its mean in each record, which the record's own offset takes
        slopes = np.concatenate([c - c.mean(axis=0) for c in columns])
        forces = np.concatenate([r.force - r.force.mean() for r in records])
        out, back = map(float, np.linalg.lstsq(slopes, forces, rcond=None)[0])
        if min(out, back) <= 0.0:
            return None
        factors = [np.where(p, out, back) for p in pulled]
        offsets = [float(np.mean(r.force - c @ (out, back))) for r, c in zip(records, columns, strict=True)]
        levelled = [
            r.replace(note="levelled by direction", force=(r.force - o) / g)
            for r, o, g in zip(records, offsets, factors, strict=True)
        ]
        result = _fit(model, levelled, options)
    if result is None or usual is None:
        return None
    repair = f"in extension it is {rounded(out / back, 2)} times that in compression; fit each direction by itself"
    numbers = len(usual.parameters) + 1
    return MissingEffect(ADDED["asymmetric"], repair, _mean_l1(result), _mean_l1(usual), numbers)
