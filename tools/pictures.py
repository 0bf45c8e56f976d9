"""Pictures of everything that dampyr shows: each page of the console, and each report as it is printed.

    python tools/pictures.py out/pictures
    python tools/pictures.py out/pictures --only reports

It makes what it shows itself: a campaign on the simulated rig, and fits, verdicts and responses from its records; with the
published campaign in ../shared/data its fit too. In the folder lie afterwards

    data/       the records, cards and jobs
    reports/    every report as HTML and as PDF on A4
    console/    NAME-WIDTH-light.png and -dark.png, the first screen of each page, and NAME-WIDTH-light-whole.png, all of it

Chromium and playwright are those of the tests (``make chromium``). What could not be shown is said at the end, and the exit
code is 1.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PUBLISHED = ROOT.parent / "shared" / "data" / "labcontrol-mr-damper"
SIZES = ((1440, 900), (390, 844))  # a laptop's window, a phone
CAMPAIGN = """
name = "pictures"
operator = "A. Operator"
note = "a campaign for pictures"
seed = 1
[[step]]
kind = "sine"
amplitude = ["4 mm", "8 mm"]
frequency = ["0.5 Hz", "1 Hz"]
voltage = ["0 V", "0.8712 V", "1.98 V"]
cycles = 4
"""
LIVE = """
name = "live"
[[step]]
kind = "sine"
amplitude = "8 mm"
frequency = "1 Hz"
voltage = ["0 V", "1.98 V"]
cycles = 20
"""
FITTED = ["--model", "dahl + spring"]


def reports(data: Path) -> dict[str, list[str]]:
    """Report -> the words of the command that writes it, in an order in which each finds what it reads."""
    records, card, plan = str(data / "tests"), str(data / "cards" / "identified.toml"), str(data / "pictures.toml")
    cases = ["--synthetic", "20", "--duration", "8", "--scale", "0.5:3:0.5", "--limit", "12mm", "--without-damper"]
    commands = {
        "plan": ["run", plan, "--dry-run"],
        "fit": ["identify", records, *FITTED, "--predict", "record", "--save", card],
        "leaderboard": ["identify", records, *_try("dahl", "bingham", "bouc_wen"), "--budget", "120"],
        "validate": ["validate", card, records],
        "validate-one": [
            "validate",
            "raminelli_2020",
            str(next(iter(sorted((data / "tests").glob("*.h5"))), "missing.h5")),
        ],
        "acceptance": ["accept", card, records, "--tolerance", "15%", "--allow-extrapolation"],
        "response": ["simulate", card, "--voltage", "0", "--voltage", "1.98"],
        "response-five": [
            "simulate",
            card,
            *_voltages(0, 0.8712, 1.98),
            "--control",
            "on_off",
            "--control",
            "clipped_optimal",
        ],
        "ensemble": ["ensemble", card, *_voltages(0, 1.98), *cases],
        "motion": ["motion"],
        "demo": ["demo", "--out", str(data.parent / "demo")],
    }
    if PUBLISHED.is_dir():
        commands["fit-published"] = ["identify", str(PUBLISHED), *FITTED]
        commands["accept-published"] = ["accept", "raminelli_2020", str(PUBLISHED), "--allow-extrapolation"]
        commands["reproduce"] = ["reproduce", "--data", str(PUBLISHED), "--out", str(data.parent / "reproduce")]
    return commands


OWN = {"demo": "demo/report.html", "reproduce": "reproduce/reproduce.html"}
"""Reports that their commands name themselves, beside the data folder: the console shows what is in that."""


def _try(*models: str) -> list[str]:
    return [word for model in models for word in ("--try", model)]


def _voltages(*values: float) -> list[str]:
    return [word for value in values for word in ("--voltage", f"{value:g}")]


class Pictures:
    """The folder, and what went wrong on the way."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.problems = folder, list[str]()
        self.data = folder / "data"

    @contextmanager
    def attempt(self, what: str) -> Iterator[None]:
        """Go on with the next picture where one fails, and say so at the end."""
        begun = time.monotonic()
        try:
            yield
        except Exception as problem:
            self.problems.append(f"{what}: {str(problem).strip().splitlines()[0]}")
            print(f"  {what}: failed", flush=True)
        else:
            print(f"  {what}: {time.monotonic() - begun:.1f} s", flush=True)

    def prepare(self) -> None:
        """A campaign on the simulated rig, in lockstep."""
        for name in ("cards", "campaigns"):
            (self.data / name).mkdir(parents=True, exist_ok=True)
        (self.data / "pictures.toml").write_text(CAMPAIGN, encoding="utf-8")
        (self.data / "campaigns" / "live.toml").write_text(LIVE, encoding="utf-8")
        (self.data / "campaigns" / "pictures.toml").write_text(CAMPAIGN, encoding="utf-8")
        with self.attempt("records"):
            _dampyr("run", str(self.data / "pictures.toml"), "--out", str(self.data / "tests"))

    def write_reports(self, only: list[str]) -> list[Path]:
        """Every report as HTML."""
        target = self.folder / "reports"
        target.mkdir(parents=True, exist_ok=True)
        pages = []
        for name, words in reports(self.data).items():
            if only and name not in only:
                continue
            with self.attempt(name):
                page = target / f"{name}.html"
                _dampyr(*words, *([] if name in OWN else ["--report", str(page)]))
                if name in OWN:
                    shutil.copyfile(self.folder / OWN[name], page)
                pages.append(page)
        return pages

    def print_reports(self, browser: Any, pages: list[Path]) -> None:
        """Each as a PDF on A4, as a person would print it."""
        for path in pages:
            with self.attempt(f"{path.stem}.pdf"):
                page = browser.new_page()
                page.goto(path.as_uri())
                page.pdf(path=path.with_suffix(".pdf"), prefer_css_page_size=True)
                page.close()


