"""Comma-separated columns, see :mod:`dampyr.records.columns`; semicolons and tabs are read too."""

from pathlib import Path

from dampyr.records import columns
from dampyr.records.files import Request
from dampyr.records.record import Record


def read(path: Path, request: Request) -> Record:
    """The record in a ``.csv`` file, in SI."""
    return columns.read(path, request, "CSV")
