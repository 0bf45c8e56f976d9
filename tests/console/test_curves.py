"""Lines for a browser: few points, six digits, every peak."""

import numpy as np
import pytest

pytest.importorskip("fastapi")

from dampyr.console.curves import line


def test_few_points_keep_every_peak_in_its_place():
    t = np.linspace(0.0, 100.0, 200_001)
    y = np.sin(t)
    y[[51_003, 120_001]] = 3.25, -4.5  # a sample each, between those that are kept of a smooth line
    short = line(t, y, 400)
    assert len(short.x) <= 400
    assert sorted(short.x) == short.x
    assert (max(short.y), min(short.y)) == (3.25, -4.5)
    assert short.x[short.y.index(3.25)] == pytest.approx(t[51_003], rel=1e-5)
    assert (short.x[0], short.x[-1]) == (0.0, 100.0)


def test_a_short_line_is_as_it_was_to_six_digits():
    values = line([0.0, 1.0, 2.0], [1 / 3, -2e9 / 3, 12345678.0])
    assert values.y == [0.333333, -666667000.0, 12345700.0]
    assert values.x == [0.0, 1.0, 2.0]
