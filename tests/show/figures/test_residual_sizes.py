"""The size of the residual of each record against input, stroke and frequency."""

import numpy as np

from dampyr.show.figures.residual_sizes import residual_sizes


def test_each_record_is_a_point_of_per_cent_over_v_mm_and_hz() -> None:
    fig = residual_sizes({"0 V": ([0, 0], [0.02, 0.01], [1, np.nan], [0.1, 0.2]), "2 V": ([2], [0.03], [0.5], [0.05])})
    expected = ([[0, 0], [2]], [[20, 10], [30]], [[1, np.nan], [0.5]])
    for panel, across in zip(fig.axes, expected, strict=True):
        for line, x, size in zip(panel.lines, across, ([10, 20], [5]), strict=True):
            np.testing.assert_allclose(line.get_xdata(), x)
            np.testing.assert_allclose(line.get_ydata(), size)
    assert [panel.get_xlabel() for panel in fig.axes] == ["voltage [V]", "stroke [mm]", "frequency [Hz]"]
    assert fig.axes[0].get_ylabel() == "rms residual / spread [%]"
    np.testing.assert_allclose(fig.axes[2].get_ylim(), (0.0, 1.08 * 20.0))
    assert len({line.get_marker() for line in fig.axes[0].lines}) == 2  # told apart without colours
