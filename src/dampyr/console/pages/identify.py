"""Identify: from chosen records to a damper's card, as a job."""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal

from fastapi import APIRouter, HTTPException, Query
from fastapi.responses import FileResponse, Response
from pydantic import BaseModel, Field

from dampyr.console import record_sources, safe_paths
from dampyr.console.cards import CARDS
from dampyr.console.job_routes import Id, JobState, as_job_state
from dampyr.console.jobs import CARD, CURVES, PAGE
from dampyr.console.state import AppState, Here
from dampyr.errors import InputError, MissingData
from dampyr.identification.leaderboard import ADD_ONS, check_count
from dampyr.models import Damper, compose, names

TITLE, ORDER = "Identify", 40
KIND = "identify"

router = APIRouter()


class Models(BaseModel):
    """What can be fitted: models that make a force by themselves, and what can be added to them."""

    models: list[str]
    add_ons: list[str]


class Wanted(BaseModel):
    """What to identify. Without a model every model of the catalogue is tried (or those in ``tried``)."""

    records: list[str] = Field(
        min_length=1, max_length=200, description="Keys of records; validation records are predicted."
    )
    model: str | None = Field(default=None, max_length=120, description="Such as dahl + spring.")
    tried: list[Annotated[str, Field(max_length=120)]] = Field(default=[], max_length=30)
    predict: Literal["", "record", "input", "frequency", "amplitude", "time"] = ""
    loss: Literal["squares", "huber", "l1"] = "squares"
    bandwidth: float | None = Field(default=None, gt=0, le=1e5, allow_inf_nan=False, description="Of the velocity, Hz.")


class Card(BaseModel):
    """The name that a card is kept by."""

    name: str = Field(min_length=1, max_length=80)


class SavedCard(BaseModel):
    """A card in the data folder."""

    name: str


@router.get("/models")
def list_models() -> Models:
    """What can be fitted."""
    return Models(models=[name for name in names() if _stands_alone(name)], add_ons=list(ADD_ONS))


@router.post("/jobs", status_code=202)
def identify(here: Here, wanted: Wanted) -> JobState:
    """Start to identify; the job says how far it is, its result what was found."""
    for key in wanted.records:
        record_sources.place(here.data, key)
    if wanted.model is None:
        check_count(len(wanted.records))
    for model in [wanted.model, *wanted.tried]:
        if model is not None:
            compose(model)
    count = len(wanted.records)
    title = f"{wanted.model or 'the best model'}, {count} record{'s' if count > 1 else ''}"
    return as_job_state(here.jobs.submit(KIND, wanted.model_dump(), title))


@router.get("/jobs/{id}/curves")
def read_curves(here: Here, id: Id, record: Annotated[str, Query(max_length=200)]) -> dict[str, Any]:
    """Measured and modelled force of one record: over time, displacement and velocity; and the residual over time."""
    curves = json.loads((_done(here, id) / CURVES).read_text("utf-8"))
    if record not in curves:
        raise MissingData(f"{record!r} is not among the records of this fit")
    return dict(curves[record])


@router.post("/jobs/{id}/card", status_code=201)
def keep_card(here: Here, id: Id, card: Card) -> SavedCard:
    """Keep the damper's card in the folder ``cards`` of the data folder; one that is there is not replaced."""
    source = _done(here, id) / CARD
    if not source.is_file():
        raise InputError("this fit made no damper, so there is no card; see its reason")
    if not safe_paths.is_name(card.name):
        raise InputError(f"{card.name!r} is no name of a file; write letters, digits, space and .()+@=-_")
    target = safe_paths.inside(here.data, f"{CARDS}/{card.name}.toml")
    safe_paths.check_quota(here.data, 2**16, here.quota)
    target.parent.mkdir(exist_ok=True)
    damper = Damper.load(source)
    with safe_paths.ALONE:
        if target.exists():
            raise HTTPException(409, f"there is a card {card.name!r} already; choose another name")
        damper.save(target)
    return SavedCard(name=target.name)


@router.get("/jobs/{id}/page", response_class=Response, responses={200: {"content": {"text/html": {}}}})
def give_page(here: Here, id: Id) -> FileResponse:
    """The page of the fit as `dampyr identify --report` writes it, as a file to keep."""
    return FileResponse(_done(here, id) / PAGE, media_type="text/html", filename="identified.html")


def _done(here: AppState, id: str) -> Any:
    if here.jobs.job(id).kind != KIND:
        raise MissingData("that job identified nothing")
    here.jobs.result(id)
    return here.jobs.place(id)


def _stands_alone(name: str) -> bool:
    try:
        return name not in ADD_ONS and bool(compose(name))
    except InputError:
        return False
