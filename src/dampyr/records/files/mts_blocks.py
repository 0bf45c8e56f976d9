"""Blocks of an MTS controller's text: each run of an acquisition is a block with a header of its own, and a record.

A block begins with ``Data Header:`` or ``Data Acquisition: Timed`` and has its own names, units and columns; blank lines part
the blocks. Blocks are numbered from 1.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from dampyr.errors import FileError
from dampyr.records.files.column_table import read_text
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import Record
from dampyr.text_table import decoded

ACQUISITION, HEADER = (
    re.compile(r"\s*Data Acquisition\s*:", re.IGNORECASE),
    re.compile(r"\s*Data Header\s*:", re.IGNORECASE),
)


def blocks_of(path: Path, encoding: str | None = None) -> list[str]:
    """The text of each block, below as many empty lines as the file has above it; none where it has fewer than two."""
    lines = decoded(path, encoding)[0].split("\n")
    starts = [
        k - 1 if k and HEADER.match(lines[k - 1]) else k for k, line in enumerate(lines) if ACQUISITION.match(line)
    ]
    if len(starts) < 2:
        return []
    # empty lines keep the numbers that messages name those of the file
    return [
        "\n" * start + "\n".join(_with_units(lines[start:end])) + "\n"
        for start, end in zip(starts, [*starts[1:], len(lines)], strict=True)
    ]


def _with_units(block: list[str]) -> list[str]:
    """The block with the line of its units put behind the names: a unit may be any word there, such as segments."""
    first = next((k for k, line in enumerate(block) if _is_row(line)), 0)
    names, units, row = (
        (line.rstrip("\t").split("\t") for line in block[first - 2 : first + 1]) if first > 1 else ([],) * 3
    )
    if len(names) != len(row) or len(units) != len(row):
        return block
    header = [
        f"{name.strip()} [{unit.strip()}]" if unit.strip() else name for name, unit in zip(names, units, strict=True)
    ]
    return [*block[: first - 2], "", "\t".join(header), *block[first:]]


def _is_row(line: str) -> bool:
    cells = line.rstrip("\t").split("\t")
    try:
        return len([float(cell.replace(",", ".")) for cell in cells]) > 1
    except ValueError:
        return False


def read_block(path: Path, blocks: list[str], request: ReadOptions) -> Record:
    """The record in the block that ``variable`` names by its number."""
    request.refuse(path, header="a block names its columns itself", delimiter="tabs part the columns of a block")
    count, wanted = len(blocks), request.variable
    if wanted is None:
        raise FileError(
            path,
            f"holds {count} blocks of an MTS controller, each a record; name one, --variable 1 or variable='1', or read its "
            "folder, which takes them all",
        )
    if wanted not in [str(k + 1) for k in range(count)]:
        raise FileError(path, f"there is no block {wanted!r}; choose a number from 1 to {count}")
    record = read_text(path, replace(request, variable=None), "text", blocks[int(wanted) - 1])
    return record.replace(note=f"block {wanted} of {count}", name=f"{path.stem} block {wanted}")
