"""Building: responses with and without a damper to one earthquake, and ensembles of many."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Literal

from fastapi import APIRouter, HTTPException, Request
from fastapi import Path as InPath
from fastapi.responses import FileResponse, Response
from pydantic import BaseModel, Field

from dampyr import ground_motions, structures
from dampyr.console import safe_paths
from dampyr.console.building_schemas import (
    LIMITS,
    MOTION_SUFFIXES,
    MOTIONS,
    STRUCTURES,
    EnsembleRequest,
    ResponseRequest,
)
from dampyr.console.dampers import CARDS, DamperLink, damper_of, list_dampers
from dampyr.console.incoming_files import BODY, incoming, receive
from dampyr.console.job_routes import Id, JobState, as_job_state
from dampyr.console.jobs import CURVES, PAGE
from dampyr.console.limits import READING
from dampyr.console.option_schemas import form_of
from dampyr.console.security import MAX_UPLOAD
from dampyr.console.state import CurrentApp
from dampyr.errors import DampyrError, FileError, InputError, MissingData
from dampyr.models import Damper
from dampyr.options import options_of
from dampyr.show.figures.symbols import law_in_words
from dampyr.structures.building_options import InstallationOptions
from dampyr.studies import THESIS, available_structures

TITLE, ORDER = "Building", 50
RESPONSE, ENSEMBLE = "respond", "ensemble"
MAX_TOML = 4 * 2**20  # bytes of a card or a structure: matrices of 400 degrees of freedom, and some 5 s of reading

router = APIRouter()


class BuildingChoices(BaseModel):
    """What can be chosen."""

    dampers: list[DamperLink]
    laws: dict[str, str] = Field(description="Control laws, each with its words for a reader.")
    motions: list[str]
    structures: list[str] = Field(description="Published ones by name; files by their path, structures/NAME.toml.")
    shared_options: list[dict[str, Any]] = Field(description="Those of a response and of an ensemble.")
    response_options: list[dict[str, Any]]
    ensemble_options: list[dict[str, Any]]


class AddedFile(BaseModel):
    """A file that was added: its folder in the data folder, and its name."""

    kind: str
    name: str


FileName = Annotated[
    str, InPath(max_length=100, description="The file's name; its suffix gives the format of a motion.")
]


@router.get("/choices")
async def list_choices(app: CurrentApp, request: Request) -> BuildingChoices:
    """Dampers, control laws and ground motions that can be chosen."""
    links = [DamperLink(**link) for link in await app.workers.run(request, READING, list_dampers, app.data)]
    motions = safe_paths.files(app.data / MOTIONS, MOTION_SUFFIXES)
    files = [f"{STRUCTURES}/{name}" for name in safe_paths.files(app.data / STRUCTURES, (".toml",))]
    offered = [name for name in available_structures() if name != THESIS]
    shared = tuple(option.name for option in options_of(InstallationOptions))
    return BuildingChoices(
        dampers=links,
        laws={name: law_in_words(name) for name in structures.available_control_laws()},
        motions=motions,
        structures=[*offered, *files],
        shared_options=form_of(InstallationOptions),
        response_options=form_of(structures.RespondOptions, shared),
        ensemble_options=form_of(structures.EnsembleOptions, shared, LIMITS),
    )


@router.put("/files/{kind}/{name}", status_code=201, openapi_extra=BODY)
async def add_file(
    app: CurrentApp, request: Request, kind: Literal["cards", "structures", "motions"], name: FileName
) -> AddedFile:
    """Add a damper's card, a structure or a ground motion; it is read first, and one that is there is not replaced."""
    suffixes = MOTION_SUFFIXES if kind == MOTIONS else (".toml",)
    if Path(name).suffix.lower() not in suffixes:
        raise InputError(f"{name[:60]!r} is no file of {kind}; it must end in {', '.join(suffixes)}")
    safe_paths.check_new_name(name)
    target = safe_paths.inside(app.data, f"{kind}/{name}")
    taken = HTTPException(409, f"there is a file {name!r} among the {kind} already; rename it, and add it again")
    if target.exists():
        raise taken
    async with incoming(app.data) as folder:
        await receive(request, folder / name, app.data, app.quota, MAX_UPLOAD if kind == MOTIONS else MAX_TOML)
        await app.uploads.run(request, READING, check_file, kind, folder / name)
        target.parent.mkdir(exist_ok=True)
        with safe_paths.ALONE:
            if target.exists():
                raise taken
            (folder / name).replace(target)
    return AddedFile(kind=kind, name=name)


