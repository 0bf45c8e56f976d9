"""The bench: a rig, live, and who works with it."""

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
from dampyr.console.state import Here, House
from dampyr.console.stream import ABORTING, Stream
from dampyr.errors import InputError

TITLE, ORDER = "Bench", 10
OPEN_HERE = ("/api/bench/abort",)
RUNS = "runs"
ID = "^[A-Za-z0-9-]{8,64}$"

router = APIRouter()


def bench(here: Here) -> Bench:
    """The bench of this console."""
    found: Bench = here.own["bench"]
    return found


Known = Annotated[Bench, Depends(bench)]


@asynccontextmanager
async def lifespan(house: House) -> AsyncIterator[None]:
    """A bench for as long as the console runs; at its end the rig is disarmed."""
    made = house.own["bench"] = Bench(house.data)
    try:
        yield
    finally:
        await asyncio.to_thread(made.close)


class Asked(BaseModel):
    """Who asks: the id with which a page opened its stream."""

    client: str = Field(pattern=ID)


class Connect(Asked):
    """Which rig: a name of the list, empty for the original one; simulated, or at the end of its wires."""

    rig: str = Field("", max_length=100)
    simulate: bool = True


class Home(Asked):
    """Look for the index mark, or take the place where the table stands (``here``) for the middle."""

    here: bool = False


class Jog(Asked):
    """m/s, extension positive; 0 stops."""

    speed: float = Field(ge=-1.0, le=1.0)


class Calibration(Asked):
    """A step; ``load`` is a force or a mass such as "20 kg", or the shunt's resistance such as "100 kohm"."""

    step: Step
    load: str = Field("", max_length=40)


class Keep(Asked):
    """Whether what was found is kept."""

    keep: bool


class Start(Asked):
    """Which campaign of the list, and into which folder below ``runs``; one that holds a part of it is gone on with."""

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
    """It is under way; `read` tells how it went."""

    accepted: bool = True


@router.get("")
def read(bench: Known) -> BenchState:
    """How the bench is."""
    return bench.state()


@router.get("/strips")
def strips(bench: Known, seconds: Annotated[float, Query(gt=0.0, le=30.0)] = 12.0) -> dict[str, list[float | None]]:
    """The last bins of the rig, least and greatest values of 10 ms each; empty lists where nothing was sampled yet."""
    known = bench.strips
    if known is None:
        return {name: [] for name in COLUMNS}
    return as_lists(known.since(known.count - round(seconds / known.width))[1])


@router.get("/rigs")
def rigs(here: Here) -> list[RigFile]:
    """The rigs that can be connected; the original one first."""
    found = []
    for name in ("", *rig_names(here.data)):
        try:
            settings = rig_settings(here.data, name)
        except InputError:
            continue  # a file that is wrong is told of by `dampyr run --rig`
        found.append(RigFile(name=name, title=settings.name, wired=bool(settings.wires.serial)))
    return found


@router.get("/runs")
def runs(here: Here) -> list[str]:
    """The folders of records that campaigns left."""
    return sorted(path.parent.name for path in (here.data / RUNS).glob(f"*/{JOURNAL}"))


@router.get("/tests")
def tests(here: Here, folder: Annotated[str, Query(max_length=100)]) -> list[TestState]:
    """The tests of a run, as its journal tells; none where it has no journal yet."""
    place = safe_paths.inside(here.data, f"{RUNS}/{folder}")
    if not (place / JOURNAL).is_file():
        return []
    found, _ = read_journal(place)
    return [TestState(name=each.name, state=each.state, attempt=each.attempt, reason=each.reason) for each in found]


@router.post("/control")
def control(asked: Asked, bench: Known) -> Done:
    """Take control, from whoever has it; what they moved stops."""
    bench.clients.take(asked.client)
    return Done()


@router.post("/connect")
def connect(asked: Connect, here: Here, bench: Known) -> Done:
    """Connect a rig."""
    rig_settings(here.data, asked.rig)
    bench.connect(asked.client, asked.rig, asked.simulate)
    return Done()


@router.post("/disconnect")
def disconnect(asked: Asked, bench: Known) -> Done:
    """Let go of the rig; an armed one is disarmed first."""
    bench.disconnect(asked.client)
    return Done()


@router.post("/arm")
def arm(asked: Asked, bench: Known) -> Done:
    """Let energy in."""
    bench.arm(asked.client)
    return Done()


@router.post("/disarm")
def disarm(asked: Asked, bench: Known) -> Done:
    """Bring the table to rest, and let no energy in."""
    bench.disarm(asked.client)
    return Done()


@router.post("/home")
def home(asked: Home, bench: Known) -> Done:
    """Find the middle of the stroke."""
    bench.home(asked.client, asked.here)
    return Done()


@router.post("/jog")
def jog(asked: Jog, bench: Known) -> Done:
    """Move for a third of a second; ask again to move on."""
    bench.jog(asked.client, asked.speed)
    return Done()


@router.post("/zero")
def zero(asked: Asked, bench: Known) -> Done:
    """Take the load cell's signal of a second for no force."""
    bench.zero(asked.client)
    return Done()


@router.post("/calibration")
def calibration(asked: Asked, bench: Known) -> Done:
    """Begin the guided steps of calibrating the load cell."""
    bench.calibrate(asked.client)
    return Done()


@router.post("/calibration/step")
def calibration_step(asked: Calibration, bench: Known) -> Done:
    """Read the load cell."""
    bench.calibrate_step(asked.client, asked.step, asked.load)
    return Done()


@router.post("/calibration/end")
def calibration_end(asked: Keep, bench: Known) -> Done:
    """Keep what was found, or forget it."""
    bench.calibrate_end(asked.client, asked.keep)
    return Done()


@router.post("/start")
def start(asked: Start, here: Here, bench: Known) -> Done:
    """Check a campaign and run it, or what is left of it."""
    path = safe_paths.existing(here.data, f"{FOLDER}/{asked.campaign}.toml")
    folder = safe_paths.inside(here.data, f"{RUNS}/{asked.folder}")
    if folder.parent != here.data / RUNS:
        raise InputError(f"folder = {asked.folder!r} is not allowed; give a name without /")
    bench.start(asked.client, asked.campaign, path, folder)
    return Done()


@router.post("/pause")
def pause(asked: Asked, bench: Known) -> Done:
    """Wait, armed and at rest, after the test under way."""
    bench.pause(asked.client, True)
    return Done()


@router.post("/resume")
def resume(asked: Asked, bench: Known) -> Done:
    """Go on."""
    bench.pause(asked.client, False)
    return Done()


@router.post("/stop")
def stop(asked: Asked, bench: Known) -> Done:
    """End the test under way in order, and the campaign with it."""
    bench.stop(asked.client)
    return Done()


@router.post("/abort")
async def abort(asked: Abort, bench: Known) -> Done:
    """Brake and cut the coil, now. Needs no control, and on this machine no token; answers when it is done."""
    await asyncio.get_running_loop().run_in_executor(ABORTING, bench.abort, asked.who)
    return Done()


@router.websocket("/stream")
async def stream(socket: WebSocket, bench: Known, client: Annotated[str, Query(pattern=ID)]) -> None:
    """What a page shows, live (:mod:`dampyr.console.stream`)."""
    await Stream(bench, client, socket).run()
