"""A quantity over time, measured and modelled, and the residual below."""

import numpy as np
from tests.show.figures.figure_examples import MAKERS, F


def test_the_residual_is_measured_less_model() -> None:
    residual = MAKERS["history"]().axes[1]
    np.testing.assert_allclose(residual.lines[0].get_ydata(), 0.1 * F)
    low, high = residual.get_ylim()
    assert low <= np.min(0.1 * F)
    assert high >= np.max(0.1 * F)
