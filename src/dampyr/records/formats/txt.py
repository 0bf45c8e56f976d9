"""Columns of plain text, see :mod:`dampyr.records.columns`: white space, tabs, commas or semicolons."""

from pathlib import Path

from dampyr.records import columns
from dampyr.records.files import Request
from dampyr.records.record import Record


def read(path: Path, request: Request) -> Record:
    """The record in a ``.txt`` file, in SI."""
    return columns.read(path, request, "text")
