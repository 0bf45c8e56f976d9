"""Requests of the Identify page, and the options of the jobs that they mean."""

from __future__ import annotations

import os
from typing import Annotated

from pydantic import Field

from dampyr.console.option_schemas import request_of
from dampyr.identification import FitOptions, ScoreOptions

MAX_WORKERS = 8  # each process compiles the models of its own trials, which more of them would only repeat
Keys = Annotated[list[str], Field(min_length=1, max_length=200, description="Keys of records.")]
Model = Annotated[str, Field(max_length=120, description="Such as dahl + spring.")]


class IdentifyRequest(request_of(FitOptions)):  # type: ignore[misc]
    """What to identify from which records; validation records are predicted.

    Without a model every model of the catalogue is tried, or those in ``models``.
    """

    records: Keys
    model: Model | None = None


class ValidateRequest(request_of(ScoreOptions)):  # type: ignore[misc]
    """Records that a damper predicts: a card of the data folder (``cards/NAME.toml``) or a published set."""

    records: Keys
    card: str = Field(min_length=1, max_length=200)


def search_workers() -> int:
    """Processes of a search for the best model: one core is left to the console and the rig."""
    return min(max((os.cpu_count() or 2) - 1, 1), MAX_WORKERS)
