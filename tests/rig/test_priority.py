"""Priority and timers on Windows, through a stand-in for its libraries: nobody has run this on Windows."""

from __future__ import annotations

import ctypes
import sys
from ctypes import wintypes
from typing import Any

import pytest

from dampyr.rig import priority


class Call:
    """A function of a library, which takes down what it was called with."""

    def __init__(self, answer: int, calls: list[tuple[Any, ...]]) -> None:
        self.answer, self.calls = answer, calls
        self.restype: Any = None
        self.argtypes: Any = None

    def __call__(self, *values: Any) -> int:
        self.calls.append(values)
        return self.answer


class Libraries:
    """kernel32 and winmm of a Windows that allows what it is asked for, or not."""

    def __init__(self, allows: bool) -> None:
        self.classes: list[tuple[Any, ...]] = []
        self.periods: list[tuple[Any, ...]] = []
        self.GetCurrentProcess = Call(-1, [])
        self.SetPriorityClass = Call(int(allows), self.classes)
        self.timeBeginPeriod = Call(0 if allows else 97, self.periods)  # TIMERR_NOCANDO
        self.names: list[str] = []

    def load(self, name: str, use_last_error: bool) -> Libraries:
        """As ctypes.WinDLL."""
        assert use_last_error
        self.names.append(name)
        return self


def windows(monkeypatch: pytest.MonkeyPatch, allows: bool = True) -> Libraries:
    libraries = Libraries(allows)
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(ctypes, "WinDLL", libraries.load, raising=False)
    return libraries


def test_a_process_of_windows_gets_the_class_high_and_a_tick_of_a_millisecond(monkeypatch: pytest.MonkeyPatch) -> None:
    libraries = windows(monkeypatch)
    assert priority.raise_priority() == "class high, timers of 1 ms"
    assert libraries.classes == [(-1, 0x80)]  # HIGH_PRIORITY_CLASS
    assert libraries.periods == [(1,)]
    assert libraries.names == ["kernel32", "winmm"]
    assert libraries.GetCurrentProcess.restype is wintypes.HANDLE  # else a 64 bit handle is cut
    assert libraries.SetPriorityClass.argtypes == [wintypes.HANDLE, wintypes.DWORD]


def test_a_windows_that_refuses_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    windows(monkeypatch, allows=False)
    assert priority.raise_priority() == "ordinary, timers of the usual tick"


def test_the_console_is_above_normal_on_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    libraries = windows(monkeypatch)
    priority.before_ordinary()
    assert libraries.classes == [(-1, 0x8000)]  # ABOVE_NORMAL_PRIORITY_CLASS
    assert not libraries.periods
