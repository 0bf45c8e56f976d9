"""Records that come in through the Records page: their columns shown, read, stored, renamed, described anew, deleted."""

from __future__ import annotations

import os
import shutil
import time
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, HTTPException, Query, Request
from fastapi import Path as InPath
from pydantic import BaseModel, Field

from dampyr import records
from dampyr.console import record_answers, record_notes, record_sources, safe_paths
from dampyr.console.incoming_files import BODY, incoming, receive
from dampyr.console.limits import READING
from dampyr.console.option_schemas import form_of, request_of
from dampyr.console.record_formats import PLAIN_TEXT, SUFFIXES
from dampyr.console.state import AppState, CurrentApp
from dampyr.errors import FileError, InputError
from dampyr.records import ReadOptions
from dampyr.records.files.column_table import guess_channels
from dampyr.records.record import CHANNELS, Role
from dampyr.text_table import read_table
from dampyr.to_json import plain

UPLOADS = "uploads"
ORIGINALS = f"{safe_paths.OWN}/originals"
"""Uploads as they were before they were described anew; nothing lists them."""
MAX_SHOWN = 6  # rows of a preview
MAX_DRAWN = 800  # rows of its charts: they are as wide as a form
Name = Annotated[str, InPath(max_length=255, description="The file's name; its suffix gives the format.")]
UPLOAD_LEAVES_OUT = ("units", "columns", "factors", "offsets", "cut")
"""Options of reading that an upload has in another form, and the one that makes several records of a file."""
Text = Annotated[str | None, Field(max_length=200)]

router = APIRouter()


class Taken(BaseModel):
    """A record that came in, and what is to be said of how it was read."""

    key: str
    notices: list[str] = []


class Place(BaseModel):
    """``position`` is 0 for what is read now, None for what is not in the queue."""

    position: int | None


class UploadedColumn(BaseModel):
    """A column of a file: name and unit as the header states them, the first values, every so many of all of them to draw,
    the channel that it seems to be."""

    name: str
    unit: str
    values: list[float | None]
    drawn: list[float | None]
    kind: str
    channel: str


class Preview(BaseModel):
    """The columns of a text file; without any where it cannot be read, with the ``problem``."""

    columns: list[UploadedColumn] = []
    rows: int = 0
    every: int = Field(default=1, description="Which rows are drawn: every one, every second, ...")
    channels: dict[str, str] = Field(default={}, description="Channel -> its SI unit.")
    notices: list[str] = []
    problem: str = ""


class Edit(BaseModel):
    """What is said of a record that was uploaded; what is left out, or None, stays as it is. SI."""

    key: str = Field(min_length=3, max_length=640)
    specimen: Text = None
    operator: Text = None
    measurement_session: Text = None
    role: Role | None = None
    voltage: float | None = Field(None, ge=0, le=1e4, allow_inf_nan=False, description="V, constant, at the coil.")
    current: float | None = Field(None, ge=-1e4, le=1e4, allow_inf_nan=False, description="A, constant.")
    temperature: float | None = Field(None, ge=-273.15, le=1e3, allow_inf_nan=False, description="degC, constant.")


class RecordRename(BaseModel):
    """Another name, without a suffix, for a record that was uploaded."""

    key: str = Field(min_length=3, max_length=640)
    name: str = Field(min_length=1, max_length=100)


class UploadRequest(request_of(ReadOptions, UPLOAD_LEAVES_OUT)):  # type: ignore[misc]
    """What the file does not say itself."""

    unit: list[str] = Field(default=[], max_length=8, description="Such as displacement=mm.")
    column: list[str] = Field(default=[], max_length=8, description="Such as force=Load cell.")
    factor: list[str] = Field(default=[], max_length=8, description="Such as displacement=0.005 mm.")
    offset: list[str] = Field(default=[], max_length=8, description="Such as force=-12 N.")
    ticket: str = Field(default="", max_length=40, description="By which its place in the queue can be asked for.")


@router.get("/uploads/options")
def list_options() -> list[dict[str, Any]]:
    """What can be said of a file besides its columns, for the form."""
    return form_of(ReadOptions, UPLOAD_LEAVES_OUT)


