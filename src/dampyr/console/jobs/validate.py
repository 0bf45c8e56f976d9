"""Validation of a card, as ``dampyr validate`` does it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from dampyr.console import record_sources
from dampyr.console.dampers import damper_of, title_of
from dampyr.console.equivalent_commands import validate_command
from dampyr.console.identify_schemas import ValidateRequest
from dampyr.console.jobs import DATA, PAGE
from dampyr.console.safe_paths import data_of
from dampyr.identification import validate
from dampyr.show.pages.how_made import made_by
from dampyr.show.pages.result_page import write_page


def run(request: dict[str, Any], folder: Path, progress: Callable[[str, float], None]) -> dict[str, Any]:
    """``request`` is a `ValidateRequest`."""
    parsed, data = ValidateRequest(**request), data_of(folder)
    chosen = record_sources.read_all(data, parsed.records)
    damper = damper_of(data, parsed.card)
    result = validate(damper, chosen, parsed.options(), title_of(parsed.card), progress)
    with made_by(validate_command(parsed), [data / parsed.card]):
        write_page(result, folder / PAGE)
    return {DATA: result.as_dict()}
