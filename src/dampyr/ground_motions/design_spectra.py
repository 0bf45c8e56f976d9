r"""Design spectra of ASCE 7 and Eurocode 8 beside a motion's, and the motion scaled to one by least squares.

ASCE 7, 11.4 (2005 to 2016, two-period spectrum), with :math:`T_0 = 0.2\,T_S` and :math:`T_S = S_{D1}/S_{DS}`:

.. math:: S_a = S_{DS}(0.4 + 0.6\,T/T_0),\quad S_{DS},\quad S_{D1}/T,\quad S_{D1} T_L/T^2

below :math:`T_0`, to :math:`T_S`, to :math:`T_L` and above. EN 1998-1:2004, 3.2.2.2, horizontal elastic spectrum to 4 s, with
:math:`\eta = \sqrt{10/(5+\xi)} \ge 0.55`, :math:`\xi` the damping in percent:

.. math:: S_e = a_g S\,[1 + (T/T_B)(2.5\,\eta - 1)],\quad 2.5\,\eta\,a_g S,\quad 2.5\,\eta\,a_g S\,T_C/T,\quad
          2.5\,\eta\,a_g S\,T_C T_D/T^2

below :math:`T_B`, to :math:`T_C`, to :math:`T_D` and to 4 s. The codes themselves were not read: the values of tables 3.2 and
3.3 of EN 1998-1 are those of several independent transcriptions that agree, the formulas of ASCE 7 those of one (of ASCE 7-10).
A national annex may have other values.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.errors import FileError, InputError
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.response_spectrum import spectrum
from dampyr.shown import Shown
from dampyr.units import in_si, parse

Array = NDArray[np.float64]

EN_1998_1 = {
    1: {"A": (1.0, 0.15, 0.4, 2.0), "B": (1.2, 0.15, 0.5, 2.0), "C": (1.15, 0.2, 0.6, 2.0), "D": (1.35, 0.2, 0.8, 2.0),
        "E": (1.4, 0.15, 0.5, 2.0)},
    2: {"A": (1.0, 0.05, 0.25, 1.2), "B": (1.35, 0.05, 0.25, 1.2), "C": (1.5, 0.1, 0.25, 1.2), "D": (1.8, 0.1, 0.3, 1.2),
        "E": (1.6, 0.05, 0.25, 1.2)},
}  # fmt: skip
"""S, T_B, T_C and T_D [s] by type of the spectrum and type of the ground."""
EN_1998_LONGEST = 4.0  # s
LEAST_ETA = 0.55
FIT_PERIODS = 100  # of a range, evenly spaced in the logarithm
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_WORD = re.compile(r"[^\d\s,;.eE+-]")  # what no line of two numbers has


@dataclass(frozen=True)
class DesignSpectrum:
    """A spectrum of a code, in four branches: pseudo-acceleration [m/s2] over the period.

    It rises from ``zero_period`` [m/s2] to ``plateau`` [m/s2] at ``corners[0]`` [s], stays there to ``corners[1]``, falls with
    1/T to ``corners[2]`` and with 1/T^2 above, to ``longest`` [s]. ``damping`` is the ratio that it is for.
    """

    name: str
    zero_period: float
    plateau: float
    corners: tuple[float, float, float]
    damping: float = 0.05
    longest: float = np.inf

    def at(self, periods: ArrayLike) -> Array:
        """Pseudo-accelerations [m/s2] at periods [s], ``(p,)``; InputError outside of 0 to the longest."""
        T = np.array(in_si(periods, "s", "the periods"), dtype=np.float64)
        wrong = T[~((T >= 0.0) & (self.longest >= T))]
        if wrong.size:
            raise InputError(
                f"a period of {wrong.flat[0]:g} s is outside of the spectrum {self.name}, from 0 to {self.longest:g} s; "
                "leave it out"
            )
        first, second, third = self.corners
        rising = self.zero_period + (self.plateau - self.zero_period) * np.minimum(T / first, 1.0)
        long = np.maximum(T, second)
        return np.asarray(rising * second / long * np.minimum(third / long, 1.0))


@dataclass(frozen=True, eq=False, repr=False)
class TableSpectrum:
    """A wanted spectrum as a table: ``accelerations`` (p,) [m/s2] at rising ``periods`` (p,) [s], at a ``damping`` ratio.

    Between two periods it is straight over logarithms, as codes are; from a period of 0 on over the numbers themselves.
    Quantities and labelled arrays are converted from their units.

    >>> import dampyr as dp
    >>> wanted = dp.ground_motions.TableSpectrum("site study", [0.1, 0.5, 2.0], [4.0, 8.0, 2.0])
    >>> wanted.at([0.1, 1.0]).round(6).tolist()
    [4.0, 4.0]
    """

    name: str
    periods: Array
    accelerations: Array
    damping: float = 0.05

    def __repr__(self) -> str:
        ends = f"{self.periods[0]:g} to {self.longest:g} s"
        return f"TableSpectrum({self.name!r}, {len(self.periods)} periods from {ends}, damping={self.damping:g})"

    def __post_init__(self) -> None:
        T = np.array(in_si(self.periods, "s", f"{self.name}: the periods"), dtype=np.float64)
        a = np.array(in_si(self.accelerations, "m/s^2", f"{self.name}: the accelerations"), dtype=np.float64)
        if T.ndim != 1 or T.shape != a.shape or len(T) < 2:
            raise InputError(
                f"{self.name}: periods have shape {T.shape} and accelerations {a.shape}; give one row of each, of two "
                "numbers or more"
            )
        if not (np.all(np.isfinite(T)) and T[0] >= 0.0 and np.all(np.diff(T) > 0.0)):
            raise InputError(f"{self.name}: the periods must be finite, at least 0 and rise; sort them, each once")
        if not np.all(np.isfinite(a) & (a > 0.0)):
            raise InputError(
                f"{self.name}: the accelerations must be finite and greater than 0; the least is {a.min():g}"
            )
        if not 0.0 < self.damping < 1.0:
            raise InputError(f"damping = {self.damping!r} is not allowed; it must be greater than 0 and less than 1")
        for name, values in (("periods", T), ("accelerations", a)):
            values.flags.writeable = False
            object.__setattr__(self, name, values)

    @property
    def longest(self) -> float:
        """The last period, s."""
        return float(self.periods[-1])

    def at(self, periods: ArrayLike) -> Array:
        """Pseudo-accelerations [m/s2] at periods [s], ``(p,)``; InputError outside of the table."""
        T = np.array(in_si(periods, "s", "the periods"), dtype=np.float64)
        first, last = float(self.periods[0]), self.longest
        wrong = T[~((first * (1 - 1e-9) <= T) & (last * (1 + 1e-9) >= T))]
        if wrong.size:
            raise InputError(
                f"a period of {wrong.flat[0]:g} s is outside of the spectrum {self.name}, from {first:g} to {last:g} s; "
                "leave it out"
            )
        straight = np.interp(T, self.periods, self.accelerations)
        known = self.periods > 0.0
        if np.sum(known) < 2:
            return np.asarray(straight)
        with np.errstate(divide="ignore"):
            over_log = np.exp(np.interp(np.log(T), np.log(self.periods[known]), np.log(self.accelerations[known])))
        return np.where(self.periods[known][0] * (1 - 1e-9) > T, straight, over_log)


def read_table_spectrum(path: str | Path, unit: str | None = None, damping: float = 0.05) -> TableSpectrum:
    """A wanted spectrum from a text file of two columns, the period in s and the acceleration.

    Numbers may be parted by commas, semicolons, tabs or spaces; lines without two numbers are passed over, and name the unit of
    the acceleration in brackets (``Sa [g]``) where ``unit`` does not.

    Raises :class:`~dampyr.errors.FileError` where the file is not there or has no such columns, and InputError as
    `TableSpectrum`.
    """
    path = Path(path)
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as problem:
        raise FileError(path, f"cannot be read as text ({problem}); give a file of periods and accelerations") from None
    rows, above = [], []
    for line in lines:
        numbers = _NUMBER.findall(line)
        if len(numbers) == 2 and not _WORD.search(line):
            rows.append([float(number) for number in numbers])
        elif not rows:
            above.append(line)
    if len(rows) < 2:
        raise FileError(
            path, "has no two lines of a period and an acceleration; write one in each line, as in 0.5, 0.75"
        )
    named = [name for name in re.findall(r"[\[(]([^\])]+)[\])]", " ".join(above)) if name.strip() not in ("s", "sec")]
    if unit is None and not named:
        raise InputError(
            f"{path}: the unit of the acceleration is not stated; give it, such as unit=g, or write Sa [g] above"
        )
    table = np.array(rows)
    factor = parse(f"1 {unit or named[-1].strip()}", "m/s^2")
    return TableSpectrum(path.name, table[:, 0], factor * table[:, 1], damping)


def asce_7(sds: float, sd1: float, tl: float) -> DesignSpectrum:
    """The design spectrum of ASCE 7 at 5 % damping, from ``sds`` and ``sd1`` [m/s2] and the long period ``tl`` [s].

    >>> import dampyr as dp
    >>> dp.ground_motions.asce_7(sds=10.0, sd1=6.0, tl=8.0).at([0.0, 0.3, 1.0, 10.0]).tolist()
    [4.0, 10.0, 6.0, 0.48]
    """
    sds, sd1, tl = in_si(sds, "m/s^2", "sds"), in_si(sd1, "m/s^2", "sd1"), in_si(tl, "s", "tl")
    _check(sds=sds, sd1=sd1, tl=tl)
    if sd1 / sds > tl:
        raise InputError(
            f"sd1/sds = {sd1 / sds:g} s is longer than tl = {tl:g} s; give the long-period transition, 4 to 16 s"
        )
    return DesignSpectrum("ASCE 7", 0.4 * sds, sds, (0.2 * sd1 / sds, sd1 / sds, tl))


def eurocode_8(ag: float, ground: str, kind: int = 1, damping: float = 0.05) -> DesignSpectrum:
    """The elastic spectrum of EN 1998-1 for ``ag`` [m/s2] on rock, ground A to E, type 1 or 2 and a damping ratio.

    >>> import dampyr as dp
    >>> dp.ground_motions.eurocode_8(ag=2.0, ground="C").at([0.0, 0.4, 1.0, 3.0]).round(4)
    array([2.3   , 5.75  , 3.45  , 0.7667])
    """
    ag = in_si(ag, "m/s^2", "ag")
    _check(ag=ag)
    if kind not in EN_1998_1:
        raise InputError(f"type {kind!r} is not one of EN 1998-1; choose 1, or 2 where no earthquake is above Ms 5.5")
    if ground not in EN_1998_1[kind]:
        raise InputError(f"ground {ground!r} has no spectrum in EN 1998-1; choose from {', '.join(EN_1998_1[kind])}")
    if not 0.0 < damping < 1.0:
        raise InputError(f"damping = {damping!r} is not allowed; it must be greater than 0 and less than 1")
    s, *corners = EN_1998_1[kind][ground]
    eta = max(float(np.sqrt(10.0 / (5.0 + 100.0 * damping))), LEAST_ETA)
    name = f"EN 1998-1 type {kind}, ground {ground}"
    first, second, third = corners
    return DesignSpectrum(name, ag * s, 2.5 * eta * ag * s, (first, second, third), damping, EN_1998_LONGEST)


def parse_design(text: str) -> DesignSpectrum | TableSpectrum:
    """A design spectrum as it is typed: ``asce7:sds=1g,sd1=0.6g,tl=8s``, ``ec8:ag=0.25g,ground=C,type=1,damping=0.05`` or
    ``table:FILE,unit=g,damping=0.05``."""
    code, _, rest = text.partition(":")
    if code.strip().lower() == "table":
        return _parse_table(text, rest)
    words = dict(part.strip().partition("=")[::2] for part in rest.split(","))
    known = {"asce7": ("sds", "sd1", "tl"), "ec8": ("ag", "ground", "type", "damping")}.get(code.strip().lower())
    needed = {"asce7": 3, "ec8": 2}.get(code.strip().lower(), 0)
    if known is None or any(name not in words for name in known[:needed]) or set(words) - set(known):
        raise InputError(
            f"{text!r} is not a design spectrum; write it as in asce7:sds=1g,sd1=0.6g,tl=8s, ec8:ag=0.25g,ground=C,type=1 "
            "or table:FILE,unit=g"
        )
    for name in ("sds", "sd1", "ag", "tl"):
        if words.get(name, "").replace(".", "", 1).isdigit():
            unit = "s" if name == "tl" else "g"
            raise InputError(f"{name} = {words[name]} has no unit; write it as in {name}={words[name]}{unit}")
    if known[0] == "sds":
        return asce_7(parse(words["sds"], "m/s^2"), parse(words["sd1"], "m/s^2"), parse(words["tl"], "s"))
    kind = words.get("type", "1")
    return eurocode_8(
        parse(words["ag"], "m/s^2"), words["ground"].strip().upper(), int(kind) if kind.isdigit() else 0, _ratio(words)
    )


def _parse_table(text: str, rest: str) -> TableSpectrum:
    path, *parts = rest.split(",")
    words = dict(part.strip().partition("=")[::2] for part in parts)
    if not path.strip() or set(words) - {"unit", "damping"}:
        raise InputError(f"{text!r} is not a table of a spectrum; write it as in table:FILE.csv,unit=g,damping=5%")
    return read_table_spectrum(path.strip(), words.get("unit"), _ratio(words))


def _ratio(words: Mapping[str, str]) -> float:
    damping = words.get("damping", "5%")
    return parse(damping.removesuffix("%"), "dimensionless") * (0.01 if damping.endswith("%") else 1.0)


@dataclass(frozen=True, eq=False, repr=False)
class DesignComparison(Shown):
    """The pseudo-accelerations of a motion and of a design spectrum, ``(p,)`` m/s2 at ``periods`` s."""

    motion: str
    design: DesignSpectrum | TableSpectrum
    periods: Array
    pseudo_acceleration: Array
    design_acceleration: Array

    @property
    def ratio(self) -> Array:
        """The motion's over the code's, ``(p,)``."""
        return self.pseudo_acceleration / self.design_acceleration


def compare_with_design(
    motion: GroundMotion, design: DesignSpectrum | TableSpectrum, periods: ArrayLike
) -> DesignComparison:
    """The spectrum of a motion beside a design spectrum, at the damping of the latter, at ``periods`` [s]."""
    T = np.atleast_1d(np.array(in_si(periods, "s", "the periods"), dtype=np.float64))
    wanted = design.at(T)
    return DesignComparison(
        motion.name, design, T, spectrum(motion, T, design.damping).pseudo_acceleration.reshape(T.shape), wanted
    )


def scaled_to_design(
    motion: GroundMotion, design: DesignSpectrum | TableSpectrum, low: float, high: float
) -> GroundMotion:
    r"""The motion times the factor that brings its spectrum nearest to a design spectrum between two periods [s].

    .. math:: f = \sum_i S_a(T_i)\,S_d(T_i) \Big/ \sum_i S_a(T_i)^2

    over 100 periods, evenly spaced in the logarithm: the least squares of the differences :math:`f S_a - S_d`. The damping is
    that of the design spectrum, and the history says the factor.

    >>> import dampyr as dp
    >>> design = dp.ground_motions.asce_7(sds=10.0, sd1=6.0, tl=8.0)
    >>> dp.ground_motions.scaled_to_design(dp.ground_motions.el_centro(), design, 0.2, 2.0).name
    'El Centro 1940 NS x 1.33176'
    """
    low, high = in_si(low, "s", "the shortest period"), in_si(high, "s", "the longest period")
    if not 0.0 < low < high:
        raise InputError(
            f"the periods from {low:g} to {high:g} s are no range; give the shorter one first, greater than 0"
        )
    compared = compare_with_design(motion, design, np.geomspace(low, high, FIT_PERIODS))
    own = compared.pseudo_acceleration
    if not np.any(own > 0.0):
        raise InputError(f"{motion.name} is 0 throughout and cannot be scaled to {design.name}; take another one")
    factor = float(own @ compared.design_acceleration / (own @ own))
    note = (
        f"scaled by {factor:.6g}, by least squares to {design.name} at {100 * design.damping:g} % damping from {low:g} to "
        f"{high:g} s"
    )
    return replace(motion.scaled(factor), history=(*motion.history, note))


def _check(**values: float) -> None:
    for name, value in values.items():
        if not (np.isfinite(value) and value > 0.0):
            raise InputError(f"{name} = {value!r} is not allowed; it must be finite and greater than 0")
