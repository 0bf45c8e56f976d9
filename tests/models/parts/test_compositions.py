# Zhou and Qu (2002), the modified Dahl model; Gavin (2001), the viscoelastic-plastic model.
"""Published models that are compositions of the catalogue's parts, in the letters of their sources."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from dampyr.models import Damper


@pytest.mark.usefixtures("plain")
def test_the_modified_dahl_model_is_dahl_with_spring_and_offset() -> None:
    K0, C0, Fd, sigma, f0 = 500.0, 700.0, 90.0, 1200.0, 35.0
    t = np.linspace(0.0, 2.0, 4001)
    x, v = 0.006 * np.sin(5 * t), 0.03 * np.cos(5 * t)

    def slope(time: float, z: np.ndarray) -> np.ndarray:
        speed = 0.03 * np.cos(5 * time)
        return sigma * speed * (1 - z * np.sign(speed))

    z = solve_ivp(slope, (0.0, 2.0), [0.0], t_eval=t, rtol=1e-9, atol=1e-11, max_step=1e-3).y[0]
    laws = {"dahl.kx": C0, "dahl.kw": Fd, "dahl.rho": sigma, "spring.k0": K0, "offset.f0": f0}
    ours = Damper("dahl + spring + offset", laws).force(t, x, voltage=0.0, velocity=v)
    np.testing.assert_allclose(ours, K0 * x + C0 * v + Fd * z + f0, atol=2e-3)


@pytest.mark.usefixtures("plain")
def test_the_viscoelastic_plastic_model_is_the_hyperbolic_tangent_with_a_spring() -> None:
    f0, Vref, Dref, c, k = 110.0, 0.02, 0.03, 400.0, 800.0
    t = np.linspace(0.0, 2.0, 401)
    x, v = 0.01 * np.sin(5 * t), 0.05 * np.cos(5 * t)
    name = "hyperbolic_tangent"
    laws = {f"{name}.c": c, f"{name}.ft": f0, f"{name}.v0": Vref, f"{name}.s": Vref / Dref, "spring.k0": k}
    ours = Damper(f"{name} + spring", laws).force(t, x, voltage=0.0, velocity=v)
    np.testing.assert_allclose(ours, f0 * np.tanh(v / Vref + x / Dref) + c * v + k * x, atol=1e-10)
