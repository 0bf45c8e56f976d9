"""The published damper over 0 to 3.212 V, and a sine of two seconds."""

import numpy as np

from dampyr.models import Damper, Polynomial

T = np.linspace(0.0, 2.0, 1001)

X = 0.01 * np.sin(2 * np.pi * T)

V = 0.02 * np.pi * np.cos(2 * np.pi * T)


def published(**changes: object) -> Damper:
    """The cubics (4.6)-(4.8)."""
    laws = {
        "dahl.kx": Polynomial((802.0, 493.1, 34.2, 85.5), 0.0, 3.212),
        "dahl.kw": Polynomial((50.237, 201.92, -24.866, 3.6157), 0.0, 3.212),
        "dahl.rho": Polynomial((42745.0, -39038.0, 17881.0, -2836.8), 0.0, 3.212),
    }
    return Damper("dahl", laws, **changes)
