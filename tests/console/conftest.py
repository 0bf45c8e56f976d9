"""A console in the test itself, and one that is served for a browser."""

from __future__ import annotations

import json
import os
import re
import shutil
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("fastapi")
from fastapi.testclient import TestClient
from tests.console import light_job
from tests.console.bench_runs import Phase, Until
from tests.rig_time import RealTime, SimulatedTime
from tests.short_campaign import SHORT

from dampyr.console import app, job_processes
from dampyr.console.bench_session import Bench

ROOT = Path(__file__).resolve().parents[2]
HERE = "http://127.0.0.1:8077"
CHROMIUM = "/usr/bin/chromium"
PAGE_WAIT = int(os.environ.get("PAGE_WAIT", "120000"))  # ms that end a wait for what never comes, on a busy machine too
QUIET = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]  # fmt: skip


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """A test in a browser is a proof, except for those that are marked as quick."""
    for item in items:
        if "chromium" in getattr(item, "fixturenames", ()) and item.get_closest_marker("quick") is None:
            item.add_marker(pytest.mark.prove)


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """An empty data folder."""
    folder = tmp_path / "data"
    folder.mkdir()
    return folder


def _bench_time(request: pytest.FixtureRequest) -> RealTime:
    """The time of a bench: simulated, or with ``--endure`` the wall clock's."""
    return RealTime() if request.config.getoption("--endure") else SimulatedTime()


bench_time = pytest.fixture(_bench_time, name="bench_time")
module_bench_time = pytest.fixture(_bench_time, name="module_bench_time", scope="module")


@pytest.fixture
def bench(tmp_path: Path, bench_time: RealTime) -> Iterator[Bench]:
    """A bench whose page "a" holds control, nothing connected; its pages are heard of while a test waits."""
    (tmp_path / "campaigns").mkdir()
    (tmp_path / "campaigns" / "short.toml").write_text(SHORT)
    made = Bench(tmp_path, bench_time.open, bench_time)
    made.clients.join("a")
    bench_time.while_waiting = lambda: (made.clients.hear("a"), made.clients.hear("b"))
    yield made
    with bench_time.passing():
        made.close()


@pytest.fixture
def until(bench_time: RealTime) -> Until:
    """``until(condition, seconds)``: wait for something; fail where it does not come."""
    return bench_time.until


@pytest.fixture
def phase(until: Until) -> Phase:
    """``phase(bench, name, seconds)``: wait for a phase of the bench."""
    return lambda bench, name, seconds=30.0: until(lambda: bench.state().phase == name, seconds)


@pytest.fixture
def idle(bench: Bench, phase: Phase) -> Bench:
    """A bench with a rig that is not armed."""
    bench.connect("a")
    phase(bench, "idle")
    return bench


@pytest.fixture
def armed(idle: Bench, phase: Phase) -> Bench:
    """A bench that is armed and homed."""
    idle.arm("a")
    phase(idle, "armed")
    idle.home("a", here=True)
    phase(idle, "armed")
    assert idle.state().homed
    return idle


@pytest.fixture
def client(data: Path) -> Iterator[TestClient]:
    """The console over that folder, asked from this machine."""
    with TestClient(app(data), base_url=HERE) as test_client:
        yield test_client


def when_ended(client: TestClient, id: str) -> dict[str, Any]:
    """The job once it has ended."""
    for _ in range(2000):
        job = client.get(f"/api/jobs/{id}").json()
        if job["state"] in ("done", "failed", "cancelled"):
            return dict(job)
        time.sleep(0.05)
    raise AssertionError(f"job {id} did not end: {job}")


@pytest.fixture
def finished(client: TestClient) -> Callable[[str], dict[str, Any]]:
    """``finished(id)``: the job once it has ended."""
    return partial(when_ended, client)


@contextmanager
def served(data: Path, *options: str, program: Sequence[str] = ("-m", "dampyr")) -> Iterator[str]:
    """A console in a process of its own; its address."""
    words = ["console", "--json", "--port", "0", "--no-browser", "--data", str(data)]
    process = subprocess.Popen([sys.executable, *program, *words, *options], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        output = ""
        while not output.rstrip().endswith("}"):
            line = process.stdout.readline()
            assert line, "the console ended before it told its address"
            output += line
        yield json.loads(output)["address"]
    finally:
        process.terminate()
        process.wait(10)
        assert process.stdout is not None
        process.stdout.close()


@contextmanager
def served_here(data: Path) -> Iterator[str]:
    """A console in a thread of this process, which starts sooner; its address."""
    uvicorn = pytest.importorskip("uvicorn")
    with socket.create_server(("127.0.0.1", 0)) as listening:
        settings = {"log_level": "warning", "access_log": False, "timeout_graceful_shutdown": 3}
        server = uvicorn.Server(uvicorn.Config(app(data), **settings))
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]}, daemon=True)
        thread.start()
        try:
            yield f"http://127.0.0.1:{listening.getsockname()[1]}/"
        finally:
            server.should_exit = True
            thread.join(30)
        assert not thread.is_alive()


