"""Laws as tables, against the laws."""

import numpy as np
import pytest

from dampyr.models import Constant, Damper, Interpolation, Polynomial
from dampyr.models.piecewise_laws import look_up, table


def test_a_table_gives_what_the_laws_give():
    laws = {
        "dahl.kx": Constant(800.0, 0.0, 3.0),
        "dahl.kw": Interpolation((0.0, 0.9, 2.0, 3.0), (50.0, 210.0, 380.0, 560.0)),
        "dahl.rho": Polynomial((42745.0, -39038.0, 17881.0, -2836.8), 0.0, 3.0),
        "offset.f0": 120.0,
    }
    damper = Damper("dahl + offset", laws)
    knots, coefficients = table(damper)
    out = np.zeros(4)
    for u in [0.0, 0.9, 2.0, 3.0, *np.linspace(0.0, 3.0, 61)]:
        look_up(knots, coefficients, u, out)
        assert out == pytest.approx(damper.values(u), rel=1e-12)
    look_up(*table(damper, static=False), 1.0, out)
    assert out[3] == 0.0
    look_up(knots, coefficients, 3.4, out)  # beyond the range the last piece goes on
    assert out[1] == pytest.approx(float(damper.all_laws["dahl.kw"](3.4)), rel=1e-12)
