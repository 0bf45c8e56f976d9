"""The bench: a rig, its live readings, and who has control."""

from __future__ import annotations

import asyncio
import itertools
import shutil
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from datetime import date
from glob import escape as glob_escape
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request, WebSocket
from fastapi import Path as InPath
from fastapi.responses import FileResponse
from pydantic import BaseModel, Field

from dampyr.campaigns import plan, read_journal
from dampyr.campaigns import read as read_campaign
from dampyr.campaigns.journal import NAME as JOURNAL
from dampyr.campaigns.recorded_tests import entries_with_files
from dampyr.campaigns.run_folders import RunFolder, folder_state, run_folder
from dampyr.console import safe_paths
from dampyr.console.bench_alarms import Reading
from dampyr.console.bench_campaigns import RUNS, records_folder
from dampyr.console.bench_events import BenchEvent
from dampyr.console.bench_reference import ReferenceLoop
from dampyr.console.bench_session import Bench
from dampyr.console.bench_state import BenchState
from dampyr.console.decimation import COLUMNS, as_lists
from dampyr.console.error_responses import MAX_SENTENCE, without_places
from dampyr.console.grid import FOLDER
from dampyr.console.guided import Step
from dampyr.console.rigs import rig_names, rig_settings
from dampyr.console.run_report import report_of
from dampyr.console.state import AppState, CurrentApp
from dampyr.console.stream import ABORTING, Stream
from dampyr.errors import InputError

TITLE, ORDER = "Bench", 10
OPEN_HERE = ("/api/bench/abort",)
MAX_RUNS = 100  # folders that a page lists
ID = "^[A-Za-z0-9-]{8,64}$"

router = APIRouter()


def bench(app: CurrentApp) -> Bench:
    """The bench of this console."""
    session: Bench = app.own["bench"]
    return session


CurrentBench = Annotated[Bench, Depends(bench)]
Name = Annotated[str, Query(max_length=100)]


@asynccontextmanager
async def lifespan(app_state: AppState) -> AsyncIterator[None]:
    """A bench for as long as the console runs; at its end the rig is disarmed."""
    session = app_state.own["bench"] = Bench(app_state.data, app_state.opener, app_state.clock)
    try:
        yield
    finally:
        await asyncio.to_thread(session.close)


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


class CalibrationRequest(ClientRequest):
    """A step; ``load`` is a force or a mass such as "20 kg", or the shunt's resistance such as "100 kohm"."""

    step: Step
    load: str = Field("", max_length=40)


class Keep(ClientRequest):
    """Whether the result is saved."""

    keep: bool


class Go(ClientRequest):
    """m from the middle, extension positive."""

    position: float = Field(ge=-1.0, le=1.0)


class SineMotion(ClientRequest):
    """A sine that is not recorded: m, Hz, V at the coil, whole cycles."""

    amplitude: float = Field(gt=0.0, le=1.0)
    frequency: float = Field(gt=0.0, le=100.0)
    voltage: float = Field(0.0, ge=0.0, le=100.0)
    cycles: int = Field(5, ge=1, le=1000)


class CoilVoltage(ClientRequest):
    """V at the coil for a time [s], with the table at rest."""

    voltage: float = Field(ge=0.0, le=100.0)
    seconds: float = Field(10.0, gt=0.0, le=3600.0)


class LimitRequest(ClientRequest):
    """The range (SI) within which a reading raises no alarm; without low and high its limit is removed."""

    reading: Reading
    low: float | None = None
    high: float | None = None


class AlarmRequest(ClientRequest):
    """Which alarm; without a number all of them."""

    number: int | None = None


class Start(ClientRequest):
    """Which campaign of the list, and into which folder below ``runs``; one with a part of it is continued.

    ``reference`` is the folder of an earlier run of the same tests, with which each cycle is compared within ``tolerance``, a
    ratio; empty: no comparison.
    """

    campaign: str = Field(max_length=100)
    folder: str = Field(max_length=100)
    operator: str = Field("", max_length=200)
    specimen: str = Field("", max_length=200)
    note: str = Field("", max_length=2000)
    reference: str = Field("", max_length=100)
    tolerance: float = Field(0.15, gt=0.0, le=1.0)


class Number(ClientRequest):
    """The number of a campaign in the queue."""

    number: int


class InterruptedRun(ClientRequest):
    """The folder of an interrupted run below ``runs``, and how many of its tests were shown as complete."""

    folder: str = Field(max_length=100)
    complete: int = Field(ge=0)


class TestName(ClientRequest):
    """A test of the campaign that runs."""

    __test__ = False
    test: str = Field(max_length=200)


class FolderState(BaseModel):
    """What running a campaign into a folder would mean: new, interrupted, complete, foreign or running, and a sentence."""

    state: str
    words: str


class SuggestedFolder(BaseModel):
    """A folder that is not there yet."""

    folder: str


