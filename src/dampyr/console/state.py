"""State shared by the pages of one console: the data folder, the jobs, and each page's own state."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from fastapi import Depends
from pydantic import BaseModel, Field
from starlette.requests import HTTPConnection

from dampyr.console.job_processes import Jobs
from dampyr.console.record_list import RecordList
from dampyr.console.rigs import Opener, opened
from dampyr.console.workers import Workers


@dataclass
class AppState:
    """The state of one console. ``own`` is for pages: page name -> its state while the console runs.

    ``workers`` plan, list and read for requests, ``uploads`` read what comes in, one after the other.
    ``opener(data, name, simulate)`` connects a rig, and ``clock`` gives the bench's time [s].
    """

    data: Path
    jobs: Jobs
    quota: int
    opener: Opener = opened
    clock: Callable[[], float] = time.monotonic
    own: dict[str, Any] = field(default_factory=dict)
    workers: Workers = field(default_factory=Workers)
    records: RecordList = field(default_factory=RecordList)
    uploads: Workers = field(default_factory=lambda: Workers(at_once=1))


def get_app_state(connection: HTTPConnection) -> AppState:
    """The state of the application that serves a request or a WebSocket."""
    app_state: AppState = connection.app.state.dampyr
    return app_state


CurrentApp = Annotated[AppState, Depends(get_app_state)]
"""Such as ``def list_cards(app: CurrentApp)``; serves requests and WebSockets."""


class ErrorAnswer(BaseModel):
    """What every error answers."""

    detail: str = Field(description="One sentence for a person.")


PROBLEMS: dict[int | str, dict[str, Any]] = {
    code: {"model": ErrorAnswer, "description": words}
    for code, words in {
        400: "The request is wrong, or cannot be understood.",
        401: "This console requires its token.",
        403: "The request comes from another site.",
        404: "Not available.",
        409: "Something else has to happen first.",
        413: "Too large.",
        422: "A value is missing, or of the wrong kind.",
    }.items()
}
