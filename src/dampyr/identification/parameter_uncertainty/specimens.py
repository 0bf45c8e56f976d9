r"""A damper type from several specimens: the mean and the spread of each parameter between them.

Each specimen is fitted by itself. Then, for each number on its own, the specimens' estimates with their standard errors give
the mean, the spread between specimens and their intervals (`dampyr.identification.parameter_uncertainty.random_effects`).
Parameters that cannot be negative are treated in their logarithm: the mean is the geometric one, and the spread, the standard
deviation of the logarithm, is relative: 0.1 is 10 %. Others are treated in their own unit.

How records differ is known from a handful of records in each specimen, so one standard error may by chance be half of
another, and the spread would follow it. With ``errors="pooled"`` the ratio of the clustered variance to that of the linear
model (how much wider than independent samples of unit variance would leave it) is averaged over the specimens, weighted by
degrees of freedom; what each specimen's own motions tell of a number stays its own. ``"own"`` takes each specimen's error as
it is.

How the numbers of one specimen go together (a strong damper is strong at every voltage) is estimated by moments: the
covariance of the estimates less the mean of their own covariances, made positive semidefinite; it shapes new specimens only.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.findings import Finding, Findings, handed_on, worst_first
from dampyr.identification.fits.fit_options import FitOptions
from dampyr.identification.fits.least_squares import fit_model, read_and_check
from dampyr.identification.fits.result import Fit
from dampyr.identification.model_choice.parameter_laws import hold_pairs
from dampyr.identification.parameter_uncertainty.profile_likelihood import variance_ratios
from dampyr.identification.parameter_uncertainty.random_effects import MIN_GROUPS, RandomEffects, random_effects
from dampyr.identification.search.problem import to_coordinates, to_values
from dampyr.models import Damper
from dampyr.models.codegen.composition import Composition
from dampyr.models.prediction_error import PredictionError, ShapeError, check_level
from dampyr.options import takes
from dampyr.origin import Origin, check_one_kind, combined
from dampyr.phrases import counted, listing
from dampyr.records import Record, nominal_inputs
from dampyr.records.files.campaign_folder import RecordsOrPaths
from dampyr.shown import Shown

Array = NDArray[np.float64]
ERRORS = ("pooled", "own")


@dataclass(frozen=True, repr=False)
class SpecimenSpread(Shown):
    """One number over the specimens, SI units.

    ``mean`` (geometric where ``relative``), its ``mean_interval``, the ``spread`` between specimens with ``spread_interval``
    (a part of the mean where ``relative``, else in the unit), and ``new_specimen``, the interval in which a further specimen
    lies (how often it does: `dampyr.identification.parameter_uncertainty.random_effects`). ``estimates``, their standard
    ``errors`` (pooled over the specimens unless asked otherwise) and ``shrunken`` (drawn towards the mean as far as their
    errors ask) by specimen; ``left_out`` says which specimens are missing here, and why. ``level`` is that of all intervals."""

    label: str
    unit: str
    relative: bool
    level: float
    mean: float
    mean_interval: tuple[float, float]
    spread: float
    spread_interval: tuple[float, float]
    new_specimen: tuple[float, float]
    estimates: dict[str, float]
    errors: dict[str, float]
    shrunken: dict[str, float]
    left_out: dict[str, str]


@dataclass(frozen=True, repr=False)
class Specimens(Shown):
    """Mean and spread of each number over several specimens: result of `fit_specimens`.

    ``spreads`` by label; ``fits`` by specimen; ``left_out`` names the specimens whose fit gave no damper, and
    ``not_estimated`` the numbers that fewer than three specimens determine, with the reason.
    """

    spreads: dict[str, SpecimenSpread]
    fits: dict[str, Fit]
    left_out: dict[str, str]
    not_estimated: dict[str, str]
    level: float
    effects: dict[str, RandomEffects] = field(repr=False)

    @property
    def origin(self) -> Origin:
        """That of all records together."""
        return combined(fit.origin for fit in self.fits.values())

    @property
    def about_sessions(self) -> str:
        """Whether the spread between specimens can be told from that between measurement sessions, and the test that would."""
        levels = [fit.levels for fit in self.fits.values()]
        if not all(level is not None and level.named for level in levels):
            return (
                "the records do not say in which measurement session each specimen was tested, so the spread between specimens "
                "contains that of sessions; state the sessions (measurement_session), and test one specimen in those of others"
            )
        shared = self._shared_sessions
        if shared:
            return (
                f"every specimen was tested in {listing(sorted(shared))}, so the spread between specimens contains none of "
                "sessions"
            )
        return (
            "specimens were tested in measurement sessions of their own, so the spread between specimens contains that of "
            "sessions; test one specimen in the sessions of others to tell them apart"
        )

    @property
    def _shared_sessions(self) -> set[str]:
        """The sessions in which every specimen was tested, of those that the records name."""
        levels = [fit.levels for fit in self.fits.values()]
        return set.intersection(*(set(of.sessions) if of is not None and of.named else set() for of in levels))

    def _prediction_error(self) -> PredictionError | None:
        """That of a record of a new specimen: how records differ, by all specimens together, and sessions where the spread
        contains none of theirs; None where a card lacks it."""
        dampers = [fit.damper for fit in self.fits.values()]
        errors = [d.prediction_error for d in dampers if d is not None and d.prediction_error is not None]
        if len(errors) < len(dampers):
            return None
        record_sd, record_freedom = _pool([(error.record_sd, error.record_freedom) for error in errors])
        apart = bool(self._shared_sessions)
        widest = max(errors, key=lambda error: error.session_sd)
        return PredictionError(
            record_sd=record_sd,
            record_freedom=record_freedom,
            session_sd=widest.session_sd if apart else 0.0,
            session_freedom=widest.session_freedom if apart else math.inf,
            session_source=widest.session_source if apart else self.about_sessions,
            freedom=float(len(self.fits) - 1),
            sessions=(),
            directions=np.zeros((0, self._damper_of_reference.coefficients.size)),
            session_levels=(),
            session_errors=(),
            shapes=_pool_shapes([shape for error in errors for shape in error.shapes]),
            # of the specimen that drifts most: a rate of a type from few specimens would have no error
            drift=max((e.drift for e in errors if e.drift), key=lambda drift: abs(drift.change), default=None),
        )

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is wrong or in doubt in the fits and in their records, and which specimens and numbers are missing, and why."""
        by_specimen = ((name, finding) for name, fit in self.fits.items() for finding in handed_on([fit]))
        missing = [f"{name} is left out: {why}" for name, why in self.left_out.items()]
        missing += [f"{label} has no spread: {why}" for label, why in self.not_estimated.items()]
        for spread in self.spreads.values():
            missing += [f"{spread.label}: {name} is left out: {why}" for name, why in spread.left_out.items()]
        return worst_first(
            (finding if finding.about else replace(finding, about=(name,)) for name, finding in by_specimen),
            (Finding("note", text) for text in (*missing, self.about_sessions)),
        )

    def damper(self) -> Damper:
        """The damper of the mean, with the covariance of a new specimen: its ``draws`` are specimens of this type.

        Raises InputError where a number has no mean.
        """
        theta, optimum = self._mean, self._reference.optimum
        T = optimum.law_matrix * np.where(self._relative, theta, 1.0)
        dampers = [fit.damper for fit in self.fits.values() if fit.damper is not None]
        mean_damper = self._damper_of_reference.with_coefficients(optimum.law_coefficients(theta))
        return replace(
            mean_damper,
            covariance=T @ self._covariance @ T.T,
            ranges=_join_ranges([fit.ranges for fit in dampers]),
            within_records=(),
            prediction_error=self._prediction_error(),
            findings=Findings(lambda: handed_on([self])),
            provenance={
                "method": "mean of specimens, random effects (dampyr.identification.fit_specimens)",
                "specimens": ", ".join(self.fits),
                "covariance": "of a new specimen",
            },
            origin=self.origin,
        )

    def new_specimens(self, n: int, seed: int = 0) -> list[Damper]:
        """``n`` dampers of this type about the mean, as wide as the intervals ``new_specimen``, Student's t.

        All are admissible, and go into `dampyr.structures.ensemble`. Raises InputError where a number has no mean, or where
        fewer than 1 % of the draws are admissible.
        """
        rng, freedom = np.random.default_rng(seed), len(self.fits) - 1
        centre = to_coordinates(self._mean, self._relative)
        values, vectors = np.linalg.eigh(self._covariance)
        root = vectors * np.sqrt(np.maximum(values, 0.0))

        def draw() -> Array:
            # Student's t in several dimensions: a normal draw over the root of a chi-square draw by its degrees of freedom
            width = math.sqrt(freedom / rng.chisquare(freedom))
            return to_values(centre + width * (root @ rng.standard_normal(centre.size)), self._relative)

        trouble = "; the spread is too wide to draw from"
        return self._reference.optimum.draw_dampers(n, self.damper(), draw, trouble)

    @property
    def _reference(self) -> Fit:
        return next(iter(self.fits.values()))

    @property
    def _damper_of_reference(self) -> Damper:
        damper = self._reference.damper
        assert damper is not None  # fits without a damper are left out
        return damper

    @cached_property
    def _mean(self) -> Array:
        missing = [label for label in self._reference.parameters if label not in self.spreads]
        if missing:
            raise InputError(f"there is no mean of {listing(missing, 4)}: {self.not_estimated[missing[0]]}")
        return np.array([self.spreads[label].mean for label in self._reference.parameters])

    @property
    def _relative(self) -> NDArray[np.bool_]:
        return np.array([self.spreads[label].relative for label in self._reference.parameters])

    @cached_property
    def _covariance(self) -> Array:
        """Of a new specimen, in the coordinates: with Student's t its intervals are as wide as those of ``new_specimen``."""
        from scipy.stats import t

        _ = self._mean
        labels = list(self._reference.parameters)
        spans = [self.effects[label].prediction for label in labels]
        # Student's t of this scale reaches as far as the interval of a new specimen, which holds the mean's own error too
        widths = 0.5 * np.diff(spans)[:, 0] / float(t.ppf(0.5 + 0.5 * self.level, len(self.fits) - 1))
        return np.asarray(self.between * np.outer(widths, widths))

    @cached_property
    def between(self) -> Array:
        """The correlation (m, m) of the numbers between specimens, by moments, in the order of the first fit's parameters.

        Of the specimens that determine all of them; independent where these are fewer than three.
        """
        labels = list(self._reference.parameters)
        complete = [
            n
            for n in self.fits
            if all(label in self.spreads and n in self.spreads[label].estimates for label in labels)
        ]
        if len(complete) < MIN_GROUPS:
            return np.eye(len(labels))
        relative = self._relative
        table = np.array([[self.spreads[label].estimates[n] for label in labels] for n in complete])
        table = to_coordinates(table, relative)
        of_fits = np.mean([_scale_covariance(self.fits[n], relative) for n in complete], axis=0)
        estimated = np.cov(table, rowvar=False).reshape(len(labels), len(labels))
        scale = np.sqrt(np.diag(estimated))
        unit = np.outer(1.0 / scale, 1.0 / scale)
        # a difference of two estimates may have negative eigenvalues: the nearest matrix without any, in units of the spreads
        values, vectors = np.linalg.eigh((estimated - of_fits) * unit)
        positive = (vectors * np.maximum(values, 0.0)) @ vectors.T
        widths = np.sqrt(np.maximum(np.diag(positive), 0.0))
        seen = widths > 1e-6
        out = positive / np.outer(np.where(seen, widths, 1.0), np.where(seen, widths, 1.0))
        out[~seen, :] = out[:, ~seen] = 0.0
        np.fill_diagonal(out, 1.0)
        return np.asarray(out)


