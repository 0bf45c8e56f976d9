"""The work along a sampled path against closed forms, the shape-preserving cubics of scipy and fine samples."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from dampyr.records import Record
from dampyr.records.checks.overview import work
from dampyr.records.cycle_analysis.path_work import path_work, work_of_steps

D, KW, RHO = 0.008, 300.0, 600.0


def trapezoids(x: np.ndarray, force: np.ndarray) -> float:
    return float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(x)))


def dahl(x: np.ndarray) -> np.ndarray:
    w, values = 0.0, [0.0]
    for step in np.diff(x):
        s = np.sign(step)
        w = s + (w - s) * np.exp(-RHO * abs(step))
        values.append(KW * w)
    return np.array(values)


def rising(samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Quasi-static cycles of 2, 4, 6 and 8 mm with so many samples each, from rest."""
    phase = np.arange(4 * samples + 1) / samples
    x = 0.25 * D * np.minimum(np.floor(phase) + 1, 4) * np.sin(2 * np.pi * phase)
    return x, dahl(x)


def test_an_ellipse_of_forty_samples_has_its_area() -> None:
    phase = 2 * np.pi * np.arange(41) / 40
    x, force = D * np.sin(phase), 500.0 * np.cos(phase)
    area = np.pi * D * 500.0
    assert path_work(x, force) == pytest.approx(area, rel=1e-4)
    assert trapezoids(x, force) == pytest.approx(0.9959 * area, rel=1e-4)


def test_the_total_energy_of_a_coarse_quasi_static_test_is_right_to_a_thousandth() -> None:
    """Dahl is exact from sample to sample along a monotone path: a coarse path has the forces of the fine one."""
    fine = path_work(*rising(8000))
    x, force = rising(40)
    assert trapezoids(x, force) / fine - 1.0 == pytest.approx(-0.0045, abs=5e-4)
    assert path_work(x, force) == pytest.approx(fine, rel=1e-3)
    time = np.arange(x.size, dtype=float)
    assert work(Record(time, x, force + 50.0, no_input=True)) == pytest.approx(fine, rel=1e-3)


def test_each_leg_is_integrated_as_by_the_cubics_of_scipy() -> None:
    x, force = rising(20)
    turns = [0, *(np.flatnonzero(np.diff(x)[:-1] * np.diff(x)[1:] < 0) + 1), x.size - 1]
    expected = 0.0
    for a, b in pairwise(turns):
        at = np.arange(a, b + 1)
        curve, path = PchipInterpolator(at, force[a : b + 1]), PchipInterpolator(at, x[a : b + 1]).derivative()
        for k in at[:-1]:
            nodes, weights = np.polynomial.legendre.leggauss(4)
            s = k + 0.5 * (nodes + 1.0)
            expected += 0.5 * float(weights @ (curve(s) * path(s)))
    assert path_work(x, force) == pytest.approx(expected, rel=1e-12)


def test_straight_pieces_are_exact_and_a_single_step_is_a_trapezoid() -> None:
    x, force = np.array([0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0]), np.array([0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0])
    assert work_of_steps(x, force) == pytest.approx([0.5, 1.5, 2.5, -2.5, -1.5, -0.5], rel=1e-12)
    assert work_of_steps(x[:2], force[:2] + 1.0).tolist() == [1.5]


def test_noise_adds_no_work() -> None:
    x, force = rising(400)
    fine, rng = path_work(x, force), np.random.default_rng(1)
    found = [path_work(x + rng.normal(0, 2e-5, x.size), force + rng.normal(0, 10.0, x.size)) for _ in range(100)]
    assert np.mean(found) == pytest.approx(fine, rel=1e-3)