def _dampyr(*words: str) -> None:
    done = subprocess.run([sys.executable, "-m", "dampyr", *words], capture_output=True, text=True)
    if done.returncode not in (0, 1, 3):  # a verdict of acceptance is no fault
        raise RuntimeError(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f"exit {done.returncode}")


class Console:
    """The pages of a console over the data, each in a state that says something."""

    def __init__(self, pictures: Pictures, browser: Any, address: str) -> None:
        self.pictures, self.browser, self.address = pictures, browser, address.rstrip("/") + "/"

    def take(self) -> None:
        """All pages, in both sizes, light and dark."""
        keys = self._records()
        where: dict[str, Callable[[], str]] = {
            "welcome": lambda: "",
            "campaigns": lambda: "#/campaigns?open=pictures",
            "records": lambda: f"#/records?source=data&{'&'.join(f'open={key}' for key in keys[:3])}",
            "acceptance": lambda: (
                f"#/records?source=data&open={keys[0]}&open={keys[-1]}&tab=acceptance&reference=cards/identified.toml"
            ),
            "identify": lambda: (
                f"#/identify?job={self._job('identify/jobs', {'records': keys, 'model': 'dahl + spring'})}"
            ),
            "building": lambda: f"#/building?job={self._job('building/responses', {})}",
        }
        for name, made in where.items():
            with self.pictures.attempt(f"console: {name}"):
                place = made()
                for size in SIZES:
                    self._both(name, size, lambda page, place=place: page.goto(self.address + place))
        self._bench()

    def _bench(self) -> None:
        """The bench connected, and while a campaign runs; one page holds control, so that one browser does it all."""
        steps: dict[str, list[str]] = {
            "bench": [],
            "bench-connected": ["Connect"],
            "bench-start": ["Arm", "Home by the index|Home", "Start"],
            "bench-running": [],
        }
        with self.pictures.attempt("console: bench"):
            page = self._page(SIZES[0], "light")
            page.goto(f"{self.address}#/bench")
            for name, presses in steps.items():
                for words in presses:
                    self._press(page, words)
                if name.endswith("running"):
                    page.get_by_label("Operator").fill("A. Operator")
                    page.locator("#start-now:enabled").click()
                page.wait_for_timeout(6000 if name.endswith("running") else 2500)
                for width, height in SIZES:
                    page.set_viewport_size({"width": width, "height": height})
                    for scheme in ("light", "dark"):
                        page.emulate_media(color_scheme=scheme)
                        page.wait_for_timeout(700)
                        self._shoot(page, f"{name}-{width}-{scheme}", whole=scheme == "light")
                page.set_viewport_size({"width": SIZES[0][0], "height": SIZES[0][1]})
            page.get_by_role("button", name=re.compile("abort", re.I)).first.click()
            page.context.close()

    def _press(self, page: Any, words: str) -> None:
        """The first button of these words that can be pressed, once it can."""
        pattern = re.compile(rf"^({words})\b", re.I)
        button = page.get_by_role("button", name=pattern, disabled=False).first
        button.click(timeout=60_000)
        page.wait_for_timeout(1500)

    def _both(self, name: str, size: tuple[int, int], show: Callable[[Any], Any]) -> None:
        for scheme in ("light", "dark"):
            page = self._page(size, scheme)
            show(page)
            page.get_by_role("heading", level=1).first.wait_for(timeout=60_000)
            page.wait_for_load_state("networkidle")
            page.wait_for_timeout(1500)  # charts are drawn in the frame after their data
            self._shoot(page, f"{name}-{size[0]}-{scheme}", whole=scheme == "light")
            if scheme == "light" and size == SIZES[0]:
                page.pdf(path=self.pictures.folder / "console" / f"{name}.pdf", format="A4")
            page.context.close()

    def _shoot(self, page: Any, name: str, whole: bool) -> None:
        folder = self.pictures.folder / "console"
        page.screenshot(path=folder / f"{name}.png")
        if whole:
            page.screenshot(path=folder / f"{name}-whole.png", full_page=True)

    def _page(self, size: tuple[int, int], scheme: str) -> Any:
        context = self.browser.new_context(viewport={"width": size[0], "height": size[1]}, color_scheme=scheme)
        page = context.new_page()
        page.set_default_timeout(60_000)
        return page

    def _records(self) -> list[str]:
        listed = _json(f"{self.address}api/records/list?source=data")
        rows = listed if isinstance(listed, list) else listed["records"]
        return [one["key"] for one in rows if "/tests/" in one["key"]]

    def _job(self, path: str, request: dict[str, Any]) -> str:
        """Start a job, wait for it, and give its id."""
        id = _json(f"{self.address}api/{path}", request)["id"]
        for _ in range(1200):
            job = _json(f"{self.address}api/jobs/{id}")
            if job["state"] not in ("waiting", "running"):
                break
            time.sleep(0.25)
        if job["state"] != "done":
            raise RuntimeError(f"{path}: {job['state']}, {job['reason']}")
        return str(id)


