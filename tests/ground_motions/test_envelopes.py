"""Envelopes of the shaking: the published forms, and what is none."""

import math

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.ground_motions import RisePlateauDecay, ShinozukaSato, Soil


def test_the_envelopes_are_the_published_forms() -> None:
    t = np.array([0.0, 1.5, 3.0, 7.0, 10.0, 20.0])
    shape_values = RisePlateauDecay()(t, 20.0)
    np.testing.assert_allclose(shape_values, [0.0, 0.25, 1.0, 1.0, 1.0, 0.05], rtol=1e-12)
    assert RisePlateauDecay()(np.array([15.0]), 20.0)[0] == pytest.approx(math.sqrt(0.05))
    fine = np.linspace(0, 60, 600001)
    shape = ShinozukaSato(0.2, 0.6)(fine, 60.0)
    assert shape.max() == pytest.approx(1.0, abs=1e-9)
    np.testing.assert_allclose(
        shape[[10000, 200000]] / shape[50000],
        [(math.exp(-0.2 * t) - math.exp(-0.6 * t)) / (math.exp(-1.0) - math.exp(-3.0)) for t in (1.0, 20.0)],
    )


def test_filters_and_envelopes_of_no_sense_are_refused() -> None:
    with pytest.raises(InputError, match=r"zeta_g = -0.6 is not allowed; it must be greater than 0"):
        Soil(15.0, -0.6, 1.5, 0.6)
    with pytest.raises(InputError, match=r"omega_f = 0 rad/s"):
        Soil(15.0, 0.6, 0.0, 0.6)
    with pytest.raises(InputError, match="0 < rise <= until < 1"):
        RisePlateauDecay(rise=0.6)
    with pytest.raises(InputError, match="0 < a < b"):
        ShinozukaSato(0.6, 0.2)
