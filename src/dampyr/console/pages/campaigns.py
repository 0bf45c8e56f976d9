"""The editor of campaigns: a grid, the rig's envelope, and the dry run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from anyio import to_thread
from fastapi import APIRouter, HTTPException, Request
from fastapi import Path as InPath
from pydantic import BaseModel, Field

from dampyr import campaigns
from dampyr.atomic_write import write_whole
from dampyr.console import record_sources, safe_paths
from dampyr.console.campaign_plans import path_answer, plan_answer
from dampyr.console.dampers import DamperLink, damper_of, dampers
from dampyr.console.grid import FOLDER, Envelope, Grid, grid_of, grid_text
from dampyr.console.job_routes import JobState, as_job_state
from dampyr.console.limits import PLANNING
from dampyr.console.option_schemas import form_of
from dampyr.console.proposals import ProposalRequest
from dampyr.console.rigs import rig_file
from dampyr.console.state import AppState, CurrentApp
from dampyr.console.step_texts import StepKind, step_kinds
from dampyr.errors import InputError, MissingData
from dampyr.planning import PlanOptions
from dampyr.studies import available_structures

TITLE, ORDER = "Campaigns", 20
EXAMPLE = Path(campaigns.__file__).with_name("quick.toml")
MAX_TEXT_LENGTH = 65536  # characters: the page's text field has the same limit

router = APIRouter()
Name = Annotated[str, InPath(max_length=100)]
Number = Annotated[float, Field(allow_inf_nan=False)]
Values = Annotated[list[Number], Field(max_length=100)]


class CampaignText(BaseModel):
    """A campaign's TOML."""

    text: str = Field(max_length=MAX_TEXT_LENGTH)


class PlanRequest(CampaignText):
    """A campaign's TOML on a rig; the original one without a name."""

    rig: str = Field("", max_length=100)


class PathRequest(PlanRequest):
    """Of which test the path is drawn; of all without a name."""

    test: str = Field("", max_length=200)


class PathTest(BaseModel):
    """A test and when it begins, s."""

    name: str
    time: float


class CampaignPath(BaseModel):
    """Displacement [mm] and voltage [V], each the times [s] and the values, with None between tests.

    The rests between the tests take their time, the slow ways do not.
    """

    displacement: list[list[float | None]]
    voltage: list[list[float | None]]
    tests: list[PathTest]
    duration_s: float


class Saved(PlanRequest):
    """A campaign to keep. ``replaces`` is the text that its file may hold; another text there is left alone."""

    replaces: str | None = Field(None, max_length=MAX_TEXT_LENGTH)


class CampaignRename(BaseModel):
    """A campaign and its new name."""

    name: str = Field(min_length=1, max_length=200)
    to: str = Field(min_length=1, max_length=100)


class GridForm(BaseModel):
    """Every amplitude [mm] with every frequency [Hz] and every voltage [V] at the coil."""

    name: str = Field("", max_length=100)
    operator: str = Field("", max_length=100)
    note: str = Field("", max_length=1000)
    amplitude: Values
    frequency: Values
    voltage: Values
    cycles: int = Field(20, ge=1, le=100_000)
    repeats: int = Field(1, ge=1, le=1000)
    random: bool = False
    seed: int = Field(0, ge=0, le=2**31)


class File(CampaignText):
    """A file, and the grid that it is, if it is one."""

    name: str
    grid: GridForm | None


class TestPlan(BaseModel):
    """A test as it would run, in the units of the page; force and refusal as expected."""

    __test__ = False
    name: str
    words: str
    duration_s: float
    speed_mm_s: float
    position_mm: float
    force_N: float | None
    voltage_V: float
    frequency_Hz: float
    refusal: str


class PlanAnswer(BaseModel):
    """The dry run."""

    name: str
    rig: str
    duration_s: float
    tests: list[TestPlan]
    notes: list[str]
    refusals: list[str]
    envelope: Envelope


class Proposing(BaseModel):
    """What tests can be proposed from and for, and the options of a plan."""

    dampers: list[DamperLink]
    structures: list[str]
    options: list[dict[str, Any]]


@router.get("/proposing")
def list_proposing(app: CurrentApp) -> Proposing:
    """What can be chosen where tests are proposed."""
    return Proposing(dampers=dampers(app.data), structures=list(available_structures()), options=form_of(PlanOptions))


@router.post("/proposals", status_code=202)
def start_proposal(app: CurrentApp, request: ProposalRequest) -> JobState:
    """Start to look for the next tests; the job reports progress and has a campaign's text."""
    for key in request.records:
        record_sources.place(app.data, key)
    if request.damper:
        damper_of(app.data, request.damper)
    rig_file(app.data, request.rig)
    replace(request.options(), peak=request.peak()).check_goal()
    return as_job_state(app.jobs.submit("propose", request.model_dump(), request.title))


@router.get("/files")
def files(app: CurrentApp) -> list[str]:
    """The campaigns of the data folder."""
    return [name.removesuffix(".toml") for name in safe_paths.files(app.data / FOLDER, (".toml",)) if "/" not in name]


