r"""Source of a kernel: one step of a building with its dampers, for a block of histories at a time.

In a step of h seconds the dampers' forces are the quadratics through their values at 0, h/2 and h (see
`dampyr.structures.time_history.time_stepping`). Their first guess continues the last half step, the dampers' laws along the
path of that guess give forces and slopes, and a Newton correction, written out, gives the forces of the step; the states
follow by their tangents. Nothing branches. At the middle of the step a site is where the cubic through both ends has it. The
error that remains is measured in every ensemble (see `dampyr.structures.ensemble`).

Every history is a column of a block; `Rows` says which row holds what. A small building's sums are written out, without the
terms whose coefficients are 0; a large one's run in loops over its modes. Up to three sites are written out one after another;
more run in loops over those of one text (`dampyr.structures.batch.site_loops`). In every case the text depends on the pattern
of the building and not on its numbers, which come as a vector.

Names in the text, of site d and coordinate i; a row of the same name is a value carried to the next step:

=================== =================================================================================================
``z0`` ...          state of the building; ``k0`` its part that the unknown forces do not touch, ``n0`` at the end
``x0``, ``v0``      stroke and rate of a site at the start, where these are not coordinates themselves
``base0`` ...       strokes of all sites, then rates, at the end: the part that the unknown forces do not touch
``h0``, ``e0`` ...  the same at h/2 and at the end under the guessed forces; ``new0`` at the end under the corrected ones
``f0``, ``mf0``     force at the start of the step, and at the middle of the last one
``g0`` ...          forces of all sites at h/2, then at h: guessed, then corrected
``s0_1``, ``t0_1``  states of a damper at the start and at the end of the step
``..._half0``       what the law of a damper computes in the first half step, at its end; ``..._end0`` in the second
``p0_1``            parameters of a damper
``u0``, ``R0``      force of a delayed damper before its delay, and at rest; ``D0`` the delay in steps
``r0``, ``j0_1``    residuals and Jacobian of Newton's correction
``E0``, ``En0``     energy that a damper took, at the start and at the end
``P0`` ...          peaks: ``P0a``, ``P0b``, ``P0c`` the value now, one and two nodes before, ``P0n`` the new peak
=================== =================================================================================================
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dampyr.models.codegen.composition import Composition
from dampyr.structures.batch.branchless_math import BLOCK_WIDTH
from dampyr.structures.batch.damper_step import Half, half_step
from dampyr.structures.batch.law_step import JUMPING, LawStep, SiteControl, ground_velocity, jumps
from dampyr.structures.batch.loop_fission import Loops
from dampyr.structures.batch.modal import ModalStep
from dampyr.structures.batch.site_loops import RING_ROW, SiteLoops, SiteRows

Array = NDArray[np.float64]
QUANTITIES = ("displacement", "drift", "acceleration", "force", "stroke", "energy")
WRITTEN_OUT_UP_TO = 4  # coordinates: two floors, whose sums have few terms
SITES_WRITTEN_OUT = 3  # beyond, Newton's matrix has too many terms to stand in the text
# Of a kernel: from which sample to which; steps per sample; the motions' accelerations, which of them each history has and
# its scale; the lengths of `TIMES`; coefficients of the building; the block; the ring of past forces, and its size less 1.
ARGUMENTS = ("first", "last", "parts", "ground", "motion", "scale", "times", "c", "b", "ring", "mask")
TIMES = "dt, sixth, share, eighth_step, three_half_rate = times[0], times[1], times[2], times[3], times[4]"


@dataclass
class Rows:
    """Row numbers of a block, ``block_width`` wide, by name, in the order of first use."""

    block_width: int
    names: list[str] = field(default_factory=list)

    def __getitem__(self, name: str) -> int:
        if name not in self.names:
            self.names.append(name)
        return self.names.index(name)

    def at(self, name: str) -> str:
        return f"b[{self[name] * self.block_width} + l]"

    def run(self, letter: str, numbers: Iterable[int]) -> int:
        """The first of the rows of a letter with these ``numbers``, which follow each other."""
        places = [self[f"{letter}{k}"] for k in numbers]
        return places[0] if places else 0


@dataclass
class KernelText:
    """A kernel being written: the dampers' part of a step here, the building's by ``frame``.

    The ``block_width`` stands in the text, so that the compiler sees that rows do not overlap; ``ring_width`` is that of the
    ring of past forces.
    """

    step: ModalStep
    compositions: tuple[Composition, ...]
    quantities: tuple[str, ...]
    block_width: int = BLOCK_WIDTH
    ring_width: str = ""
    controls: tuple[SiteControl | None, ...] = ()
    coefficients: list[float] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    updates: dict[str, str] = field(default_factory=dict)
    peaks: dict[tuple[str, int], str] = field(default_factory=dict)
    cuts: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        from dampyr.structures.batch.building_step import Large, Small

        self.rows = Rows(self.block_width, ["low", "high"])  # the ground's acceleration about a step
        self.ring_width = self.ring_width or str(self.block_width)
        self.size, self.sites = self.step.end.shape[0], len(self.compositions)
        self.unknown = [f"g{r}" for r in range(2 * self.sites)]
        width = self.size + 2 + self.sites
        self.moved = (self.step.sites @ self.step.end)[
            :, width:
        ]  # strokes, then rates, at the end by the unknown forces
        x, v = self.moved[: self.sites], self.moved[self.sites :]
        self.mid_moved = np.vstack([0.5 * x - self.step.h / 8.0 * v, 1.5 / self.step.h * x - 0.25 * v])
        controlled = {d: control for d, control in enumerate(self.controls) if control is not None}
        self.in_loops = self.sites > SITES_WRITTEN_OUT
        self.loops_of_sites = SiteLoops(self, controlled) if self.in_loops else None
        if self.loops_of_sites:
            self.order, self.laws = self.loops_of_sites.order, self.loops_of_sites.laws
        else:
            self.order = list(range(self.sites))
            self.laws = {d: LawStep(self, d, control) for d, control in controlled.items()}
        small = self.size <= WRITTEN_OUT_UP_TO and not self.in_loops
        self.frame = (Small if small else Large)(self)
        self.starts = self.frame.starts
        self.frame.before()
        if self.sites and not self.in_loops:
            self._dampers()
        self.frame.after()
        self.decisions = self.loops_of_sites.decisions() if self.loops_of_sites else self._decisions()
        self.source = self._source()

    @property
    def functions(self) -> str:
        """The text of the formulas of control laws."""
        written = self.loops_of_sites.written if self.loops_of_sites else self.laws
        return "\n\n".join(dict.fromkeys(text for d in written if d in self.laws for text in self.laws[d].functions))

    @property
    def searches(self) -> tuple[tuple[str, Composition], ...]:
        """The searches of laws that ask for a force, by name, and the dampers that they run backwards."""
        written = self.loops_of_sites.written if self.loops_of_sites else self.laws
        return tuple(
            (self.laws[d].search_function, self.compositions[d])
            for d in written
            if d in self.laws and self.laws[d].control.search
        )

    @property
    def own_rows(self) -> Rows:
        """All rows, where a site in a loop writes to its own."""
        return self.rows.rows if isinstance(self.rows, SiteRows) else self.rows

    @property
    def kinds(self) -> tuple[Composition, ...]:
        """The dampers whose functions the kernel calls."""
        return tuple(dict.fromkeys(self.compositions)) if self.loops_of_sites else self.compositions

    @property
    def starts_at(self) -> dict[str, float]:
        """What rows hold at the start besides what a history brings, where it is not 0."""
        return {row: value for law in self.laws.values() for row, value in law.starts.items()}

    def value_rows(self, d: int) -> list[str]:
        """The rows of the numbers that a site brings: its parameters, and under a law all that these follow."""
        if d in self.laws:
            return self.laws[d].value_rows
        return [f"p{d}_{k}" for k in range(len(self.compositions[d].parameters))]

    def _decisions(self) -> list[str]:
        """What comes before a step: laws decide, forces jump, and the ground's velocity goes on."""
        lines = []
        for d, law in self.laws.items():
            for row in ("V", *self.value_rows(d), *law.starts):
                self.rows[row]
            lines += law.decision()
        lines += jumps(self, self.laws)
        return lines + (ground_velocity(self) if any(law.needs_ground_velocity for law in self.laws.values()) else [])

    def emit(self, *lines: str) -> None:
        self.lines += lines

    def cut(self) -> None:
        """End a loop over the histories here: what is needed later goes through memory, and fewer numbers wait in registers."""
        self.cuts.append(len(self.lines))

    def carry(self, name: str, value: str) -> None:
        """Carry ``value`` to the next step as ``name``."""
        self.updates[name] = value
        self.rows[name]

    def number(self, value: float) -> str:
        """A coefficient by name."""
        self.coefficients.append(float(value))
        return f"c{len(self.coefficients) - 1}"

    def whole_number(self, value: int) -> str:
        """A whole number: of a site in a loop over sites it is one of the coefficients."""
        return f"floor({self.number(value)} + half)" if self.in_loops else str(value)

    def sum(self, row: Iterable[float], names: Sequence[str]) -> str:
        """The sum of a row of coefficients times names."""
        pairs = [(value, name) for value, name in zip(row, names, strict=True) if value != 0.0]
        terms = [name if value == 1.0 else f"{self.number(value)}*{name}" for value, name in pairs]
        return " + ".join(terms) or "zero"

    def _dampers(self) -> None:
        N = self.sites
        self.middles, self.ends = ([self._numbers(row) for row in rows] for rows in (self.mid_moved, self.moved))
        for d in range(N):
            self.emit(*self.guess(d))
        for law in self.laws.values():
            self.emit(*law.coil())
        self.cut()
        self.emit(*(f"e{r} = {self._moved(r)}" for r in range(2 * N)))
        done = [self.law_of(d) for d in range(N)]
        self.cut()
        self._correct(done)
        for r in range(2 * N):
            self.emit(f"new{r} = {self._moved(r)}")
        for d in range(N):
            self.finish(d, *done[d])

    def is_delayed(self, d: int) -> bool:
        """Whether a site's force is that of some time ago."""
        return self.compositions[d].has_delay

    def guess(self, d: int) -> list[str]:
        """The first guess of the forces of a step."""
        if self.is_delayed(d):
            return self._delayed(d)
        rise = f"force_rise{d}"
        return [f"{rise} = f{d} - mf{d}", f"g{d} = f{d} + half*{rise}", f"g{self.sites + d} = f{d} + {rise}"]

    def _delayed(self, d: int) -> list[str]:
        """The forces that a delayed damper would have given some steps ago, by its quadratics in the ring; at rest before."""
        lines = []
        self.rows[f"R{d}"]
        for name, ahead in ((f"g{d}", "half"), (f"g{self.sites + d}", "one")):
            lines += [f"when = real(steps) + {ahead} - {self._delay(d)}", "past = floor(when)"]
            nodes = ", ".join(
                f"ring[{self._ring_row(d)}, ((2*past + {k}) & mask)*{self.ring_width} + l]" for k in range(3)
            )
            lines.append(f"{name} = quadratic({nodes}, when - real(past)) if when > zero else R{d}")
        return lines

    def _ring_row(self, d: int) -> str:
        """The row of a site in the ring."""
        return RING_ROW if self.in_loops else str(d)

    def _delay(self, d: int) -> str:
        self.rows[f"D{d}"]
        return f"D{d}"

    def _numbers(self, row: Array) -> list[str]:
        return [self.number(value) for value in row]

    def _moved(self, r: int) -> str:
        """Stroke or rate of a site at the end under the forces ``g``."""
        return f"base{r} + " + " + ".join(f"{c}*{g}" for c, g in zip(self.ends[r], self.unknown))

    def _middle(self, d: int, x1: str, v1: str) -> list[str]:
        x0, v0 = self.starts[d], self.starts[self.sites + d]
        return [
            f"h{d} = half*({x0} + {x1}) + eighth_step*({v0} - {v1})",
            f"h{self.sites + d} = three_half_rate*({x1} - {x0}) - quarter*({v0} + {v1})",
        ]

    def law_of(self, d: int) -> tuple[Half, Half]:
        """Emit the law of a damper along the path of the guess."""
        N, composition = self.sites, self.compositions[d]
        self.emit(*self._middle(d, f"e{d}", f"e{N + d}"))
        quarter, half, three, end = (
            [self._value(d, k, at) for k in range(len(composition.parameters))] for at in "abcd"
        )
        states = [f"s{d}_{k}" for k in range(composition.n_states - composition.in_series)]
        before = f"u{d}" if self.is_delayed(d) else f"f{d}"
        states += [before] * composition.in_series
        early = {"x0": self.starts[d], "x1": f"h{d}", "v0": self.starts[N + d], "v1": f"h{N + d}", "dt": "dt"}
        early |= {"g0": before, "g1": before if self.is_delayed(d) else f"g{d}"}
        late = {"x0": f"h{d}", "x1": f"e{d}", "v0": f"h{N + d}", "v1": f"e{N + d}", "dt": "dt"}
        first = half_step(composition, f"_half{d}", states, quarter, early, half)
        late |= {"g0": first.force, "g1": first.force if self.is_delayed(d) else f"g{N + d}"}
        second = half_step(composition, f"_end{d}", [*first.ends, *states[len(first.ends) :]], three, late, end)
        self.emit(*first.lines, *second.lines)
        return first, second

    def _value(self, d: int, k: int, at: str) -> str:
        """The name of a parameter at an instant of the step."""
        self.rows[f"p{d}_{k}"]
        return self.laws[d].value(k, at) if d in self.laws else f"p{d}_{k}"

    def _correct(self, done: list[tuple[Half, Half]]) -> None:
        """Newton's correction of the guess."""
        N, matrix, right = self.sites, [], []
        for r in range(2 * N):
            d = r % N
            half, slopes = (done[d][0], self.middles) if r < N else (done[d][1], self.ends)
            self.emit(f"r{r} = zero" if self.is_delayed(d) else f"r{r} = {half.force} - g{r}")
            right.append(f"r{r}")
            for c in range(2 * N):
                one = "one - " if r == c else "-"
                if self.is_delayed(d):
                    self.emit(f"j{r}_{c} = {'one' if r == c else 'zero'}")
                    continue
                self.emit(f"j{r}_{c} = {one}({half.slopes[0]}*{slopes[d][c]} + {half.slopes[1]}*{slopes[N + d][c]})")
            matrix.append([f"j{r}_{c}" for c in range(2 * N)])
        self.emit(*solved(matrix, right), *(f"g{r} = g{r} + r{r}" for r in range(2 * N)))

    def finish(self, d: int, first: Half, second: Half) -> None:
        """States, corrected by their tangents and held to their bounds, forces and energy of a site at the end."""
        N, composition = self.sites, self.compositions[d]
        for k, (low, high) in enumerate(list(composition.states.values())[: len(second.ends)]):
            value = second.ends[k]
            for name, row in ((second.by_x[k], d), (second.by_v[k], N + d)):
                value += f" + {name}*(new{row} - e{row})" if name else ""
            if np.isfinite([low, high]).all():
                value = f"min(max({value}, {self.number(low)}), {self.number(high)})"
            self.emit(f"t{d}_{k} = {value}")
            self.carry(f"s{d}_{k}", f"t{d}_{k}")
        if self.is_delayed(d):
            forces = enumerate((first.force, second.force))
            self.emit(*(f"ring[{self._ring_row(d)}, slot_{k}*{self.ring_width} + l] = {force}" for k, force in forces))
            self.carry(f"u{d}", second.force)
        if "energy" in self.quantities:
            self.emit(*self._middle(d, f"new{d}", f"new{N + d}"))
            power = f"f{d}*{self.starts[N + d]} + four*g{d}*h{N + d} + g{N + d}*new{N + d}"
            self.emit(f"En{d} = E{d} + sixth*({power})")
            self.carry(f"E{d}", f"En{d}")
        self.carry(f"f{d}", f"g{N + d}")
        self.carry(f"mf{d}", f"g{d}")

    def outputs(self) -> list[tuple[str, int, Array]]:
        """What peaks are taken of: (quantity, which, its row over the state, the forces and the ground's acceleration at the
        end)."""
        none = np.zeros((0, self.sites))
        forces = np.eye(self.size + self.sites)[self.size :]
        rows = {
            "displacement": self.step.displacement,
            "drift": self.step.drift,
            "stroke": self.step.sites[: self.sites],
            "acceleration": self.step.acceleration,
            "force": forces,
        }
        peak_rows = []
        for quantity in self.quantities:
            for i, row in enumerate(rows.get(quantity, none)):
                wide = np.zeros(self.size + self.sites + 1)
                wide[: len(row)] = row
                peak_rows.append((quantity, i, wide))
        return peak_rows

    def jumps(self, quantity: str) -> bool:
        """Whether a quantity may jump or bend between two nodes, so that no parabola leads through them."""
        return bool(self.laws) and quantity in JUMPING

    def peak(self, name: str, now: str, mid: str, old: str, jumps: bool = False) -> list[str]:
        """Raise a peak by the middle one of three nodes in a row, and by the parabola through them where it turns near it."""
        if jumps:
            return [f"{name}n = max({name}, abs({mid}))"]
        return [
            f"apart = {now} - {old}",
            f"bend = abs({now} - two*{mid} + {old})",
            "more = min(apart*apart*eighth_over(bend + tiny), half*bend)",
            f"{name}n = max({name}, abs({mid}) + more)",
        ]

    def loops(self, places: dict[str, str]) -> list[str]:
        """The lines as loops over the histories."""
        written = Loops(self.lines, [0, *self.cuts, len(self.lines)], self.updates, self.rows, places).written()
        return [line for loop in written for line in loop]

    def _source(self) -> str:
        """The Python text of the kernel."""
        body = self.frame.body()
        numbers = [f"c{k} = c[{k}]" for k in range(self.frame.named)]
        return "\n    ".join(
            [
                f"def integrate_block({', '.join(ARGUMENTS)}):",
                TIMES,
                *numbers,
                *([] if self.in_loops else [law.clock for law in self.laws.values()]),
                "for i in range(first, last):",
                "    part = zero",
                f"    for l in range({self.block_width}):",
                *(
                    f"        {self.rows.at(name)} = ground[i + {k}, motion[l]]*scale[l]"
                    for k, name in enumerate(("low", "high"))
                ),
                "    for j in range(parts):",
                "        steps = i*parts + j",
                "        slot_0, slot_1 = (2*steps + 1) & mask, (2*steps + 2) & mask",
                *("        " + line for line in [*self.decisions, *body]),
                "        part = part + share",
                "",
            ]
        )


def solved(matrix: list[list[str]], right: list[str]) -> list[str]:
    """Lines that solve ``matrix x = right`` into ``right``, without exchange of rows: the matrix is one plus what a step can
    change."""
    size = len(right)
    if size == 2:
        (a, b), (c, d) = matrix
        x = f"solution = ({d}*{right[0]} - {b}*{right[1]})*over"
        return [
            f"over = one/({a}*{d} - {b}*{c})",
            x,
            f"{right[1]} = ({a}*{right[1]} - {c}*{right[0]})*over",
            f"{right[0]} = solution",
        ]
    lines = []
    for k in range(size):
        lines.append(f"o{k} = one/{matrix[k][k]}")
        for i in range(k + 1, size):
            lines.append(f"factor = {matrix[i][k]}*o{k}")
            lines += [f"{matrix[i][j]} = {matrix[i][j]} - factor*{matrix[k][j]}" for j in range(k + 1, size)]
            lines.append(f"{right[i]} = {right[i]} - factor*{right[k]}")
    for k in range(size - 1, -1, -1):
        terms = "".join(f" - {matrix[k][j]}*{right[j]}" for j in range(k + 1, size))
        lines.append(f"{right[k]} = ({right[k]}{terms})*o{k}")
    return lines
