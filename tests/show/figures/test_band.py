"""A measured force in its predictive band: the band, the line, and the samples that lie outside."""

import numpy as np
from tests.show.figures.figure_examples import lines

from dampyr.origin import Origin
from dampyr.show.figures.band import band

T = np.linspace(0.0, 1.0, 101)
FORCE = 100.0 * np.sin(2 * np.pi * T)


def test_the_samples_outside_of_the_band_are_marked_and_no_others() -> None:
    fig = band(T, FORCE, np.full(101, -95.0), np.full(101, 80.0), 0.8, record_origin=Origin("measured"))
    outside = (FORCE < -95.0) | (FORCE > 80.0)
    by_label = lines(fig)
    np.testing.assert_allclose(by_label["measured"], (T, FORCE))
    np.testing.assert_allclose(by_label["outside"], (T[outside], FORCE[outside]))
    [filled] = fig.axes[0].collections
    corners = filled.get_paths()[0].get_extents()
    assert (corners.x0, corners.x1, corners.y0, corners.y1) == (0.0, 1.0, -95.0, 80.0)
    assert filled.get_label() == "80 % band"
    assert (fig.axes[0].get_xlabel(), fig.axes[0].get_ylabel()) == ("time [s]", "force [N]")


def test_nothing_is_marked_where_the_band_holds_everything() -> None:
    assert "outside" not in lines(band(T, FORCE, FORCE - 1.0, FORCE + 1.0))
