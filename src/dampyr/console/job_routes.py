"""Jobs over HTTP: their states, results and cancellation."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter
from fastapi import Path as InPath
from pydantic import BaseModel, Field

from dampyr.console.job_processes import Job, State
from dampyr.console.page_words import in_page_words
from dampyr.console.state import CurrentApp

Id = Annotated[str, InPath(pattern="^[0-9a-f]{16}$")]

router = APIRouter(tags=["Jobs"])


class JobState(BaseModel):
    """State of a job."""

    id: str
    kind: str
    title: str
    state: State
    stage: str
    progress: float = Field(ge=0, le=1)
    reason: str
    made: float = Field(description="When it was requested, seconds since 1970.")
    ended: float | None


class JobInFull(JobState):
    """A job with its request, and its result once it is done."""

    request: dict[str, Any]
    result: dict[str, Any] | None


def as_job_state(job: Job) -> JobState:
    """A job as the API returns it."""
    return JobState(**vars(job) | {"reason": in_page_words(job.reason)})


@router.get("/jobs")
def list_jobs(app: CurrentApp) -> list[JobState]:
    """Every stored job, the latest first."""
    return [as_job_state(job) for job in app.jobs.all()]


@router.get("/jobs/{id}")
def read_job(id: Id, app: CurrentApp) -> JobInFull:
    """One job: its state, its request, and its result once it is done."""
    job = app.jobs.job(id)
    result = app.jobs.result(id) if job.state == "done" else None
    return JobInFull(**vars(as_job_state(job)), request=app.jobs.request(id), result=result)


@router.post("/jobs/{id}/cancel")
def cancel_job(id: Id, app: CurrentApp) -> JobState:
    """End a job that waits or runs."""
    return as_job_state(app.jobs.cancel(id))


@router.delete("/jobs/{id}", status_code=204)
def remove_job(id: Id, app: CurrentApp) -> None:
    """Forget a job that has ended, with its files."""
    app.jobs.remove(id)
