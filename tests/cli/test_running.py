"""A campaign while it runs: a stream that breaks ends nothing, a line per test, and the keys."""

import sys
import threading
from pathlib import Path

import pytest
from tests.cli.broken_stream import Broken
from tests.short_campaign import SHORT

from dampyr import campaigns
from dampyr.campaigns.run_control import Progress
from dampyr.cli import _running
from dampyr.cli._running import shown


@pytest.mark.parametrize("terminal", [True, False])
@pytest.mark.parametrize("after", [0, 1])
@pytest.mark.parametrize(
    "problem", [BrokenPipeError(32, "Broken pipe"), OSError(28, "No space left"), ValueError("closed")]
)
def test_progress_that_cannot_be_shown_ends_nothing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, problem: Exception, after: int, terminal: bool
) -> None:
    (tmp_path / "short.toml").write_text(SHORT)
    stream = Broken(problem, after, terminal)
    monkeypatch.setattr(sys, "stderr", stream)
    with shown(campaigns.plan(tmp_path / "short.toml")) as show:
        for name in ("a", "b", "c", "d", "e"):
            show(Progress(0, 5, name, "testing"))
    assert stream.left < 0


def test_where_nobody_looks_a_line_tells_each_test(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "short.toml").write_text(SHORT)
    with shown(campaigns.plan(tmp_path / "short.toml")) as show:
        for name, phase, left in (
            ("a", "testing", 75.0),
            ("a", "testing", 70.0),
            ("", "rest", 60.0),
            ("b", "testing", 59.9),
        ):
            show(Progress(int(name == "b"), 2, name, phase, time_left=left))
    lines = [line.partition(" s  ")[2] for line in capsys.readouterr().err.splitlines()]
    assert lines == ["1/2  testing a  (1:15 of rig time left)", "2/2  testing b  (0:59 of rig time left)"]


class Buttons:
    """What was pressed."""

    def __init__(self) -> None:
        self.paused, self.pressed = False, []  # type: ignore[var-annotated]

    def pause(self) -> None:
        self.paused = True
        self.pressed.append("pause")

    def resume(self) -> None:
        self.paused = False
        self.pressed.append("resume")

    def stop(self) -> None:
        self.pressed.append("stop")

    def abort(self) -> None:
        self.pressed.append("abort")


def test_keys_pause_go_on_stop_and_abort() -> None:
    buttons, over = Buttons(), threading.Event()
    typed = iter(("p", "", "P", "x", "s", "p", "a"))

    def read() -> str:
        key = next(typed, None)
        if key is None:
            over.set()
        return key or ""

    _running._listen(read, buttons, over)  # type: ignore[arg-type]
    assert buttons.pressed == ["pause", "resume", "stop", "pause", "abort"]