@takes(FitOptions)
def fit_specimens(
    records: RecordsOrPaths | Mapping[str, Sequence[Record]],
    model: str | Composition | Damper,
    options: FitOptions | None = None,
    level: float = 0.95,
    errors: str = "pooled",
    progress: Callable[[str, float], None] | None = None,
    **keywords: Any,
) -> Specimens:
    """Fit each specimen by itself, and the mean and spread of each number over the specimens.

    Parameters
    ----------
    records
        of all specimens, each naming its own (``record.specimen``), or the files or folders that hold them, or
        specimen -> its records. All
        specimens need the same
        inputs, and three records or more at each, as a number without an error between records is left out. Inputs that agree
        between specimens but for noise count as one (`dampyr.records.nominal_inputs`); records of the role "validation" are
        left out.
    model, options
        as of `dampyr.identification.fit`, the same for all specimens.
    level
        of all intervals.
    errors
        ``"pooled"``: how records differ is averaged over the specimens; ``"own"``: each has the error of its own fit.
    progress
        called with the specimen that is fitted and the fraction of all that is done.

    Returns
    -------
    Specimens
        specimens whose fit gave no damper or did not converge are left out and named, and so is a specimen's number that is
        at its limit, not determined or without an interval.

    Raises
    ------
    InputError
        a record that names no specimen, or fewer than three specimens that can be used.
    """
    check_level(level)
    if errors not in ERRORS:
        raise InputError(f"{errors!r} is an unknown kind of errors; choose {' or '.join(ERRORS)}")
    chosen = FitOptions.of("fit_specimens", options, keywords)
    if not isinstance(records, Mapping):
        records = read_and_check("fit_specimens", records, model)
    by_specimen = records if isinstance(records, Mapping) else group_by_specimen(records)
    # inputs that agree between specimens but for noise count as one, so all records are looked at together
    nominal = iter(nominal_inputs([record for own_records in by_specimen.values() for record in own_records]))
    groups = {
        name: [record for record in (next(nominal) for _ in own_records) if record.role != "validation"]
        for name, own_records in by_specimen.items()
    }
    if len(groups) < MIN_GROUPS:
        raise InputError(
            f"{counted(len(groups), 'specimen')} ({listing(list(groups), 4)}) cannot give a spread between specimens; "
            f"give the records of {MIN_GROUPS} or more"
        )
    if not chosen.mixed_origins:
        check_one_kind(record for own_records in groups.values() for record in own_records)
    tell = progress or (lambda stage, done: None)
    fits, left_out = dict[str, Fit](), dict[str, str]()
    for k, (name, own_records) in enumerate(groups.items()):
        tell(f"fitting {name}", k / len(groups))
        specimen_fit = fit_model(model, own_records, hold_pairs(chosen, model))
        if specimen_fit.damper is None or not specimen_fit.converged:
            left_out[name] = (
                f"its search {specimen_fit.reason}" if specimen_fit.damper is not None else specimen_fit.reason
            )
        else:
            fits[name] = specimen_fit
    tell("fitting", 1.0)
    if len(fits) < MIN_GROUPS:
        why = "; ".join(f"{name}: {reason}" for name, reason in left_out.items())
        raise InputError(f"only {counted(len(fits), 'specimen')} gave a damper, of which there is no spread ({why})")
    return _combine_fits(fits, left_out, level, errors == "pooled")


