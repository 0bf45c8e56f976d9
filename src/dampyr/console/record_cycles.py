"""Figures of cycles of records on the Records page, as ``dampyr cycles`` tells them."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response
from pydantic import BaseModel, Field

from dampyr.console import record_sources
from dampyr.console.equivalent_commands import cycles_command
from dampyr.console.limits import READING
from dampyr.console.option_schemas import form_of, request_of
from dampyr.console.page_tables import page_table
from dampyr.console.page_words import in_page_words
from dampyr.console.record_acceptance import MAX_RECORDS, Key, page_to_keep
from dampyr.console.state import CurrentApp
from dampyr.records import CycleOptions, cycles
from dampyr.records.cycle_analysis.cycle_figures import CycleFigures
from dampyr.show.pages.how_made import made_by
from dampyr.show.pages.result_page import write_page
from dampyr.show.records.cycle_figures import named_tables

router = APIRouter()


class CyclesRequest(request_of(CycleOptions)):  # type: ignore[misc]
    """Which records, and the options of their figures."""

    key: list[Key] = Field(min_length=1, max_length=MAX_RECORDS, description="Records, such as data/uploads/test.h5.")


class FigureTable(BaseModel):
    """A table as the page shows it, in the units of the request."""

    name: str
    caption: str
    columns: list[str]
    units: list[str]
    rows: list[list[str | float | bool | None]]
    notes: list[str]


class CycleAnswer(BaseModel):
    """The tables that have something to say; ``data`` is what `dampyr cycles --json` prints."""

    tables: list[FigureTable]
    notes: list[str] = Field(description="What a person should look at in the records, worst first.")
    data: dict[str, Any]


@router.get("/cycle-figures/options")
def list_options() -> list[dict[str, Any]]:
    """What can be chosen, for the form."""
    return form_of(CycleOptions)


@router.get("/cycle-figures")
async def tell(app: CurrentApp, request: Request, query: Annotated[CyclesRequest, Query()]) -> CycleAnswer:
    """The figures of every cycle of records, and of the device by them; see `dampyr.records.cycles`."""
    return CycleAnswer(**await app.workers.run(request, READING, answer_of, app.data, query))


@router.get("/cycle-figures/page", response_class=Response, responses={200: {"content": {"text/html": {}}}})
async def give_page(app: CurrentApp, request: Request, query: Annotated[CyclesRequest, Query()]) -> Response:
    """The page as `dampyr cycles --report` writes it, as a file to keep."""
    html = await app.workers.run(request, READING, page_of, app.data, query)
    return page_to_keep(html, "cycles.html")


def answer_of(data: Path, query: CyclesRequest) -> dict[str, Any]:
    """A `CycleAnswer` as plain values."""
    result = _figures(data, query)
    return {
        "tables": [{"name": name} | page_table(table) for name, table in named_tables(result).items()],
        "notes": [in_page_words(finding.sentence) for finding in result.findings],
        "data": result.as_dict(),
    }


def page_of(data: Path, query: CyclesRequest) -> str:
    """The report's page."""
    result = _figures(data, query)
    with tempfile.TemporaryDirectory(prefix="dampyr-") as folder, made_by(cycles_command(query)):
        return write_page(result, Path(folder) / "page.html").read_text("utf-8")


def _figures(data: Path, query: CyclesRequest) -> CycleFigures:
    return cycles(record_sources.read_all(data, query.key), query.options())