def check_file(kind: str, path: Path) -> None:
    """Read a file as the page will; an error of it names the file and not its place."""
    try:
        if kind == CARDS:
            Damper.load(path)
        elif kind == STRUCTURES:
            structures.load(path)
        else:
            _check_motion(path)
    except FileError as problem:
        raise InputError(str(problem).replace(f"{path}", path.name)) from None


def _check_motion(path: Path) -> None:
    """A motion whose file does not state its unit is told one on the page."""
    try:
        ground_motions.read(path)
    except DampyrError as problem:
        try:
            ground_motions.read(path, units="m/s2")
        except DampyrError:
            raise problem from None


@router.post("/responses", status_code=202)
def respond(app: CurrentApp, request: ResponseRequest) -> JobState:
    """Start to compute a response; bare, and with the damper at each input."""
    _check(app.data, request)
    title = f"{request.building.title}, {request.motion.kind.replace('_', ' ')}, {_shown(request.damper.name)}"
    title += f", {_inputs(request)}"
    return as_job_state(app.jobs.submit(RESPONSE, request.model_dump(), title))


@router.post("/ensembles", status_code=202)
def run_ensemble(app: CurrentApp, request: EnsembleRequest) -> JobState:
    """Start an ensemble; its result holds fragility curves."""
    _check(app.data, request)
    title = f"ensemble, {request.motions} motions, {len(request.scales)} scales, {_shown(request.damper.name)}"
    title += f", {_inputs(request)}, seed {request.seed}"
    return as_job_state(app.jobs.submit(ENSEMBLE, request.model_dump(), title))


@router.get("/responses/{id}/curves")
def read_curves(app: CurrentApp, id: Id) -> dict[str, Any]:
    """The histories of every case, SI, and the frames of the animation."""
    app.jobs.result(id)
    if app.jobs.job(id).kind != RESPONSE:
        raise MissingData("that job is not a response")
    return dict(json.loads((app.jobs.place(id) / CURVES).read_text("utf-8")))


@router.get("/jobs/{id}/page", response_class=Response, responses={200: {"content": {"text/html": {}}}})
def give_page(app: CurrentApp, id: Id) -> FileResponse:
    """The page as `dampyr simulate --report` or `dampyr ensemble --report` writes it, as a file to keep."""
    app.jobs.result(id)
    if app.jobs.job(id).kind not in (RESPONSE, ENSEMBLE):
        raise MissingData("that job is neither a response nor an ensemble")
    return FileResponse(app.jobs.place(id) / PAGE, media_type="text/html", filename=f"{app.jobs.job(id).kind}.html")


def _check(data: Any, request: ResponseRequest | EnsembleRequest) -> None:
    """Refuse at once what is wrong with a request, rather than in the job."""
    request.building.building(data)
    if request.motion.kind == "file":
        request.motion.motion(data)
    options = request.options()
    if isinstance(request, EnsembleRequest):
        options.checked_limits()
    damper = damper_of(data, request.damper.name)
    request.damper.placed(damper)
    request.damper.inputs_by_kind(damper)


def _inputs(request: ResponseRequest | EnsembleRequest) -> str:
    """What drives the damper: its constant inputs and its control laws."""
    return (
        " ".join([*(f"{value:g}" for value in request.damper.inputs), *map(law_in_words, request.damper.laws)])
        or "no input"
    )


def _shown(name: str) -> str:
    return name.removeprefix(f"{CARDS}/").removesuffix(".toml")
