"""One trial step of a Dahl damper, against its closed form."""

import numpy as np
import pytest

from dampyr.export import trial_step
from dampyr.models import compose
from dampyr.models.codegen.kernels import bind

KX, KW, RHO = 900.0, 150.0, 2000.0
DT = 0.004  # s


@pytest.mark.parametrize("moved", [0.0008, -0.0003])
def test_the_force_and_its_derivatives_are_those_of_the_exact_step(moved: float) -> None:
    """w goes to the sign of the path by exp(-rho |path|); the derivatives are those of the end of this step."""
    step = bind(trial_step.try_step, (compose("dahl"),))
    s, work, out = np.array([0.3]), np.zeros(1), np.zeros(3)
    x0, v0, v1 = 0.002, 0.1, 0.2 * np.sign(moved)
    step(s, work, x0, np.sign(moved) * v0, x0 + moved, v1, 0.0, DT, np.array([KX, KW, RHO]), out)
    sign, left = np.sign(moved), np.exp(-RHO * abs(moved))
    w = sign + (0.3 - sign) * left
    assert s[0] == 0.3
    assert work[0] == pytest.approx(w, rel=1e-12)
    assert out[0] == pytest.approx(KX * v1 + KW * w, rel=1e-12)
    assert out[1] == pytest.approx(KW * RHO * (1.0 - sign * w), rel=1e-4)
    assert out[2] == pytest.approx(KX, rel=1e-6)


def test_where_no_time_has_passed_the_state_stays() -> None:
    step = bind(trial_step.try_step, (compose("dahl"),))
    s, work, out = np.array([0.3]), np.zeros(1), np.zeros(3)
    step(s, work, 0.0, 0.0, 0.01, 0.5, 0.0, 0.0, np.array([KX, KW, RHO]), out)
    assert work[0] == 0.3
    assert out[0] == pytest.approx(KX * 0.5 + KW * 0.3, rel=1e-12)


def test_unbound_it_says_what_is_missing() -> None:
    with pytest.raises(TypeError, match="a driver runs only after"):
        trial_step.force()
