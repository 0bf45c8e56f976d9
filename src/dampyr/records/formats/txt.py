"""Columns of plain text, see :mod:`dampyr.text_table`: white space, tabs, commas or semicolons."""

from pathlib import Path

from dampyr.records.files.column_table import read_text
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import Record

TITLE = "text"
PLAIN_TEXT = True


def read(path: Path, request: ReadOptions) -> Record:
    """The record in a ``.txt`` file, in SI."""
    return read_text(path, request, "text")
