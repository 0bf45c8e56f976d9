"""The Bouc-Wen part: its shape is checked, and the letters of its sources come back."""

import pytest

from dampyr.errors import DampyrWarning, InputError
from dampyr.models import Damper, Polynomial
from dampyr.models.parts.bouc_wen import BoucWen, from_printed, to_printed


def test_bouc_wen_checks_its_shape() -> None:
    with pytest.raises(InputError, match="sigma"):
        BoucWen(1.0, 1.0, 1.0, 1.0, 0.0, 1.0)
    with pytest.warns(DampyrWarning, match="not dissipative on every path"):
        BoucWen(1.0, 1.0, 1.0, 1.0, 0.3, 1.0)
    laws = {"bouc_wen.c0": 1.0, "bouc_wen.k0": 0.0, "bouc_wen.kw": 9.0, "bouc_wen.rho": 100.0, "bouc_wen.n": 1.0}
    with pytest.warns(DampyrWarning, match=r"bouc_wen\.sigma .* = 0\.3 is below 0\.5"):
        Damper("bouc_wen", laws | {"bouc_wen.sigma": Polynomial((0.6, -0.1), 0.0, 3.0)})
    with pytest.raises(InputError, match="makes energy"):
        from_printed(0.0, 0.0, 1.0, 1.0, beta=3.0, gamma=-1.0, n=1.5)
    with pytest.raises(InputError, match="without bound"):
        from_printed(0.0, 0.0, 1.0, 1.0, beta=-3.0, gamma=1.0, n=1.5)


@pytest.mark.parametrize("A", [0.3, 1.0, 250.0])
def test_printed_letters_come_back(A: float) -> None:
    model = BoucWen(c0=500.0, k0=900.0, kw=120.0, rho=3000.0, sigma=1.2, n=1.6)
    there = to_printed(model, A=A)
    again = from_printed(there.c0, there.k0, there.alpha, there.A, there.beta, there.gamma, there.n)
    assert vars(again) == pytest.approx(vars(model), rel=1e-12)
