"""A stream whose reader has left."""

from __future__ import annotations

import io


class Broken(io.TextIOBase):
    """A stream whose reader has left."""

    def __init__(self, problem: Exception, after: int, terminal: bool) -> None:
        super().__init__()
        self.problem, self.left, self.terminal = problem, after, terminal

    def write(self, text: str) -> int:
        self.left -= 1
        if self.left < 0:
            raise self.problem
        return len(text)

    def isatty(self) -> bool:
        return self.terminal
