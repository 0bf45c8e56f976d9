"""Columns of plain text as testing machines write them, see :mod:`dampyr.text_table`: as ``.txt``."""

from pathlib import Path

from dampyr.records.files.column_table import read_text
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import Record

TITLE = "text"
PLAIN_TEXT = True


def read(path: Path, request: ReadOptions) -> Record:
    """The record in a ``.dat`` file, in SI."""
    return read_text(path, request, "text")
