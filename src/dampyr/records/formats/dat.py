"""Columns of plain text as testing machines write them, see :mod:`dampyr.records.text_columns`: as ``.txt``."""

from pathlib import Path

from dampyr.records import text_columns
from dampyr.records.record import Record
from dampyr.records.record_files import Request

TITLE = "text"
PLAIN_TEXT = True


def read(path: Path, request: Request) -> Record:
    """The record in a ``.dat`` file, in SI."""
    return text_columns.read(path, request, "text")
