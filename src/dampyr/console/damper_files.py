"""Dampers written for other tools: every kind of `dampyr.export.kinds`, as one file that a browser saves."""

from __future__ import annotations

import io
import tempfile
import zipfile
from pathlib import Path

from dampyr import registry
from dampyr.export import REGISTRY, export
from dampyr.models import Damper


def export_kinds() -> dict[str, str]:
    """Each kind with its title."""
    return {name: registry.title(module) for name, module in registry.members(REGISTRY)}


def zipped_export(damper: Damper, kind: str) -> bytes:
    """A zip of the files of one kind; InputError where there is no such kind, or the damper cannot be written as it."""
    content = io.BytesIO()
    with tempfile.TemporaryDirectory(prefix="dampyr-") as folder, zipfile.ZipFile(content, "w") as archive:
        for path in export(damper, kind, folder):
            archive.write(path, Path(path).name)
    return content.getvalue()
