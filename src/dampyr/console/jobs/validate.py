"""Validation of a card, as ``dampyr validate`` does it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.console import curves, record_sources
from dampyr.console.dampers import damper_of, title_of
from dampyr.console.equivalent_commands import validate_command
from dampyr.console.identify_schemas import ValidateRequest
from dampyr.console.jobs import CURVES, DATA, PAGE
from dampyr.console.page_tables import page_table
from dampyr.console.page_words import in_page_words
from dampyr.console.safe_paths import data_of
from dampyr.identification import validate
from dampyr.identification.scoring.validate import Validated
from dampyr.records import with_velocity
from dampyr.show.descriptions import describe
from dampyr.show.pages.how_made import made_by
from dampyr.show.pages.result_page import write_page
from dampyr.to_json import plain


def run(request: dict[str, Any], folder: Path, progress: Callable[[str, float], None]) -> dict[str, Any]:
    """``request`` is a `ValidateRequest`."""
    parsed, data = ValidateRequest(**request), data_of(folder)
    chosen = record_sources.read_all(data, parsed.records)
    damper = damper_of(data, parsed.card)
    result = validate(damper, chosen, parsed.options(), title_of(parsed.card), progress)
    with made_by(validate_command(parsed), [data / parsed.card]):
        write_page(result, folder / PAGE)
    write_whole(folder / CURVES, json.dumps(_curves(result)))
    return {DATA: result.as_dict(), **_summarise(result)}


def _summarise(result: Validated) -> dict[str, Any]:
    """What the page shows in its own form, besides the data."""
    shown = describe(result)
    return {
        "card": result.card,
        "model": str(result.damper.composition),
        "notice": result.origin.notice,
        "verdict": [in_page_words(sentence) for sentence in shown.verdict],
        "warnings": [in_page_words(finding.sentence) for finding in result.findings],
        "records": [record.name for record in result.records],
        "tables": [page_table(make()) for make in shown.tables],
    }


def _curves(result: Validated) -> dict[str, Any]:
    """Lines by record, over the samples that are scored: the measured force, and the predicted one with its offset."""
    lines = {}
    for record in result.records:
        score, moving = result.scores[record.name], with_velocity(record)
        force = np.asarray(result.forces[record.name]) + score.offset
        channels = (record.time, record.displacement, moving.velocity, record.force, force)
        scored = [np.asarray(channel)[score.window.slice] for channel in channels]
        lines[record.name] = curves.measured_and_modelled(*scored)
    return dict(plain(lines))
