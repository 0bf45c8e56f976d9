r"""Filters of the ground for white noise from the rock: the Kanai-Tajimi filter with the high-pass of Clough and Penzien.

The layers above the rock are one oscillator (omega_g, zeta_g) and a second one (omega_f, zeta_f) takes away what is slow,
without which velocity and displacement would have infinite variance. The power spectral density of the ground acceleration is

.. math:: S(\omega) = S_0\,
    \frac{\omega_g^4 + 4\zeta_g^2\omega_g^2\omega^2}{(\omega_g^2-\omega^2)^2 + 4\zeta_g^2\omega_g^2\omega^2}\cdot
    \frac{\omega^4}{(\omega_f^2-\omega^2)^2 + 4\zeta_f^2\omega_f^2\omega^2},

two-sided: the variance is its integral over omega from minus to plus infinity; S0 in m2/s3 (for each rad/s).

References
----------
.. [Kanai1957] K. Kanai, "Semi-empirical formula for the seismic characteristics of the ground", Bulletin of the Earthquake
   Research Institute, University of Tokyo 35, 309-325, 1957.
.. [Tajimi1960] H. Tajimi, "A statistical method of determining the maximum response of a building structure during an
   earthquake", Proc. 2nd World Conference on Earthquake Engineering, Tokyo, 2, 781-797, 1960.
.. [CloughPenzien1975] R. W. Clough and J. Penzien, Dynamics of Structures, McGraw-Hill, New York, 1975.
.. [DerKiureghianNeuenhofer1992] A. Der Kiureghian and A. Neuenhofer, "Response spectrum method for multi-support seismic
   excitations", Earthquake Engineering and Structural Dynamics 21(8), 713-740, 1992 (firm, medium and soft).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import InputError


@dataclass(frozen=True)
class Soil:
    """The two filters. All are greater than 0; omega_f is usually about a tenth of omega_g."""

    omega_g: float  # rad/s, of the layers
    zeta_g: float  # ratio
    omega_f: float  # rad/s, of the high-pass
    zeta_f: float  # ratio

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not math.isfinite(value) or value <= 0:
                unit = " rad/s" if name.startswith("omega") else ""
                raise InputError(f"{name} = {value:g}{unit} is not allowed; it must be greater than 0")

    def transfer(self, omega: ArrayLike) -> NDArray[np.complex128]:
        """H(omega) from the noise to the acceleration of the ground; its squared size is S/S0, its phase causal."""
        w = np.asarray(omega, dtype=float)
        g, f = 2j * self.zeta_g * self.omega_g * w, 2j * self.zeta_f * self.omega_f * w
        layers = (self.omega_g**2 + g) / (self.omega_g**2 - w**2 + g)
        return np.asarray(layers * -(w**2) / (self.omega_f**2 - w**2 + f))

    def density(self, omega: ArrayLike, intensity: float = 1.0) -> NDArray[np.float64]:
        """S(omega) [m2/s3], two-sided, for ``omega`` [rad/s] and S0 = ``intensity`` [m2/s3]."""
        return np.asarray(intensity * np.abs(self.transfer(omega)) ** 2)


FIRM = Soil(15.0, 0.6, 1.5, 0.6)
"""Firm soil of [DerKiureghianNeuenhofer1992]_."""
MEDIUM = Soil(10.0, 0.4, 1.0, 0.6)
"""Medium soil of [DerKiureghianNeuenhofer1992]_."""
SOFT = Soil(5.0, 0.2, 0.5, 0.6)
"""Soft soil of [DerKiureghianNeuenhofer1992]_."""
