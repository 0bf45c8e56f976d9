"""Building's part of a step: written out for a small one, in loops over modes and rows for a large one."""

from __future__ import annotations

from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
GROUND = ["ground_rise = high - low", "a0 = low + ground_rise*part", "a1 = low + ground_rise*(part + share)"]


PRODUCTS_AT_ONCE = 8  # with a row, which is loaded and stored once for as many


class Small:
    """Every sum of the building written out."""

    def __init__(self, text: Any) -> None:
        self.text = text
        self.state = [f"z{k}" for k in range(text.size)]
        self.starts = [self._start(r) for r in range(2 * text.sites)]

    def _start(self, r: int) -> str:
        """Stroke or rate of a site at the start: a name of its own, or the coordinate that it is."""
        row = self.text.step.sites[r]
        alone = np.flatnonzero(row)
        if len(alone) == 1 and row[alone[0]] == 1.0:
            return self.state[alone[0]]
        return f"{'x' if r < self.text.sites else 'v'}{r % self.text.sites}"

    @property
    def named(self) -> int:
        """How many coefficients have names in the kernel."""
        return len(self.text.coefficients)

    def before(self) -> None:
        """The motion that the unknown forces do not touch."""
        text, terms = self.text, [*self.state, "a0", "a1", *(f"f{d}" for d in range(self.text.sites))]
        text.emit(*GROUND)
        for i in range(text.size):
            text.emit(f"k{i} = {text.sum(text.step.end[i, : len(terms)], terms)}")
        for r in range(2 * text.sites):
            text.emit(f"base{r} = {text.sum(text.step.sites[r], [f'k{i}' for i in range(text.size)])}")

    def after(self) -> None:
        """The state at the end and its peaks."""
        text, width = self.text, self.text.size + 2 + self.text.sites
        for i in range(text.size):
            moved = text.sum(text.step.end[i, width:], text.unknown) if text.sites else "zero"
            text.emit(f"n{i} = k{i} + {moved}")
            text.carry(f"z{i}", f"n{i}")
        for r, start in enumerate(self.starts):
            if not start.startswith("z"):
                text.carry(start, f"new{r}")
        text.cut()
        self._observe()

    def _observe(self) -> None:
        """Peaks of each different row of the outputs."""
        text = self.text
        names = [*(f"n{i}" for i in range(text.size)), *(f"g{text.sites + d}" for d in range(text.sites)), "a1"]
        seen: dict[tuple[float, ...], str] = {}
        for quantity, i, row in text.outputs():
            key = tuple(row)
            if key not in seen:
                name = seen[key] = f"P{len(seen)}"
                peak = text.peak(name, f"{name}a", f"{name}b", f"{name}c", text.jumps(quantity))
                text.emit(f"{name}a = {text.sum(row, names)}", *peak)
                for row_name, value in ((name, f"{name}n"), (f"{name}b", f"{name}a"), (f"{name}c", f"{name}b")):
                    text.carry(row_name, value)
            text.peaks[quantity, i] = seen[key]

    def latest(self, peak: str) -> str:
        """The row with the value at the last node of what a peak is taken of."""
        return f"{peak}b"

    def body(self) -> list[str]:
        """The lines of a step."""
        return list(self.text.loops({}))


