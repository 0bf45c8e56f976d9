"""Many sites in a kernel: loops over those whose dampers and laws have one text, and Newton's matrix in loops over its rows.

The text is that of the first site of each text (`dampyr.structures.batch.assemble`, `dampyr.structures.batch.law_step`), once;
a row of it stands for as many as there are sites of this text, one after the other, and so do its coefficients. ``order`` are
the sites so arranged, in which the rows follow each other that products with the building's matrices run over.

Names besides those of a single site: ``site`` counts within a text, ``ring_row`` is its row in the ring, ``~m0`` ... are what
laws measure, ``~now`` the ground's acceleration at a decision, ``~r0``, ``~fx0``, ``~fv0`` residuals and slopes of all sites at
h/2, then at h, ``~j0`` ... the matrix row by row, ``~o0`` one over its diagonal.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.structures.batch.law_step import JUMPING, LawStep, SiteControl, ground_velocity
from dampyr.structures.batch.loop_fission import Loops

Array = NDArray[np.float64]
RING_ROW = "ring_row"
# names of all sites, at h/2 and at h, which loops and products share
SHARED = ("base", "g", "e", "new", "r", "fx", "fv")
OF_A_SITE = re.compile(rf"(~?)({'|'.join((*SHARED, *'fsptxvuRDEq'))}|mf|En|law|knot)(\d+)(.*)")
TAGGED = re.compile(r".*_(half|end|now)\d+")


class SiteRows:
    """The rows of a text for all its sites ``members``: a name of the first stands for those of all, one after the other."""

    def __init__(self, rows: Any, members: list[int], sites: int) -> None:
        self.rows, self.members, self.sites = rows, members, sites
        self.block_width = rows.block_width

    @property
    def names(self) -> list[str]:
        """All rows so far."""
        return list(self.rows.names)

    def __getitem__(self, name: str) -> int:
        places = [self.rows[self._of(name, d)] for d in self.members]
        if places != list(range(places[0], places[0] + len(places))):
            raise ValueError(f"the rows of {name} do not follow each other: {places}")
        return places[0]

    def at(self, name: str) -> str:
        """The row of a site's name."""
        return f"b[({self[name]} + site)*{self.block_width} + l]"

    def _of(self, name: str, d: int) -> str:
        """The name of site ``d`` for one of the first."""
        first, found = self.members[0], OF_A_SITE.fullmatch(name)
        if found and not TAGGED.fullmatch(name) and int(found[3]) in (first, self.sites + first):
            return f"{found[1]}{found[2]}{int(found[3]) - first + d}{found[4]}"
        return name if d == first else f"{name}@{d}"


