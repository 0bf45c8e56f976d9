"""A data file that a result was made from: its name and its SHA-256, so that years later it is recognised."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

BLOCK = 1 << 20  # bytes that are in memory at a time


@dataclass(frozen=True, order=True)
class SourceFile:
    """The name of a file, without its folder, and the SHA-256 of its bytes in hexadecimal digits."""

    name: str
    sha256: str


def source_file(path: str | Path) -> SourceFile:
    """The file at ``path`` as it is now; raises OSError where it cannot be read."""
    path, digest = Path(path), hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(BLOCK):
            digest.update(block)
    return SourceFile(path.name, digest.hexdigest())