@router.put("/uploads/{name}", status_code=201, openapi_extra=BODY)
async def take(app: CurrentApp, request: Request, name: Name, query: Annotated[UploadRequest, Query()]) -> Taken:
    """Upload a record: it is read in a process with limits and saved as an .h5 file in the folder ``uploads``."""
    pairs = {"units": query.unit, "columns": query.column, "factors": query.factor, "offsets": query.offset}
    options = query.options(**{name: _pairs(texts) for name, texts in pairs.items()})
    stored = _name_of_upload(name)
    target = safe_paths.inside(app.data, f"{UPLOADS}/{Path(stored).stem}.h5")
    if target.exists():
        raise HTTPException(409, f"there is a record {target.stem!r} already; rename the file, and upload it again")
    async with incoming(app.data) as folder:
        await receive(request, folder / stored, app.data, app.quota)
        written = folder / "read.h5"
        taken = await app.uploads.run(
            request, READING, record_answers.take_upload, folder / stored, written, options, ticket=query.ticket
        )
        target.parent.mkdir(exist_ok=True)
        with safe_paths.ALONE:
            if target.exists():
                raise HTTPException(
                    409, f"a record {target.stem!r} came in meanwhile; rename the file, and upload it again"
                )
            written.replace(target)
    notices = [f"{name!r} is stored as {target.stem!r}, a name that every system allows"] if stored != name else []
    notices += [note for note in taken["history"] if note.startswith("read as ")]
    return Taken(key=_key(target), notices=notices)


@router.put("/preview/{name}", openapi_extra=BODY)
async def preview(
    app: CurrentApp,
    request: Request,
    name: Name,
    header: Annotated[int | None, Query(ge=0, le=10**6, description="Line of the names, from 1; 0: none.")] = None,
    part: Annotated[bool, Query(description="Whether the file goes on after what is sent.")] = False,
) -> Preview:
    """The columns of a text file, of which the first part is enough; nothing is saved."""
    stored = _name_of_upload(name)
    if Path(stored).suffix.lower() not in PLAIN_TEXT:
        return Preview(problem="the file names its channels itself")
    async with incoming(app.data) as folder:
        await receive(request, folder / stored, app.data, app.quota)
        shown = await app.workers.run(request, READING, columns_of, folder / stored, header, part)
    return Preview(**shown)


@router.get("/queue")
def read_queue(app: CurrentApp, ticket: Annotated[str, Query(min_length=1, max_length=40)]) -> Place:
    """How many uploads are read before that with this ticket."""
    return Place(position=app.uploads.position(ticket))


@router.post("/edit")
async def edit(app: CurrentApp, request: Request, body: Edit) -> Taken:
    """Write an upload anew with what is said of it; the file as it came stays in the console's own folder."""
    path = _upload(app, body.key)
    changes = body.model_dump(exclude={"key"}, exclude_none=True)
    if not changes:
        raise InputError("nothing is changed; enter what is known of the record")
    safe_paths.check_quota(app.data, path.stat().st_size, app.quota)
    async with incoming(app.data) as folder:
        written = folder / "read.h5"
        await app.uploads.run(request, READING, edited, path, written, changes, time.strftime("%Y-%m-%d %H:%M"))
        with safe_paths.ALONE:
            _keep_original(app, path)
            written.replace(path)
    return Taken(key=body.key)


@router.post("/rename")
def rename(app: CurrentApp, body: RecordRename) -> Taken:
    """Give an upload another name; its note goes with it."""
    path = _upload(app, body.key)
    safe_paths.check_new_name(body.name)
    target = path.with_name(f"{body.name}{path.suffix}")
    with safe_paths.ALONE:
        if target.exists():
            raise HTTPException(409, f"there is a record {body.name!r} already; choose another name")
        path.rename(target)
        with suppress(FileNotFoundError):
            _original(app, path).rename(_original(app, target))
        record_notes.move_note(app.data, body.key, _key(target))
    return Taken(key=_key(target))


@router.delete("/uploads/{name}", status_code=204)
def remove(app: CurrentApp, name: Annotated[str, InPath(max_length=260)]) -> None:
    """Delete a record that was uploaded, with its note."""
    path = safe_paths.existing(app.data, f"{UPLOADS}/{name}")
    path.unlink()
    _original(app, path).unlink(missing_ok=True)
    record_notes.write_note(app.data, _key(path), "")


