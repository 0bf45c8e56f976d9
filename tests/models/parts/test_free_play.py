# Tao and Kokotovic (1996), the dead band of a joint in series with a spring.
"""Free play in series: a spring in an eye with room."""

import numpy as np
import pytest

from dampyr.models import Damper


@pytest.mark.usefixtures("plain")
def test_a_spring_pushes_only_beyond_the_gap() -> None:
    k, g = 5e4, 0.002
    damper = Damper("spring + free_play", {"spring.k0": k, "free_play.g": g, "free_play.fc": 1e-3})
    t = np.linspace(0.0, 1.0, 2001)
    x = 0.01 * np.sin(9 * t)
    exact = k * np.sign(x) * np.maximum(np.abs(x) - g, 0.0)
    np.testing.assert_allclose(damper.force(t, x, voltage=0.0), exact, atol=0.2)


@pytest.mark.usefixtures("plain")
def test_friction_crosses_the_gap_at_each_reversal() -> None:
    laws = {"dahl.kx": 0.0, "dahl.kw": 200.0, "dahl.rho": 1e6}
    t = np.linspace(0.0, 4.0, 8001)
    x = 0.01 * np.sin(np.pi * t)
    force = Damper("dahl + free_play", laws | {"free_play.g": 0.001, "free_play.fc": 0.5}).force(t, x, voltage=0.0)
    late = (t > 1.5) & (t < 2.5)  # one stroke back, from the lower turning point at 1.5 s
    assert x[late][np.argmax(force[late] > 0.0)] == pytest.approx(-0.01 + 0.001, abs=3e-5)
    assert x[late][np.argmax(force[late] > 199.0)] == pytest.approx(-0.01 + 0.002, abs=3e-5)


@pytest.mark.usefixtures("plain")
def test_a_tight_joint_changes_nothing() -> None:
    laws = {"dahl.kx": 800.0, "dahl.kw": 90.0, "dahl.rho": 3000.0}
    t = np.linspace(0.0, 3.0, 700)
    x = 0.008 * np.sin(5 * t)
    tight = Damper("dahl + free_play", laws | {"free_play.g": 0.0, "free_play.fc": 1.0}).force(t, x, voltage=0.0)
    np.testing.assert_allclose(tight[1:], Damper("dahl", laws).force(t, x, voltage=0.0)[1:], atol=1e-9)
