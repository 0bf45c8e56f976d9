"""The editor of campaigns: a grid, the rig's envelope, and the dry run."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, HTTPException
from fastapi import Path as InPath
from pydantic import BaseModel, Field

from dampyr.atomic_write import write_whole
from dampyr.console import safe_paths
from dampyr.console.grid import (
    FOLDER,
    Envelope,
    Grid,
    envelope_of,
    grid_of,
    grid_text,
    place_of,
    planned_text,
)
from dampyr.console.rigs import rig_file, rig_settings
from dampyr.console.state import Here
from dampyr.console.step_texts import StepKind, step_kinds
from dampyr.errors import InputError
from dampyr.report.plan_page import plan_notes

TITLE, ORDER = "Campaigns", 20
MAX_TEXT_LENGTH = 65536  # characters: the page's text field has the same limit

router = APIRouter()
Name = Annotated[str, InPath(max_length=100)]
Number = Annotated[float, Field(allow_inf_nan=False)]
Values = Annotated[list[Number], Field(max_length=100)]


class Text(BaseModel):
    """A campaign's TOML."""

    text: str = Field(max_length=MAX_TEXT_LENGTH)


class PlanRequest(Text):
    """A campaign's TOML on a rig; the original one without a name."""

    rig: str = Field("", max_length=100)


class Saved(PlanRequest):
    """A campaign to keep. ``replaces`` is the text that its file may hold; another text there is left alone."""

    replaces: str | None = Field(None, max_length=MAX_TEXT_LENGTH)


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


class File(Text):
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


@router.get("/files")
def files(here: Here) -> list[str]:
    """The campaigns of the data folder."""
    return [name.removesuffix(".toml") for name in safe_paths.files(here.data / FOLDER, (".toml",)) if "/" not in name]


@router.get("/files/{name}")
def load(name: Name, here: Here) -> File:
    """A campaign."""
    path = safe_paths.existing(here.data, f"{FOLDER}/{name}.toml")
    try:
        text = path.read_text("utf-8")
    except UnicodeDecodeError:
        raise InputError(f"{name}.toml is not UTF-8 text; rewrite it") from None
    return File(name=name, text=text, grid=_grid(text))


@router.put("/files/{name}")
def save(name: Name, request: Saved, here: Here) -> File:
    """Save a campaign that can be read; what the rig cannot do may be saved."""
    path = safe_paths.inside(here.data, f"{FOLDER}/{name}.toml")
    if path.parent != here.data / FOLDER:
        raise InputError(f"{name!r} is not a valid campaign name; leave out the /")
    _plan(request, here)
    safe_paths.check_quota(here.data, len(request.text), here.quota)
    path.parent.mkdir(exist_ok=True)
    with safe_paths.ALONE:
        if request.replaces is not None and path.exists() and path.read_bytes() != request.replaces.encode():
            raise HTTPException(
                409, f"{name!r} holds another campaign by now; open it anew, or save under another name"
            )
        write_whole(path, request.text)
    return File(name=name, text=request.text, grid=_grid(request.text))


@router.get("/kinds")
def list_kinds() -> list[StepKind]:
    """Every kind of step that a campaign may have, with its table to begin from."""
    return step_kinds()


@router.post("/text")
def text(grid: GridForm) -> Text:
    """A grid as TOML."""
    return Text(text=grid_text(Grid(**grid.model_dump())))


@router.post("/plan")
def dry_run(request: PlanRequest, here: Here) -> PlanAnswer:
    """What a campaign would ask of a rig, and all that it cannot do; nothing moves."""
    return _plan(request, here)


def _grid(text: str) -> GridForm | None:
    try:
        grid = grid_of(text)
        return None if grid is None else GridForm(**vars(grid))
    except (ValueError, TypeError):
        return None  # no grid: the page shows the text alone


def _plan(request: PlanRequest, here: Here) -> PlanAnswer:
    settings, path = rig_settings(here.data, request.rig), rig_file(here.data, request.rig)
    campaign_plan = planned_text(request.text, here.data, settings, None if path is None else path.parent)
    tests = [
        TestPlan(
            name=each.name, words=each.words, duration_s=each.duration, speed_mm_s=1e3 * each.peak_speed,
            position_mm=1e3 * each.peak_position, force_N=each.peak_force, voltage_V=each.peak_voltage,
            frequency_Hz=place_of(each.peak_speed, each.peak_position)[0], refusal=each.refusal,
        )
        for each in campaign_plan.tests
    ]  # fmt: skip
    return PlanAnswer(
        name=campaign_plan.campaign.header.name, rig=campaign_plan.rig.name, duration_s=campaign_plan.duration, tests=tests,
        notes=plan_notes(campaign_plan), refusals=list(campaign_plan.refusals), envelope=envelope_of(campaign_plan),
    )  # fmt: skip
