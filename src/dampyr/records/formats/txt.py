"""Columns of plain text, see :mod:`dampyr.records.text_columns`: white space, tabs, commas or semicolons."""

from pathlib import Path

from dampyr.records import text_columns
from dampyr.records.record import Record
from dampyr.records.record_files import Request

TITLE = "text"
PLAIN_TEXT = True


def read(path: Path, request: Request) -> Record:
    """The record in a ``.txt`` file, in SI."""
    return text_columns.read(path, request, "text")
