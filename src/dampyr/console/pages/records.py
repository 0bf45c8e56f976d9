"""Records: measurements and their quality, overlays, cycles, notes, upload and export."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Annotated, Any

from anyio import to_thread
from fastapi import APIRouter, HTTPException, Query, Request
from fastapi import Path as InPath
from fastapi.responses import FileResponse, Response
from pydantic import BaseModel, Field
from starlette.background import BackgroundTask

from dampyr import records
from dampyr.console import curves, limits, record_acceptance, record_sources, safe_paths
from dampyr.console import record_notes as written
from dampyr.console.curves import Line
from dampyr.console.error_responses import without_places
from dampyr.console.record_formats import FIGURE, MEDIA_TYPES, NEED_VELOCITY, SUFFIXES, RecordFormats, offered_formats
from dampyr.console.security import MAX_UPLOAD
from dampyr.console.state import Here
from dampyr.errors import DampyrError, InputError
from dampyr.records import Record
from dampyr.to_json import plain

TITLE, ORDER = "Records", 30
UPLOADS = "uploads"
Key = Annotated[str, Query(min_length=3, max_length=340, description="Such as data/uploads/test.h5.")]

router = APIRouter()
router.include_router(record_acceptance.router)


class SourceLink(BaseModel):
    """A folder with records."""

    name: str
    title: str


class RecordEntry(BaseModel):
    """A record in a list: ``about`` is what `dampyr records --json` prints of it, ``problem`` why it cannot be read."""

    key: str
    about: dict[str, Any] | None = None
    problem: str = ""
    note: str = ""


class Curves(BaseModel):
    """A record's lines, SI: over time, as loops, and by frequency. The velocity is as recorded, or derived."""

    name: str
    displacement: Line
    velocity: Line
    force: Line
    force_displacement: Line
    force_velocity: Line
    spectrum: Line = Field(description="Amplitude of the force, N, by frequency, Hz.")


class Note(BaseModel):
    """What a person wrote about a record."""

    key: str = Field(min_length=3, max_length=340)
    text: str = Field(max_length=written.MAX_LENGTH)


class Taken(BaseModel):
    """A record that came in."""

    key: str


@router.get("/sources")
def list_sources(here: Here) -> list[SourceLink]:
    """Where records come from."""
    return [SourceLink(name=one.name, title=one.title) for one in record_sources.sources(here.data)]


@router.get("/list")
def list_records(here: Here, source: Annotated[str, Query(max_length=40)] = record_sources.OWN) -> list[RecordEntry]:
    """The records of a source, measured and checked."""
    said = written.notes(here.data)
    return [
        _describe_record(here.data, key, said.get(key, ""))
        for key in record_sources.keys(record_sources.source(here.data, source))
    ]


@router.get("/one")
def read_one(here: Here, key: Key) -> RecordEntry:
    """One record in full."""
    return RecordEntry(
        key=key, about=plain(record_sources.described(here.data, key)), note=written.notes(here.data).get(key, "")
    )


@router.get("/curves")
def read_curves(here: Here, key: Key) -> Curves:
    """The lines of one record."""
    record = _with_velocity(record_sources.read(here.data, key))
    assert record.velocity is not None
    t, x, v, f = record.time, record.displacement, record.velocity, record.force
    return Curves(
        name=record.name,
        displacement=curves.line(t, x),
        velocity=curves.line(t, v),
        force=curves.line(t, f),
        force_displacement=curves.line(x, f, 2 * curves.POINTS),
        force_velocity=curves.line(v, f, 2 * curves.POINTS),
        spectrum=curves.line(*records.spectrum(record, "force")),
    )


@router.get("/cycles")
def read_cycles(here: Here, key: Key) -> list[dict[str, float]]:
    """Every whole cycle of one record, SI, with the peak-velocity pick-up; see `dampyr.records.Cycle`."""
    return [plain(one) for one in records.cycle_table(record_sources.read(here.data, key))]


@router.put("/notes")
def write_note(here: Here, note: Note) -> Note:
    """Keep a note about a record; an empty one takes it away."""
    record_sources.place(here.data, note.key)
    written.write_note(here.data, note.key, note.text)
    return note


