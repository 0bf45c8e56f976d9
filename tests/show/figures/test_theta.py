"""Theta of the limit-cycle method over the displacement, with the chosen points."""

import numpy as np
from tests.show.figures.figure_examples import F, X, lines

from dampyr.show.figures.theta import theta


def test_theta_its_closed_form_and_the_chosen_points_are_in_n_over_mm() -> None:
    fig = theta(X, F, {"x*": (0.002, 0.0), "x*1": (0.004, 90.0)}, (X, 0.9 * F))
    by_label = lines(fig)
    np.testing.assert_allclose(by_label["θ"], (1e3 * X, F))
    np.testing.assert_allclose(by_label["closed form"], (1e3 * X, 0.9 * F))
    np.testing.assert_allclose(np.ravel(by_label["x*"]), (2.0, 0.0))
    np.testing.assert_allclose(np.ravel(by_label["x*1"]), (4.0, 90.0))
    assert (fig.axes[0].get_xlabel(), fig.axes[0].get_ylabel()) == ("displacement [mm]", "θ [N]")
