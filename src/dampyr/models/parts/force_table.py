r"""The force table: force against speed at six speeds, in extension and in compression, straight between them.

.. math:: F = \operatorname{sgn}(v) \sum_{i=1}^6 d_i\, \operatorname{clip}\!\left(\frac{|v| - s_{i-1}}{w_i}, 0, 1\right),
          \qquad s_i = w_1 + \dots + w_i, \qquad d_i = \begin{cases} e_i & v \ge 0 \\ c_i & v < 0 \end{cases}

as the sheet of a shock dyno states it, of any damper without memory. :math:`w_i` is the step of the speed from one row of the
sheet to the next, :math:`e_i` and :math:`c_i` by how much the force rises over it in extension (rebound) and in compression
(bump): as no rise is negative, the table is monotone. Beyond the last speed the last slope goes on: the sixth share is not held
at 1. `from_sheet` reads a sheet of text and `from_rows` takes numbers; of more than six rows the six are kept between which
straight lines leave the others least, and a warning says by how much.

A sheet has no gas force and no friction: forces at a speed of 0 are refused, take them off first and add `offset` or `bingham`.
It has no memory, so a loop in the force-velocity plane needs `compliance` beside it. In a fit the speeds are best held at those
of interest (``fixed=`` of w1 to w6): then all numbers that are left are linear. Where they are searched, a single start may end
with a row within a straight piece and none at a kink, so a fit has thirty unless it is told otherwise (``starts=``), and still
may. Of the last row only the slopes e6/w6 and c6/w6 can be known, and of a kink beyond the speed of the records nothing.

It dissipates whatever the motion.

The piecewise linear characteristic of shock absorbers, as in Dixon (2007), The Shock Absorber Handbook.
"""

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np

from dampyr.channel_columns import TextOptions, check_cells, check_units, columns_of, in_si
from dampyr.errors import DampyrWarning, FileError, InputError
from dampyr.models.part import Scale, checked
from dampyr.models.parts._slip import slip
from dampyr.text_table import read_table
from dampyr.units import Quantity

Numbers = Sequence[float] | np.ndarray
ROWS = 6
SEARCH_STARTS = 30  # a row that lies within a straight piece stays there
CONSTANT = ("w1", "w2", "w3", "w4", "w5", "w6")  # the rows of a sheet are at the same speeds whatever the input
EXAMPLE = {
    "w1": 0.002,
    "w2": 0.004,
    "w3": 0.01,
    "w4": 0.02,
    "w5": 0.04,
    "w6": 0.06,
    "e1": 150.0,
    "e2": 100.0,
    "e3": 60.0,
    "e4": 40.0,
    "e5": 60.0,
    "e6": 80.0,
    "c1": 80.0,
    "c2": 60.0,
    "c3": 40.0,
    "c4": 30.0,
    "c5": 40.0,
    "c6": 50.0,
}


@checked
@dataclass(frozen=True)
class ForceTable:
    """Steps of the speed ``w1`` to ``w6``; rises of the force over them in extension, ``e1``, and compression, ``c1``."""

    w1: Annotated[float, Quantity("m/s", low=0, open_low=True)]
    w2: Annotated[float, Quantity("m/s", low=0, open_low=True)]
    w3: Annotated[float, Quantity("m/s", low=0, open_low=True)]
    w4: Annotated[float, Quantity("m/s", low=0, open_low=True)]
    w5: Annotated[float, Quantity("m/s", low=0, open_low=True)]
    w6: Annotated[float, Quantity("m/s", low=0, open_low=True)]
    e1: Annotated[float, Quantity("N", low=0, linear=True)]
    e2: Annotated[float, Quantity("N", low=0, linear=True)]
    e3: Annotated[float, Quantity("N", low=0, linear=True)]
    e4: Annotated[float, Quantity("N", low=0, linear=True)]
    e5: Annotated[float, Quantity("N", low=0, linear=True)]
    e6: Annotated[float, Quantity("N", low=0, linear=True)]
    c1: Annotated[float, Quantity("N", low=0, linear=True)]
    c2: Annotated[float, Quantity("N", low=0, linear=True)]
    c3: Annotated[float, Quantity("N", low=0, linear=True)]
    c4: Annotated[float, Quantity("N", low=0, linear=True)]
    c5: Annotated[float, Quantity("N", low=0, linear=True)]
    c6: Annotated[float, Quantity("N", low=0, linear=True)]


def force(
    v: float, w1: float, w2: float, w3: float, w4: float, w5: float, w6: float,
    e1: float, e2: float, e3: float, e4: float, e5: float, e6: float,
    c1: float, c2: float, c3: float, c4: float, c5: float, c6: float,
) -> float:  # fmt: skip
    u = abs(v)
    r1 = 0.5 + 0.5 * slip(-1.0, 2.0 * u / w1)
    r2 = 0.5 + 0.5 * slip(-1.0, 2.0 * (u - w1) / w2)
    r3 = 0.5 + 0.5 * slip(-1.0, 2.0 * (u - w1 - w2) / w3)
    r4 = 0.5 + 0.5 * slip(-1.0, 2.0 * (u - w1 - w2 - w3) / w4)
    r5 = 0.5 + 0.5 * slip(-1.0, 2.0 * (u - w1 - w2 - w3 - w4) / w5)
    r6 = (u - w1 - w2 - w3 - w4 - w5) / w6
    if r6 < 0.0:
        r6 = 0.0
    if v < 0.0:
        return -(c1 * r1 + c2 * r2 + c3 * r3 + c4 * r4 + c5 * r5 + c6 * r6)
    return e1 * r1 + e2 * r2 + e3 * r3 + e4 * r4 + e5 * r5 + e6 * r6


