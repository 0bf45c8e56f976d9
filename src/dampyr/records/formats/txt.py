"""Columns of plain text, see :mod:`dampyr.records.files.text_columns`: white space, tabs, commas or semicolons."""

from pathlib import Path

from dampyr.records.files import text_columns
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import Record

TITLE = "text"
PLAIN_TEXT = True


def read(path: Path, request: ReadOptions) -> Record:
    """The record in a ``.txt`` file, in SI."""
    return text_columns.read(path, request, "text")
