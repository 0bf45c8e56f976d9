"""An ensemble as one job: a building, motions and a damper in, peaks and fragility curves out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dampyr.errors import InputError
from dampyr.findings import Finding, as_dicts, worst_first
from dampyr.ground_motions import GroundMotion, end_in_words, kanai_tajimi
from dampyr.models import Damper
from dampyr.origin import NOT_STATED, Origin
from dampyr.representation import Representation, Summary, Table, column_name, counted, data_frame, listing
from dampyr.structures.building import Building
from dampyr.structures.ensembles.ensemble import run
from dampyr.structures.ensembles.ensemble_accuracy import doubts, truncation_in_words
from dampyr.structures.ensembles.ensemble_grid import STEPS, Cases, cases
from dampyr.structures.ensembles.fragility import Curve, Fragility, fragility
from dampyr.structures.ensembles.incremental import incremental
from dampyr.structures.ensembles.store import UNITS, finding_of
from dampyr.structures.ensembles.summary import summary
from dampyr.structures.time_history.peaks import INTENSITIES
from dampyr.structures.time_history.simulate import all_inputs, check_inputs, installed
from dampyr.to_json import plain
from dampyr.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PRECISIONS = (64, 32)  # bits
SYNTHETIC_DT = 0.01  # s: 100 samples a second, the rate of many accelerographs
SYNTHETIC_DURATION = 20.0  # s, about the strong part of El Centro 1940
SYNTHETIC_PGA = 0.3 * STANDARD_GRAVITY  # m/s2, a strong motion


@dataclass(frozen=True)
class Limit:
    """A limit of ``quantity``, SI; with the storeys' ``height`` in m, ``value`` is a drift ratio."""

    quantity: str = "drift"
    value: float = 0.012
    height: float | None = None

    def __post_init__(self) -> None:
        if self.quantity not in UNITS:
            raise InputError(f"{self.quantity!r} has no limit; choose {', '.join(UNITS)}")
        if not self.value > 0:
            raise InputError(f"limit = {self.value!r} is not allowed; it must be greater than 0")


@dataclass(frozen=True)
class EnsembleOptions:
    """Options of `run_ensemble`; ``inputs``, ``laws``, ``place`` and ``brace`` as in `SimulateOptions`.

    ``bare`` runs the building without damper, too; ``after`` s of rest follow each motion; ``draws`` dampers are drawn from
    the card's covariance by ``seed``. There is a fragility curve over ``intensity`` for each of ``limits``. Raises
    :class:`~dampyr.errors.InputError` for a value that is not allowed.
    """

    inputs: tuple[float, ...] = ()
    laws: tuple[str, ...] = ()
    place: Any = 1
    brace: float | None = None
    bare: bool = False
    draws: int = 0
    seed: int = 1
    scales: tuple[float, ...] = (1.0,)
    limits: tuple[Limit, ...] = ()
    intensity: str = "pga"
    accuracy: str = "fast"
    precision: int = 64
    allow_extrapolation: bool = False
    after: float = 0.0

    def __post_init__(self) -> None:
        check_inputs(self.inputs, self.laws)
        for name, allowed in (("accuracy", tuple(STEPS)), ("precision", PRECISIONS), ("intensity", tuple(INTENSITIES))):
            if getattr(self, name) not in allowed:
                words = ", ".join(map(str, allowed))
                raise InputError(f"{name} = {getattr(self, name)!r} is not allowed; choose {words}")
        if self.draws < 0:
            raise InputError(f"draws = {self.draws} is not allowed; it must be 0 or more")


@dataclass(frozen=True)
class EnsemblePlots:
    """Each method draws one figure and returns its matplotlib axes ``(k,)``."""

    result: EnsembleResult

    def fragility(self, number: int = 0) -> Any:
        """The fragility curves of one limit, counted from 0 in the order of the options."""
        if not 0 <= number < len(self.result.curves):
            raise InputError(
                f"number = {number} is not allowed; there are {len(self.result.curves)} limits, counted from 0"
            )
        return self.result.curves[number].plot()

    def incremental(self, name: str | None = None, quantity: str = "drift") -> Any:
        """Peaks over the intensity for each motion, with fractiles; of one case, by default the first."""
        return incremental(self.result.dataset, quantity, self.result.intensity).plot(name)


