"""The specimen of the simulated rig: the force is the damper's own, over its calibrated range."""

import numpy as np
import pytest
from tests.rig.simulation.driver import follow, rig, sine
from tests.rig.simulation.parts import settings

from dampyr.models import Constant, Damper, Interpolation
from dampyr.rig.specimen import original_specimen


def test_the_force_is_the_dampers_own_along_the_same_path() -> None:
    made, host = rig(settings(actuator={"backlash": 0.0}), step=2.5e-5)
    host.arm()
    made.write(1.98)
    host.wait()
    follow(made, host, sine(0.008, 0.8, 5, 0.01))
    truth = made.truth
    settled = truth.time > 0.2
    damper, t = original_specimen(), truth.time[settled]
    force = damper.force(
        t, truth.position[settled], voltage=4.4 * truth.current[settled], velocity=truth.speed[settled]
    )
    np.testing.assert_allclose(truth.force[settled], force, atol=0.002 * np.ptp(force))


def test_a_specimen_over_current_and_a_range_that_is_left() -> None:
    specimen = Damper(
        "hyperbolic_tangent",
        {"hyperbolic_tangent.c": 500.0, "hyperbolic_tangent.ft": Interpolation((0.0, 0.2), (10.0, 400.0)),
         "hyperbolic_tangent.v0": Constant(1e-3, 0.0, 0.2), "hyperbolic_tangent.s": Constant(0.0, 0.0, 0.2)},
        input="A",
    )  # fmt: skip
    said: list[str] = []
    made, host = rig(specimen=specimen, on_event=lambda time, words: said.append(words))
    host.arm()
    made.write(4.4)
    follow(made, host, sine(0.005, 1.0, 3, 0.01))
    truth = made.truth
    assert truth.held[-1] == (truth.current[-1] > 0.2)
    assert np.any(truth.held)
    assert truth.force.max() == pytest.approx(400.0 + 500.0 * truth.speed.max(), rel=0.02)
    assert any("outside the specimen's calibrated range" in words for words in said)
