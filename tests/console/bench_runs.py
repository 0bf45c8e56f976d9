"""A short campaign at the bench, and what a test asks of the bench about it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from dampyr.campaigns import read_journal
from dampyr.console.bench_session import Bench

Until = Callable[..., None]
Phase = Callable[..., None]


def start(bench: Bench, folder: str = "run", **more: object) -> None:
    """Start the campaign for page "a"."""
    bench.start("a", "short", folder, **more)


def records_of(bench: Bench, folder: str = "run") -> Path:
    """Where the records of a run are."""
    return bench.data / "runs" / folder


def outcome(bench: Bench) -> str:
    """How the run ended."""
    progress = bench.state().run
    return progress.outcome if progress else ""


def reason(bench: Bench) -> str:
    """Why the run ended so."""
    progress = bench.state().run
    return progress.reason if progress else ""


def position(bench: Bench) -> float:
    """Where the table is, m."""
    live = bench.state().live
    assert live is not None
    return live.position


def states(folder: Path) -> dict[str, str]:
    """The state of each test of a folder."""
    return {entry.name: entry.state for entry in read_journal(folder)[0]}
