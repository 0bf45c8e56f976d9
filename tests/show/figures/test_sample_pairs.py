"""Samples of pairs of numbers, and the ellipse that holds 95 % of a normal distribution."""

import numpy as np
from scipy.stats import chi2
from tests.show.figures.figure_examples import lines

from dampyr.show.figures.sample_pairs import sample_pairs
from dampyr.show.figures.style import Axis

AXES = {"kx": Axis("kx", "N s/mm", 1e-3), "kw": Axis("kw", "N")}
DRAWS = np.random.default_rng(4).multivariate_normal([1000.0, 200.0], [[400.0, 30.0], [30.0, 9.0]], 4000).T


def test_the_ellipse_is_the_line_of_equal_mahalanobis_distance_that_holds_95_per_cent() -> None:
    fig = sample_pairs({"kx": DRAWS[0], "kw": DRAWS[1]}, AXES, {"kx": 1001.0, "kw": 201.0}, [("kx", "kw")])
    by_label = lines(fig)
    outline = np.array(by_label["95 % of a normal distribution"]) * [[1e3], [1.0]]
    inverse, centre = np.linalg.inv(np.cov(DRAWS)), DRAWS.mean(axis=1)[:, None]

    def distance(points: np.ndarray) -> np.ndarray:
        away = points - centre
        return np.asarray(np.einsum("ik,ij,jk->k", away, inverse, away))

    np.testing.assert_allclose(distance(outline), chi2.ppf(0.95, 2), rtol=1e-4)
    assert abs(np.mean(distance(DRAWS) <= chi2.ppf(0.95, 2)) - 0.95) < 0.012  # 3.5 standard deviations of 4000 draws
    np.testing.assert_allclose(by_label["fit"], ([1.001], [201.0]))
    np.testing.assert_allclose(by_label["sample"], (1e-3 * DRAWS[0, ::2], DRAWS[1, ::2]))  # every second of 4000
    assert (fig.axes[0].get_xlabel(), fig.axes[0].get_ylabel()) == ("kx [N s/mm]", "kw [N]")


def test_a_number_against_itself_has_no_ellipse() -> None:
    fig = sample_pairs({"kx": DRAWS[0]}, AXES, {"kx": 1000.0}, [("kx", "kx")])
    assert set(lines(fig)) == {"sample", "fit"}