@router.get("/files/{name}")
async def load(name: Name, app: CurrentApp, request: Request) -> File:
    """A campaign."""
    path = safe_paths.existing(app.data, f"{FOLDER}/{name}.toml")
    if (size := path.stat().st_size) > MAX_TEXT_LENGTH:
        raise InputError(
            f"{name}.toml has {size / 1024:.0f} KiB, a page edits at most {MAX_TEXT_LENGTH // 1024}; shorten it"
        )
    try:
        text = path.read_text("utf-8")
    except UnicodeDecodeError:
        raise InputError(f"{name}.toml is not UTF-8 text; rewrite it") from None
    return File(name=name, text=text, grid=await _grid(app, request, text))


@router.put("/files/{name}")
async def save(name: Name, body: Saved, app: CurrentApp, request: Request) -> File:
    """Save a campaign that can be read; what the rig cannot do may be saved."""
    path = safe_paths.inside(app.data, f"{FOLDER}/{name}.toml")
    if path.parent != app.data / FOLDER or not (safe_paths.is_new_name(name) or path.is_file()):
        raise InputError(f"{name!r} is not a valid campaign name; use letters, digits, space and .()+@=-_")
    await app.workers.run(request, PLANNING, plan_answer, app.data, body.text, body.rig)
    grid = await _grid(app, request, body.text)
    await to_thread.run_sync(_write, app, path, body)
    return File(name=name, text=body.text, grid=grid)


@router.post("/example", status_code=201)
async def add_example(app: CurrentApp, request: Request) -> File:
    """Save the example campaign, three short tests; one by its name that is there is left as it is."""
    path = safe_paths.inside(app.data, f"{FOLDER}/{EXAMPLE.name}")
    text = EXAMPLE.read_text("utf-8")
    await to_thread.run_sync(_write, app, path, Saved(text=text, rig="", replaces=""))
    return File(name=path.stem, text=text, grid=await _grid(app, request, text))


@router.post("/rename")
def rename(body: CampaignRename, app: CurrentApp) -> File:
    """Give a campaign another name."""
    path, target = _campaign(app, body.name), _campaign(app, body.to)
    if not safe_paths.is_new_name(body.to):
        raise InputError(f"{body.to!r} is not a valid campaign name; use letters, digits, space and .()+@=-_")
    with safe_paths.ALONE:
        if not path.is_file():
            raise MissingData(f"there is no campaign {body.name!r}; it may have been renamed or deleted meanwhile")
        if target.exists():
            raise HTTPException(409, f"there is a campaign {body.to!r} already; choose another name")
        path.rename(target)
    return File(name=body.to, text="", grid=None)


@router.delete("/files/{name}", status_code=204)
def remove(name: Name, app: CurrentApp) -> None:
    """Delete a campaign; records of it stay."""
    safe_paths.existing(app.data, f"{FOLDER}/{name}.toml").unlink()


def _campaign(app: AppState, name: str) -> Path:
    path = safe_paths.inside(app.data, f"{FOLDER}/{name}.toml")
    if path.parent != app.data / FOLDER:
        raise InputError(f"{name!r} is not a valid campaign name; leave out the /")
    return path


def _write(app: AppState, path: Path, body: Saved) -> None:
    safe_paths.check_quota(app.data, len(body.text), app.quota)
    path.parent.mkdir(exist_ok=True)
    with safe_paths.ALONE:
        if body.replaces is not None and path.exists() and path.read_bytes() != body.replaces.encode():
            raise HTTPException(
                409, f"{path.stem!r} holds another campaign by now; open it anew, or save under another name"
            )
        write_whole(path, body.text)


@router.get("/kinds")
def list_kinds() -> list[StepKind]:
    """Every kind of step that a campaign may have, with its table to begin from."""
    return step_kinds()


@router.post("/text")
def text(grid: GridForm) -> CampaignText:
    """A grid as TOML."""
    return CampaignText(text=grid_text(Grid(**grid.model_dump())))


@router.post("/plan")
async def dry_run(body: PlanRequest, app: CurrentApp, request: Request) -> PlanAnswer:
    """What a campaign would ask of a rig, and all that it cannot do; nothing moves."""
    return PlanAnswer(**await app.workers.run(request, PLANNING, plan_answer, app.data, body.text, body.rig))


@router.post("/path")
async def draw_path(body: PathRequest, app: CurrentApp, request: Request) -> CampaignPath:
    """The path of a whole campaign over time, or of one of its tests."""
    arguments = (app.data, body.text, body.rig, body.test)
    return CampaignPath(**await app.workers.run(request, PLANNING, path_answer, *arguments))


async def _grid(app: AppState, request: Request, text: str) -> GridForm | None:
    form = await app.workers.run(request, PLANNING, grid_values, text)
    return None if form is None else GridForm(**form)


def grid_values(text: str) -> dict[str, Any] | None:
    """The fields of a `GridForm` that a campaign's TOML says and nothing else; None where the page shows the text alone."""
    try:
        grid = grid_of(text)
        return None if grid is None else GridForm(**vars(grid)).model_dump()
    except (ValueError, TypeError):
        return None