class Abort(BaseModel):
    """Who asks, if they want to be named."""

    who: str = Field("", max_length=40)


class RigFile(BaseModel):
    """A rig that can be connected; ``wired`` where its file names wires, ``problem`` where its file cannot be read."""

    name: str
    title: str
    wired: bool
    problem: str = ""


class TestState(BaseModel):
    """A test of a run."""

    __test__ = False
    name: str
    state: str
    attempt: int
    reason: str
    words: str = ""
    """What it does, of the run under way or the last one."""


class Disk(BaseModel):
    """Bytes of the disk on which the data folder lies."""

    folder: str
    total: int
    free: int


class Done(BaseModel):
    """It is under way; `read` returns its outcome."""

    accepted: bool = True


@router.get("")
def read(bench: CurrentBench) -> BenchState:
    """How the bench is."""
    return bench.state()


@router.get("/strips")
def strips(
    bench: CurrentBench, seconds: Annotated[float, Query(gt=0.0, le=60.0)] = 12.0
) -> dict[str, list[float | None]]:
    """The last bins of the rig, least and greatest values of 10 ms each; empty lists where nothing was sampled yet."""
    history = bench.strips
    if history is None:
        return {name: [] for name in COLUMNS}
    return as_lists(history.since(history.count - round(seconds / history.width))[1])


@router.get("/rigs")
def rigs(app: CurrentApp) -> list[RigFile]:
    """The rigs that can be connected; the original one first."""
    rig_files = []
    for name in ("", *rig_names(app.data)):
        try:
            settings = rig_settings(app.data, name)
            rig_files.append(RigFile(name=name, title=settings.name, wired=bool(settings.wires.serial)))
        except InputError as problem:
            words = without_places(str(problem), app.data)[:MAX_SENTENCE]
            rig_files.append(RigFile(name=name, title=name, wired=False, problem=words))
    return rig_files


@router.get("/runs")
def runs(app: CurrentApp) -> list[RunFolder]:
    """The folders of records that campaigns left, the latest first; the last hundred."""
    journals = [path for path in (app.data / RUNS).glob(f"*/{JOURNAL}") if not path.is_symlink()]
    latest = sorted(journals, key=lambda path: path.stat().st_mtime, reverse=True)[:MAX_RUNS]
    return [run_folder(path.parent) for path in latest]


@router.get("/runs/{folder}/report")
def report(app: CurrentApp, folder: Annotated[str, InPath(max_length=100)]) -> FileResponse:
    """The report of a run: its acceptance, or else the figures of its protocol or of its cycles, written when asked for."""
    path = report_of(safe_paths.existing(app.data, f"{RUNS}/{folder}/{JOURNAL}").parent)
    return FileResponse(path, filename=f"{folder}-{path.name}", headers={"content-type": "text/html; charset=utf-8"})


@router.get("/folder")
def folder_state_of(app: CurrentApp, bench: CurrentBench, campaign: Name, folder: Name) -> FolderState:
    """What starting a campaign into a folder would mean, before it is started."""
    place = records_folder(app.data, folder)
    if not (place / JOURNAL).is_file():
        return FolderState(state="new", words="a new folder")
    path = safe_paths.existing(app.data, f"{FOLDER}/{campaign}.toml")
    settings = bench.rig.settings if bench.rig is not None else rig_settings(app.data, "")
    state, words = folder_state(plan(read_campaign(path), settings), place)
    return FolderState(state=state, words=words)


@router.get("/suggested")
def suggested(app: CurrentApp, campaign: Name) -> SuggestedFolder:
    """A folder for the next run of a campaign: its name, the date, and a number from the second one of a day on."""
    name = f"{campaign}-{date.today().isoformat()}"[:95]
    taken = {path.name for path in (app.data / RUNS).glob(f"{glob_escape(name)}*")}
    numbers = (name if k == 1 else f"{name}-{k}" for k in itertools.count(1))
    return SuggestedFolder(folder=next(free for free in numbers if free not in taken))


@router.get("/disk")
def disk(app: CurrentApp) -> Disk:
    """The room on the disk of the data folder."""
    usage = shutil.disk_usage(app.data)
    return Disk(folder=app.data.resolve().name, total=usage.total, free=usage.free)


@router.get("/events")
def events(bench: CurrentBench) -> list[BenchEvent]:
    """Who did what, the latest first; all of it is in the file bench/bench-events.jsonl of the data folder."""
    return bench.events.recent()


@router.get("/reference")
def reference(bench: CurrentBench) -> ReferenceLoop | None:
    """The loop of the reference of the test under way; null where there is none."""
    reference = bench.runs.reference
    return None if reference is None else reference.loop


