"""The console as an application: its pages' endpoints, the files that a browser loads, and the guard around both."""

from __future__ import annotations

import mimetypes
import time
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from fastapi import APIRouter, FastAPI, HTTPException, Request
from fastapi.responses import FileResponse, Response
from pydantic import BaseModel, Field
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp

import dampyr
from dampyr import registry
from dampyr.console import cards, job_routes
from dampyr.console.error_responses import add_handlers
from dampyr.console.job_processes import Jobs
from dampyr.console.rigs import Opener, opened
from dampyr.console.safe_paths import OWN
from dampyr.console.security import AnswerHeaders, BodyLimit, HostCheck, OriginCheck, TokenBrake, TokenCheck
from dampyr.console.state import PROBLEMS, AppState
from dampyr.source_digest import full_version

PAGES = "dampyr.console.pages"
LOOK = Path(str(files("dampyr.show.pages"))) / "templates" / "look.css"  # one source of colours for console and reports
QUOTA = 4 * 2**30  # bytes: 64 of the largest uploads
CHARTS = ("bokeh.min.js", "bokeh-api.min.js")  # of BokehJS, all that is ever loaded
NO_CHARTS = (
    'charts need the package bokeh, which is not installed: run pip install "dampyr[console]", '
    "then start the console again"
)
TYPES = {".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}


class PageLink(BaseModel):
    """A page of the navigation."""

    name: str
    title: str


class Console(BaseModel):
    """What the console is."""

    version: str
    pages: list[PageLink]
    charts: str = Field(description="Why no charts can be drawn; empty where they can.")


def app(
    data: str | Path,
    token: str | None = None,
    loopback_only: bool = True,
    quota: int = QUOTA,
    at_once: int | None = None,
    opener: Opener = opened,
    clock: Callable[[], float] = time.monotonic,
) -> ASGIApp:
    """The console over the folder ``data``.

    Parameters
    ----------
    data
        where records, cards and campaigns are, and where everything is written; made where it is missing.
    token
        what a browser must present once; None requires none.
    loopback_only
        whether only the names of this machine's loopback are accepted.
    quota
        bytes that the data folder may hold before uploads are refused.
    at_once
        how many jobs run at a time; by default one core is left free.
    opener
        ``opener(data, name, simulate)`` connects the bench's rig, for rigs that a ``rig.toml`` cannot describe.
    clock
        the time [s] by which the bench notices that a page is silent, and by which wrong tokens are braked.
    """
    folder = Path(data).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    app_state = AppState(folder, Jobs(folder / OWN / "jobs", at_once), quota, opener, clock)
    pages = sorted(registry.members(PAGES), key=lambda member: member[1].ORDER)
    inner = FastAPI(
        title="dampyr console", version=dampyr.__version__, openapi_url="/api/openapi.json", docs_url=None, redoc_url=None,
        lifespan=_lifespan(app_state, [module for _, module in pages]), responses=PROBLEMS,
    )  # fmt: skip
    inner.state.dampyr = app_state
    add_handlers(inner, folder)
    inner.include_router(_about([PageLink(name=name, title=module.TITLE) for name, module in pages]), prefix="/api")
    for shared in (job_routes, cards):
        inner.include_router(shared.router, prefix="/api")
    for name, module in pages:
        inner.include_router(module.router, prefix=f"/api/{name}", tags=[module.TITLE])
    _add_files(inner)
    open_here = frozenset(path for _, module in pages for path in getattr(module, "OPEN_HERE", ()))
    guarded: ASGIApp = BodyLimit(inner)  # around FastAPI, so that its answers to faults have the headers, too
    if token is not None:
        guarded = TokenCheck(guarded, token, open_here)
    guarded = HostCheck(OriginCheck(guarded), loopback_only)
    if token is not None:
        guarded = TokenBrake(guarded, token, open_here, clock)
    return AnswerHeaders(guarded)


def _about(links: list[PageLink]) -> APIRouter:
    router = APIRouter(tags=["Console"])

    @router.get("/console")
    def about() -> Console:
        """What this console is, and which pages it has."""
        return Console(version=full_version(), pages=links, charts="" if _charts() else NO_CHARTS)

    return router


def _lifespan(app_state: AppState, modules: list[Any]) -> Any:
    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        async with AsyncExitStack() as stack:
            stack.callback(app_state.jobs.close)
            stack.callback(app_state.workers.close)
            stack.callback(app_state.uploads.close)
            for module in modules:
                if hasattr(module, "lifespan"):
                    await stack.enter_async_context(module.lifespan(app_state))
            yield

    return lifespan


def _add_files(inner: FastAPI) -> None:
    """The page itself and what it loads, by names of types that do not depend on the machine."""
    for suffix, kind in TYPES.items():
        mimetypes.add_type(kind, suffix)
    static = Path(str(files("dampyr.console"))) / "static"

    @inner.api_route("/", methods=["GET", "HEAD"], include_in_schema=False)
    def index() -> FileResponse:
        return FileResponse(static / "index.html")

    @inner.get("/static/look.css", include_in_schema=False)
    def look() -> FileResponse:
        return FileResponse(LOOK)

    inner.mount("/static", StaticFiles(directory=static))
    for name in CHARTS:
        inner.add_api_route(f"/bokeh/{name}", _chart_file(name), include_in_schema=False)


def _charts() -> Path | None:
    """The folder of BokehJS in the installed package ``bokeh``, which is not imported; None where files of it are missing."""
    package = find_spec("bokeh")
    folder = Path(package.origin).parent / "server" / "static" / "js" if package and package.origin else None
    return folder if folder and all((folder / name).is_file() for name in CHARTS) else None


def _chart_file(name: str) -> Callable[[Request], Response]:
    """The endpoint of one file of BokehJS."""

    def chart_file(request: Request) -> Response:
        folder = _charts()
        if folder is None:
            raise HTTPException(404, NO_CHARTS)
        return StaticFiles(directory=folder).file_response(folder / name, (folder / name).stat(), request.scope)

    return chart_file
