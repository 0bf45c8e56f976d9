"""Every error that a caller of dampyr may catch.

::

    DampyrError
    ├── InputError (ValueError)       an argument or a value is wrong: what, its value, the allowed range, the repair
    │   ├── FileError                 a file is wrong: the message starts with its path
    │   └── RangeError                an input lies outside the range that a damper was calibrated on
    ├── MissingData (FileNotFoundError)  a data set or file is not there, and how to get it
    └── RigFault                      the rig does not answer, or stopped: why, and what to look at

    DampyrWarning (UserWarning)
    ├── ExtrapolationWarning          a result leaves the calibrated range; the caller asked for it by name
    └── FindingWarning                something to look at, which is among the ``findings`` of the result, too

Each message is one sentence for a person. The command line prints it without a traceback and exits with 2.
A fit that does not converge is not an error: it is a value with a reason (``fit.converged``, ``fit.reason``).
"""

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from pathlib import Path


class DampyrError(Exception):
    """The root of all dampyr errors."""


class InputError(DampyrError, ValueError):
    """An argument or a value is wrong."""


class FileError(InputError):
    """A file is wrong; the message starts with its path."""

    def __init__(self, path: str | Path, message: str) -> None:
        super().__init__(f"{path}: {message}")
        self.path = Path(path)


class RangeError(InputError):
    """An input lies outside the range that a damper was calibrated on."""


class MissingData(DampyrError, FileNotFoundError):
    """A data set or file is not there."""

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else "data are missing"


class RigFault(DampyrError):
    """The rig does not answer, or it stopped by itself; ``ring`` is the safety layer that acted, if one did."""

    def __init__(self, message: str, ring: str = "") -> None:
        super().__init__(message)
        self.ring = ring


class DampyrWarning(UserWarning):
    """The root of all dampyr warnings."""


class ExtrapolationWarning(DampyrWarning):
    """A result leaves the calibrated range; the caller asked for it by name."""


class FindingWarning(DampyrWarning):
    """Something to look at, which is among the ``findings`` of the result, too."""


def did_you_mean(name: str, available: Iterable[str]) -> str:
    """The question after the nearest name, with a space behind it; empty where none is near."""
    close = get_close_matches(name, list(available), n=1)
    return f"did you mean {close[0]!r}? " if close else ""


def choose_from(name: str, available: Sequence[str]) -> str:
    """The repair for a name that is not known: the nearest one, and all that there are."""
    return f"{did_you_mean(name, available)}choose from {', '.join(available)}"


def one_line(problem: BaseException) -> str:
    """What another library's error says, on one line; the error's kind where it says nothing."""
    return " ".join(str(problem).split()) or type(problem).__name__


def install_line(extra: str) -> str:
    """The command that installs an extra of dampyr, quoted as every shell takes it."""
    return f'pip install "dampyr[{extra}]"'
