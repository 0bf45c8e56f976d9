"""What a plan is after: a peak of a structure and its gradient, or parameters with their targets."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.synthetic import sine
from tests.planning.laboratory import DAHL

from dampyr import ground_motions, structures
from dampyr.errors import InputError, RangeError
from dampyr.ground_motions import trimmed
from dampyr.models import Damper
from dampyr.planning import Peak, propose
from dampyr.planning.expected_information import layout
from dampyr.planning.goal import parameter_goal, peak_goal
from dampyr.rig import RigSettings

QUICK = {"seconds": 4.0, "voltages": (0.0, 1.98), "kinds": ("sine", "voltage_steps")}
RIG = RigSettings()


@pytest.mark.prove
def test_a_peak_is_planned_for_by_its_gradient() -> None:
    peak = Peak(structures.two_storey(), ground_motions.el_centro().scaled(0.3), 1.98)
    planned = propose(DAHL, RIG, goal="peak", peak=peak, tests=3, **QUICK)
    assert planned.goal == "the largest drift at 1.98 V"
    assert planned.peak == pytest.approx(peak.value(DAHL), rel=0.05)
    assert planned.peak_after is not None
    assert 0.0 < planned.peak_after < 1.0
    with pytest.raises(RangeError, match="outside"):
        propose(DAHL, RIG, goal="peak", peak=replace(peak, voltage=3.5), tests=3, **QUICK)
    # two records at 1.98 V do not say how records differ there, so the peak has no interval yet
    few = [
        sine(DAHL, u, f"{u:g}V-{k}", 0.06 / (2 * np.pi * f), float(f), seconds=4.0)
        for u, n in ((0.0, 4), (1.98, 2))
        for k, f in enumerate(np.geomspace(0.5, 2.0, n))
    ]
    options = QUICK | {"kinds": ("sine",), "laws": "interpolation", "model": "dahl"}
    after_few = propose(few, RIG, goal="peak", peak=peak, tests=3, **options)
    assert after_few.peak_before == np.inf
    assert after_few.peak_after is not None
    assert np.isfinite(after_few.peak_after)
    assert "none ->" in repr(after_few)


CONSTANT = Damper("dahl", {"dahl.kx": 1500.0, "dahl.kw": 200.0, "dahl.rho": 15000.0})


@pytest.mark.prove
def test_a_peak_scales_with_the_motion_the_friction_and_the_shape_together() -> None:
    """f = kx v + kw w with dw = rho (dx - w |dx|): a motion s times as strong, kw s times and rho 1/s times as great, gives all
    displacements s times; so the logarithm's derivatives by kw, less that by rho, and by the scale are 1 in all."""
    motion = trimmed(ground_motions.el_centro(), 0.05, 0.35)
    peak = Peak(structures.two_storey(), motion, 1.98)
    gradient, value = peak.gradient(plan := layout(CONSTANT, [1.98] * 3))
    by = {label.partition(" @ ")[0]: float(g) for label, g in zip(plan.labels, gradient, strict=True)}
    larger, smaller = (replace(peak, motion=motion.scaled(scale)).value(CONSTANT) for scale in (1.02, 0.98))
    assert by["dahl.kw"] - by["dahl.rho"] + np.log(larger / smaller) / 0.04 == pytest.approx(1.0, abs=0.05)
    assert by["dahl.kx"] < 0.0  # more damping, less drift
    assert value == pytest.approx(peak.value(CONSTANT))
    goal, again = peak_goal(plan, peak)
    assert again == value
    np.testing.assert_array_equal(goal.gradient, gradient)


def test_targets_are_the_least_that_is_asked_of_a_coefficient() -> None:
    plan = layout(DAHL, [0.0, 1.0, 1.98, 3.212])
    assert np.all(parameter_goal(plan, {}).weights == np.where(plan.held, 0.0, 1.0))
    labels = [label for label in plan.labels if label.startswith("dahl.kw")]
    goal = parameter_goal(plan, {labels[0]: 0.05, "dahl.kw": 0.1})
    aims = dict(zip(plan.labels, goal.targets, strict=True))
    assert [aims[label] for label in labels] == [0.05, *[0.1] * (len(labels) - 1)]
    assert all(np.isinf(aims[label]) for label in plan.labels if not label.startswith("dahl.kw"))
    assert list(goal.weights) == [1.0 if label in labels else 0.0 for label in plan.labels]


def test_a_target_or_a_peak_of_no_sense_is_refused() -> None:
    plan = layout(DAHL, [0.0, 1.0, 1.98, 3.212])
    with pytest.raises(InputError, match=r"target names 'dahl.kz'; choose among dahl.kx, dahl.kw, dahl.rho"):
        parameter_goal(plan, {"dahl.kz": 0.05})
    with pytest.raises(InputError, match=r"the target of dahl.kw is 5; give a half width over the value"):
        parameter_goal(plan, {"dahl.kw": 5.0})
    with pytest.raises(
        InputError, match="'speed' is not a peak of a structure; choose drift, displacement, acceleration"
    ):
        Peak(structures.two_storey(), ground_motions.el_centro(), 1.98, "speed")