class SiteLoops:
    """Writes the sites' part of a kernel ``text`` (`dampyr.structures.batch.assemble.KernelText`) in loops over sites."""

    def __init__(self, text: Any, controls: dict[int, SiteControl]) -> None:
        self.text, self.controls, self.laws = text, controls, dict[int, LawStep]()
        for d, control in controls.items():
            self.laws[d] = self._apart(partial(LawStep, text, d, control))[0]
        groups: dict[Any, list[int]] = {}
        for d, composition in enumerate(text.compositions):
            groups.setdefault((composition, self._law_text(d)), []).append(d)
        self.groups = list(groups.values())
        self.order = [d for group in self.groups for d in group]
        self.rows = [SiteRows(text.rows, group, text.sites) for group in self.groups]

    @property
    def written(self) -> list[int]:
        """The sites whose texts stand in the kernel."""
        return [group[0] for group in self.groups]

    def _law_text(self, d: int) -> Any:
        """What decides the text of a site's law."""
        if d not in self.controls:
            return None
        control, text = self.controls[d], self.text

        def written() -> Any:
            law = LawStep(text, 0, control)  # as if it were the first
            return law.decide(), law.coil(), control.pieces, control.search, len(law.measured)

        return repr((type(control.controller.law), self._apart(written, apart_rows=True)[0]))

    def _apart(
        self, make: Callable[[], Any], rows: Any = None, apart_rows: bool = False
    ) -> tuple[Any, list[float], Any]:
        """What ``make`` gives, with the coefficients, lines and updates that it wrote beside those of the text."""
        text = self.text
        kept = text.coefficients, text.lines, text.updates, text.cuts, text.rows
        text.coefficients, text.lines, text.updates, text.cuts = [], [], {}, []
        if rows is not None:
            text.rows = rows
        elif apart_rows:
            text.rows = type(text.rows)(text.block_width)
        try:
            made = make()
            return made, text.coefficients, (text.lines, text.updates, text.cuts)
        finally:
            text.coefficients, text.lines, text.updates, text.cuts, text.rows = kept

    def _both(self, letter: str) -> int:
        """The first of the rows of a letter at h/2 and at h, in the order of the sites."""
        return int(self.text.rows.run(f"~{letter}", self.frame.both))

    def write(self, frame: Any) -> None:
        """Take rows for all sites, in the building's ``frame``."""
        text, rows = self.text, self.text.rows
        self.frame, self.places = frame, {f"{letter}{r}": f"~{letter}{r}" for letter in SHARED for r in frame.both}
        self.first = {letter: self._both(letter) for letter in SHARED}
        for letter in "xv":
            rows.run(letter, text.order)
        for k, group in enumerate(self.groups):
            law = self.laws.get(group[0])
            for row in (*text.value_rows(group[0]), *(law.starts if law else ())):
                self.rows[k][row]
        self.steps = [self._steps(k) for k in range(len(self.groups))]
        self.matrix, self.over = rows.run("~j", range(4 * text.sites**2)), rows.run("~o", range(2 * text.sites))
        if self.laws:
            self.now, self.measured = rows["~now"], self._measured_rows()

    def _measured_rows(self) -> int:
        """The first row of what laws measure, a channel of all sites of a text after the other."""
        names = [
            f"{self.laws[d].name}_m{c}"
            for group in self.groups
            if group[0] in self.laws
            for c in range(len(self.laws[group[0]].measured))
            for d in group
        ]
        self.channels = [(int(d), int(c)) for d, c in (name[3:].split("_m") for name in names)]
        places = [self.text.rows[f"~{name}"] for name in names]
        return int(places[0]) if places else 0

    def _steps(self, k: int) -> list[list[str]]:
        """The loops of the sites of a text in a step: before the guess, the laws along its path, and after the correction."""
        group, written, numbers = self.groups[k], list[Any](), list[list[float]]()
        for d in group:
            _, coefficients, lines = self._apart(partial(self._step_of, d), self._rows_of(k, d))
            written.append(lines)
            numbers.append(coefficients)
        lines, updates, cuts = written[0]
        loops = Loops(lines, [0, *cuts, len(lines)], updates, self.rows[k], self.places).written()
        return [self._over(k, loop, numbers) for loop in loops]

    def _rows_of(self, k: int, d: int) -> SiteRows:
        """The rows that site ``d`` of text k writes its lines with: the first for all, another for its coefficients alone."""
        return self.rows[k] if d == self.groups[k][0] else SiteRows(self.text.rows, [d], self.text.sites)

    def _step_of(self, d: int) -> None:
        """Emit a site's lines of a step."""
        text, N = self.text, self.text.sites
        text.emit(*text.guess(d))
        if d in self.laws:
            text.emit(*self.laws[d].coil())
        text.cut()
        first, second = text.law_of(d)
        for r, half in ((d, first), (N + d, second)):
            if text.is_delayed(d):
                text.emit(*(f"{name}{r} = zero" for name in ("r", "fx", "fv")))
            else:
                text.emit(f"r{r} = {half.force} - g{r}", f"fx{r} = {half.slopes[0]}", f"fv{r} = {half.slopes[1]}")
        text.cut()
        text.finish(d, first, second)
        for r in (d, N + d):
            text.carry(self.frame.starts[r], f"new{r}")
        for row, value in text.updates.items():  # what the correction changes is stored after it
            if value in self.places:
                text.emit(f"last_{row} = {value}")
                text.updates[row] = f"last_{row}"

    def _over(self, k: int, loop: list[str], numbers: list[list[float]], given: tuple[str, ...] = ()) -> list[str]:
        """A loop over the histories inside one over the sites of text k, with their coefficients and what is ``given``."""
        used = sorted({int(c) for line in (*loop, *given) for c in re.findall(r"\bc(\d+)\b", line)})
        first = self.frame.stored(np.array([[row[c] for c in used] for row in numbers])) if used else 0
        here = self.order.index(self.groups[k][0])
        lines = [f"c{c} = c[{first} + site*{len(used)} + {j}]" for j, c in enumerate(used)]
        if any(RING_ROW in line for line in loop):
            lines.append(f"{RING_ROW} = {here} + site")
        return [f"for site in range({len(self.groups[k])}):", *(f"    {line}" for line in [*lines, *given, *loop])]

    def body(self) -> list[str]:
        """The lines of a step from the building's motion without the unknown forces to the forces."""
        frame, size = self.frame, 2 * self.text.sites
        moved = self.text.moved[np.ix_(frame.both, range(size))]
        motion = [frame.product(moved, frame.unknown, self.first[letter], start=frame.base) for letter in ("e", "new")]
        before, laws, after = ([line for steps in self.steps for line in steps[k]] for k in range(3))
        return [*before, *motion[0], *laws, *self._correct(), *motion[1], *after]

    def _correct(self) -> list[str]:
        """Newton's correction of the guess, as `dampyr.structures.batch.assemble.solved` does it."""
        text, frame, wide = self.text, self.frame, self.text.block_width
        N, size = text.sites, 2 * text.sites
        both = np.array(frame.both)
        rows = np.vstack([text.mid_moved, text.moved])  # of each site: strokes and rates at h/2, then at h
        x = np.vstack([rows[:N], rows[2 * N : 3 * N]])[np.ix_(both, both)]
        v = np.vstack([rows[N : 2 * N], rows[3 * N :]])[np.ix_(both, both)]
        numbers = frame.stored(np.stack([x, v], axis=-1))

        def taken(**places: str) -> list[str]:
            """Rows by name: the compiler sees that these do not overlap, or asks once for all histories of a block."""
            return [f"{name} = b[({place})*{wide} : ({place} + 1)*{wide}]" for name, place in places.items()]

        def entry(r: str, k: str) -> str:
            return f"{self.matrix} + ({r})*{size} + {k}"

        first, histories = self.first, f"for l in range({wide}):"
        return indented(
            f"for r in range({size}):",
            [
                *taken(by_x=f"{first['fx']} + r", by_v=f"{first['fv']} + r"),
                f"for k in range({size}):",
                [
                    f"of_x, of_v = c[{numbers} + (r*{size} + k)*2], c[{numbers} + (r*{size} + k)*2 + 1]",
                    "diagonal = one if r == k else zero",
                    *taken(to=entry("r", "k")),
                    histories,
                    ["to[l] = diagonal - (by_x[l]*of_x + by_v[l]*of_v)"],
                ],
            ],
            f"for k in range({size}):",
            [
                *taken(pivot=entry("k", "k"), over=f"{self.over} + k", known=f"{first['r']} + k"),
                histories,
                ["over[l] = one/pivot[l]"],
                f"for r in range(k + 1, {size}):",
                [
                    *taken(factor=entry("r", "k"), to=f"{first['r']} + r"),
                    histories,
                    ["factor[l] = factor[l]*over[l]", "to[l] = to[l] - factor[l]*known[l]"],
                    f"for other in range(k + 1, {size}):",
                    [
                        *taken(to=entry("r", "other"), pivot=entry("k", "other")),
                        histories,
                        ["to[l] = to[l] - factor[l]*pivot[l]"],
                    ],
                ],
            ],
            f"for up in range({size}):",
            [
                f"k = {size - 1} - up",
                *taken(to=f"{first['r']} + k", over=f"{self.over} + k", force=f"{first['g']} + k"),
                f"for other in range(k + 1, {size}):",
                [
                    *taken(factor=entry("k", "other"), known=f"{first['r']} + other"),
                    histories,
                    ["to[l] = to[l] - factor[l]*known[l]"],
                ],
                histories,
                ["to[l] = to[l]*over[l]", "force[l] = force[l] + to[l]"],
            ],
        )

    def decisions(self) -> list[str]:
        """What comes before a step: laws measure and decide, forces jump, and the ground's velocity goes on."""
        text, frame = self.text, self.frame
        if not self.laws:
            return []
        z, wide = range(frame.z, frame.z + text.size), text.block_width
        now = text.rows.at
        ground = [f"for l in range({wide}):", f"    {now('~now')} = {now('low')} + ({now('high')} - {now('low')})*part"]
        known = [*z, text.rows["V"], self.now, *frame.forces]
        lines = ["due, jump = False, False"]
        decide, jump = list[str](), list[str]()
        for k, group in enumerate(self.groups):
            if group[0] not in self.laws:
                continue
            law = self.laws[group[0]]
            due = f"steps % {law.every} == 0"
            numbers = [[float(self.controls[d].every)] for d in group]
            clock = f"{law.every} = floor(c0 + half)"
            found = [f"if {due}:", "    due = True", *(["    jump = True"] if law.jumps else [])]
            lines += self._over(k, found, numbers, (clock,))
            made = [self._apart(partial(self._clocked, d), self._rows_of(k, d)) for d in group]
            (some, updates), _, _ = made[0]
            decide += self._over(k, self._decided(k, due, some, updates), [row for _, row, _ in made], (clock,))
            if law.jumps:
                jump += self._over(k, self._decided(k, "", *law.jump()), [[] for _ in group])
        measure = list[str]()
        if self.channels:
            matrix = np.array([self.controls[d].rows[c] for d, c in self.channels])
            measure = frame.product(matrix, known, self.measured)
        lines += ["if due:", *(f"    {line}" for line in [*ground, *measure, *decide])]
        if jump:
            lines += ["if jump:", *(f"    {line}" for line in [*jump, *self._raised()])]
        return lines + (ground_velocity(text) if any(law.needs_ground_velocity for law in self.laws.values()) else [])

    def _clocked(self, d: int) -> tuple[list[str], dict[str, str]]:
        """A law's decision, whose first coefficient says every how many steps it is made."""
        self.text.number(float(self.controls[d].every))
        return self.laws[d].decide()

    def _decided(self, k: int, due: str, lines: list[str], updates: dict[str, str]) -> list[str]:
        """Lines in a loop over the histories where it is time."""
        for row in updates:
            self.rows[k][row]
        measured = {name: f"~{name}" for name in self.laws[self.groups[k][0]].measured}
        [loop] = Loops(lines, [0, len(lines)], updates, self.rows[k], measured).written()
        return [f"if {due}:", *(f"    {line}" for line in loop)] if due else loop

    def _raised(self) -> list[str]:
        """The peaks of what jumps, raised by the forces after the jump."""
        text, frame, lines = self.text, self.frame, list[str]()
        columns = [*range(frame.z, frame.z + text.size), *frame.forces, self.now]
        first = 0
        for jumps, some in groupby(text.outputs(), lambda output: output[0] in JUMPING):
            rows = np.array([row for _, _, row in some])
            if jumps:
                lines += frame.product(rows, columns, frame.values + first)
                places = {"now": frame.row(frame.values + first), "top": frame.row(frame.top + first)}
                lines += frame.loop(len(rows), places, [], ["top[l] = max(top[l], abs(now[l]))"])
            first += len(rows)
        return lines


def indented(*lines: Any) -> list[str]:
    """Lines, those of a list inside the line before it."""
    written: list[str] = []
    for line in lines:
        written += [f"    {inner}" for inner in indented(*line)] if isinstance(line, list) else [line]
    return written
