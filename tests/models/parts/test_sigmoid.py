# Ma, Wang, Rakheja and Su, 41st IEEE CDC (2002); Wang, Ma, Rakheja and Su, Proc. IMechE D 217 (2003) 537.
"""The sigmoid model in the letters of the source, once the velocity has moved by 2 vh since it turned."""

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.identification import fit
from dampyr.models import Damper

FT, C, VK, VH = 150.0, 400.0, 0.015, 0.004


def damper() -> Damper:
    return Damper("sigmoid", {"sigmoid.ft": FT, "sigmoid.c": C, "sigmoid.vk": VK, "sigmoid.vh": VH})


def test_the_published_curve_on_both_branches() -> None:
    V, omega = 0.06, 4.0
    phase = np.linspace(0.0, 6 * np.pi, 6001)
    v, rising = V * np.sin(phase), np.cos(phase) > 0
    force = damper().force(phase / omega, -V / omega * np.cos(phase), voltage=0.0, velocity=v)
    settled = (phase > np.pi) & np.where(rising, v > -V + 2 * VH, v < V - 2 * VH)
    alpha, kv, shift = 2 / VK, C / FT, np.where(rising, -VH, VH)
    e = np.exp(-alpha * (v + shift))
    published = FT * (1 - e) / (1 + e) * (1 + kv * np.abs(v))
    np.testing.assert_allclose(force[settled], published[settled], atol=1e-9)
    assert settled.mean() > 0.5


def test_its_letters_do_not_collide_with_the_motion() -> None:
    t = np.array([0.0, 1.0, 2.0])
    force = damper().force(t, np.zeros(3), voltage=0.0, velocity=np.array([0.0, 0.05, 0.05]))
    assert force[2] == pytest.approx((FT + C * 0.05) * np.tanh((0.05 - VH) / VK), rel=1e-12)


@pytest.mark.prove
def test_a_fit_gives_the_parameters_back() -> None:
    fit_result = fit(sine(damper(), 0.0), "sigmoid")
    assert fit_result.converged, fit_result.reason
    assert list(fit_result.parameters.values()) == pytest.approx([FT, C, VK, VH], rel=1e-4)
