"""Loop fission: the lines of a step in several loops over the histories, which pass values on through rows."""

from __future__ import annotations

import ast
from dataclasses import dataclass, field
from typing import Any

from dampyr.models.codegen.syntax_trees import statements_of


@dataclass
class Loops:
    """``lines`` cut into loops at ``cuts``; ``updates`` names what each row is to hold after the step.

    ``places`` names the rows of what the lines take from elsewhere or leave for others.
    """

    lines: list[str]
    cuts: list[int]
    updates: dict[str, str]
    rows: Any
    places: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.parts = [self.lines[a:b] for a, b in zip(self.cuts, self.cuts[1:]) if b > a]
        self.reads, self.writes = [], []
        for part in self.parts:
            read, written = _used(part)
            self.reads.append(read)
            self.writes.append(written)

    def written(self) -> list[list[str]]:
        """Each loop with what it loads and stores."""
        written = set().union(*self.writes)
        return [self._loop(k, written) for k in range(len(self.parts))]

    def _loop(self, k: int, written: set[str]) -> list[str]:
        late = [(row, value) for row, value in self.updates.items() if self._stored_in(row, value) == k]
        updated = {value for _, value in late} - self.writes[k]
        needed = sorted((self.reads[k] | updated) & (set(self.rows.names) | written | set(self.places)))
        loads = [f"    {name} = {self.rows.at(self._place(name))}" for name in needed]
        later = set().union(*self.reads[k + 1 :], *(self._updated_names(j) for j in range(k + 1, len(self.parts))))
        passed = sorted(self.writes[k] & (later | set(self.places)))
        stores = [f"    {self.rows.at(self._place(name))} = {name}" for name in passed]
        stores += [f"    {self.rows.at(row)} = {value}" for row, value in late]
        return [
            f"for l in range({self.rows.block_width}):",
            *loads,
            *("    " + line for line in self.parts[k]),
            *stores,
        ]

    def _updated_names(self, k: int) -> set[str]:
        return {value for row, value in self.updates.items() if self._stored_in(row, value) == k} - self.writes[k]

    def _place(self, name: str) -> str:
        """The row of a name: one of its own, or a passing one."""
        if name in self.places:
            return self.places[name]
        return name if name in self.updates or not any(name in w for w in self.writes) else f"~{name}"

    def _stored_in(self, row: str, value: str) -> int:
        """The first loop after which nothing reads the old value."""
        last_write = max((k for k, names in enumerate(self.writes) if value in names), default=0)
        readers = [k for k, names in enumerate(self.reads) if row in names]
        return max([last_write, *readers])


def _used(lines: list[str]) -> tuple[set[str], set[str]]:
    """Names that lines need from before, and names that they write."""
    read: set[str] = set()
    written: set[str] = set()
    for line in lines:
        tree = statements_of(line).body[0]
        names = [node for node in ast.walk(tree) if isinstance(node, ast.Name)]
        loaded = {n.id for n in names if isinstance(n.ctx, ast.Load)}
        stored = {n.id for n in names if isinstance(n.ctx, ast.Store)}
        if isinstance(tree, ast.AugAssign):
            loaded |= stored
        read |= loaded - written
        written |= stored
    return read, written