@pytest.fixture
def serving() -> Callable[..., Any]:
    """``with serving(data, *options) as address``: a console in a process of its own that ends with its block."""
    return served


@pytest.fixture
def address(data: Path) -> Iterator[str]:
    """Where the console over ``data`` is served."""
    with served_here(data) as url:
        yield url


def _chromium() -> str:
    executable = CHROMIUM if Path(CHROMIUM).exists() else shutil.which("chromium") or shutil.which("chromium-browser")
    if not executable:
        pytest.skip("no Chromium was found; `make chromium` installs Debian's")
    return executable


def _yielding(folder: pytest.TempPathFactory) -> str:
    """A Chromium that does not starve a rig in real time beside it."""
    script = folder.mktemp("browser") / "chromium"
    script.write_text(f'#!/bin/sh\nexec nice -n 10 {_chromium()} "$@"\n')
    script.chmod(0o755)
    return str(script)


@pytest.fixture(scope="session")
def chromium(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A browser, or a skip that says what is missing."""
    executable = _yielding(tmp_path_factory) if request.config.getoption("--endure") else _chromium()
    api = pytest.importorskip("playwright.sync_api")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable, args=QUIET)
        yield browser
        browser.close()


class Seen:
    """A page, and what went wrong on it."""

    def __init__(self, page: Any, refused: int | None) -> None:
        self.page, self.wrong = page, []
        page.on("pageerror", lambda problem: self.wrong.append(f"error: {problem}"))
        page.on(
            "console",
            lambda message: (
                message.type in ("error", "warning")
                and f"status of {refused} " not in message.text
                and self.wrong.append(f"{message.type}: {message.text}")
            ),
        )
        page.on("request", lambda request: self._note(request.url))

    def _note(self, url: str) -> None:
        if not re.match(r"(http|ws)://(127\.0\.0\.1|localhost)[:/]|data:|blob:", url):
            self.wrong.append(f"asked elsewhere: {url}")


@pytest.fixture
def new_page(chromium: Any) -> Iterator[Callable[..., Any]]:
    """``new_page(address)``: a page there, in a browser that has seen nothing; at the end nothing may have gone wrong.

    ``refused`` is the status of an answer that is expected, and that a browser complains of by itself.
    """
    made: list[tuple[Any, Seen]] = []

    def open_at(address: str, refused: int | None = None, **settings: Any) -> Any:
        context = chromium.new_context(**{"viewport": {"width": 1280, "height": 900}} | settings)
        seen = Seen(context.new_page(), refused)
        made.append((context, seen))
        seen.page.set_default_timeout(PAGE_WAIT)
        seen.page.goto(address)
        return seen.page

    yield open_at
    for context, _ in made:
        context.close()
    assert [wrong for _, seen in made for wrong in seen.wrong] == []


@pytest.fixture
def reach() -> Callable[..., Any]:
    """``reach(page, locator)``: go there by the Tab key alone, as one does who has no mouse."""

    def go(page: Any, locator: Any, max_presses: int = 120) -> Any:
        for _ in range(max_presses):
            page.keyboard.press("Tab")
            if locator.evaluate("one => one === document.activeElement"):
                return locator
        raise AssertionError(f"{locator} is not reached by Tab")

    return go


def axe_source() -> Path | None:
    """axe-core, where npm put it (``make axe``) or where DAMPYR_AXE says."""
    places = (
        os.environ.get("DAMPYR_AXE", ""),
        ROOT / "node_modules/axe-core/axe.min.js",
        ROOT / "out/axe/node_modules/axe-core/axe.min.js",
    )
    return next((Path(place) for place in places if place and Path(place).is_file()), None)


@pytest.fixture
def accessible() -> Callable[[Any], None]:
    """``accessible(page)``: axe finds nothing wrong with labels, contrast, roles and structure."""
    source = axe_source()
    if source is None:
        pytest.skip("axe-core was not found; `make axe` installs it with npm")

    def check(page: Any) -> None:
        page.evaluate(source.read_text("utf-8"))
        report = page.evaluate(
            "axe.run(document, {runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'best-practice']})"
        )
        violations = [f"{v['id']}: {v['help']}: {v['nodes'][0]['html'][:160]}" for v in report["violations"]]
        assert violations == []

    return check


@pytest.fixture
def light(monkeypatch: pytest.MonkeyPatch) -> None:
    """Jobs are processes that start at once and do nothing: what is tested is the queue."""
    monkeypatch.setattr(job_processes, "do_job", light_job.wait)
