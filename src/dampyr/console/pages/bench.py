"""The bench: a rig, its live readings, and who has control."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Annotated

from fastapi import APIRouter, Depends, Query, WebSocket
from pydantic import BaseModel, Field

from dampyr.campaigns import read_journal
from dampyr.campaigns.journal import NAME as JOURNAL
from dampyr.console import safe_paths
from dampyr.console.bench_session import Bench
from dampyr.console.bench_state import BenchState
from dampyr.console.decimation import COLUMNS, as_lists
from dampyr.console.grid import FOLDER
from dampyr.console.guided import Step
from dampyr.console.rigs import rig_names, rig_settings
from dampyr.console.state import AppState, Here
from dampyr.console.stream import ABORTING, Stream
from dampyr.errors import InputError

TITLE, ORDER = "Bench", 10
OPEN_HERE = ("/api/bench/abort",)
RUNS = "runs"
ID = "^[A-Za-z0-9-]{8,64}$"

router = APIRouter()


def bench(here: Here) -> Bench:
    """The bench of this console."""
    session: Bench = here.own["bench"]
    return session


CurrentBench = Annotated[Bench, Depends(bench)]


@asynccontextmanager
async def lifespan(app_state: AppState) -> AsyncIterator[None]:
    """A bench for as long as the console runs; at its end the rig is disarmed."""
    made = app_state.own["bench"] = Bench(app_state.data, app_state.opener, app_state.clock)
    try:
        yield
    finally:
        await asyncio.to_thread(made.close)


class ClientRequest(BaseModel):
    """Who asks: the id with which a page opened its stream."""

    client: str = Field(pattern=ID)


class Connect(ClientRequest):
    """Which rig: a name of the list, empty for the original one; simulated, or at the end of its wires."""

    rig: str = Field("", max_length=100)
    simulate: bool = True


class Home(ClientRequest):
    """Look for the index mark, or take the place where the table stands (``here``) for the middle."""

    here: bool = False


class Jog(ClientRequest):
    """m/s, extension positive; 0 stops."""

    speed: float = Field(ge=-1.0, le=1.0)


class Calibration(ClientRequest):
    """A step; ``load`` is a force or a mass such as "20 kg", or the shunt's resistance such as "100 kohm"."""

    step: Step
    load: str = Field("", max_length=40)


class Keep(ClientRequest):
    """Whether the result is saved."""

    keep: bool


class Start(ClientRequest):
    """Which campaign of the list, and into which folder below ``runs``; one with a part of it is continued."""

    campaign: str = Field(max_length=100)
    folder: str = Field(max_length=100)


class Abort(BaseModel):
    """Who asks, if they want to be named."""

    who: str = Field("", max_length=40)


class RigFile(BaseModel):
    """A rig that can be connected; ``wired`` where its file names wires."""

    name: str
    title: str
    wired: bool


class TestState(BaseModel):
    """A test of a run."""

    __test__ = False
    name: str
    state: str
    attempt: int
    reason: str


class Done(BaseModel):
    """It is under way; `read` returns its outcome."""

    accepted: bool = True


@router.get("")
def read(bench: CurrentBench) -> BenchState:
    """How the bench is."""
    return bench.state()


@router.get("/strips")
def strips(
    bench: CurrentBench, seconds: Annotated[float, Query(gt=0.0, le=30.0)] = 12.0
) -> dict[str, list[float | None]]:
    """The last bins of the rig, least and greatest values of 10 ms each; empty lists where nothing was sampled yet."""
    history = bench.strips
    if history is None:
        return {name: [] for name in COLUMNS}
    return as_lists(history.since(history.count - round(seconds / history.width))[1])


@router.get("/rigs")
def rigs(here: Here) -> list[RigFile]:
    """The rigs that can be connected; the original one first."""
    rig_files = []
    for name in ("", *rig_names(here.data)):
        try:
            settings = rig_settings(here.data, name)
        except InputError:
            continue  # `dampyr run --rig` reports what is wrong with a file
        rig_files.append(RigFile(name=name, title=settings.name, wired=bool(settings.wires.serial)))
    return rig_files


@router.get("/runs")
def runs(here: Here) -> list[str]:
    """The folders of records that campaigns left."""
    return sorted(path.parent.name for path in (here.data / RUNS).glob(f"*/{JOURNAL}"))


