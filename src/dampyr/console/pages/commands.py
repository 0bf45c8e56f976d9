"""Commands: every command of the terminal as a form, performed as a job."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Annotated, Any

from anyio import to_thread
from fastapi import APIRouter, HTTPException, Query, Request
from fastapi.responses import FileResponse, Response
from pydantic import BaseModel, Field

from dampyr.console import safe_paths
from dampyr.console.command_words import CommandRequest, command_line, command_places, file_choices, forms, groups
from dampyr.console.job_routes import Id, JobState, as_job_state
from dampyr.console.jobs import FIGURES, FILES, PAGE
from dampyr.console.limits import READING
from dampyr.console.pages.bench import CurrentBench
from dampyr.console.state import AppState, CurrentApp
from dampyr.errors import MissingData

TITLE, ORDER = "Commands", 60
KIND = "command"
WORDS_OF_TITLE = 6  # of a command line: enough to tell jobs apart
OPEN_A_RIG = ("calibrate", "doctor")
"""Commands that open the rig that they are given: not while the Bench holds one."""

router = APIRouter()
FileName = Annotated[str, Query(max_length=640)]


class CommandPlace(BaseModel):
    """A command, the page that has a form of its own for it (``commands``: this page alone), and why it is not offered here."""

    command: str
    page: str
    why: str


class Commands(BaseModel):
    """The commands by group in the order of the page, their forms, what can be chosen for files, and where each one is."""

    groups: dict[str, list[str]]
    forms: dict[str, dict[str, Any]]
    files: dict[str, list[dict[str, str]]] = Field(description="By kind, but for records.")
    places: list[CommandPlace]


@router.get("/choices")
async def list_choices(app: CurrentApp, request: Request) -> Commands:
    """The forms of all commands."""
    described = await to_thread.run_sync(forms)  # at first a third of a second, in which the bench's stream goes on
    return Commands(
        groups={title: list(names) for title, names in groups().items()},
        forms=described,
        files=await app.workers.run(request, READING, file_choices, app.data),
        places=[CommandPlace(command=command, page=page, why=why) for command, page, why in command_places()],
    )


@router.post("/jobs", status_code=202)
def start_command(app: CurrentApp, bench: CurrentBench, request: CommandRequest) -> JobState:
    """Start a command; what the command line would refuse is refused here."""
    line = command_line(request, app.data, safe_paths.OWN)
    opens_a_rig = request.command in OPEN_A_RIG and "rig" in request.values
    if opens_a_rig and bench.state().phase != "disconnected":
        raise HTTPException(409, "the Bench is connected, and a rig serves one host; disconnect it there first")
    typed = [word for word in line.typed if not word.startswith("--report=")]
    title = " ".join(typed[:WORDS_OF_TITLE]) + (" …" if len(typed) > WORDS_OF_TITLE else "")
    return as_job_state(app.jobs.submit(KIND, request.model_dump(), title))


@router.get("/jobs/{id}/page", response_class=Response, responses={200: {"content": {"text/html": {}}}})
def give_page(app: CurrentApp, id: Id) -> FileResponse:
    """The page that the command writes with --report, as a file to keep."""
    return FileResponse(_file(app, id, PAGE), media_type="text/html", filename="report.html")


@router.get("/jobs/{id}/figure", response_class=Response, responses={200: {"content": {"image/svg+xml": {}}}})
def give_figure(app: CurrentApp, id: Id, name: FileName) -> FileResponse:
    """One figure, SVG."""
    return FileResponse(_file(app, id, f"{FIGURES}/{name}"), media_type="image/svg+xml")


@router.get("/jobs/{id}/figures", response_class=Response, responses={200: {"content": {"application/zip": {}}}})
def give_figures(app: CurrentApp, id: Id) -> Response:
    """All figures as SVG and PDF, and what they draw as CSV, in a zip."""
    folder, content = _done(app, id) / FIGURES, io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(folder.iterdir()):
            archive.write(path, path.name)
    headers = {"content-disposition": 'attachment; filename="figures.zip"'}
    return Response(content.getvalue(), media_type="application/zip", headers=headers)


@router.get("/jobs/{id}/file", response_class=Response, responses={200: {"content": {"application/octet-stream": {}}}})
def give_file(app: CurrentApp, id: Id, name: FileName) -> FileResponse:
    """A file that the command wrote."""
    path = _file(app, id, f"{FILES}/{name}")
    return FileResponse(path, media_type="application/octet-stream", filename=path.name)


def _done(app: AppState, id: str) -> Path:
    if app.jobs.job(id).kind != KIND:
        raise MissingData("that job is not a command")
    app.jobs.result(id)
    return app.jobs.place(id)


def _file(app: AppState, id: str, name: str) -> Path:
    return safe_paths.existing(_done(app, id), name)
