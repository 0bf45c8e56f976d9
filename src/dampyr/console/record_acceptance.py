"""Acceptance of records on the Records page, as ``dampyr accept`` does it."""

from __future__ import annotations

import math
import tempfile
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response
from pydantic import BaseModel, Field

from dampyr.console import record_sources
from dampyr.console.dampers import CARDS, DamperLink, damper_of, list_dampers
from dampyr.console.equivalent_commands import accept_command
from dampyr.console.limits import READING
from dampyr.console.option_schemas import form_of, request_of
from dampyr.console.page_words import in_page_words
from dampyr.console.state import CurrentApp
from dampyr.identification import AcceptOptions, accept
from dampyr.identification.acceptance_tests.accept import Accepted
from dampyr.identification.acceptance_tests.acceptance import QUANTITIES, Acceptance, AcceptancePoint
from dampyr.models import Damper
from dampyr.records import Record
from dampyr.show.identification.acceptance import band
from dampyr.show.pages.how_made import made_by
from dampyr.show.pages.result_page import write_page

MAX_RECORDS = 6  # as many as the page has colours for
MAX_POINTS, MAX_OUTSIDE = 900, 200  # what a chart can show and a person reads

Key = Annotated[str, Field(min_length=3, max_length=640)]

router = APIRouter()


class AcceptanceRequest(request_of(AcceptOptions)):  # type: ignore[misc]
    """Which records, by what reference, in what band."""

    key: list[Key] = Field(min_length=1, max_length=MAX_RECORDS, description="Records, such as data/uploads/test.h5.")
    reference: list[Key] = Field(
        min_length=1,
        max_length=MAX_RECORDS,
        description="A card, cards/NAME.toml, a published damper, or records by their keys.",
    )


class OnePoint(BaseModel):
    """A point outside, or the worst, SI; ``deviation`` is measured over expected less 1."""

    cycle: int
    quantity: str
    speed: float
    measured: float
    low: float | None
    high: float | None
    deviation: float | None


class Points(BaseModel):
    """The points of a quantity as columns, SI; ``used`` in halves of the band. Those inside are thinned where they are many."""

    quantity: str
    cycle: list[int]
    speed: list[float]
    measured: list[float]
    used: list[float | None]
    inside: list[bool | None]


class LevelJudged(BaseModel):
    """The cycles of one level, SI; ``deviation`` of each quantity is the mean measured over the mean expected value less 1."""

    number: int
    stroke_m: float
    frequency_hz: float
    cycles: int
    judged: int
    outside: bool
    deviation: dict[str, float | None]


class RecordVerdict(BaseModel):
    """One record: how it came out, and why points were not judged (the reason and how many).

    Cycles count from the start of the motion: ``run`` in halves, ``cut`` whole ones, ``judged_cycles`` by every
    quantity; strokes in m. ``wrong_rejection`` and ``wrong_acceptance`` are chances, see
    `dampyr.identification.acceptance_tests.acceptance.Acceptance`. The forces were divided by ``level``, 1 but for records
    that are relevelled.
    """

    key: str
    name: str
    input: str | None
    input_value: float | None
    verdict: Literal["passed", "failed", "not judged"]
    count: int
    judged: int
    run: float
    cut: int
    judged_cycles: int
    stroke_m: float
    judged_stroke_m: float
    wrong_rejection: float | None
    wrong_acceptance: float | None
    level: float | None
    levels: list[LevelJudged]
    outside_count: int
    reason: str
    reasons: dict[str, int]
    worst: OnePoint | None
    outside: list[OnePoint] = Field(description=f"The worst {MAX_OUTSIDE} of them.")
    points: list[Points]


class AcceptanceBand(BaseModel):
    """The band along the speed for the records of one input, in one direction, SI."""

    input: str | None
    input_value: float | None
    quantity: str
    speed: list[float]
    expected: list[float]
    low: list[float]
    high: list[float]


class Judgement(BaseModel):
    """All records, those judged a second time, and the bands to draw; ``data`` is what `dampyr accept --json` prints."""

    records: list[RecordVerdict]
    relevelled: list[RecordVerdict]
    bands: list[AcceptanceBand]
    notes: list[str] = Field(
        description="What a person should look at in the records and in the reference, worst first."
    )
    data: dict[str, Any]


@router.get("/references")
async def list_references(app: CurrentApp, request: Request) -> list[DamperLink]:
    """Dampers that records can be judged by; every record can be a reference, too."""
    return [DamperLink(**link) for link in await app.workers.run(request, READING, list_dampers, app.data)]


@router.get("/acceptance/options")
def list_options() -> list[dict[str, Any]]:
    """What can be chosen, for the form."""
    return form_of(AcceptOptions)


@router.get("/acceptance")
async def judge(app: CurrentApp, request: Request, query: Annotated[AcceptanceRequest, Query()]) -> Judgement:
    """Judge every whole cycle of every level of records by a reference; see `dampyr.identification.accept`."""
    return Judgement(**await app.workers.run(request, READING, judgement_of, app.data, query))


