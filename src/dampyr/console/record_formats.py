"""Formats of records as the console offers them: every file of `dampyr.records.formats`."""

from __future__ import annotations

from pydantic import BaseModel, Field

from dampyr import registry
from dampyr.records.files.record_files import REGISTRY

FORMATS = dict(registry.members(REGISTRY))
SUFFIXES = tuple(f".{name}" for name in FORMATS)
PLAIN_TEXT = tuple(f".{name}" for name, module in FORMATS.items() if getattr(module, "PLAIN_TEXT", False))
NEED_VELOCITY = tuple(f".{name}" for name, module in FORMATS.items() if getattr(module, "NEEDS_VELOCITY", False))
FIGURE = "png"
MEDIA_TYPES = {
    name: getattr(module, "MEDIA_TYPE", "application/octet-stream")
    for name, module in FORMATS.items()
    if hasattr(module, "write")
} | {FIGURE: "image/png"}


class RecordFormat(BaseModel):
    """A format by its name, which is its suffix without the dot, and its title for people."""

    name: str
    title: str


class RecordFormats(BaseModel):
    """What an upload may be, and what a record can be saved as."""

    read: list[RecordFormat]
    written: list[RecordFormat] = Field(description="Formats of records, and a figure.")


def offered_formats() -> RecordFormats:
    """All formats."""
    return RecordFormats(
        read=[_offered(name) for name in FORMATS], written=[_offered(name) for name in sorted(MEDIA_TYPES)]
    )


def _offered(name: str) -> RecordFormat:
    return RecordFormat(name=name, title=getattr(FORMATS.get(name), "TITLE", name.upper()))
