"""A data file that a result was made from: its name and its SHA-256, so that years later it is recognised."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from pathlib import Path

from dampyr.errors import FileError, InputError

BLOCK = 1 << 20  # bytes that are in memory at a time
SHOWN_DIGITS = 12  # of a checksum that a line has room for: enough to tell any two files apart


@dataclass(frozen=True, order=True)
class SourceFile:
    """The name of a file, without its folder, and the SHA-256 of its bytes in hexadecimal digits."""

    name: str
    sha256: str

    def __str__(self) -> str:
        return f"{self.sha256}  {self.name}"

    @classmethod
    def from_line(cls, line: str) -> SourceFile:
        """That of a line as ``str`` gives it and ``sha256sum`` writes it; InputError where it is not one."""
        sha256, _, name = line.partition("  ")
        if not (name and re.fullmatch("[0-9a-f]{64}", sha256)):
            raise InputError(
                f"{line!r} is not a SHA-256, 64 hexadecimal digits, two spaces and a file's name; correct it"
            )
        return cls(name, sha256)


def source_file(path: str | Path) -> SourceFile:
    """The file at ``path`` as it is now; raises OSError where it cannot be read."""
    path, digest = Path(path), hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(BLOCK):
            digest.update(block)
    return SourceFile(path.name, digest.hexdigest())


def check_name(path: Path) -> None:
    """Raise :class:`~dampyr.errors.FileError` for a name that no card, page or JSON can hold, as old archives have them."""
    try:
        path.name.encode()
    except UnicodeEncodeError:
        raise FileError(ascii(path.name), "the name of this file is not in UTF-8; rename it") from None
