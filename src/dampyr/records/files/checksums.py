"""Checksums of what a record's file holds, SHA-256, as JSON in its attribute ``sha256``: one per dataset and the attributes'.

That of a dataset is over its values, little-endian in their order, texts as UTF-8 each followed by a zero byte; that of the
attributes over their JSON, names sorted, by object. A damaged disk or copy is reported with the name of what differs.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.errors import FileError

NAME = "sha256"
ATTRIBUTES = "attributes"
ROOT = ("format", "schema", "complete", "name", "role", "test", "try", "measurement_session", "specimen")
GROUPS = ("label", "smoothed", "provenance")
INTERCHANGE = ("units", "CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST")
"""Attributes for other readers, which say nothing that is not said elsewhere: no checksum is over them."""
REPAIR = (
    "record or copy the test again (dampyr run has --again for it), or delete the attribute "
    f"{NAME} of / where the file was changed on purpose"
)

Attributes = Mapping[str, Mapping[str, Any]]


class Checksums:
    """The checksums of a file that is being written: values are added in their order, piece by piece."""

    def __init__(self) -> None:
        self._hashes: dict[str, Any] = {}

    def add(self, name: str, values: Any) -> None:
        """Further values of a dataset."""
        self._hashes.setdefault(name, hashlib.sha256()).update(_bytes(values))

    def write(self, file: Any) -> None:
        """Write them; everything else is in the file already."""
        sums = {name: digest.hexdigest() for name, digest in self._hashes.items()}
        file.attrs[NAME] = json.dumps(sums | {ATTRIBUTES: _sum_of(attributes_of(file), sums)})


class Stored:
    """The checksums that a file holds; none in files of before 2026-11-23 and in those under way.

    Raises :class:`~dampyr.errors.FileError` where the ``attributes`` of the file's objects are not those that were written.
    """

    def __init__(self, path: Path, attributes: Attributes) -> None:
        self.path, text = path, attributes["/"].get(NAME)
        try:
            self._sums: dict[str, str] = {} if text is None else json.loads(text)
        except ValueError:
            raise FileError(path, f"its checksums are damaged; {REPAIR}") from None
        if text is not None and self._sums.get(ATTRIBUTES) != _sum_of(attributes, self._sums):
            raise FileError(path, f"its attributes are not what was written, their SHA-256 differs; {REPAIR}")
        for name in self._sums.keys() - attributes.keys() - {ATTRIBUTES}:
            raise FileError(path, f"/{name} is missing, or its checksum is damaged; {REPAIR}")

    def check(self, name: str, values: Any) -> None:
        """Raise :class:`~dampyr.errors.FileError` where a dataset's values are not those that were written."""
        if name in self._sums and hashlib.sha256(_bytes(values)).hexdigest() != self._sums[name]:
            raise FileError(self.path, f"/{name} is not what was written, its SHA-256 differs; {REPAIR}")


def attributes_of(file: Any) -> Attributes:
    """The attributes of the root, of its groups and of what is in them, by path; a record's file is not deeper."""
    attributes = {"/": dict(file.attrs)}
    for name, member in _members(file):
        attributes[name] = dict(member.attrs)
        attributes |= {f"{name}/{inner}": dict(data.attrs) for inner, data in _members(member)}
    return attributes


def _members(group: Any) -> list[tuple[str, Any]]:
    """What is in a group, but for links that lead nowhere; nothing where it is a dataset."""
    return [(name, member) for name, member in group.items() if member is not None] if hasattr(group, "items") else []


def _sum_of(attributes: Attributes, datasets: Iterable[str]) -> str:
    """Of a record's own attributes: what somebody added elsewhere in the file is theirs."""
    root = {name: value for name, value in attributes["/"].items() if name in ROOT}
    covered = {name: attributes[name] for name in (*datasets, *GROUPS) if name in attributes}
    plain = {
        path: {name: _plain(value) for name, value in entries.items() if name not in INTERCHANGE}
        for path, entries in ({"/": root} | covered).items()
    }
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.generic | np.ndarray) else str(value)


def _bytes(values: Any) -> Any:
    if isinstance(values, tuple | list):
        return b"".join(str(text).encode() + b"\0" for text in values)
    array = np.asarray(values)
    array = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
    return array.reshape(-1).view(np.uint8).data if array.size else b""
