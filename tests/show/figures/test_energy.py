"""Energies over time, stacked, with what the ground put in as a line."""

import numpy as np
from tests.show.figures.figure_examples import lines

from dampyr.show.figures.energy import energy_over_time

T = np.linspace(0.0, 2.0, 41)


def test_each_share_stands_on_those_before_it() -> None:
    shares = {"dampers": 3.0 * T, "viscous": T**2, "kinetic": np.full(41, 0.5)}
    fig = energy_over_time(T, shares, sum(shares.values()))
    [panel] = fig.axes
    assert [filled.get_label() for filled in panel.collections] == list(shares)
    below = np.zeros(41)
    for filled, values in zip(panel.collections, shares.values(), strict=True):
        vertices = filled.get_paths()[0].vertices
        for t, low, high in zip(T[1:-1], below[1:-1], (below + values)[1:-1], strict=True):
            heights = vertices[np.isclose(vertices[:, 0], t), 1]
            np.testing.assert_allclose((heights.min(), heights.max()), (low, high), atol=1e-12)
        below = below + values
    np.testing.assert_allclose(lines(fig)["input"][1], below)  # the shares add up to the input
    assert panel.get_ylim()[0] == 0.0
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("time [s]", "energy [J]")
