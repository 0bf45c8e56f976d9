"""Identify: from chosen records to a damper's card, and a card validated on records, as jobs."""

from __future__ import annotations

import json
from typing import Annotated, Any

from anyio import to_thread
from fastapi import APIRouter, HTTPException, Query, Request
from fastapi.responses import FileResponse, Response
from pydantic import BaseModel, Field

from dampyr.console import record_sources, safe_paths
from dampyr.console.damper_files import export_kinds, zipped_export
from dampyr.console.dampers import CARDS, DamperLink, damper_of, list_dampers, title_of
from dampyr.console.identify_schemas import IdentifyRequest, ValidateRequest, search_workers
from dampyr.console.job_routes import Id, JobState, as_job_state
from dampyr.console.jobs import CARD, CURVES, PAGE
from dampyr.console.limits import READING
from dampyr.console.option_schemas import form_of
from dampyr.console.state import AppState, CurrentApp
from dampyr.errors import InputError, MissingData
from dampyr.identification import FitOptions, ScoreOptions
from dampyr.identification.fits.fit_options import BUDGET
from dampyr.models import Damper, available_parts
from dampyr.models.part import part
from dampyr.phrases import counted

TITLE, ORDER = "Identify", 40
KIND, VALIDATION = "identify", "validate"
OVERHEAD = 1.25  # of a search's counted work: what compiles, and the last fits

router = APIRouter()


class IdentifyChoices(BaseModel):
    """What can be chosen: models, add-ons, the options of a fit, kinds of export with their words; cards to validate, and the
    options of that."""

    models: list[str]
    add_ons: list[str]
    options: list[dict[str, Any]]
    dampers: list[DamperLink]
    score_options: list[dict[str, Any]]
    exports: dict[str, str]
    search_time: str = Field(description="How long a search for the best model takes about, in a sentence.")


class Card(BaseModel):
    """The name that a card is saved by."""

    name: str = Field(min_length=1, max_length=80)


class SavedCard(BaseModel):
    """A card in the data folder."""

    name: str


@router.get("/choices")
async def list_choices(app: CurrentApp, request: Request) -> IdentifyChoices:
    """Allowed values of a request."""
    links = [DamperLink(**link) for link in await app.workers.run(request, READING, list_dampers, app.data)]
    names = {name: part(name).add_on for name in available_parts()}
    return IdentifyChoices(
        models=[name for name, add_on in names.items() if not add_on],
        add_ons=[name for name, add_on in names.items() if add_on],
        options=form_of(FitOptions),
        dampers=links,
        score_options=form_of(ScoreOptions),
        exports=export_kinds(),
        search_time=await to_thread.run_sync(_search_time, app),
    )


@router.post("/jobs", status_code=202)
def start_identification(app: CurrentApp, request: IdentifyRequest) -> JobState:
    """Start to identify; the job reports progress and has the result."""
    _check_keys(app, request.records)
    request.options().check_of_model(request.model)
    title = f"{request.model or 'the best model'}, {counted(len(request.records), 'record')}"
    return as_job_state(app.jobs.submit(KIND, request.model_dump(), title))


@router.post("/validations", status_code=202)
def start_validation(app: CurrentApp, request: ValidateRequest) -> JobState:
    """Start to validate a card on records that it predicts."""
    _check_keys(app, request.records)
    damper_of(app.data, request.card)
    title = f"validation of {title_of(request.card)}, {counted(len(request.records), 'record')}"
    return as_job_state(app.jobs.submit(VALIDATION, request.model_dump(), title))


@router.get("/jobs/{id}/curves")
def read_curves(app: CurrentApp, id: Id, record: Annotated[str, Query(max_length=200)]) -> dict[str, Any]:
    """Measured and modelled force of one record: over time, displacement and velocity; and the residual over time."""
    curves = json.loads((_done(app, id, (KIND, VALIDATION)) / CURVES).read_text("utf-8"))
    if record not in curves:
        raise MissingData(f"{record!r} is not among the records of this job")
    return dict(curves[record])


@router.post("/jobs/{id}/card", status_code=201)
def save_card(app: CurrentApp, id: Id, card: Card) -> SavedCard:
    """Save the damper's card in the folder ``cards`` of the data folder; an existing one is not replaced."""
    damper = _damper(app, id)
    safe_paths.check_new_name(card.name)
    target = safe_paths.inside(app.data, f"{CARDS}/{card.name}.toml")
    safe_paths.check_quota(app.data, 2**16, app.quota)
    target.parent.mkdir(exist_ok=True)
    with safe_paths.ALONE:
        if target.exists():
            raise HTTPException(409, f"there is a card {card.name!r} already; choose another name")
        damper.save(target)
    return SavedCard(name=target.name)


@router.get("/jobs/{id}/export", response_class=Response, responses={200: {"content": {"application/zip": {}}}})
def give_export(app: CurrentApp, id: Id, to: Annotated[str, Query(max_length=40)]) -> Response:
    """The damper for another tool as `dampyr export` writes it, in a zip."""
    content = zipped_export(_damper(app, id), to)
    return Response(
        content,
        media_type="application/zip",
        headers={"content-disposition": f'attachment; filename="damper-{to}.zip"'},
    )


@router.get("/jobs/{id}/page", response_class=Response, responses={200: {"content": {"text/html": {}}}})
def give_page(app: CurrentApp, id: Id) -> FileResponse:
    """The page as `dampyr identify --report` or `dampyr validate --report` writes it, as a file to keep."""
    name = {KIND: "identified.html", VALIDATION: "validated.html"}
    path = _done(app, id, tuple(name)) / PAGE
    return FileResponse(path, media_type="text/html", filename=name[app.jobs.job(id).kind])


def _done(app: AppState, id: str, kinds: tuple[str, ...] = (KIND,)) -> Any:
    if app.jobs.job(id).kind not in kinds:
        raise MissingData("that job is not an identification")
    app.jobs.result(id)
    return app.jobs.place(id)


def _search_time(app: AppState) -> str:
    """How long it takes to find the best model: as the last such search here, else what its counted work comes to."""
    for job in app.jobs.all():
        if job.kind == KIND and job.state == "done" and job.ended is not None:
            request = app.jobs.request(job.id)
            if request.get("model") is None:
                count = counted(len(request.get("records", ())), "record")
                return f"The last search in this data folder took {_minutes(job.ended - job.made)}, for {count}."
    most = BUDGET * OVERHEAD / search_workers()
    return f"Takes up to about {_minutes(most)} here, by its budget of counted work; longer beside other work."


def _minutes(seconds: float) -> str:
    return f"{max(round(seconds), 1)} s" if seconds < 90 else f"{seconds / 60:.0f} min"


def _damper(app: AppState, id: str) -> Damper:
    card = _done(app, id) / CARD
    if not card.is_file():
        raise InputError("this fit made no damper, so there is no card; see its reason")
    return Damper.load(card)


def _check_keys(app: AppState, keys: list[str]) -> None:
    for key in keys:
        record_sources.place(app.data, key)