@router.get("/tests")
def tests(app: CurrentApp, bench: CurrentBench, folder: Name) -> list[TestState]:
    """The tests of a run, from its journal and its files; none where it has no journal yet."""
    place = safe_paths.inside(app.data, f"{RUNS}/{folder}")
    if not (place / JOURNAL).is_file():
        return []
    entries, _ = read_journal(place)
    words = bench.runs.targets(folder)
    return [
        TestState(
            name=entry.name,
            state=entry.state,
            attempt=entry.attempt,
            reason=entry.reason,
            words=words.get(entry.name, ""),
        )
        for entry in entries_with_files(entries, place)
    ]


COMMANDS: dict[str, tuple[type[ClientRequest], Callable[..., None], str]] = {
    "control": (ClientRequest, Bench.take_control, "Take control, from whoever has it; what they moved stops."),
    "connect": (Connect, Bench.connect, "Connect a rig."),
    "disconnect": (ClientRequest, Bench.disconnect, "Let go of the rig; an armed one is disarmed first."),
    "arm": (ClientRequest, Bench.arm, "Let energy in."),
    "disarm": (ClientRequest, Bench.disarm, "Bring the table to rest, and let no energy in."),
    "home": (Home, Bench.home, "Find the middle of the stroke."),
    "jog": (Jog, Bench.jog, "Move for a third of a second; ask again to move on."),
    "go": (Go, Bench.go, "Move slowly to a position."),
    "sine": (SineMotion, Bench.sine, "Move as a sine, without recording."),
    "coil": (CoilVoltage, Bench.energise, "Put a voltage on the coil for a time, with the table at rest."),
    "halt": (ClientRequest, Bench.halt, "End a motion by hand or the coil's voltage, and stay armed."),
    "extremes": (ClientRequest, Bench.reset_extremes, "Let the least and the greatest readings begin anew."),
    "alarms/acknowledge": (AlarmRequest, Bench.acknowledge, "Acknowledge an alarm, or all of them."),
    "alarms/limit": (LimitRequest, Bench.set_alarm_limit, "Set, change or remove an alarm limit."),
    "zero": (ClientRequest, Bench.zero, "Take the load cell's signal of a second for no force."),
    "calibration": (ClientRequest, Bench.calibrate, "Begin the guided steps of calibrating the load cell."),
    "calibration/step": (CalibrationRequest, Bench.calibrate_step, "Read the load cell."),
    "calibration/end": (Keep, Bench.calibrate_end, "Save the result, or discard it."),
    "start": (Start, Bench.start, "Check a campaign and run it, or what is left of it."),
    "queue": (Start, Bench.enqueue, "Run a campaign after the one under way."),
    "queue/remove": (Number, Bench.dequeue, "Take a campaign out of the queue."),
    "runs/remove": (InterruptedRun, Bench.remove_run, "Remove an interrupted run with its records."),
    "skip": (TestName, Bench.skip, "Leave out a test, or end the one under way in order; it stays incomplete."),
    "repeat": (TestName, Bench.repeat, "Record a test once more, after those that are left."),
    "pause": (ClientRequest, Bench.pause, "Wait, armed and at rest, after the test under way."),
    "resume": (ClientRequest, Bench.resume, "Go on."),
    "stop": (ClientRequest, Bench.stop, "End the test under way in order, and the campaign with it."),
}
"""Path -> the kind of its request, the command of the bench that takes the fields of the request, and what it does."""
OPERATIONS = {
    "alarms/acknowledge": "acknowledge",
    "alarms/limit": "alarm_limit",
    "queue": "enqueue",
    "queue/remove": "dequeue",
}
"""Names of operations in the schema that are not those of their paths: programs that were made from it know them."""


def _add_command(path: str, kind: type[ClientRequest], command: Callable[..., None], words: str) -> None:
    def answer(request: ClientRequest, bench: CurrentBench) -> Done:
        command(bench, **vars(request))
        return Done()

    answer.__annotations__["request"] = kind  # by which FastAPI reads and documents the request
    router.post(f"/{path}", name=OPERATIONS.get(path, path.replace("/", "_")), description=words)(answer)


for _path, _command in COMMANDS.items():
    _add_command(_path, *_command)


@router.post("/abort")
async def abort(request: Abort, connection: Request, bench: CurrentBench) -> Done:
    """Brake and cut the coil, now. Needs no control, and on this machine no token; answers when it is done."""
    # whoever asks need not have a page open: only their address is certain
    who = f"{request.who or 'a request'} from {connection.client.host if connection.client else 'an unknown address'}"
    await asyncio.get_running_loop().run_in_executor(ABORTING, bench.abort, who)
    return Done()


@router.websocket("/stream")
async def stream(socket: WebSocket, bench: CurrentBench, client: Annotated[str, Query(pattern=ID)]) -> None:
    """What a page shows, live (:mod:`dampyr.console.stream`)."""
    await Stream(bench, client, socket).run()
