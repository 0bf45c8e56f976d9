"""Measured and predicted force side by side, as columns of text for a plot or another program."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.errors import FileError
from dampyr.records.record import Array, Record

SIGNATURE = "# written by dampyr: measured and predicted force"
HEADER = "time [s],displacement [m],measured force [N],predicted force [N]"


def write_comparison(record: Record, predicted: Array, path: str | Path, offset: float = 0.0) -> Path:
    """Write time (s), displacement (m), measured and predicted force (N) of a record as CSV, whole or not at all.

    ``predicted`` is ``(n,)`` in N; ``offset`` (N) is added to it and told in the second line. A file that is there is replaced
    if :func:`check_free` lets it.

    Raises
    ------
    FileError
        The folder is not there, or the file was not written by this function.
    """
    path = Path(path)
    check_free(path)
    page = io.StringIO()
    values = np.column_stack([record.time, record.displacement, record.force, predicted + offset])
    said = f"# {text}\n" if (text := record.origin.notice) else ""
    head = f"{SIGNATURE}\n{said}# record {record.name}; the predicted force holds an offset of {offset:.6g} N\n{HEADER}"
    np.savetxt(page, values, delimiter=",", header=head, comments="", fmt="%.9g")
    write_whole(path, page.getvalue())
    return path


def check_free(path: Path) -> None:
    """Raise :class:`FileError` where ``path`` is a file that :func:`write_comparison` did not write."""
    if not path.exists():
        return
    if path.is_file():
        with path.open("rb") as file:
            if file.read(len(SIGNATURE)) == SIGNATURE.encode():
                return
    raise FileError(path, "is there and was not written by dampyr; choose another folder, or move it away")


def file_name(record: Record) -> str:
    """The name of a record as that of a file: ``NAME.csv``, with ``_`` for what separates folders."""
    return f"{record.name.translate(str.maketrans('/:', '__')).replace(chr(92), '_')}.csv"