def group_by_specimen(records: Sequence[Record]) -> dict[str, list[Record]]:
    """The records by the specimen that they name; InputError where one names none."""
    groups: dict[str, list[Record]] = {}
    for record in records:
        if record.specimen is None:
            raise InputError(
                f"{record.name} names no specimen; give it in a column specimen of campaign.csv, by specimen= where it is "
                "read, or pass specimen -> records"
            )
        groups.setdefault(record.specimen, []).append(record)
    return groups


def _combine_fits(fits: dict[str, Fit], left_out: dict[str, str], level: float, pooled: bool) -> Specimens:
    factors = _pool_errors(fits) if pooled else {}
    labels = list(dict.fromkeys(label for fit in fits.values() for label in fit.parameters))
    spreads, effects, missing = dict[str, SpecimenSpread](), dict[str, RandomEffects](), dict[str, str]()
    for label in labels:
        determined = {name: fit for name, fit in fits.items() if not _explain_exclusion(fit, label)}
        without = {name: why for name, fit in fits.items() if (why := _explain_exclusion(fit, label))}
        if len(determined) < MIN_GROUPS:
            reasons = "; ".join(f"{name}: {why}" for name, why in without.items())
            missing[label] = (
                f"{counted(len(determined), 'specimen')} determine it, of {MIN_GROUPS} at least ({reasons})"
            )
            continue
        first = next(iter(determined.values()))
        # a number that cannot be negative has its spread in the logarithm
        low = first.problem.limits[0][list(first.parameters).index(label)]
        relative = bool(low >= 0.0) and first.parameters[label] > 0.0
        values = np.array([fit.parameters[label] for fit in determined.values()])
        errors = np.array([fit.stderr[label] * factors.get((name, label), 1.0) for name, fit in determined.items()])
        y = np.log(values) if relative else values
        effect = random_effects(y, errors / values if relative else errors, level)
        back: Callable[[float], float] = math.exp if relative else float
        effects[label] = effect
        spreads[label] = SpecimenSpread(
            label=label,
            unit=first.units[label],
            relative=relative,
            level=level,
            mean=back(effect.mean),
            mean_interval=(back(effect.mean_interval[0]), back(effect.mean_interval[1])),
            spread=effect.spread,
            spread_interval=effect.spread_interval,
            new_specimen=(back(effect.prediction[0]), back(effect.prediction[1])),
            estimates=dict(zip(determined, map(float, values), strict=True)),
            errors=dict(zip(determined, map(float, errors), strict=True)),
            shrunken={name: back(float(value)) for name, value in zip(determined, effect.shrunken, strict=True)},
            left_out=without,
        )
    if not spreads:
        raise InputError(f"no number is determined in {MIN_GROUPS} specimens or more; {next(iter(missing.values()))}")
    return Specimens(spreads, fits, left_out, missing, level, effects)