@dataclass(frozen=True, eq=False, repr=False)
class EnsembleResult(Representation):
    """Result of `run_ensemble`: the ``dataset`` of peaks, and the ``curves`` over ``intensity``, one for each limit."""

    dataset: Any
    curves: tuple[Fragility, ...]
    intensity: str

    @property
    def origin(self) -> Origin:
        """That of the dampers' cards together; the responses are computed, whatever these rest on."""
        return Origin.from_json(self.dataset.attrs.get("damper_origin", NOT_STATED.kind))

    @property
    def plot(self) -> EnsemblePlots:
        """Figures: ``result.plot.fragility()`` and ``.incremental()``, each giving matplotlib axes."""
        return EnsemblePlots(self)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is wrong or in doubt in the dampers, the accuracy and the cases; the worst first."""
        attributes = self.dataset.attrs
        outside = [attributes["outside"]] if attributes.get("outside") else []
        return worst_first(
            map(finding_of, attributes.get("findings", ())),
            (Finding("doubt", words) for words in (*doubts(attributes), *outside)),
        )

    def to_dataframe(self) -> Any:
        """Medians and 84 % fractiles of the peaks as a ``pandas.DataFrame``, SI units: one row a case and scale."""
        rows = summary(self.dataset)
        columns: dict[str, Any] = {"case": [row.name for row in rows], "scale": [row.scale for row in rows]}
        for quantity in rows[0].peaks:
            pairs = [row.peaks[quantity] or (None, None) for row in rows]
            for k, part in enumerate(("median", "fractile_84")):
                columns[column_name(f"{quantity}_{part}", UNITS[quantity])] = [pair[k] for pair in pairs]
        return data_frame(columns)

    def _small_figure(self) -> Figure | None:
        return self.curves[0]._small_figure() if self.curves else None

    def _summary(self) -> Summary:
        sizes, attributes = self.dataset.sizes, self.dataset.attrs
        each = (
            (sizes["damper"], "damper case"),
            (sizes["input"], "input"),
            (sizes["motion"], "motion"),
            (sizes["scale"], "scale"),
        )
        rows = [
            ("building", listing([str(name) for name in self.dataset.building_name.values])),
            ("cases", f"{attributes['cases']}: {', '.join(counted(n, noun) for n, noun in each)}"),
            (
                "accuracy",
                f"{attributes['accuracy']}, largest change on halving the step {100 * attributes['error_estimate']:.2g} %",
            ),
            ("end", end_in_words(attributes.get("after_s", 0.0))),
            ("without bound", f"{attributes['unbounded']} cases"),
            *(("left out", words) for words in (truncation_in_words(attributes),) if words),
        ]
        rows += [("fragility", f"{curve.limit_in_words}, over {curve.intensity}") for curve in self.curves[:4]]
        return "EnsembleResult", rows

    def _table(self) -> Table:
        rows = [
            [row.name, row.scale, *(1e3 * v for v in (row.peaks.get("drift") or (float("nan"),) * 2))]
            for row in summary(self.dataset)
        ]
        return ("case", "scale", "drift, median [mm]", "84 % [mm]"), rows

    def as_dict(self) -> dict[str, Any]:
        """Peaks and curves for JSON, SI units."""
        curves = [
            {
                "quantity": each.quantity, "limit": each.limit, "limit_unit": each.limit_unit,
                "intensity": each.intensity, "intensity_unit": each.unit, "motions": each.motions,
                "curves": [_curve_as_dict(curve) for curve in each.curves],
            }
            for each in self.curves
        ]  # fmt: skip
        attributes = self.dataset.attrs | {"damper_origin": self.origin.as_dict(), "findings": as_dicts(self.findings)}
        return dict(plain({**attributes, "peaks": summary(self.dataset), "fragility": curves}))


def synthetic_motions(
    count: int, seed: int = 1, duration: float = SYNTHETIC_DURATION, pga: float = SYNTHETIC_PGA
) -> list[GroundMotion]:
    """``count`` synthetic motions [s, m/s2] by Kanai and Tajimi, each by its own seed (``seed``, k), k from 1."""
    return [kanai_tajimi(duration, SYNTHETIC_DT, (seed, k), pga=pga) for k in range(1, count + 1)]


def requested_cases(
    building: Building, motions: Sequence[GroundMotion], damper: Damper, options: EnsembleOptions
) -> Cases:
    """The checked cases of a request: every damper at every input under every motion at every scale."""
    drawn = damper.draws(options.draws, options.seed) if options.draws else [damper]
    placements = [{options.place: installed(one, brace=options.brace)} for one in drawn]
    inputs = all_inputs(damper, options.inputs, options.laws)
    return cases(
        building,
        motions,
        [*([None] if options.bare else []), *placements],
        inputs if damper.input == "V" else None,
        options.scales,
        currents=inputs if damper.input == "A" else None,
        accuracy=options.accuracy,
        precision=options.precision,
        allow_extrapolation=options.allow_extrapolation,
        after=options.after,
    )


def run_ensemble(
    building: Building,
    motions: Sequence[GroundMotion],
    damper: Damper,
    options: EnsembleOptions,
    progress: Callable[[int, int], None] | None = None,
    out: str | Path | None = None,
    workers: int | None = None,
) -> EnsembleResult:
    """Run a building with a damper through many motions and scales; peaks and fragility curves.

    ``progress`` is called with the number of cases that are done and of all; ``out`` and interrupted runs as in
    `dampyr.structures.ensemble`; ``workers`` threads, by default one for each core.
    """
    what = requested_cases(building, motions, damper, options)
    with ThreadPoolExecutor(workers) as pool:
        dataset = run(what, pool, out, progress)
    return evaluate_ensemble(dataset, options.limits, options.intensity, options.seed)


def evaluate_ensemble(
    dataset: Any, limits: Sequence[Limit] = (), intensity: str = "pga", seed: int = 1
) -> EnsembleResult:
    """The result of an ensemble that was computed already: its curves, with bands by ``seed``."""
    curves = tuple(
        fragility(dataset, one.quantity, one.value, intensity, height=one.height, seed=seed) for one in limits
    )
    return EnsembleResult(dataset, curves, intensity)


def _curve_as_dict(curve: Curve) -> dict[str, Any]:
    return {
        "name": curve.name,
        "theta": curve.theta,
        "theta_band_90": curve.theta_band(),
        "beta": curve.beta,
        "reason": curve.reason,
        "no_band": curve.no_band,
        "direct": curve.direct,
        "never_exceeded": curve.capacities.above,
        "exceeded_at_once": curve.capacities.below,
        "cases": int(curve.of.sum()),
        "exceeding": int(curve.exceeding.sum()),
        "unbounded": curve.unbounded,
    }
