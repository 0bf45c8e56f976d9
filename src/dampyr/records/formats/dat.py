"""Columns of plain text as testing machines write them, see :mod:`dampyr.records.files.text_columns`: as ``.txt``."""

from pathlib import Path

from dampyr.records.files import text_columns
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import Record

TITLE = "text"
PLAIN_TEXT = True


def read(path: Path, request: ReadOptions) -> Record:
    """The record in a ``.dat`` file, in SI."""
    return text_columns.read(path, request, "text")
