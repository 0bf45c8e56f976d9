"""Random roads of ISO 8608 and bumps: their spectra, their shapes, and what is refused."""

import numpy as np
import pytest
from scipy.signal import periodogram, welch

from dampyr.errors import InputError
from dampyr.structures import bump, random_road
from dampyr.structures.road_profile import road_density


def test_the_density_of_class_c_is_the_published_one_and_falls_by_the_square():
    """256e-6 m3 at 0.1 cycle/m within 5 %, slope -2.00 +- 0.05, by an estimate that knows nothing of the synthesis."""
    spacing, densities = 0.05, []
    for seed in range(10):
        n, density = welch(random_road("C", 2000.0, spacing, seed, lead=0.0), 1.0 / spacing, nperseg=8000)
        densities.append(density)
    inside = (n > 0.03) & (n < 2.0)  # the window of 400 m smears the lowest lines
    slope, level = np.polyfit(np.log(n[inside] / 0.1), np.log(np.mean(densities, axis=0)[inside]), 1)
    assert np.exp(level) == pytest.approx(256e-6, rel=0.05)
    assert slope == pytest.approx(-2.0, abs=0.05)


@pytest.mark.parametrize("road_class", "ABCDEFGH")
def test_the_spectrum_of_the_whole_length_is_that_of_the_class_line_by_line(road_class):
    heights = random_road(road_class, 500.0, 0.1, seed=4, lead=0.0)[:-1]
    n, density = periodogram(heights, 10.0, detrend=False)
    inside = (n >= 0.011) & (n <= 2.83)
    np.testing.assert_allclose(density[inside], road_density(road_class) * (n[inside] / 0.1) ** -2.0, rtol=1e-9)
    assert density[~inside].max() < 1e-20
    assert road_density(road_class) == 16e-6 * 4 ** "ABCDEFGH".index(road_class)


def test_a_road_rises_from_level_and_is_another_for_each_seed():
    one, same, other = (random_road("E", 100.0, seed=seed) for seed in (1, 1, 2))
    assert np.array_equal(one, same)
    assert np.corrcoef(one, other)[0, 1] < 0.9
    assert abs(one[0]) < 1e-12
    assert abs(one[1] - one[0]) < 1e-6  # its slope, too
    assert random_road("E", 100.0, seed=1, lead=0.0) == pytest.approx(one[200:])


def test_bumps_are_what_they_are_called():
    heights = bump(0.05, 1.0)
    s = 0.02 * np.arange(-50, 251)
    assert heights == pytest.approx(np.where((s > 0) & (s < 1), 0.05 * np.sin(np.pi * s) ** 2, 0.0))
    hump = bump("8 cm", 3.6, 0.05, "trapezoid", ramp=0.6)
    assert hump.max() == pytest.approx(0.08)
    assert np.count_nonzero(hump > 0.0799) == pytest.approx((3.6 - 1.2) / 0.05, abs=1.1)
    assert np.diff(hump).max() == pytest.approx(0.08 * 0.05 / 0.6)
    assert bump(-0.03, 1.0).min() == pytest.approx(-0.03)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: random_road("I", 100.0), r"road_class = 'I' .* A, B, C, D, E, F, G, H"),
        (lambda: random_road("", 100.0), "road_class = ''"),
        (lambda: random_road("C", 0.5), r"length = 0.5 m .* at least 20 spacings, 1 m"),
        (lambda: random_road("C", 100.0, spacing=0.0), "spacing = 0.0 m"),
        (lambda: random_road("C", 10.0, spacing=0.5, lead=-1.0), "lead = -1.0 m"),
        (lambda: random_road("C", 100.0, seed=-1), "seed = -1"),
        (lambda: random_road("C", 4000.0, spacing=100.0), "no wave between 0.011 and 2.83"),
        (lambda: bump(0.05, 0.1), "needs at least eight spacings"),
        (lambda: bump(0.05, 1.0, shape="step"), "shape = 'step'"),
        (lambda: bump(float("nan"), 1.0), "height = nan m"),
        (lambda: bump(0.05, 1.0, shape="trapezoid", ramp=0.6), "at most 0.5 m"),
    ],
)
def test_what_is_no_road_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
