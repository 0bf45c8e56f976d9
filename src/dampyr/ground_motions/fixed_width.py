"""Numbers in fields of equal width, as Fortran writes them: they may touch, ``1.5057E+0-2.2223E+0``."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import FileError

Array = NDArray[np.float64]
DESCRIPTOR = re.compile(r"\(\s*(?:\dP,?)?\s*\d*\s*[FEGI](\d+)(?:\.\d+)?\s*\)", re.IGNORECASE)


def width_of(descriptor: str, default: int) -> int:
    """The width of a field by a Fortran format in a text, such as 10 for ``(8F10.5)``; ``default`` where there is none."""
    match = DESCRIPTOR.search(descriptor)
    return int(match[1]) if match else default


def read_fields(
    path: Path, lines: Sequence[str], first: int, count: int, width: int, offset: int = 0, whole: bool = True
) -> tuple[Array, int]:
    """``count`` numbers from the line ``first`` (from 0) on, and the line after them; ``offset`` blanks begin each line.

    ``whole``: nothing else stands on the last of these lines.

    Raises :class:`~dampyr.errors.FileError` where a field is not a number, or fewer numbers follow than the header says.
    """
    values: list[float] = []
    number = first
    while len(values) < count:
        if number >= len(lines):
            raise FileError(
                path, f"the header says {count} values but {len(values)} follow; the file was cut, so fetch it again"
            )
        line = lines[number].rstrip()
        for start in range(offset, len(line), width):
            field = line[start : start + width].strip()
            try:
                values.append(float(field.replace("D", "E").replace("d", "e")))
            except ValueError:
                raise FileError(
                    path,
                    f"line {number + 1}, columns {start + 1} to {start + width}: {field!r} is not a number "
                    f"({len(values)} of {count} values were read); fetch the file again",
                ) from None
        number += 1
    if whole and len(values) > count:
        raise FileError(
            path, f"line {number} holds {len(values) - count} values more than the {count} that the header says"
        )
    return np.array(values[:count]), number


def header_numbers(path: Path, lines: Sequence[str], first: int, count: int, width: int, per_line: int) -> Array:
    """The block of ``count`` numbers in a header, ``per_line`` of them a line."""
    rows = math.ceil(count / per_line)
    if len(lines) < first + rows:
        raise FileError(path, f"lines {first + 1} to {first + rows} of the header are missing; fetch the file again")
    # what stands beyond the last column of numbers is a comment
    block = [*lines[:first], *(line[: width * per_line] for line in lines[first : first + rows])]
    return read_fields(path, block, first, count, width, whole=False)[0]
