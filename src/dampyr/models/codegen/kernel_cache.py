"""The cache of compiled kernels on disk, in the user's cache or in that of ``DAMPYR_CACHE``.

Every kernel has files of its own, whose names hold a hash of what its machine code depends on
(`dampyr.models.codegen.kernel_key`). The name of the folder holds a hash of how kernels are compiled (`KERNEL_SOURCES`).
"""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import tempfile
import time
import uuid
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

from dampyr import compiling
from dampyr.models.codegen import shipped_kernels
from dampyr.models.codegen.kernel_key import kernel_key
from dampyr.source_digest import source_digest

# what every kernel depends on
KERNEL_SOURCES = tuple(f"models/codegen/{name}.py" for name in ("kernels", "kernel_key", "kernel_compilers"))
MAX_CACHE_AGE = 30 * 86400.0  # s: a month in which a kernel was not used
SWEEP = 86400.0  # s between two looks for such kernels


@lru_cache(maxsize=1)
def cache_folder() -> Path:
    """The folder of compiled kernels, created if need be; a temporary folder where the user's cache is not writable."""
    base = os.environ.get("DAMPYR_CACHE") or _user_cache()
    folder = Path(base) / f"kernels-{source_digest(KERNEL_SOURCES)[:16]}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
        _remove_old(folder)
        return folder
    except OSError:
        return Path(tempfile.mkdtemp(prefix="dampyr-kernels-"))


def _remove_old(folder: Path) -> None:
    """Once a day, remove the kernels that have not been used for a month, and the folders that have not been written to.

    The time of last use is that of the last reading, which most systems note once a day; where they do not, a kernel is
    compiled anew a month after it was.
    """
    swept = folder / "swept"
    if swept.exists() and time.time() - swept.stat().st_mtime < SWEEP:
        return
    swept.touch()
    for other in folder.parent.glob("kernels-*"):
        if time.time() - other.stat().st_mtime > MAX_CACHE_AGE:
            shutil.rmtree(other, ignore_errors=True)
    for file in folder.glob("*.nb?"):
        with suppress(OSError):  # another process has removed it
            if time.time() - max(file.stat().st_atime, file.stat().st_mtime) > MAX_CACHE_AGE:
                file.unlink()


def _user_cache() -> Path:
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home())) / "dampyr"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "dampyr"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "dampyr"


@lru_cache(maxsize=1)
def _locator_class() -> Any:
    from numba.core import caching

    class Locator(caching._CacheLocator):
        """Our folder; the file's name carries the kernel's key, so the stamp need not."""

        def __init__(self, function: Any) -> None:
            words = f"{function.__qualname__} {function.settings} {kernel_key(function)}"
            self.key = hashlib.sha256(words.encode()).hexdigest()[:24]

        def get_cache_path(self) -> str:
            return str(cache_folder())

        def get_source_stamp(self) -> str:
            return cache_folder().name

        def get_disambiguator(self) -> str:
            return self.key

        @classmethod
        def from_function(cls, function: Any, file: str) -> Any:
            return cls(function)

    return Locator


@lru_cache(maxsize=1)
def cache_class() -> Any:
    from numba.core import caching

    class Implementation(caching.CompileResultCacheImpl):
        _locator_classes = [_locator_class()]  # noqa: RUF012

    class Files(caching.IndexDataCacheFile):
        """Every saved signature has a file name of its own.

        Numba counts its files. Two processes that save two signatures of a kernel at once then count alike, and the index of
        one leads to the machine code of the other: what runs is made for other arguments and writes where it may not.
        """

        def save(self, key: Any, data: Any) -> None:
            name = self._load_index().get(key, self._data_name(uuid.uuid4().int))
            self._save_data(name, data)
            self._save_index(self._load_index() | {key: name})

    class Cache(caching.FunctionCache):
        _impl_class = Implementation

        def __init__(self, function: Any) -> None:
            super().__init__(function)
            place, stamp = self._impl.locator.get_cache_path(), self._impl.locator.get_source_stamp()
            self._cache_file = Files(place, self._impl.filename_base, stamp)

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            found = super().load_overload(sig, target_context)
            _used.add(Path(self._cache_file._index_path).name)
            if found is None:
                compiling.note(begins=True)
                found = shipped_kernels.load_shipped(self._entry(sig), target_context)
                if found is not None:
                    self.save_overload(sig, found)
            return found

        def save_overload(self, sig: Any, data: Any) -> None:
            super().save_overload(sig, data)
            shipped_kernels.note_compiled(self._entry(sig), data)
            compiling.note(begins=False)

        def _entry(self, sig: Any) -> str:
            locator = self._impl.locator
            return shipped_kernels.entry_name(f"{locator.get_source_stamp()}-{locator.get_disambiguator()}", sig)

    return Cache


def used_kernels() -> set[str]:
    """The files of the kernels that this process has loaded or compiled so far: of each the index, ``*.nbi``."""
    return set(_used)


_used: set[str] = set()
