"""What the limit-cycle method shows: its parameters, and how much rho depends on the chosen point."""

import numpy as np

from dampyr.identification.limit_cycle_methods.limit_cycle import LimitCycle
from dampyr.show.descriptions import description_of


def test_the_parameters_and_the_branch_have_their_units() -> None:
    x = np.linspace(-0.01, 0.01, 50)
    cycle = LimitCycle(1234.5, 200.0, 42745.0, 380.5, -0.002, 0.003, (40000.0, 45000.0), x, 3e4 * x)
    assert dict(description_of(cycle).rows) == {
        "kx": "1234.5 N s/m",
        "kw": "380.5 N",
        "rho": "42745 1/m, 4e+04 … 4.5e+04 1/m by the choice of x*1",
        "a": "200 N/m",
        "x*": "-0.002 m, x*1 0.003 m",
        "branch": "50 samples, -0.01 … 0.01 m, theta -300 … 300 N",
    }
