"""Fragility curves, their bands and the counted shares."""

import numpy as np
import pytest
from tests.show.figures.figure_examples import FRAGILE, lines
from tests.structures.ensembles.known_peaks import drawn, made

from dampyr.show.figures.fragility import fragility_curves
from dampyr.show.pages.fragility_section import fragility_section
from dampyr.show.structures.fragility import comparisons, curve_table, first_curves
from dampyr.structures import fragility


def test_a_fragility_is_in_g_and_per_cent_and_one_without_a_curve_shows_its_points() -> None:
    fig = fragility_curves(FRAGILE)
    x, y = lines(fig)["0 V"]
    np.testing.assert_allclose((x[-1], y[-1]), (9.0 / 9.80665, 100.0))
    x, y = lines(fig)["no curve"]
    np.testing.assert_allclose(x, np.array([1.0, 5.0]) / 9.80665)
    np.testing.assert_array_equal(y, 0.0)
    [band] = fig.axes[0].collections
    assert band.get_paths()[0].get_extents().y1 == pytest.approx(100.0 * 9.0 / 8.0)


def test_what_the_cases_do_not_determine_is_dashed_with_two_digits_and_a_reason() -> None:
    few = fragility(made(drawn(6)), "drift", 1.0, "scale", draws=0)
    many = fragility(made(drawn(30)), "drift", 1.0, "scale", draws=200, seed=1)
    for result, style, digits in ((few, "--", 2), (many, "-", 4)):
        [curve] = [line for line in first_curves(result).axes[0].lines if len(line.get_xdata()) == 300]
        assert curve.get_linestyle() == style
        [row] = curve_table(result).rows
        for value in (row[1], row[4]):
            assert value == float(f"{value:.{digits}g}")
        assert (digits == 2) == ("Dashed: not determined" in fragility_section(result).blocks[0].caption)
    assert few.curves[0].theta != float(f"{few.curves[0].theta:.2g}")  # which the figure and JSON still hold whole
    [words, *_] = comparisons(few)
    assert words.endswith(
        "not determined, so its curve is dashed and its numbers have two digits: no bootstrap was asked for."
    )
