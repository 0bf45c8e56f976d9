"""Kernels of the usual work that come with a wheel, as bitcode that is not optimised yet.

Numba's front end takes more than half of the time of compiling, and what it writes depends on the version of Python and the
kind of machine alone, not on the processor. A wheel holds one archive for each of these that it was built on, and stays
portable: elsewhere, and for kernels that no archive holds, everything is compiled from its source. An entry's name holds the
kernel's key (`dampyr.models.codegen.kernel_key`), so that no kernel of other sources is loaded.
"""

from __future__ import annotations

import hashlib
import pickle
import sys
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from dampyr.models.codegen.kernel_compilers import optimised, unoptimised
from dampyr.source_digest import PACKAGE

FOLDER = PACKAGE / "kernels"  # in a wheel; tools/make_kernels.py writes it
_collections: list[dict[str, bytes]] = []  # that are open


def archive_path() -> Path:
    """The archive for this version of Python and this kind of machine."""
    from llvmlite.binding import get_process_triple

    return FOLDER / f"{sys.implementation.cache_tag}-{get_process_triple()}.zip"


def entry_name(key: str, signature: Any) -> str:
    """The name of a kernel's entry: its key, and the types of its arguments."""
    return f"{key}-{hashlib.sha256(str(signature).encode()).hexdigest()[:16]}"


def load_shipped(name: str, target: Any) -> Any:
    """The kernel that the archive holds under ``name``, compiled for this processor; None where it holds none."""
    if not (path := archive_path()).exists():
        return None
    with zipfile.ZipFile(path) as archive:
        return optimised(pickle.loads(archive.read(name)), target) if name in archive.NameToInfo else None


@contextmanager
def collected_kernels() -> Iterator[dict[str, bytes]]:
    """The kernels that are compiled within, not optimised, by the names of their entries."""
    found: dict[str, bytes] = {}
    _collections.append(found)
    try:
        yield found
    finally:
        _collections.remove(found)


def note_compiled(name: str, compiled: Any) -> None:
    """Add a kernel that was just compiled to the `collected_kernels`."""
    if _collections:
        from numba.core.serialize import dumps

        pickled = dumps(unoptimised(compiled))
        for found in _collections:
            found[name] = pickled


def write_archive(kernels: Mapping[str, bytes]) -> Path:
    """Write `collected_kernels` as this machine's archive; the same kernels make the same file."""
    path = archive_path()
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w") as archive:
        for name in sorted(kernels):
            archive.writestr(zipfile.ZipInfo(name), kernels[name], zipfile.ZIP_LZMA)
    return path
