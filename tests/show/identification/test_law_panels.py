"""Panels of fitted laws: the fitted values at their inputs, half of their intervals, and the law through them."""

import numpy as np

from dampyr.identification import Fit
from dampyr.show.identification.law_panels import law_panels


def test_points_are_the_fitted_numbers_and_the_curve_is_the_law_of_the_damper(joint: Fit) -> None:
    damper = joint.damper
    assert damper is not None
    spans = {label: (value - 2.0, value + 3.0) for label, value in joint.parameters.items()}
    spans["dahl.kw @ 1 V"] = (-np.inf, np.inf)
    panels = {panel.axis.words: panel for panel in law_panels(joint.optimum, spans, damper)}
    assert {name: panel.axis.unit for name, panel in panels.items()} == {"kx": "N s/mm", "kw": "N", "rho": "1/mm"}
    for name, panel in panels.items():
        assert panel.points is not None
        assert panel.curve is not None
        np.testing.assert_array_equal(panel.points[0], [0.0, 1.0, 2.0])
        fitted = [joint.parameters[f"dahl.{name} @ {u} V"] for u in (0, 1, 2)]
        np.testing.assert_array_equal(panel.points[1], fitted)
        inputs, values = (np.asarray(side) for side in panel.curve)
        assert (inputs[0], inputs[-1]) == (0.0, 2.0)
        np.testing.assert_allclose([values[0], values[-1]], [fitted[0], fitted[2]])
        np.testing.assert_allclose(values[100], damper.laws[f"dahl.{name}"](inputs[100]))
    np.testing.assert_array_equal(panels["kx"].error, [2.5, 2.5, 2.5])
    np.testing.assert_array_equal(panels["kw"].error, [2.5, 0.0, 2.5])  # an infinite interval is no bar
