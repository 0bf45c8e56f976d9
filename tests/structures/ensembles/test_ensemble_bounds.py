"""The bounds that an ensemble states, on random dampers, buildings and motions; and the error that it measures of itself."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from tests.endurance import Endurance

from dampyr.errors import DampyrWarning
from dampyr.ground_motions import GroundMotion, kanai_tajimi
from dampyr.models import Damper
from dampyr.structures import Building, ensemble, respond, shear_building, two_storey
from dampyr.structures.ensembles.ensemble_accuracy import BOUNDS
from dampyr.structures.ensembles.ensemble_grid import STEPS
from dampyr.structures.ensembles.ensemble_result import EnsembleResult
from dampyr.studies import raminelli_2020

Array = np.ndarray
QUANTITIES = ("displacement", "drift")
PARTS = ("dahl", "dahl", "hyperbolic_tangent", "maxwell_slip", "bouc_wen")
PLACES = {1: (1,), 2: (1, (0, 2)), 3: (1, (0, 2))}  # by the number of floors


def random_building(rng: np.random.Generator) -> Building:
    """One to three floors of like masses, the first period from 0.2 to 0.8 s or so, damping up to 5 %."""
    n = int(rng.integers(1, 4))
    masses = 10 ** rng.uniform(2.0, 3.5) * rng.uniform(0.6, 1.4, n)
    omega = 2 * np.pi * rng.uniform(1.2, 5.0)
    stiffnesses = masses.mean() * omega**2 * n**1.2 * rng.uniform(0.7, 1.4, n)
    return shear_building(masses, stiffnesses, damping_ratio=rng.uniform(0.0, 0.05), method="modal")


def random_damper(rng: np.random.Generator, building: Building, pull: float) -> Damper:
    """Its friction from a hundredth of ``pull`` to three times, where it locks the floors it joins; its yield stroke from
    10 um to 1 mm, its dashpot up to a third of critical."""
    part = str(rng.choice(PARTS))
    friction, rho = pull * 10 ** rng.uniform(-2.0, 0.5), 10 ** rng.uniform(3.0, 5.0)
    dashpot = rng.uniform(0.0, 0.3) * 2 * np.sqrt(building.K[0, 0] * building.M[0, 0])
    if part == "hyperbolic_tangent":
        v0 = friction / (2 * building.M[0, 0] * 2 * np.pi * 10 ** rng.uniform(1.0, 2.0))
        values = {"c": dashpot, "ft": friction, "v0": v0, "s": rng.uniform(-0.3, 0.3)}
    elif part == "bouc_wen":
        shape = {"sigma": rng.uniform(0.5, 1.2), "n": rng.uniform(1.0, 2.5)}
        values = {"c0": dashpot, "k0": 0.0, "kw": friction, "rho": rho} | shape
    else:
        values = {"kx": dashpot, "kw": friction, "rho": rho}
    return Damper(part, {f"{part}.{name}": float(value) for name, value in values.items()})


def exact(building: Building, motion: GroundMotion, place: object, damper: Damper) -> tuple[Array, Array]:
    """The peaks (peaks,) to a millionth by `respond`, and which are above the sizes that the bounds speak of."""
    response = respond(building, motion, {place: damper}, voltage=0.0, accuracy=1e-6)
    sizes = [response.peak_displacement, response.peak_drift]
    moving = np.concatenate([(one > 1e-4) & (one > 0.01 * one.max()) for one in sizes])
    return np.concatenate(sizes), moving


@pytest.mark.prove
@pytest.mark.endure
@pytest.mark.filterwarnings("ignore::dampyr.errors.DampyrWarning")
def test_the_stated_bounds_hold(endurance: Endurance) -> None:
    """Two motions, one weak and one strong, for each damper in a building of its own."""
    seed, cases = 20261123, 2000 if endurance.full else 8  # about two seconds each
    worst, locked = {name: [0.0, 0.0] for name in BOUNDS}, 0
    for k in range(cases // 2):
        rng = np.random.default_rng((seed, k))
        building, pga = random_building(rng), 10 ** rng.uniform(-0.5, 0.9)
        motion = kanai_tajimi(6.0, 0.02, seed=(seed, k), pga=pga, rest=2.0)
        damper = random_damper(rng, building, pga * np.trace(building.M))
        place = PLACES[building.n][int(rng.integers(len(PLACES[building.n])))]
        scales = [float(10 ** rng.uniform(-1.5, -0.5)), 1.0]
        peaks = {}
        for name in BOUNDS:
            data = ensemble(
                building, motion, {place: damper}, 0.0, scales, accuracy=name, quantities=QUANTITIES
            ).dataset
            peaks[name] = np.concatenate([data[q].values.reshape(2, -1) for q in QUANTITIES], axis=1)
        for s, scale in enumerate(scales):
            sizes, moving = exact(building, motion.scaled(scale), place, damper)
            for name, bound in BOUNDS.items():
                error = np.abs(peaks[name][s] / sizes - 1.0)
                held = error[moving].max(initial=0.0)
                worst[name] = [max(worst[name][0], error.max()), max(worst[name][1], held)]
                assert held < bound, (name, k, scale, damper, place)
            locked += not moving.all()
    figures = ", ".join(f"{n}: {100 * m:.2g} % (of all peaks {100 * a:.2g} %)" for n, (a, m) in worst.items())
    print(figures, f"{locked} of {cases} with peaks below the sizes")
    assert locked > cases // 10
    endurance.report(
        f"{cases} random dampers, buildings and motions, {locked} of them locked: largest error", seed, figures
    )


def mixed(weak_scale: float = 0.05) -> tuple[Building, list[GroundMotion], Damper]:
    """64 strong motions, then 64 weak ones, on a damper that locks the first floor in these."""
    building = shear_building([400.0, 380.0, 300.0], [3.2e5, 2.8e5, 2.2e5], damping_ratio=0.02, method="modal")
    motions = [kanai_tajimi(5.0, 0.02, seed=k, pga=6.0, rest=0.0) for k in range(128)]
    motions[64:] = [motion.scaled(weak_scale) for motion in motions[64:]]
    return building, motions, Damper("dahl", {"dahl.kx": 26.19, "dahl.kw": 1708.46, "dahl.rho": 133636.0})


@pytest.mark.filterwarnings("ignore:.*was calibrated:dampyr.errors.DampyrWarning")
def test_the_hardest_cases_are_among_those_that_are_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    """The published damper at its highest voltage, which weak motions hardly move, and of a thousand cases a few are weak."""
    motions = [kanai_tajimi(5.0, 0.02, seed=k, pga=5.0, rest=0.0) for k in range(40)]
    given = (
        two_storey(),
        [*motions, motions[7].scaled(0.01)],
        raminelli_2020.damper(),
        3.212,
        np.linspace(0.5, 1.5, 25),
    )
    monkeypatch.setitem(BOUNDS, "fast", 2e-4)
    with pytest.warns(DampyrWarning, match="more than the 0.02 % of accuracy 'fast'"):
        data = ensemble(*given, quantities=QUANTITIES).dataset
    monkeypatch.setitem(STEPS, "strict", 0.05)
    fine = ensemble(*given, quantities=QUANTITIES, accuracy="strict").dataset
    truth = max(float(np.abs(data[q] / fine[q] - 1.0).max()) for q in QUANTITIES)
    assert truth / 3 < data.attrs["error_estimate"] < 3 * truth
    assert (data.attrs["judged"], data.attrs["cases"]) == (64, 41 * 25)
    monkeypatch.setitem(BOUNDS, "fast", 1.0)
    assert ensemble(*given, quantities=QUANTITIES).dataset.identical(data)


@pytest.mark.prove  # its kernels take long to compile
@pytest.mark.parametrize("accuracy", ["fast", "strict"])
@pytest.mark.parametrize("strong_first", [True, False])
def test_the_error_of_a_mixed_block_is_the_true_one(accuracy: str, strong_first: bool) -> None:
    """Within a factor of 3 of the largest over all 128 cases, by `respond` on the four that differ most from a finer run."""
    building, motions, damper = mixed()
    motions = motions if strong_first else motions[::-1]
    given = (building, motions, damper, 0.0)
    with pytest.warns(DampyrWarning, match="on halving the step, and by .* among peaks above 0.1 mm"):
        data = ensemble(*given, accuracy=accuracy, quantities=QUANTITIES).dataset
    peaks = np.concatenate([data[q].values.reshape(128, -1) for q in QUANTITIES], axis=1)
    with warnings.catch_warnings(), pytest.MonkeyPatch.context() as patch:
        warnings.simplefilter("ignore", DampyrWarning)
        patch.setitem(STEPS, "strict", 0.05)
        fine = ensemble(*given, accuracy="strict", quantities=QUANTITIES).dataset
    finer = np.concatenate([fine[q].values.reshape(128, -1) for q in QUANTITIES], axis=1)
    hardest = np.argsort(np.abs(peaks / finer - 1.0).max(axis=1))[-4:]
    truth = max(np.abs(peaks[k] / exact(building, motions[k], 1, damper)[0] - 1.0).max() for k in hardest)
    assert truth / 3 < data.attrs["error_estimate"] < 3 * truth
    assert data.attrs["error_estimate_moving"] < BOUNDS[accuracy]
    assert data.attrs["judged"] == 64
    result = EnsembleResult(data, (), "pga")
    assert "on halving the step" in result.findings[0].words
    assert result.as_dict()["findings"][0] == result.findings[0].as_dict()
    assert "on halving the step" in repr(result)
