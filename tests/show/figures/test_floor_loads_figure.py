"""Loads on floors over time: a panel for each of the largest, from the highest floor down."""

import numpy as np
from tests.show.figures.figure_examples import MAKERS, lines

from dampyr.show.figures.floor_loads import DRAWN, floor_loads


def test_each_floor_has_its_panel_and_peak() -> None:
    figure = MAKERS["loads"]()
    assert [line for line in lines(figure) if ":" in line] == ["roof: 80 N", "floor 1: 30 N"]
    assert len(figure.axes) == 2
    large = floor_loads(np.array([0.0, 1.0]), {"1": np.array([0.0, 2e4])})
    assert [line for line in lines(large) if ":" in line] == ["floor 1: 20 kN"]


def test_of_many_floors_the_largest_are_drawn() -> None:
    t = np.linspace(0.0, 1.0, 11)
    forces = {str(k): (k % 7 + 1.0) * np.sin(np.pi * t) for k in range(1, 21)}
    figure = floor_loads(t, forces)
    assert len(figure.axes) == DRAWN
    assert {line for line in lines(figure) if ":" in line} <= {f"floor {k}: {k % 7 + 1} N" for k in range(1, 21)}
    assert all(": 7 N" in line or ": 6 N" in line for line in lines(figure) if ":" in line)