def _pool_errors(fits: dict[str, Fit]) -> dict[tuple[str, str], float]:
    """By specimen and number: the pooled standard error over that of the specimen's own fit."""
    ratios: dict[str, dict[str, tuple[float, float]]] = {}
    for name, fit in fits.items():
        labels = list(fit.parameters)
        for block in fit.optimum.blocks:
            ratios_of_fit, freedoms = variance_ratios(fit, block)
            for k, ratio in ratios_of_fit.items():
                label = labels[block.places[k]]
                if not _explain_exclusion(fit, label):
                    ratios.setdefault(label, {})[name] = ratio, freedoms[k]
    factors = dict[tuple[str, str], float]()
    for label, by_specimen in ratios.items():
        mean = sum(ratio * freedom for ratio, freedom in by_specimen.values()) / sum(
            freedom for _, freedom in by_specimen.values()
        )
        factors |= {(name, label): math.sqrt(mean / ratio) for name, (ratio, _) in by_specimen.items()}
    return factors


def _explain_exclusion(fit: Fit, label: str) -> str:
    """Why a specimen's fit says nothing of a number; empty where it does."""
    if label not in fit.parameters:
        return "it was not tested at this input"
    error = fit.stderr[label]
    if math.isnan(error):
        return "it stands at its limit"
    if math.isinf(error):
        return "its records do not determine it"
    if not error > 0.0:
        return "its error is zero"
    if label in fit.within_records:
        return fit.why_no_interval(label)
    return ""


