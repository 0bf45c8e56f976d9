"""Kernels of the usual work that come with a wheel: the half that numba's front end has written, for LLVM to finish.

The front end takes more than half of the time of compiling, and knows nothing of the processor; what it writes hangs on the
version of Python and the kind of machine alone. A wheel holds one archive for each of these that it was built on, and is no
less portable for it: elsewhere, and for kernels that are in no archive, everything is compiled as before. An entry's name
holds the kernel's key (`dampyr.models.codegen.kernel_key`), so that no kernel of other sources is taken.
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

from dampyr.models.codegen.kernel_compilers import finished, kept_half
from dampyr.source_digest import PACKAGE

FOLDER = PACKAGE / "kernels"  # in a wheel; tools/make_kernels.py writes it
_collected: list[dict[str, bytes]] = []  # of those who collect now


def archive() -> Path:
    """The archive for this version of Python and this kind of machine."""
    from llvmlite.binding import get_process_triple

    return FOLDER / f"{sys.implementation.cache_tag}-{get_process_triple()}.zip"


def entry(key: str, signature: Any) -> str:
    """The name of a kernel's entry: its key, and the types of its arguments."""
    return f"{key}-{hashlib.sha256(str(signature).encode()).hexdigest()[:16]}"


def shipped(name: str, target: Any) -> Any:
    """The kernel that the archive holds under ``name``, compiled for this processor; None where it holds none."""
    if not (path := archive()).exists():
        return None
    with zipfile.ZipFile(path) as kept:
        return finished(pickle.loads(kept.read(name)), target) if name in kept.NameToInfo else None


@contextmanager
def collected() -> Iterator[dict[str, bytes]]:
    """What numba's front end writes of the kernels that are compiled within, by the names of their entries."""
    found: dict[str, bytes] = {}
    _collected.append(found)
    try:
        yield found
    finally:
        _collected.remove(found)


def collect(name: str, compiled: Any) -> None:
    """Note a kernel that was just compiled, where somebody collects."""
    if _collected:
        from numba.core.serialize import dumps

        text = dumps(kept_half(compiled))
        for found in _collected:
            found[name] = text


def write_archive(found: Mapping[str, bytes]) -> Path:
    """Write what was `collected` as the `archive`; the same kernels make the same file."""
    path = archive()
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w") as kept:
        for name in sorted(found):
            kept.writestr(zipfile.ZipInfo(name), found[name], zipfile.ZIP_LZMA)
    return path