def starts(scale: Scale) -> Iterator[dict[str, float]]:
    for parts in ((0.03, 0.03, 0.06, 0.13, 0.25, 0.5), (0.1, 0.15, 0.15, 0.2, 0.2, 0.2)):
        yield {key: part * scale.speed for key, part in zip(CONSTANT, parts, strict=True)}


def from_rows(speeds: Numbers, extension: Numbers, compression: Numbers) -> ForceTable:
    """The table through the rows of a sheet: speeds [m/s], and sizes of the forces [N] at them in each direction.

    The speeds rise from row to row, and no force falls. Fewer than six rows are continued by their last slope; of more, six
    are kept and a :class:`~dampyr.errors.DampyrWarning` says how far the table is from the others at most. A first row at a
    speed of 0 must have no force. Raises :class:`~dampyr.errors.InputError` otherwise.
    """
    sides = (speeds, extension, compression)
    if (
        len({np.size(side) for side in sides}) > 1
        or np.size(speeds) == 0
        or not np.isfinite(np.concatenate(sides)).all()
    ):
        raise InputError(
            f"a table needs a speed and two forces, finite numbers, in each of its rows; there are {np.size(speeds)} speeds, "
            f"{np.size(extension)} and {np.size(compression)} forces"
        )
    s, forces = np.array(speeds, dtype=float), np.abs(np.array([extension, compression], dtype=float))
    if s[0] == 0.0:
        if forces[:, 0].any():
            raise InputError(
                f"the forces at a speed of 0 are {forces[0, 0]:g} and {forces[1, 0]:g} N; take gas force and friction off all "
                "rows first, and add offset or bingham to the table"
            )
        s, forces = s[1:], forces[:, 1:]
    if s.size == 0 or s[0] < 0.0 or np.any(np.diff(s) <= 0.0):
        raise InputError(
            f"the speeds {', '.join(f'{one:g}' for one in s)} m/s do not rise from above 0; sort the rows by speed"
        )
    for name, row in zip(("extension", "compression"), forces, strict=True):
        fall = np.flatnonzero(np.diff(row) < 0.0)
        if fall.size:
            k = int(fall[0])
            raise InputError(
                f"in {name} the force falls from {row[k]:g} N at {s[k]:g} m/s to {row[k + 1]:g} N at {s[k + 1]:g} m/s; a table "
                "must not fall: smooth these rows or leave one out"
            )
    s, forces = np.append(0.0, s), np.column_stack(([0.0, 0.0], forces))
    kept = _keep_rows(s, forces)
    s, forces = s[kept], forces[:, kept]
    while s.size <= ROWS:
        s, forces = np.append(s, 2.0 * s[-1] - s[-2]), np.column_stack((forces, 2.0 * forces[:, -1] - forces[:, -2]))
    return ForceTable(*np.diff(s).tolist(), *np.diff(forces).ravel().tolist())


def _keep_rows(s: np.ndarray, forces: np.ndarray) -> list[int]:
    """0, the last row, and up to five between, each where straight lines between those before are farthest off."""
    kept = [0, s.size - 1]
    while True:
        off = np.max(np.abs([np.interp(s, s[kept], row[kept]) - row for row in forces]), axis=0)
        if len(kept) > ROWS or not off.any():
            break
        kept = sorted({*kept, int(np.argmax(off))})
    if np.any(off > 1e-9 * forces.max()):
        k = int(np.argmax(off))
        warnings.warn(
            f"a table has {ROWS} rows and the sheet {s.size - 1}: at {s[k]:g} m/s it is {off[k]:.3g} N off, and nowhere more",
            DampyrWarning,
            stacklevel=3,
        )
    return kept if len(kept) > 2 else sorted({0, 1, s.size - 1})


@dataclass(frozen=True)
class SheetOptions(TextOptions):
    """What a caller states of a sheet, which it does not state itself."""

    CHANNELS: ClassVar[Mapping[str, str]] = {"speed": "m/s", "extension": "N", "compression": "N"}


def from_sheet(path: str | Path, **options: Any) -> ForceTable:
    """The table of a sheet of text: names with their units, such as ``speed (mm/s), rebound (N), compression (N)``, then a row
    for each speed.

    The columns are found by their names (speed or velocity; extension or rebound; compression, bump or jounce), in any order;
    the signs of forces do not matter. Texts are read as those of records are, with their encodings, delimiters and decimal
    marks; ``options`` are those of `dampyr.records.read` for texts, such as ``columns={"extension": "Zug"}``,
    ``units={"speed": "in/s"}``, ``factors``, ``header``, ``delimiter``. See `from_rows`.
    """
    path, request = Path(path), SheetOptions(**options)
    table = read_table(path, request, by_number=request.is_by_number)
    used = columns_of(path, table, request)
    for what, si in request.CHANNELS.items():
        if what not in used:
            name = f"{what} ({'mm/s' if si == 'm/s' else si})"
            raise FileError(
                path,
                f"no column is the {what} (there: {table.listed()}); call it {name!r}, or give columns={{{what!r}: NAME}}",
            )
    check_cells(path, table, used)
    check_units(path, table, used, request)
    sides = {what: in_si(path, table, what, column, request)[0] for what, column in used.items()}
    return from_rows(sides["speed"], sides["extension"], sides["compression"])
