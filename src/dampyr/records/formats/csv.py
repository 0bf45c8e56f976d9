"""Comma-separated columns, see :mod:`dampyr.text_table`; semicolons and tabs are read too."""

import io
from pathlib import Path

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.errors import FileError
from dampyr.records.files.column_table import read_text
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import CHANNELS, Record, stated

TITLE, MEDIA_TYPE = "CSV", "text/csv"
PLAIN_TEXT = True


def read(path: Path, request: ReadOptions) -> Record:
    """The record in a ``.csv`` file, in SI."""
    return read_text(path, request, "CSV")


def write(record: Record, path: Path) -> Path:
    """Write a record's channels in SI, a constant input as a column, so that :func:`read` gives them back exactly.

    Session, specimen and origin stand in lines of comment above the header, where they are stated. Raises FileError for a
    record that is smoothed and not undone, which columns cannot say.
    """
    if record.smoothed is not None:
        raise FileError(path, "columns cannot say that the record is smoothed; write .h5, or undo it first")
    channels = {name: getattr(record, name) for name in CHANNELS if getattr(record, name) is not None}
    columns = [np.broadcast_to(values, record.n) for values in channels.values()]
    text = io.StringIO()
    header = ",".join(f"{name} [{CHANNELS[name]}]" for name in channels)
    comments = [f"# {name}: {value}\n" for name, value in stated(record).items()]
    np.savetxt(text, np.column_stack(columns), delimiter=",", header=header, comments="", fmt="%.17g")
    write_whole(path, "".join(comments) + text.getvalue())
    return path
