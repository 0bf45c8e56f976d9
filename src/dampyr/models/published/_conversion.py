r"""From the letters of the literature, in SI, to the laws of the parts.

The sources give alpha, c0 and c1 as polynomials of the input u. Those of `bouc_wen` are polynomials still, since
:math:`k_w = \alpha z_\max`. Those of `modified_bouc_wen` are ratios of two, :math:`v_c = k_w/c_1`, :math:`r = c_0/c_1`,
:math:`\kappa = k_0/k_w`; they are interpolated at knots that crowd where the denominator is small, and stay within 1e-4 of
the ratio.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dampyr.models.laws import Constant, Interpolation, Law, Polynomial
from dampyr.models.parts.bouc_wen import PrintedBoucWen as BoucWenPrinted

KNOTS = 65  # of a ratio; they keep it within 1e-4
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}  # m
LINEAR = {"c0": ["c0a", "c0b"], "c1": ["c1a", "c1b"], "alpha": ["alpha_a", "alpha_b"]}

Laws = dict[str, Law | float]


@dataclass(frozen=True)
class PrintedSet:
    """The printed numbers of a set by the letters of the models, gamma with \\|v\\| z, in SI.

    ``numbers`` has them by the letters of the source, ``letters`` the letters that differ, ``length`` the unit of length in m.
    """

    numbers: Mapping[str, float]
    letters: Mapping[str, str | list[str]]
    length: float

    def scalar(self, letter: str) -> float:
        """One number as printed; 0 where the source has none."""
        return self.numbers.get(str(self.letters.get(letter, letter)), 0.0)

    def stiffness(self, letter: str) -> float:
        """One number in N/m."""
        return self.scalar(letter) / self.length

    def polynomial(self, letter: str) -> list[float]:
        """Coefficients per unit of length, in rising powers of the input."""
        return [self.numbers[name] / self.length for name in self.letters.get(letter, LINEAR[letter])]

    @property
    def z_max(self) -> float:
        """The ultimate value of z in m."""
        return BoucWenPrinted(0.0, 0.0, 1.0, self.scalar("A"), *self._shape(), self.scalar("n")).z_max

    def _shape(self) -> tuple[float, float]:
        """beta and gamma."""
        power = self.length ** self.scalar("n")
        return self.scalar("beta") / power, self.scalar("gamma") / power

    def shape(self, part: str, limits: tuple[float, float]) -> Laws:
        """The laws of rho, sigma and n."""
        beta, gamma = self._shape()
        return {
            f"{part}.rho": Constant(self.scalar("A") / self.z_max, *limits),
            f"{part}.sigma": Constant(gamma / (beta + gamma), *limits),
            f"{part}.n": Constant(self.scalar("n"), *limits),
        }


def bouc_wen(p: PrintedSet, limits: tuple[float, float]) -> Laws:
    """The laws of `bouc_wen` without its spring."""
    return {
        "bouc_wen.c0": Polynomial(tuple(p.polynomial("c0")), *limits),
        "bouc_wen.k0": Constant(0.0, *limits),
        "bouc_wen.kw": Polynomial(tuple(a * p.z_max for a in p.polynomial("alpha")), *limits),
        **p.shape("bouc_wen", limits),
    }


def modified_bouc_wen(p: PrintedSet, limits: tuple[float, float]) -> Laws:
    """The laws of `modified_bouc_wen`, and of an `offset`: the printed f0, or that of the spring k1 (x - x0)."""
    kw, c1 = [a * p.z_max for a in p.polynomial("alpha")], p.polynomial("c1")
    laws: Laws = {
        "modified_bouc_wen.kw": Polynomial(tuple(kw), *limits),
        "modified_bouc_wen.k1": Constant(p.stiffness("k1"), *limits),
        "modified_bouc_wen.vc": ratio(kw, c1, limits),
        "modified_bouc_wen.r": ratio(p.polynomial("c0"), c1, limits),
        "modified_bouc_wen.kappa": ratio([p.stiffness("k0")], kw, limits),
        **p.shape("modified_bouc_wen", limits),
    }
    offset = p.scalar("f0") or -p.stiffness("k1") * p.scalar("x0") * p.length
    return laws | {"offset.f0": offset} if offset else laws


MODELS = {"bouc_wen": bouc_wen, "modified_bouc_wen": modified_bouc_wen}


def ratio(above: Sequence[float], below: Sequence[float], limits: tuple[float, float]) -> Interpolation:
    """``above/below``, two polynomials in rising powers, as a law between the limits."""
    low, high = limits
    u = low + (high - low) * np.linspace(0.0, 1.0, KNOTS) ** 2
    values = np.polynomial.polynomial.polyval(u, above) / np.polynomial.polynomial.polyval(u, below)
    return Interpolation(tuple(map(float, u)), tuple(map(float, values)))