@router.get("/tests")
def tests(here: Here, folder: Annotated[str, Query(max_length=100)]) -> list[TestState]:
    """The tests of a run, from its journal; none where it has no journal yet."""
    place = safe_paths.inside(here.data, f"{RUNS}/{folder}")
    if not (place / JOURNAL).is_file():
        return []
    entries, _ = read_journal(place)
    return [TestState(name=each.name, state=each.state, attempt=each.attempt, reason=each.reason) for each in entries]


@router.post("/control")
def control(request: ClientRequest, bench: CurrentBench) -> Done:
    """Take control, from whoever has it; what they moved stops."""
    bench.clients.take(request.client)
    return Done()


@router.post("/connect")
def connect(request: Connect, here: Here, bench: CurrentBench) -> Done:
    """Connect a rig."""
    rig_settings(here.data, request.rig)
    bench.connect(request.client, request.rig, request.simulate)
    return Done()


@router.post("/disconnect")
def disconnect(request: ClientRequest, bench: CurrentBench) -> Done:
    """Let go of the rig; an armed one is disarmed first."""
    bench.disconnect(request.client)
    return Done()


@router.post("/arm")
def arm(request: ClientRequest, bench: CurrentBench) -> Done:
    """Let energy in."""
    bench.arm(request.client)
    return Done()


@router.post("/disarm")
def disarm(request: ClientRequest, bench: CurrentBench) -> Done:
    """Bring the table to rest, and let no energy in."""
    bench.disarm(request.client)
    return Done()


@router.post("/home")
def home(request: Home, bench: CurrentBench) -> Done:
    """Find the middle of the stroke."""
    bench.home(request.client, request.here)
    return Done()


@router.post("/jog")
def jog(request: Jog, bench: CurrentBench) -> Done:
    """Move for a third of a second; ask again to move on."""
    bench.jog(request.client, request.speed)
    return Done()


@router.post("/zero")
def zero(request: ClientRequest, bench: CurrentBench) -> Done:
    """Take the load cell's signal of a second for no force."""
    bench.zero(request.client)
    return Done()


@router.post("/calibration")
def calibration(request: ClientRequest, bench: CurrentBench) -> Done:
    """Begin the guided steps of calibrating the load cell."""
    bench.calibrate(request.client)
    return Done()


@router.post("/calibration/step")
def calibration_step(request: Calibration, bench: CurrentBench) -> Done:
    """Read the load cell."""
    bench.calibrate_step(request.client, request.step, request.load)
    return Done()


@router.post("/calibration/end")
def calibration_end(request: Keep, bench: CurrentBench) -> Done:
    """Save the result, or discard it."""
    bench.calibrate_end(request.client, request.keep)
    return Done()


@router.post("/start")
def start(request: Start, here: Here, bench: CurrentBench) -> Done:
    """Check a campaign and run it, or what is left of it."""
    path = safe_paths.existing(here.data, f"{FOLDER}/{request.campaign}.toml")
    folder = safe_paths.inside(here.data, f"{RUNS}/{request.folder}")
    if folder.parent != here.data / RUNS:
        raise InputError(f"folder = {request.folder!r} is not allowed; give a name without /")
    bench.start(request.client, request.campaign, path, folder)
    return Done()


@router.post("/pause")
def pause(request: ClientRequest, bench: CurrentBench) -> Done:
    """Wait, armed and at rest, after the test under way."""
    bench.pause(request.client, True)
    return Done()


@router.post("/resume")
def resume(request: ClientRequest, bench: CurrentBench) -> Done:
    """Go on."""
    bench.pause(request.client, False)
    return Done()


@router.post("/stop")
def stop(request: ClientRequest, bench: CurrentBench) -> Done:
    """End the test under way in order, and the campaign with it."""
    bench.stop(request.client)
    return Done()


@router.post("/abort")
async def abort(request: Abort, bench: CurrentBench) -> Done:
    """Brake and cut the coil, now. Needs no control, and on this machine no token; answers when it is done."""
    await asyncio.get_running_loop().run_in_executor(ABORTING, bench.abort, request.who)
    return Done()


@router.websocket("/stream")
async def stream(socket: WebSocket, bench: CurrentBench, client: Annotated[str, Query(pattern=ID)]) -> None:
    """What a page shows, live (:mod:`dampyr.console.stream`)."""
    await Stream(bench, client, socket).run()
