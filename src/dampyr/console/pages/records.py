"""Records: measurements and their quality, overlays, cycles, notes, upload and export."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Annotated, Any

from anyio import to_thread
from fastapi import APIRouter, Query, Request
from fastapi.responses import FileResponse, Response
from pydantic import BaseModel, Field
from starlette.background import BackgroundTask

from dampyr.console import record_acceptance, record_answers, record_cycles, record_sources, record_uploads
from dampyr.console import record_notes as written
from dampyr.console.curves import Line
from dampyr.console.limits import READING
from dampyr.console.record_formats import MEDIA_TYPES, RecordFormats, offered_formats
from dampyr.console.state import CurrentApp

TITLE, ORDER = "Records", 30
Key = Annotated[str, Query(min_length=3, max_length=640, description="Such as data/uploads/test.h5.")]

router = APIRouter()
router.include_router(record_acceptance.router)
router.include_router(record_cycles.router)
router.include_router(record_uploads.router)


class SourceLink(BaseModel):
    """A folder with records."""

    name: str
    title: str


class RecordEntry(BaseModel):
    """A record in a list: ``about`` is what `dampyr records --json` prints of it, ``problem`` why it cannot be read.

    ``left_out`` is why a fit leaves it out unless it is chosen: it was interrupted, or done again.
    """

    key: str
    about: dict[str, Any] | None = None
    problem: str = ""
    left_out: str = ""
    note: str = ""


class HarmonicAmplitude(BaseModel):
    """The amplitude of the force, N, at a multiple of the excitation, Hz; 1 is the excitation itself."""

    number: int
    frequency: float
    amplitude: float


class RecordSpectrum(Line):
    """Amplitude of the force, N, by frequency, Hz: ``of`` which part, and what stands at the excitation and its multiples.

    The excitation is None where the motion does not repeat itself.
    """

    of: str
    excitation: float | None
    harmonics: list[HarmonicAmplitude]


class Curves(BaseModel):
    """A record's lines, SI: over time, as loops, and by frequency. The velocity is as recorded, or derived.

    Times are from the begin of the motion, which is at ``begin``, s, by the record's clock.
    """

    name: str
    begin: float
    displacement: Line
    velocity: Line
    force: Line
    force_displacement: Line
    force_velocity: Line
    spectrum: RecordSpectrum


class Note(BaseModel):
    """What a person wrote about a record."""

    key: str = Field(min_length=3, max_length=640)
    text: str = Field(max_length=written.MAX_LENGTH)


@router.get("/sources")
def list_sources(app: CurrentApp) -> list[SourceLink]:
    """Where records come from."""
    return [SourceLink(name=folder.name, title=folder.title) for folder in record_sources.sources(app.data)]


@router.get("/list")
async def list_records(
    app: CurrentApp, request: Request, source: Annotated[str, Query(max_length=40)] = record_sources.OWN
) -> list[RecordEntry]:
    """The records of a source, measured and checked."""
    notes = written.notes(app.data)
    folder = record_sources.source(app.data, source)
    keys = await to_thread.run_sync(record_sources.keys, folder)
    described = await app.records.describe(app.workers, request, app.data, keys[: record_sources.MAX_RECORDS])
    reasons = record_sources.superseded({key: entry["about"] for key, entry in described.items() if "about" in entry})
    entries = [
        RecordEntry(key=key, note=notes.get(key, ""), left_out=reasons.get(key, ""), **entry)
        for key, entry in described.items()
    ]
    entries.sort(key=lambda entry: bool(entry.problem))  # what cannot be read stands below what can
    unseen = await to_thread.run_sync(record_sources.left_out, folder)
    entries += [RecordEntry(key=key, problem=why) for key, why in list(unseen.items())[: record_sources.MAX_RECORDS]]
    if more := keys[record_sources.MAX_RECORDS :]:
        words = f"{len(more)} more files are not listed, a list has {record_sources.MAX_RECORDS}; take some out of the folder"
        entries.append(RecordEntry(key=more[0], problem=words))
    return entries


@router.get("/one")
async def read_one(app: CurrentApp, request: Request, key: Key) -> RecordEntry:
    """One record in full."""
    about = await app.workers.run(request, READING, record_answers.describe_one, app.data, key)
    return RecordEntry(key=key, about=about, note=written.notes(app.data).get(key, ""))


@router.get("/curves")
async def read_curves(app: CurrentApp, request: Request, key: Key) -> Curves:
    """The lines of one record."""
    return Curves(**await app.workers.run(request, READING, record_answers.curves_of, app.data, key))


@router.get("/cycles")
async def read_cycles(app: CurrentApp, request: Request, key: Key) -> list[dict[str, float | None]]:
    """Every whole cycle of one record, SI, with the peak-velocity pick-up; see `dampyr.records.cycle_table`."""
    cycles: list[dict[str, float | None]] = await app.workers.run(
        request, READING, record_answers.cycles_of, app.data, key
    )
    return cycles


@router.put("/notes")
def write_note(app: CurrentApp, note: Note) -> Note:
    """Keep a note about a record; an empty one takes it away."""
    record_sources.place(app.data, note.key)
    written.write_note(app.data, note.key, note.text)
    return note


@router.get("/formats")
def list_formats() -> RecordFormats:
    """The formats that are read and written."""
    return offered_formats()


@router.get(
    "/export", response_class=Response, responses={200: {"content": {kind: {} for kind in MEDIA_TYPES.values()}}}
)
async def give(
    app: CurrentApp, request: Request, key: Key, format: Annotated[str, Query(pattern=f"^({'|'.join(MEDIA_TYPES)})$")]
) -> FileResponse:
    """One record as a file: csv and h5 in SI, mat as the campaign's files, png a figure of its loops."""
    folder = Path(tempfile.mkdtemp(prefix="dampyr-"))
    path = folder / f"record.{format}"
    try:
        record = await app.workers.run(request, READING, record_answers.export_record, app.data, key, path)
    except BaseException:
        shutil.rmtree(folder)
        raise
    name = "".join(c if c.isascii() and (c.isalnum() or c in "._-") else "_" for c in record) + path.suffix
    return FileResponse(
        path, media_type=MEDIA_TYPES[format], filename=name, background=BackgroundTask(shutil.rmtree, folder)
    )
