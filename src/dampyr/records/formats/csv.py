"""Comma-separated columns, see :mod:`dampyr.text_table`; semicolons and tabs are read too."""

from pathlib import Path

import numpy as np

from dampyr.atomic_write import write_whole
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

    Each number has the fewest digits that do so. Session, specimen, origin and published data set stand in lines of comment
    above the header, where they are stated.
    """
    channels = {name: getattr(record, name) for name in CHANNELS if getattr(record, name) is not None}
    columns = [map(repr, np.broadcast_to(values, record.n).tolist()) for values in channels.values()]
    comments = [f"# {name}: {value}" for name, value in stated(record).items()]
    header = ",".join(f"{name} [{CHANNELS[name]}]" for name in channels)
    write_whole(path, "\n".join([*comments, header, *map(",".join, zip(*columns, strict=True)), ""]))
    return path