@router.get("/acceptance/page", response_class=Response, responses={200: {"content": {"text/html": {}}}})
async def give_page(app: CurrentApp, request: Request, query: Annotated[AcceptanceRequest, Query()]) -> Response:
    """The page as `dampyr accept --report` writes it, as a file to keep."""
    html = await app.workers.run(request, READING, page_of, app.data, query)
    return page_to_keep(html, "acceptance.html")


def page_to_keep(html: str, name: str) -> Response:
    """A page that the browser saves under a name, in the place of showing it."""
    return Response(html, media_type="text/html", headers={"content-disposition": f'attachment; filename="{name}"'})


def judgement_of(folder: Path, query: AcceptanceRequest) -> dict[str, Any]:
    """A `Judgement` as plain values."""
    accepted = _judged(folder, query)
    keys, data = dict.fromkeys(query.key), accepted.as_dict()

    def summaries(name: str, results: Sequence[Acceptance]) -> list[dict[str, Any]]:
        described = zip(keys, results, data.get(name, ()), strict=True) if results else ()
        return [_summarise(*of_record).model_dump() for of_record in described]

    return {
        "records": summaries("records", accepted.results),
        "relevelled": summaries("relevelled", accepted.relevelled),
        "bands": [acceptance_band.model_dump() for acceptance_band in _bands(accepted.results)],
        "notes": [in_page_words(finding.sentence) for finding in accepted.findings],
        "data": data,
    }


def page_of(data: Path, query: AcceptanceRequest) -> str:
    """The report's page."""
    accepted = _judged(data, query)
    cards = [data / name for name in query.reference if name.startswith(f"{CARDS}/")]
    with tempfile.TemporaryDirectory(prefix="dampyr-") as folder, made_by(accept_command(query), cards):
        return write_page(accepted, Path(folder) / "page.html").read_text("utf-8")


def _judged(data: Path, query: AcceptanceRequest) -> Accepted:
    chosen = record_sources.read_all(data, query.key)
    if len(query.reference) == 1 and _is_damper(query.reference[0]):
        reference: Damper | list[Record] = damper_of(data, query.reference[0])
    else:
        reference = record_sources.read_all(data, query.reference)
    name = ", ".join(_shown(reference_name) for reference_name in query.reference)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return accept(chosen, reference, query.options(), name)


def _is_damper(name: str) -> bool:
    """Keys of records have a source, parted by /; names of published dampers have none."""
    return name.startswith(f"{CARDS}/") or "/" not in name


def _shown(name: str) -> str:
    return Path(name).stem if "/" in name else name


def _summarise(key: str, acceptance: Acceptance, described: dict[str, Any]) -> RecordVerdict:
    """What a page shows of a record, out of what JSON holds of it."""
    outside = [level in acceptance.levels_outside for level in acceptance.levels]
    levels = [level | {"outside": is_outside} for level, is_outside in zip(described["levels"], outside, strict=True)]
    of_quantity = [[p for p in acceptance.points if p.quantity == quantity] for quantity in acceptance.quantities]
    return RecordVerdict.model_validate(
        described
        | {
            "key": key,
            "name": acceptance.record,
            "count": len(acceptance.points),
            "levels": levels,
            "outside_count": described["outside"],
            "reasons": acceptance.unjudged,
            "outside": [OnePoint.model_validate(p, from_attributes=True) for p in acceptance.outside[:MAX_OUTSIDE]],
            "points": [_points(name, points) for name, points in zip(acceptance.quantities, of_quantity, strict=True)],
        }
    )


def _points(quantity: str, points: Sequence[AcceptancePoint]) -> Points:
    stride = -(-len(points) // MAX_POINTS) or 1
    selected = [p for k, p in enumerate(points) if k % stride == 0]
    few = {id(p): p for p in [*selected, *[p for p in points if p.inside is False][:MAX_POINTS]]}.values()
    shown = sorted(few, key=lambda p: p.cycle)
    return Points(
        quantity=quantity,
        cycle=[p.cycle for p in shown],
        speed=[p.speed for p in shown],
        measured=[p.measured for p in shown],
        used=[_finite(p.used) for p in shown],
        inside=[p.inside for p in shown],
    )


def _bands(acceptances: Sequence[Acceptance]) -> list[AcceptanceBand]:
    groups: dict[tuple[str | None, float | None], list[Acceptance]] = {}
    for acceptance in acceptances:
        groups.setdefault((acceptance.input, acceptance.input_value), []).append(acceptance)
    bands = []
    for (unit, value), group in sorted(groups.items(), key=lambda item: math.inf if item[0][1] is None else item[0][1]):
        for quantity in QUANTITIES[:2]:
            rows = band(group, quantity)
            if rows:
                speed, expected, low, high = map(list, zip(*rows, strict=True))
                bands.append(
                    AcceptanceBand(
                        input=unit, input_value=value, quantity=quantity,
                        speed=speed, expected=expected, low=low, high=high,
                    )
                )  # fmt: skip
    return bands


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
