"""Whether an HDF5 file holds all that it shows: what points out of it could show any file that this process may read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from dampyr.errors import FileError

# A record has about twenty links, two deep; whoever sent a file should not decide how long it is looked at.
MAX_LINKS = 10_000  # links
DEEPEST = 16  # groups within groups


def check_contained(path: Path, file: Any) -> None:
    """Raise :class:`~dampyr.errors.FileError` where something in an open file lies in another one; no data are read.

    Refused are external links, links that a user defined, datasets in external storage and virtual datasets, wherever in the
    file they are: a soft link could lead to them.
    """
    import h5py

    count = 0

    def look(name: bytes, link: Any) -> str | None:
        nonlocal count
        count += 1
        if count > MAX_LINKS:
            return f"the file has more than {MAX_LINKS} links"
        if name.count(b"/") > DEEPEST:
            return f"the file has groups more than {DEEPEST} deep"
        where = f"/{name.decode(errors='replace')}"
        if link.type == h5py.h5l.TYPE_HARD:
            return _stored(where, file.id, name)
        return None if link.type == h5py.h5l.TYPE_SOFT else f"{where} is a link out of the file"

    reason = file.id.links.visit(look, info=True)
    if reason:
        raise FileError(
            path,
            f"{reason}, and a file is read only where it holds all of its data; copy it with h5repack so that it does, or "
            "record the test again",
        )


def _stored(where: str, file: Any, name: bytes) -> str | None:
    """Where a dataset's values are, if they are not in the file."""
    import h5py

    if h5py.h5o.get_info(file, name).type != h5py.h5o.TYPE_DATASET:
        return None
    how = h5py.h5d.open(file, name).get_create_plist()
    if how.get_layout() == h5py.h5d.VIRTUAL:
        return f"{where} is a virtual dataset, whose values lie elsewhere"
    if how.get_external_count():
        return f"{where} has its values in another file, {how.get_external(0)[0].decode(errors='replace')!r}"
    return None