def columns_of(path: Path, header: int | None, part: bool) -> dict[str, Any]:
    """A `Preview` of a text file as plain values."""
    if part:  # the last line may be cut
        content = path.read_bytes()
        path.write_bytes(content[: content.rfind(b"\n") + 1] or content)
    try:
        table = read_table(path, ReadOptions(header=header), by_number=True)
    except FileError as problem:
        return {"problem": str(problem).replace(f"{path}", path.name)}
    guessed = {column: channel for channel, column in guess_channels(path, table).items()}
    kinds = table.kinds or ("number",) * table.values.shape[1]
    rows = len(table.values)
    every = max(-(-rows // MAX_DRAWN), 1)
    columns = [
        {
            "name": table.names[k] if table.names else "",
            "unit": table.units[k] if table.units else "",
            "values": plain(table.values[:MAX_SHOWN, k]),
            "drawn": plain(table.values[::every, k]),
            "kind": kinds[k],
            "channel": guessed.get(k, ""),
        }
        for k in range(table.values.shape[1])
    ]
    return {
        "columns": columns,
        "rows": rows,
        "every": every,
        "channels": dict(CHANNELS),
        "notices": list(table.notes),
    }


def edited(path: Path, to: Path, changes: dict[str, Any], when: str) -> None:
    """Write the record at ``path`` to ``to`` with ``changes``, which its history and its provenance name."""
    record = records.read(path)
    fields: dict[str, Any] = {
        name: changes[name] for name in ("specimen", "measurement_session", "role") if changes.get(name) is not None
    }
    if "voltage" in changes and "current" in changes:
        raise InputError("voltage and current are both given; a record has one input, so leave one of them out")
    if "voltage" in changes or "current" in changes:
        fields["no_input"] = False
    if "voltage" in changes:
        fields |= {"voltage": changes["voltage"], "current": None}
    if "current" in changes:
        fields |= {"current": changes["current"], "voltage": None}
    if "temperature" in changes:
        import numpy as np

        fields["temperature"] = np.full(record.n, changes["temperature"])
    provenance = dict(record.provenance) | {"edited": f"{when}: {', '.join(changes)}"}
    if "operator" in changes:
        provenance["operator"] = changes["operator"]
    note = "edited in the console: " + ", ".join(f"{name} = {value}" for name, value in changes.items())
    records.write(record.replace(note=note, provenance=provenance, **fields), to)


def _name_of_upload(name: str) -> str:
    """The name by which a file is stored, of which its suffix picks the reader."""
    if Path(name).suffix.lower() not in SUFFIXES:
        raise InputError(f"{name[:60]!r} has no suffix of a record; it must end in {', '.join(SUFFIXES)}")
    if safe_paths.is_reserved(name):
        safe_paths.check_new_name(name)
    stored = name if safe_paths.is_new_name(name) else safe_paths.new_name(name)
    if not stored or name[0] in ".-~" or "/" in name or "\\" in name or not name.isprintable():
        raise InputError(f"{name[:60]!r} is not a valid file name; rename it with letters, digits, space and .()+@=-_")
    return stored


def _upload(app: AppState, key: str) -> Path:
    """The file of a record that was uploaded; the others are not changed here."""
    prefix = f"{record_sources.OWN}/{UPLOADS}/"
    if not key.startswith(prefix) or "/" in key.removeprefix(prefix):
        raise InputError("only records that were uploaded can be changed; those of a run stay as they were recorded")
    return safe_paths.existing(app.data, f"{UPLOADS}/{key.removeprefix(prefix)}")


def _key(path: Path) -> str:
    return f"{record_sources.OWN}/{UPLOADS}/{path.name}"


def _original(app: AppState, path: Path) -> Path:
    return app.data / ORIGINALS / path.name


def _keep_original(app: AppState, path: Path) -> None:
    """Link the file as it came under its name in the console's own folder, where it is the first."""
    original = _original(app, path)
    if original.exists():
        return
    original.parent.mkdir(exist_ok=True)
    try:
        os.link(path, original)
    except OSError:  # a file system without hard links
        shutil.copyfile(path, original)


def _pairs(texts: list[str]) -> dict[str, str]:
    for pair in texts:
        if "=" not in pair or len(pair) > 120:
            raise InputError(f"{pair[:60]!r} is not a pair; write it as in displacement=mm")
    return dict(pair.split("=", 1) for pair in texts)
