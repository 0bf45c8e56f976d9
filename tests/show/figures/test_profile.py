"""The profile of an objective over one coefficient, with its parabola, threshold and interval."""

import numpy as np
import pytest
from tests.show.figures.figure_examples import lines

from dampyr.show.figures.profile import profile_curve
from dampyr.show.figures.style import Axis

KX = Axis("kx", "N s/mm", 1e-3)
VALUES = np.linspace(900.0, 1100.0, 21)


def test_the_parabola_has_the_rise_of_one_at_one_standard_error() -> None:
    fig = profile_curve(KX, VALUES, ((VALUES - 1000.0) / 25.0) ** 2, 3.84, (950.0, 1060.0), (1000.0, 50.0))
    by_label, [panel] = lines(fig), fig.axes
    np.testing.assert_allclose(by_label["profile"], (1e-3 * VALUES, ((VALUES - 1000.0) / 25.0) ** 2))
    x, rise = by_label["parabola of the error"]
    np.testing.assert_allclose(np.interp([0.95, 1.0, 1.05], x, rise), [1.0, 0.0, 1.0], atol=1e-3)
    assert by_label["threshold"][1][0] == 3.84
    np.testing.assert_allclose(sorted(line.get_xdata()[0] for line in panel.lines[3:]), [0.95, 1.06])
    [span] = panel.patches
    assert span.get_extents().transformed(panel.transData.inverted()).intervalx == pytest.approx([0.95, 1.06])
    assert panel.get_ylim() == pytest.approx((0.0, 2.5 * 3.84))
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("kx [N s/mm]", "adjusted rise [1]")


def test_an_end_that_is_not_finite_is_not_drawn() -> None:
    fig = profile_curve(KX, VALUES, np.zeros(21), 3.84, (950.0, np.inf))
    [panel] = fig.axes
    assert [line.get_xdata()[0] for line in panel.lines[2:]] == pytest.approx([0.95])
    assert len(panel.patches) == 0