class Large:
    """Sums in loops; the state in pairs of coordinates that the step does not mix with others, or dense."""

    def __init__(self, text: Any) -> None:
        self.text = text
        N = text.sites
        self.starts = [f"{'x' if r < N else 'v'}{r % N}" for r in range(2 * N)]
        size, self.both = text.size, [*text.order, *(N + d for d in text.order)]
        self.z, self.k = text.rows.run("z", range(size)), text.rows.run("~k", range(size))
        self.a = text.rows.run("~a", range(2))
        text.rows.run("f", text.order)
        self.forces = [text.rows[f"f{d}"] for d in range(N)]
        self.base, self.g = text.rows.run("~base", self.both), text.rows.run("~g", self.both)
        self.unknown = [text.rows[f"~g{r}"] for r in range(2 * N)]
        off_block = np.kron(np.eye(size // 2), np.ones((2, 2))) == 0
        self.pairs = not np.any(text.step.end[:, :size][off_block])

    def before(self) -> None:
        """Nothing: it is in `body`."""

    def after(self) -> None:
        text = self.text
        if text.loops_of_sites:
            text.loops_of_sites.write(self)
        else:
            for r, start in enumerate(self.starts):
                text.carry(start, f"new{r}")
        outputs = text.outputs()
        self.values, self.top, self.mid, self.old = (
            text.rows.run(letter, range(len(outputs))) for letter in ("~q", "P", "Pb", "Pc")
        )
        for r, (quantity, i, _) in enumerate(outputs):
            text.peaks[quantity, i] = f"P{r}"
        self.jumping = [text.jumps(quantity) for quantity, _, _ in outputs]
        self.outputs = np.array([row for _, _, row in outputs]).reshape(len(outputs), text.size + text.sites + 1)

    def latest(self, peak: str) -> str:
        """The row with the value at the last node of what a peak is taken of."""
        return f"Pb{peak[1:]}"

    @property
    def named(self) -> int:
        """How many coefficients have names in the kernel."""
        return 0 if self.text.loops_of_sites else self.named_

    def body(self) -> list[str]:
        """The lines of a step."""
        text = self.text
        self.named_ = len(text.coefficients)  # the others are matrices, behind them
        size, N = text.size, text.sites
        shared = {f"base{r}": f"~base{r}" for r in range(2 * N)} | {f"g{r}": f"~g{r}" for r in range(2 * N)}
        dampers = text.loops_of_sites.body() if text.loops_of_sites else text.loops(shared) if N else []
        width = size + 2 + N
        explicit, unknown = text.step.end[:, :width], text.step.end[:, width:]
        ground = [f"{name} = {text.rows.at(name)}" for name in ("low", "high")]
        lines = [f"for l in range({text.block_width}):", *(f"    {line}" for line in [*ground, *GROUND])]
        lines += [f"    b[{(self.a + j) * text.block_width} + l] = a{j}" for j in range(2)]
        others = [self.a, self.a + 1, *self.forces]
        if self.pairs:
            lines += self._pairs(explicit[:, :size])
            lines += self.product(explicit[:, size:], others, self.k, start=self.k)
        else:
            lines += self.product(explicit, [*range(self.z, self.z + size), *others], self.k)
        if N:
            for part in (0, N):  # strokes, then rates: each takes half of the modes' coordinates
                rows = text.step.sites[self.both[part : part + N]]
                lines += self.product(rows, range(self.k, self.k + size), self.base + part)
        lines += dampers
        lines += self.product(unknown, self.unknown, self.z, start=self.k)
        lines += self._values([*range(self.z, self.z + size), *self.forces, self.a + 1])
        pieces = [
            (jumps, len(list(some))) for jumps, some in groupby(self.jumping)
        ]  # of outputs of the same kind in a row
        firsts = np.cumsum([0, *(count for _, count in pieces)]).tolist()
        return lines + [
            line
            for first, (jumps, count) in zip(firsts, pieces, strict=False)
            for line in self._peaks(first, count, jumps)
        ]

    def _values(self, columns: list[int]) -> list[str]:
        """What peaks are taken of; drifts are differences of displacements where both are wanted."""
        wanted, n = self.text.quantities, len(self.text.step.displacement)
        if not {"displacement", "drift"} <= set(wanted) or not self.text.step.is_stack:
            return self.product(self.outputs, columns, self.values)
        lines = self.product(self.outputs[:n], columns, self.values)
        first = {"x": self.row(self.values + n), "y": self.row(self.values)}
        lines += self.loop(1, first, [], ["x[l] = y[l]"])
        rows = {"x": self.row(self.values + n + 1), "y": self.row(self.values + 1), "z": self.row(self.values)}
        lines += self.loop(n - 1, rows, [], ["x[l] = y[l] - z[l]"])
        rest = self.outputs[2 * n :]
        return lines + (self.product(rest, columns, self.values + 2 * n) if len(rest) else [])

    def stored(self, values: Array) -> int:
        """Append numbers to the named coefficients; returns the index of the first."""
        first = len(self.text.coefficients)
        self.text.coefficients.extend(float(v) for v in np.ravel(values))
        return first

    def _pairs(self, blocks: Array) -> list[str]:
        """The state carried on, pair by pair."""
        size = len(blocks)
        first = self.stored(np.array([blocks[i, i - i % 2 : i - i % 2 + 2] for i in range(size)]))
        rows = {
            "u": self.row(self.z, 2),
            "v": self.row(self.z + 1, 2),
            "x": self.row(self.k, 2),
            "y": self.row(self.k + 1, 2),
        }
        lines = [f"q{j} = c[{first + j} + r*4]" for j in range(4)]
        sums = [f"{out}[l] = q{2 * j}*u[l] + q{2 * j + 1}*v[l]" for j, out in enumerate("xy")]
        return self.loop(size // 2, rows, lines, sums)

    def product(self, matrix: Array, columns: Any, target: int, start: int | None = None) -> list[str]:
        """Rows of a block from ``target`` on: a matrix times the rows ``columns``, added to the rows from ``start`` on.

        Some columns at a time, so that a row is loaded and stored once for as many products; columns of zeros are left out.
        """
        filled = np.flatnonzero(np.any(matrix != 0.0, axis=0))
        matrix, columns = matrix[:, filled], [list(columns)[k] for k in filled]
        lines = []
        for at in range(0, max(len(columns), 1), PRODUCTS_AT_ONCE):
            some = columns[at : at + PRODUCTS_AT_ONCE]
            first = self.stored(matrix[:, at : at + PRODUCTS_AT_ONCE])
            rows = {"x": self.row(target)} if at or start is None else {"x": self.row(target), "y": self.row(start)}
            terms = [f"q{k}*b[{row * self.text.block_width} + l]" for k, row in enumerate(some)]
            terms += ["x[l]"] if at else ["y[l]"] if start is not None else []
            given = [f"q{k} = c[{first} + r*{len(some)} + {k}]" for k in range(len(some))]
            lines += self.loop(len(matrix), rows, given, [f"x[l] = {' + '.join(terms) or 'zero'}"])
        return lines

    def _peaks(self, first: int, count: int, jumps: bool) -> list[str]:
        rows = {
            "now": self.row(self.values + first),
            "old": self.row(self.old + first),
            "mid": self.row(self.mid + first),
            "top": self.row(self.top + first),
        }
        loop = [f"{name}_ = {name}[l]" for name in rows]
        loop += self.text.peak("top_", "now_", "mid_", "old_", jumps)
        return self.loop(count, rows, [], [*loop, "top[l] = top_n", "old[l] = mid_", "mid[l] = now_"])

    def row(self, first: int, apart: int = 1) -> str:
        """Row ``first`` of a block, then every next one as r counts."""
        wide = self.text.block_width
        return f"b[r*{apart * wide} + {first * wide} : r*{apart * wide} + {(first + 1) * wide}]"

    def loop(self, count: int, rows: dict[str, str], given: list[str], lines: list[str]) -> list[str]:
        """A loop over rows with one over the histories inside."""
        return [
            f"for r in range({count}):",
            *(f"    {name} = {row}" for name, row in rows.items()),
            *(f"    {line}" for line in given),
            f"    for l in range({self.text.block_width}):",
            *(f"        {line}" for line in lines),
        ]
