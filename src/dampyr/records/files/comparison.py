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

    Parameters
    ----------
    record
        The measured record of n samples.
    predicted
        ``(n,)`` in N: the force of a model along the record's motion.
    path
        Where to. A file that this function wrote before is replaced.
    offset
        N, added to ``predicted`` and stated in the second line: what a fit found as the zero of the load cell; by default 0.

    Returns
    -------
    Path
        ``path``.

    Raises
    ------
    FileError
        The folder is not there, or the file was not written by this function.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> from dampyr.records.files.comparison import write_comparison
    >>> t = np.linspace(0.0, 1.0, 101)
    >>> record = dp.records.Record(t, 0.01 * np.sin(6 * t), 50.0 * np.cos(6 * t))
    >>> path = write_comparison(record, 49.0 * np.cos(6 * t), "sine.csv")
    >>> path.read_text().splitlines()[2]
    'time [s],displacement [m],measured force [N],predicted force [N]'
    """
    path = Path(path)
    check_free(path)
    text = io.StringIO()
    values = np.column_stack([record.time, record.displacement, record.force, predicted + offset])
    origin = f"# {notice}\n" if (notice := record.origin.notice) else ""
    head = (
        f"{SIGNATURE}\n{origin}# record {record.name}; the predicted force holds an offset of {offset:.6g} N\n{HEADER}"
    )
    np.savetxt(text, values, delimiter=",", header=head, comments="", fmt="%.9g")
    write_whole(path, text.getvalue())
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
