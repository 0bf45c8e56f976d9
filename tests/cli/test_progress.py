"""Progress where nobody looks: a line per stage, and again while a long one goes on."""

import pytest

from dampyr.cli import _progress


def test_a_log_hears_of_each_stage_and_of_long_ones_again(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    clock = iter((100.0, 100.0, 110.0, 125.0, 128.0, 150.0, 150.0))
    monkeypatch.setattr(_progress.time, "monotonic", lambda: next(clock))
    monkeypatch.setattr(_progress.sys.stderr, "isatty", lambda: False, raising=False)
    with _progress.stages() as progress:
        for done in (0.0, 0.1, 0.25, 0.3, 1.0):
            progress("screening models", done)
        progress("validating", 0.0)
    lines = capsys.readouterr().err.splitlines()
    assert [line.strip() for line in lines] == [
        "0.0 s  screening models",
        "10.0 s  screening models, 10%",
        "25.0 s  screening models, 25%",
        "50.0 s  validating",
    ]