def _scale_covariance(fit: Fit, relative: NDArray[np.bool_]) -> Array:
    """The covariance of one fit in the coordinates."""
    errors, values = np.array(list(fit.stderr.values())), np.array(list(fit.parameters.values()))
    spread = errors / np.where(relative, values, 1.0)
    return np.asarray(fit.correlation * np.outer(spread, spread))


def _pool(spreads: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """One standard deviation of several with their degrees of freedom; that of the stated ones where none was estimated."""
    estimated = [(sd, freedom) for sd, freedom in spreads if math.isfinite(freedom)]
    if not estimated:
        return max(sd for sd, _ in spreads), math.inf
    total = sum(freedom for _, freedom in estimated)
    return math.sqrt(sum(freedom * sd**2 for sd, freedom in estimated) / total), total


def _pool_shapes(shapes: Sequence[ShapeError]) -> tuple[ShapeError, ...]:
    """The residual by input: its mean over the specimens, and its spread between their records and between them."""
    by_input: dict[float, list[ShapeError]] = {}
    for shape in shapes:
        by_input.setdefault(round(shape.input, 6), []).append(shape)
    pooled = []
    for u, at_input in sorted(by_input.items()):
        means = np.array([shape.shape_mean for shape in at_input])
        within = np.mean(np.square([shape.shape_sd for shape in at_input]), axis=0)
        noise, white = (
            math.sqrt(np.mean([getattr(shape, name) ** 2 for shape in at_input])) for name in ("noise", "white")
        )
        times = [shape.noise_time for shape in at_input if shape.noise_time > 0.0]
        pooled.append(
            ShapeError(
                input=u,
                shape_mean=tuple(means.mean(axis=0)),
                shape_sd=tuple(np.sqrt(within + means.var(axis=0))),
                noise=noise,
                noise_time=float(np.median(times)) if times else 0.0,
                white=white,
                records=sum(shape.records for shape in at_input),
                energy=float(np.mean([shape.energy for shape in at_input])),
            )
        )
    return tuple(pooled)


def _join_ranges(ranges: Sequence[Mapping[str, tuple[float, float]]]) -> dict[str, tuple[float, float]]:
    """The calibrated ranges of all specimens together."""
    names = dict.fromkeys(name for of_specimen in ranges for name in of_specimen)
    ends = {name: [of_specimen[name] for of_specimen in ranges if name in of_specimen] for name in names}
    return {name: (min(low for low, _ in spans), max(high for _, high in spans)) for name, spans in ends.items()}
