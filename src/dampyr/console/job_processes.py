"""Jobs in processes of their own: they survive a reload of the page, can be cancelled, and cannot take the console down.

A job is a folder: ``request.json``, ``job.json`` (its state), ``result.json`` and the files that
it made. Its kind is a file of :mod:`dampyr.console.jobs`. Jobs wait for one another, so that the machine keeps a core for
the rig. A job that ran when the console was stopped is reported as failed when it starts again.
"""

from __future__ import annotations

import json
import os
import secrets
import shutil
import threading
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal

from dampyr import registry
from dampyr.atomic_write import write_whole
from dampyr.console.job_work import WORK, do_job
from dampyr.console.request_process import FORKED
from dampyr.errors import DampyrError, InputError, MissingData
from dampyr.processes import ChildProcess

State = Literal["waiting", "running", "done", "failed", "cancelled"]
ENDED = ("done", "failed", "cancelled")
MAX_ENDED = 60  # jobs: their folders hold pages and curves, and the disk is bounded
MAX_WAITING = 20  # jobs: more is a page that repeats itself
STOPPED = "the console was stopped while it ran or waited; run it again"
ENDED_HARD = "the console ended unexpectedly while it ran or waited; run it again"


@dataclass(frozen=True)
class Job:
    """State of a job. ``progress`` is 0 to 1 within its ``stage``; ``reason`` says why it did not end well."""

    id: str
    kind: str
    title: str
    state: State = "waiting"
    stage: str = ""
    progress: float = 0.0
    reason: str = ""
    made: float = 0.0
    ended: float | None = None


class Jobs:
    """The jobs of one console, kept in a folder."""

    def __init__(self, folder: Path, at_once: int | None = None) -> None:
        self.folder = folder
        self._lock = threading.Condition()
        self._jobs: dict[str, Job] = {}
        self._running: dict[str, ChildProcess | None] = {}
        self._closed = False
        folder.mkdir(parents=True, exist_ok=True)
        self._remember()
        for _ in range(max(1, min(4, (os.cpu_count() or 2) - 1)) if at_once is None else at_once):
            threading.Thread(target=self._serve, daemon=True).start()

    def submit(self, kind: str, request: dict[str, Any], title: str) -> Job:
        """Put work in the queue; ``kind`` is a file of `dampyr.console.jobs`, ``request`` what its ``run`` takes."""
        registry.member(WORK, kind)
        with self._lock:
            if sum(job.state == "waiting" for job in self._jobs.values()) >= MAX_WAITING:
                raise InputError(f"{MAX_WAITING} jobs are waiting already; wait for them, or cancel some")
            job = Job(secrets.token_hex(8), kind, title, made=time.time())
            place = self.folder / job.id
            place.mkdir()
            write_whole(place / "request.json", json.dumps({"kind": kind, "request": request}))
            self._keep(job)
            ended = [other for other in self.all() if other.state in ENDED and other.id not in self._running]
            for oldest in ended[MAX_ENDED:]:
                self.remove(oldest.id)
            self._lock.notify()
        return job

    def all(self) -> list[Job]:
        """Every job, the latest first."""
        with self._lock:
            return sorted(self._jobs.values(), key=lambda job: -job.made)

    def job(self, id: str) -> Job:
        """The state of one, or MissingData."""
        with self._lock:
            if id not in self._jobs:
                raise MissingData(f"there is no job {id[:40]!r}; it may have been removed")
            return self._jobs[id]

    def request(self, id: str) -> dict[str, Any]:
        """The request of a job."""
        request: dict[str, Any] = json.loads((self.place(id) / "request.json").read_text("utf-8"))["request"]
        return request

    def result(self, id: str) -> dict[str, Any]:
        """The result of a job; MissingData before it is done."""
        job = self.job(id)
        if job.state != "done":
            raise MissingData(f"the job is {job.state}{f': {job.reason}' if job.reason else ''}; it has no result")
        result: dict[str, Any] = json.loads((self.place(id) / "result.json").read_text("utf-8"))
        return result

    def place(self, id: str) -> Path:
        """The folder of a job."""
        return self.folder / self.job(id).id

    def cancel(self, id: str) -> Job:
        """End a job that waits or runs; one that has ended stays as it is."""
        with self._lock:
            job = self.job(id)
            if job.state not in ENDED:
                self._keep(replace(job, state="cancelled", reason="cancelled", ended=time.time()))
            if (process := self._running.get(id)) is not None:
                process.kill()
            return self.job(id)

    def remove(self, id: str) -> None:
        """Forget a job that has ended, with its files."""
        with self._lock:
            if self.job(id).state not in ENDED or id in self._running:
                raise InputError("the job has not ended; cancel it first")
            del self._jobs[id]
            shutil.rmtree(self.folder / id, ignore_errors=True)

    def close(self) -> None:
        """End all that runs; called when the console stops."""
        with self._lock:
            self._closed = True
            for job in [job for job in self._jobs.values() if job.state not in ENDED]:
                self._keep(replace(job, state="failed", reason=STOPPED, ended=time.time()))
            for process in filter(None, self._running.values()):
                process.kill()
            self._lock.notify_all()

    def _remember(self) -> None:
        for path in self.folder.glob("*/job.json"):
            try:
                job = Job(**json.loads(path.read_text("utf-8")))
            except (ValueError, TypeError):
                continue
            if job.state not in ENDED:
                job = replace(job, state="failed", reason=ENDED_HARD, ended=time.time())
            self._keep(job)

    def _keep(self, job: Job) -> None:
        self._jobs[job.id] = job
        write_whole(self.folder / job.id / "job.json", json.dumps(asdict(job)))

    def _serve(self) -> None:
        while (job := self._next()) is not None:
            self._run(job)

    def _next(self) -> Job | None:
        with self._lock:
            while not self._closed:
                waiting = [job for job in self._jobs.values() if job.state == "waiting"]
                if waiting:
                    job = replace(min(waiting, key=lambda job: job.made), state="running", stage="starting")
                    self._keep(job)
                    self._running[job.id] = None  # until its process has started
                    return job
                self._lock.wait()
        return None

    def _run(self, job: Job) -> None:
        try:
            process = ChildProcess(do_job, self.folder / job.id, forked=FORKED)
        except DampyrError as problem:
            self._end(job.id, state="failed", reason=str(problem))
            return
        with self._lock:
            self._running[job.id] = process
            if self._jobs[job.id].state != "running":  # it was cancelled meanwhile
                process.kill()
        (connection,) = process.connections
        reason = "it ended without a result; see the console's own output"
        try:
            while True:
                message = connection.recv()
                reason = message.pop("reason", reason)[:500]
                self._update(job.id, **message)
        except (EOFError, OSError):  # it has ended
            done = process.wait() == 0 and (self.folder / job.id / "result.json").is_file()
        process.end()
        if done:
            self._end(job.id, state="done", progress=1.0)
        else:
            self._end(job.id, state="failed", reason=reason)

    def _end(self, id: str, **changes: Any) -> None:
        self._update(id, ended=time.time(), **changes)
        with self._lock:
            del self._running[id]

    def _update(self, id: str, **changes: Any) -> None:
        with self._lock:
            job = self._jobs[id]
            if job.state == "running" and any(getattr(job, name) != value for name, value in changes.items()):
                changed = replace(job, **changes)
                if changed.state == "running":
                    self._jobs[id] = changed
                else:
                    self._keep(changed)