@router.put(
    "/uploads/{name}",
    status_code=201,
    openapi_extra={
        "requestBody": {
            "required": True,
            "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
        }
    },
)
async def take(
    here: Here,
    request: Request,
    name: Annotated[str, InPath(max_length=100, description="The file's name; its suffix gives the format.")],
    unit: Annotated[list[str], Query(default_factory=list, max_length=8, description="Such as displacement=mm.")],
    column: Annotated[list[str], Query(default_factory=list, max_length=8, description="Such as force=Load cell.")],
    voltage: Annotated[float | None, Query(allow_inf_nan=False, description="V, constant, at the coil.")] = None,
    current: Annotated[float | None, Query(allow_inf_nan=False, description="A, constant.")] = None,
    dt: Annotated[str | None, Query(max_length=40, description="Sampling interval, such as 2 ms.")] = None,
    variable: Annotated[str | None, Query(max_length=100, description="Matrix of a MATLAB file.")] = None,
    header: Annotated[int | None, Query(ge=0, le=10**6, description="Line of the names, from 1; 0: none.")] = None,
    force_sign: Annotated[int | None, Query(ge=-1, le=1, description="-1 turns the force.")] = None,
    measurement_session: Annotated[
        str | None, Query(max_length=100, description="A day's records on a mounting.")
    ] = None,
    specimen: Annotated[str | None, Query(max_length=100, description="Which damper it is.")] = None,
) -> Taken:
    """Upload a record: it is read in a process with limits and saved as an .h5 file in the folder ``uploads``."""
    said: dict[str, Any] = {"voltage": voltage, "current": current, "units": _pairs(unit), "columns": _pairs(column)}
    said |= {"dt": dt, "variable": variable, "header": header, "force_sign": force_sign}
    said |= {"measurement_session": measurement_session, "specimen": specimen}
    if not safe_paths.is_name(name) or Path(name).suffix.lower() not in SUFFIXES:
        raise InputError(f"{name!r} is not a valid record name; it must end in {', '.join(SUFFIXES)}")
    target = safe_paths.inside(here.data, f"{UPLOADS}/{Path(name).stem}.h5")
    if target.exists():
        raise HTTPException(409, f"there is a record {target.stem!r} already; rename the file, and upload it again")
    async with _incoming(here.data) as folder:
        await _receive(request, folder / name, here.data, here.quota)
        made = folder / "read.h5"
        await to_thread.run_sync(limits.read_apart, folder / name, made, said)
        target.parent.mkdir(exist_ok=True)
        with safe_paths.ALONE:
            if target.exists():
                raise HTTPException(
                    409, f"a record {target.stem!r} came in meanwhile; rename the file, and upload it again"
                )
            made.replace(target)
    return Taken(key=f"{record_sources.OWN}/{UPLOADS}/{target.name}")


@router.delete("/uploads/{name}", status_code=204)
def remove(here: Here, name: Annotated[str, InPath(max_length=110)]) -> None:
    """Delete a record that was uploaded, with its note."""
    safe_paths.existing(here.data, f"{UPLOADS}/{name}").unlink()
    written.write_note(here.data, f"{record_sources.OWN}/{UPLOADS}/{name}", "")


@router.get("/formats")
def list_formats() -> RecordFormats:
    """The formats that are read and written."""
    return offered_formats()


@router.get(
    "/export", response_class=Response, responses={200: {"content": {kind: {} for kind in MEDIA_TYPES.values()}}}
)
def give(here: Here, key: Key, format: Annotated[str, Query(pattern=f"^({'|'.join(MEDIA_TYPES)})$")]) -> FileResponse:
    """One record as a file: csv and h5 in SI, mat as the campaign's files, png a figure of its loops."""
    record = record_sources.read(here.data, key)
    folder = Path(tempfile.mkdtemp(prefix="dampyr-"))
    path = folder / f"record.{format}"
    try:
        _write(record, path)
    except BaseException:
        shutil.rmtree(folder)
        raise
    name = "".join(c if c.isascii() and (c.isalnum() or c in "._-") else "_" for c in record.name) + path.suffix
    return FileResponse(
        path, media_type=MEDIA_TYPES[format], filename=name, background=BackgroundTask(shutil.rmtree, folder)
    )


def _write(record: Record, path: Path) -> None:
    if path.suffix == f".{FIGURE}":
        from dampyr.figures.loops import loops
        from dampyr.figures.style import save

        shown = _with_velocity(record)
        save(loops(shown.displacement, shown.velocity, shown.force, title=record.name), path)
    else:
        records.write(_with_velocity(record) if path.suffix in NEED_VELOCITY else record, path)


def _with_velocity(record: Record) -> Record:
    return record if record.velocity is not None else records.with_velocity(record)


def _describe_record(data: Path, key: str, note: str) -> RecordEntry:
    try:
        return RecordEntry(key=key, about=plain(record_sources.described(data, key)), note=note)
    except DampyrError as problem:
        return RecordEntry(key=key, problem=without_places(str(problem), data), note=note)


def _pairs(given: list[str]) -> dict[str, str]:
    for pair in given:
        if "=" not in pair or len(pair) > 120:
            raise InputError(f"{pair[:60]!r} is not a pair; write it as in displacement=mm")
    return dict(pair.split("=", 1) for pair in given)


@asynccontextmanager
async def _incoming(data: Path) -> AsyncIterator[Path]:
    """A folder for one file that comes in; gone afterwards."""
    folder = Path(tempfile.mkdtemp(prefix="incoming-", dir=data / safe_paths.OWN))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


async def _receive(request: Request, path: Path, data: Path, quota: int) -> None:
    """Write the body to ``path`` as it comes, within the limits."""
    free_bytes = quota - await to_thread.run_sync(safe_paths.used, data)
    size = 0
    with path.open("wb") as file:
        async for piece in request.stream():
            size += len(piece)
            if size > MAX_UPLOAD:
                raise HTTPException(413, f"too large; at most {MAX_UPLOAD // 2**20} MiB are taken")
            if 2 * size > free_bytes:
                raise HTTPException(
                    413, "the data folder is full; delete what is not needed, or start with a larger --quota"
                )
            file.write(piece)
    if size == 0:
        raise InputError("the file is empty; choose another")
