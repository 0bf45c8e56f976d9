"""An ensemble as one job: a building, motions and a damper in, peaks and fragility curves out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dampyr.errors import InputError
from dampyr.findings import Finding, worst_first
from dampyr.ground_motions import GroundMotion, kanai_tajimi
from dampyr.models import Damper
from dampyr.origin import NOT_STATED, Origin
from dampyr.shown import Shown
from dampyr.structures.building import Building
from dampyr.structures.ensembles.ensemble import run
from dampyr.structures.ensembles.ensemble_accuracy import doubts
from dampyr.structures.ensembles.ensemble_grid import STEPS, Cases, cases
from dampyr.structures.ensembles.fragility import Fragility, fragility
from dampyr.structures.ensembles.store import UNITS, finding_of
from dampyr.structures.time_history.peaks import INTENSITIES
from dampyr.structures.time_history.simulate import all_inputs, check_inputs, installed
from dampyr.units import STANDARD_GRAVITY

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


@dataclass(frozen=True, eq=False, repr=False)
class EnsembleResult(Shown):
    """Result of `run_ensemble`: the ``dataset`` of peaks, and the ``curves`` over ``intensity``, one for each limit."""

    dataset: Any
    curves: tuple[Fragility, ...]
    intensity: str

    @property
    def origin(self) -> Origin:
        """That of the dampers' cards together; the responses are computed, whatever these rest on."""
        return Origin.from_json(self.dataset.attrs.get("damper_origin", NOT_STATED.kind))

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is wrong or in doubt in the dampers, the accuracy and the cases; the worst first."""
        attributes = self.dataset.attrs
        outside = [attributes["outside"]] if attributes.get("outside") else []
        return worst_first(
            map(finding_of, attributes.get("findings", ())),
            (Finding("doubt", words) for words in (*doubts(attributes), *outside)),
        )


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
