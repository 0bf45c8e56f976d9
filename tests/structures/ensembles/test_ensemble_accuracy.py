"""How accurate the two accuracies of an ensemble are: the standard suite, and many random cases."""

from __future__ import annotations

import numpy as np
import pytest
from tests.endurance import Endurance

from dampyr.ground_motions import GroundMotion, el_centro, kanai_tajimi
from dampyr.models import Damper
from dampyr.structures import ensemble, respond, two_storey
from dampyr.structures.batch.engine import engine
from dampyr.structures.ensembles.ensemble_grid import STEPS, cases
from dampyr.structures.sites import connections
from dampyr.structures.time_history.step_size import difference_slopes, largest_step

Array = np.ndarray
LIMIT = 1e-3  # of the peak
FINEST = 64  # steps per sample of the reference
JUDGED = ("displacement", "drift")

pytestmark = pytest.mark.filterwarnings("ignore:.*was calibrated:dampyr.errors.DampyrWarning")


def synthetic(seed: int, pga: float) -> GroundMotion:
    return kanai_tajimi(duration=20.0, dt=0.02, seed=seed, pga=pga)


def peaks(damper: Damper, given: list[tuple[GroundMotion, float, float]], accuracy: str | None) -> Array:
    """Peak displacements and drifts (cases, 4); of the reference where no accuracy is named."""
    values_by_case = np.empty((len(given), 4))
    sites = [cases(two_storey(), m, damper, [u], [s]).sites_of(0, 0, 0) for m, u, s in given]
    rules = [largest_step(two_storey(), s, difference_slopes(s), 1.0) for s in sites]
    steps = [FINEST if accuracy is None else np.ceil(0.02 / (STEPS[accuracy] * rule) - 1e-9) for rule in rules]
    for m in np.unique(steps):
        [members] = np.nonzero(np.array(steps) == m)
        made = engine(two_storey(), connections(two_storey(), sites[0]), (damper.composition,), 0.02, int(m), JUDGED)
        for block in np.array_split(members, -(-len(members) // 64)):
            motions = [given[k][0].acceleration * given[k][2] for k in block]
            values = np.array([sites[k][0].values for k in block])
            out = made.run(motions, [values], np.zeros((len(block), 1)))
            values_by_case[block] = np.hstack([out[quantity] for quantity in JUDGED])
    return values_by_case


def worst(damper: Damper, given: list[tuple[GroundMotion, float, float]], accuracy: str) -> tuple[float, int]:
    errors = np.abs(peaks(damper, given, accuracy) / peaks(damper, given, None) - 1.0).max(axis=1)
    return float(errors.max()), int(errors.argmax())


def suite() -> list[tuple[GroundMotion, float, float]]:
    """Three scales of El Centro and four synthetic records at three voltages."""
    motions = [(el_centro(), scale) for scale in (0.5, 1.0, 2.0)]
    motions += [(synthetic(seed, pga), 1.0) for seed, pga in ((1, 1.0), (2, 3.0), (3, 5.0), (4, 8.0))]
    return [(motion, u, scale) for motion, scale in motions for u in (0.0, 1.0, 2.25)]


@pytest.mark.parametrize("accuracy", ["fast", pytest.param("strict", marks=pytest.mark.prove)])
def test_the_standard_suite(cubics: Damper, accuracy: str) -> None:
    assert worst(cubics, suite(), accuracy)[0] < LIMIT


@pytest.mark.parametrize("start", [1, pytest.param(5, marks=pytest.mark.prove)])
def test_the_reference_is_that_of_respond(cubics: Damper, start: int) -> None:
    """Its own kernel, Newton to 1e-10, turning points split."""
    given = suite()[start::8]
    for case_peaks, (motion, u, scale) in zip(peaks(cubics, given, None), given):
        one = respond(two_storey(), motion.scaled(scale), {1: cubics}, voltage=u, step=0.02 / FINEST)
        np.testing.assert_allclose(case_peaks, [*one.peak_displacement, *one.peak_drift], rtol=1e-5)


@pytest.mark.prove
@pytest.mark.endure
def test_strict_holds_in_many_random_cases(cubics: Damper, endurance: Endurance) -> None:
    """2000 cases by hand, 500 otherwise, for each of three records: none over 0.1 %.

    0.05 to 3.2 times as strong, 0 to 2.25 V.
    """
    number = endurance.count(2000, part=4)
    rng = np.random.default_rng(20261121)
    for motion in (el_centro(), synthetic(1, 3.0), synthetic(2, 3.0)):
        scales = np.exp(rng.uniform(np.log(0.05), np.log(3.2), number))
        given = [(motion, float(u), float(s)) for u, s in zip(rng.uniform(0.0, 2.25, number), scales)]
        error, k = worst(cubics, given, "strict")
        print(f"{motion.name[:40]}: {error:.2e} at {given[k][1]:.3f} V x {given[k][2]:.3f}")
        assert error < LIMIT, given[k]


@pytest.mark.prove
@pytest.mark.endure
def test_how_far_single_cases_of_many_are_off(
    cubics: Damper, monkeypatch: pytest.MonkeyPatch, endurance: Endurance
) -> None:
    """10,000 cases by hand, 4,000 otherwise, as of a million: what the docs say.

    Drawn dampers, noise that holds their resonance, strong and weak.
    """
    spread = np.exp(0.1 * np.random.default_rng(1).standard_normal((100 if endurance.full else 40, 3)))
    values = cubics.values(1.0, static=False)
    drawn = [Damper("dahl", dict(zip(cubics.laws, map(float, values * row)))) for row in spread]
    motions = [kanai_tajimi(30.0, 0.02, seed=k, pga=4.0, rest=0.0) for k in range(20)]
    given = (two_storey(), motions, drawn, 0.0, [0.05, 0.15, 0.45, 1.0, 2.0])
    datasets = {accuracy: ensemble(*given, accuracy=accuracy).dataset for accuracy in STEPS}
    monkeypatch.setitem(STEPS, "strict", 0.05)
    reference = ensemble(*given, accuracy="strict").dataset
    limits = {"fast": (1e-3, 0.015, 0.015, 0.12), "strict": (1e-4, 2e-3, 1e-3, 0.025)}
    for accuracy, bounds in limits.items():
        for names, typical, max_error in ((JUDGED, *bounds[:2]), (("acceleration",), *bounds[2:])):
            errors = np.concatenate([np.abs(datasets[accuracy][q] / reference[q] - 1.0).values.ravel() for q in names])
            ninety, largest = np.quantile(errors, 0.9), errors.max()
            print(f"{accuracy}, {' and '.join(names)}: 90 % of cases within {ninety:.1e}, the worst {largest:.1e}")
            assert ninety < typical
            assert largest < max_error
