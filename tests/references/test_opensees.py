"""OpenSees 3.7.1 (openseespy 3.7.1.2), Newmark's average acceleration with its BoucWen material as Dahl's: the peaks of the
building of chapter 5 under El Centro 1940 NS with the published damper, as its step shrinks.

Recorded as OpenSees prints them, to six digits, by `benchmarks/_opensees.py`; `make bench BENCH=opensees` runs it again. Its
BoucWen is backward Euler, of first order: carried on to no step its peaks are ours.
"""

import numpy as np
import pytest

from dampyr.ground_motions import el_centro
from dampyr.structures import ensemble, respond, two_storey
from dampyr.studies import raminelli_2020

STEPS = (125e-6, 62.5e-6, 31.25e-6)  # s
PEAKS_MM = {
    0.0: [(27.2083, 18.6950), (27.2082, 18.6954), (27.2081, 18.6957)],
    1.0: [(15.1558, 12.0148), (15.1552, 12.0153), (15.1549, 12.0155)],
    2.25: [(5.97414, 9.96474), (5.97375, 9.96395), (5.97356, 9.96356)],
}  # V -> first floor and drift of the second storey, a pair for each step
pytestmark = pytest.mark.filterwarnings("ignore:.*was calibrated:dampyr.errors.DampyrWarning")


@pytest.mark.parametrize("volts", [pytest.param(u, marks=[pytest.mark.prove] * (u == 1.0)) for u in PEAKS_MM])
def test_its_peaks_go_to_ours_at_first_order(volts: float) -> None:
    response = respond(two_storey(), el_centro(), {1: raminelli_2020.damper()}, voltage=volts, accuracy=2e-6)
    ours = 1e3 * np.array([response.peak_displacement[0], response.peak_drift[1]])
    theirs = np.array(PEAKS_MM[volts])
    np.testing.assert_allclose(2 * theirs[-1] - theirs[-2], ours, rtol=1e-5)
    gaps, digits = np.abs(theirs - ours), 1e-5 * ours
    assert np.all(gaps[1:] < 0.55 * gaps[:-1] + digits)
    assert np.all(gaps[0] > 2 * gaps[-1])


@pytest.mark.prove
@pytest.mark.parametrize(("accuracy", "allowed"), [("fast", 1e-3), ("strict", 2e-4)])
def test_ensembles_meet_them(accuracy: str, allowed: float) -> None:
    volts = list(PEAKS_MM)
    dataset = ensemble(two_storey(), el_centro(), raminelli_2020.damper(), volts, accuracy=accuracy).dataset
    ours = 1e3 * np.stack([dataset.displacement.isel(floor=0), dataset.drift.isel(storey=1)], axis=-1).reshape(
        len(volts), 2
    )
    limits = [2 * np.array(PEAKS_MM[u][-1]) - np.array(PEAKS_MM[u][-2]) for u in volts]
    np.testing.assert_allclose(ours, limits, rtol=allowed)