def _json(url: str, body: dict[str, Any] | None = None) -> Any:
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(url, data, {"content-type": "application/json", "origin": url.split("/api")[0]})
    with urllib.request.urlopen(request, timeout=60) as answer:
        return json.load(answer)


@contextmanager
def served(data: Path) -> Iterator[str]:
    """A console over ``data``; its address."""
    words = ["console", "--json", "--port", "0", "--no-browser", "--data", str(data)]
    process = subprocess.Popen([sys.executable, "-m", "dampyr", *words], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        text = ""
        while not text.rstrip().endswith("}"):
            line = process.stdout.readline()
            if not line:
                raise RuntimeError("the console ended before it gave its address")
            text += line
        yield json.loads(text)["address"]
    finally:
        process.terminate()
        process.wait(20)
        process.stdout.close()


@contextmanager
def chromium() -> Iterator[Any]:
    """The browser of the tests."""
    from playwright.sync_api import sync_playwright

    executable = shutil.which("chromium") or shutil.which("chromium-browser")
    if executable is None:
        raise SystemExit("no Chromium was found; `make chromium` installs it")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable, args=["--no-sandbox", "--disable-gpu"])
        yield browser
        browser.close()


def main() -> int:
    """Take them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("folder", type=Path, help="where they go")
    parser.add_argument("--only", choices=("reports", "console"), help="one half of them")
    parser.add_argument("--report", action="append", default=[], help="only this report; may be repeated")
    arguments = parser.parse_args()
    pictures = Pictures(arguments.folder.resolve())
    (pictures.folder / "console").mkdir(parents=True, exist_ok=True)
    os.environ.setdefault("PYTHONHASHSEED", "0")
    if not (pictures.data / "tests").is_dir():
        pictures.prepare()
    pages = [] if arguments.only == "console" else pictures.write_reports(arguments.report)
    with chromium() as browser:
        pictures.print_reports(browser, pages)
        if arguments.only != "reports" and not arguments.report:
            with served(pictures.data) as address, pictures.attempt("console"):
                Console(pictures, browser, address).take()
    for problem in pictures.problems:
        print(f"not shown: {problem}", file=sys.stderr)
    print(f"pictures in {pictures.folder}")
    return 1 if pictures.problems else 0


if __name__ == "__main__":
    sys.exit(main())
