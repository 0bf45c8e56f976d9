"""Columns of plain text as testing machines write them, see :mod:`dampyr.text_table`: as ``.txt``.

A file of an MTS controller may hold several blocks, see :mod:`dampyr.records.files.mts_blocks`: each is a record, and
``variable`` is the number of one.
"""

from pathlib import Path

from dampyr.records.files import mts_blocks
from dampyr.records.files.column_table import read_text
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import Record

TITLE = "text"
PLAIN_TEXT = True


def read(path: Path, request: ReadOptions) -> Record:
    """The record in a ``.dat`` file, or in one of its blocks, in SI."""
    blocks = mts_blocks.blocks_of(path, request.encoding)
    return mts_blocks.read_block(path, blocks, request) if blocks else read_text(path, request, "text")


def parts(path: Path) -> list[str]:
    """What ``variable`` is of each record in a file that holds several; none where it holds one."""
    return [str(k + 1) for k in range(len(mts_blocks.blocks_of(path)))]
