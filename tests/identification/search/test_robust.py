"""Robust losses: what spikes do to each, their errors, and the least sum of absolute residuals by other means."""

import numpy as np
import pytest
from scipy.optimize import minimize
from tests.identification.fitted_numbers import NUMBERS, values
from tests.identification.synthetic import DAHL, sine

from dampyr.identification import fit
from dampyr.models import Damper
from dampyr.records import Record


def spiked(record: Record) -> Record:
    """One sample in forty with a spike of the load cell, on the way out only."""
    spikes = np.zeros(record.n)
    spikes[150::40] = 400.0 * (record.velocity[150::40] > 0)
    return record.replace(note="spikes", force=record.force + spikes)


@pytest.mark.parametrize("loss", ["huber", "l1"])
def test_spikes_move_squares_and_not_the_robust_losses(loss: str) -> None:
    record = spiked(sine(DAHL, 0.0, noise=2.0, seconds=12.0))
    squares, robust = fit(record, "dahl"), fit(record, "dahl", loss=loss)
    assert robust.converged, robust.reason
    assert np.max(np.abs(values(squares)[:2] / NUMBERS[:2] - 1)) > 0.08
    np.testing.assert_allclose(values(robust), NUMBERS, rtol=0.03)


@pytest.mark.parametrize("loss", ["huber", "l1"])
def test_without_outliers_the_losses_agree_within_their_errors(loss: str) -> None:
    record = sine(DAHL, 0.0, noise=3.0, seconds=15.0)
    squares, robust = fit(record, "dahl"), fit(record, "dahl", loss=loss)
    errors = np.array(list(robust.stderr.values()))
    assert np.all(np.abs(values(robust) - NUMBERS) < 4 * errors)
    assert np.all(np.abs(values(robust) - values(squares)) < 3 * errors)


@pytest.mark.parametrize("loss", ["huber", pytest.param("l1", marks=pytest.mark.prove)])
def test_the_errors_of_the_robust_losses_are_of_the_right_size(loss: str) -> None:
    numbers, errors, naive = [], [], []
    for seed in range(20):
        fit_result = fit(sine(DAHL, 0.0, noise=4.0, seed=seed, seconds=12.0), "dahl", loss=loss)
        numbers.append(values(fit_result))
        errors.append(list(fit_result.stderr.values()))
        naive.append(list(fit_result.naive_stderr.values()))
    for each in (errors, naive):
        ratio = np.std(numbers, axis=0) / np.mean(each, axis=0)
        assert np.all((ratio > 0.6) & (ratio < 1.6)), ratio


@pytest.mark.prove
def test_l1_minimises_the_sum_of_the_ratios_that_are_scored() -> None:
    """A quiet and a noisy record that disagree: a record's noise does not decide how much it counts."""
    quiet, noisy = (Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": kw, "dahl.rho": 2500.0}) for kw in (300.0, 330.0))
    pair = [sine(quiet, 0.0, "quiet", noise=3.0, seconds=12.0), sine(noisy, 0.0, "noisy", noise=60.0, seconds=12.0)]

    def ratios(kw: float | None) -> tuple[float, float]:
        fit_result = fit(pair, "dahl", loss="l1", fixed={"dahl.rho": 2500.0} | ({} if kw is None else {"dahl.kw": kw}))
        total = 0.0
        for piece, force in zip(fit_result.problem.pieces, fit_result.forces, strict=True):
            middle = np.mean(np.quantile(piece.force, (0.01, 0.99)))
            total += np.sum(np.abs(piece.force - force)) / np.sum(np.abs(piece.force - middle))
        return fit_result.parameters.get("dahl.kw", 0.0), total

    best, least = ratios(None)
    grid = np.arange(302.0, 329.0, 2.0)
    assert abs(grid[np.argmin([ratios(kw)[1] for kw in grid])] - best) <= 3.0
    assert min(ratios(kw)[1] for kw in (best - 4.0, best + 4.0)) > least


def test_l1_is_the_least_sum_of_absolute_residuals_that_scipy_finds() -> None:
    record = spiked(sine(DAHL, 0.0, noise=3.0, seconds=10.0))
    fit_result = fit(record, "dahl", loss="l1")
    t, x, v = record.time, record.displacement, record.velocity
    first = record.n - fit_result.forces[0].size

    def absolute(z: np.ndarray) -> float:
        kx, kw, rho, offset, w0 = z * [900.0, 70.0, 2500.0, 100.0, 1.0]
        damper = Damper("dahl", {"dahl.kx": kx, "dahl.kw": kw, "dahl.rho": rho})
        force = damper.force(t[first:], x[first:], 0.0, velocity=v[first:], state0=[np.clip(w0, -1, 1)])
        return float(np.sum(np.abs(record.force[first:] - force - offset)))

    ours = absolute(
        np.array(
            [*values(fit_result), fit_result.nuisances["test"].offset, fit_result.nuisances["test"].states["dahl.w"]]
        )
        / [900.0, 70.0, 2500.0, 100.0, 1.0]
    )
    theirs = minimize(
        absolute, [1.0, 1.0, 1.0, 1.2, 0.0], method="Nelder-Mead", options={"maxiter": 3000, "xatol": 1e-7}
    )
    assert ours == pytest.approx(theirs.fun, rel=2e-3)
    assert ours < absolute(np.append(values(fit(record, "dahl")) / NUMBERS, [1.2, 0.0]))
