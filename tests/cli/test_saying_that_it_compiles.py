"""A command that compiles for long says so once, to a person who waits and to nobody else."""

import sys
import time
from pathlib import Path

import pytest

from dampyr import compiling
from dampyr.cli import _frame


def compile_for(seconds: float) -> None:
    compiling.note(begins=True)
    time.sleep(seconds)
    compiling.note(begins=False)


@pytest.mark.parametrize(
    ("terminal", "pieces", "lines"),
    [(True, [0.01], 0), (True, [0.5], 1), (True, [0.12, 0.12, 0.3], 1), (True, [0.5, 0.5], 1), (False, [0.5], 0)],
    ids=["quick", "slow", "slow together", "once", "no terminal"],
)
def test_it_is_said_once_where_it_takes_long(
    terminal: bool,
    pieces: list[float],
    lines: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(_frame, "SLOW", 0.2)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal, raising=False)
    with _frame.compilation_notice():
        for seconds in pieces:
            compile_for(seconds)
    assert capsys.readouterr().err.count("dampyr: compiling, once") == lines
    with _frame.compilation_notice():
        pass
    compile_for(0.0)  # nobody listens any more


def test_kernels_tell_when_they_are_compiled_and_not_when_they_are_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from dampyr.models.codegen import kernel_cache, kernels

    def double(x: float) -> float:
        return 2.0 * x

    monkeypatch.setenv("DAMPYR_CACHE", str(tmp_path))
    kernel_cache.cache_folder.cache_clear()
    told: list[bool] = []
    try:
        with compiling.watched(told.append):
            assert kernels.jit(double, keep=True)(1.5) == 3.0
            assert told == [True, False]
            assert kernels.jit(double, keep=True)(1.5) == 3.0
            assert told == [True, False]
    finally:
        kernel_cache.cache_folder.cache_clear()
