"""Control laws in a block of histories: what a law measures, decides and remembers, and the damper's parameters behind it.

Before the step at which a law decides come its lines, in a loop of their own over the histories; where its coil follows with a
lag, each step has the parameters at a quarter, a half, three quarters and its end. Nothing branches but the question whether it
is time, which is the same for all histories. The names in the text, of site d:

======================= ============================================================================================
``V``                   velocity of the ground
``law0_m1``             what is measured; ``law0_y1`` what the sensor gives of it, ``law0_late1_2`` two samples ago
``law0_s1``             arguments of the law's formulas, the states last; ``law0_x1`` memory of its filter
``law0_command``        the latest decision, ``law0_least`` and ``law0_most`` the extremes, ``law0_level`` the input at the coil
``q0_1_2_3``            coefficient of the power 3 in piece 2 of the law of parameter 1, ``knot0_1_2`` where that piece begins
``p0_1a`` ... ``p0_1d`` parameters at the four instants of a step
======================= ============================================================================================
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.models.codegen.formula import Formula
from dampyr.models.laws import polynomial_table
from dampyr.structures.batch.damper_step import force_now
from dampyr.structures.batch.lane_inverse import SearchSizes, search_numbers
from dampyr.structures.batch.loop_fission import Loops
from dampyr.structures.control_laws import check_decided
from dampyr.structures.controller import Controller, law_texts, setting_names
from dampyr.structures.sensor_noise import counter

Array = NDArray[np.float64]
MAX_DELAY = 8  # samples of a sensor: each is a row of the block
EXTREMES = {"least": "min", "most": "max"}  # of the decisions, by which one beyond the law's range is found
JUMPING = ("acceleration", "force")  # peaks that a jump of the input may raise at once


@dataclass(frozen=True, eq=False)
class SiteControl:
    """The law of one site: its controller, with ``rows`` over the kernel's coordinates; ``every`` so many steps it decides; the
    ``lag`` of its coil [s]; ``pieces``, of each parameter's law how many pieces it has, and its degree."""

    controller: Controller
    rows: Array
    every: int
    lag: float
    pieces: tuple[tuple[int, int], ...]
    search: SearchSizes | None = None  # of a law that asks for a force
    left: float = 0.0  # see `dampyr.structures.batch.lane_inverse.left_after_period`


def pieces_of(damper: Any) -> tuple[tuple[int, int], ...]:
    """Of each parameter's law, how many pieces it has and its degree; (0, 0) for what is constant, which needs no look-up."""
    knots, coefficients = polynomial_table(damper, static=False)
    return tuple(
        (int(np.sum(np.isfinite(at)) or 1), _degree(c)) if np.any(c[1:]) or np.any(c[:, 1:]) else (0, 0)
        for at, c in zip(knots, coefficients, strict=True)
    )


def _degree(coefficients: Array) -> int:
    return int(np.max(np.flatnonzero(np.any(coefficients != 0.0, axis=0)), initial=0))


def values_of(damper: Any, values: Array, law: Any, pieces: tuple[tuple[int, int], ...]) -> Array:
    """The numbers of a site under a law, in the order of `LawStep.value_rows`."""
    knots, coefficients = polynomial_table(damper, static=False)
    more = [
        number
        for k, (count, degree) in enumerate(pieces)
        for piece in range(count)
        for number in (knots[k, piece] if np.isfinite(knots[k, piece]) else 0.0, *coefficients[k, piece, : degree + 1])
    ]
    return np.array([*values, *more, float(law.seed), *search_numbers(law, damper)])


class LawStep:
    """Writes the lines of one site's law into a kernel ``text`` (`dampyr.structures.batch.assemble.KernelText`)."""

    def __init__(self, text: Any, d: int, control: SiteControl) -> None:
        self.text, self.d, self.control, self.controller = text, d, control, control.controller
        self.name = f"law{d}"
        self.cls = type(control.controller.law)
        self.prefix = f"{self.name}_{self.cls.__name__}"
        self.formulas = control.controller.formulas
        self.every = f"{self.name}_every"
        # a number of the engine and not of the text: one kernel serves every step and period
        self.clock = f"{self.every} = floor({text.number(float(control.every))} + half)"

    @property
    def functions(self) -> list[str]:
        """The texts of the formulas, and of what they call."""
        return law_texts(self.cls, self.prefix)

    @property
    def value_rows(self) -> list[str]:
        """The rows that hold the numbers of the damper and the seed."""
        d, pieces = self.d, self.control.pieces
        table = [
            name
            for k, (count, degree) in enumerate(pieces)
            for piece in range(count)
            for name in (f"knot{d}_{k}_{piece}", *(f"q{d}_{k}_{piece}_{j}" for j in range(degree + 1)))
        ]
        return [*(f"p{d}_{k}" for k in range(len(pieces))), *table, f"{self.name}_seed", *self.search_rows]

    @property
    def search_rows(self) -> list[str]:
        """The rows of the search of a law that asks for a force."""
        return [f"{self.name}_i{k}" for k in range(self.control.search.rows if self.control.search else 0)]

    @property
    def starts(self) -> dict[str, float]:
        """What rows hold at the start, where it is not 0."""
        states = {f"{self.name}_s{j}": value for j, value in self._states(self.formulas.states)}
        low, high = float(self.controller.law.low), float(self.controller.law.high)
        at_low = dict.fromkeys((f"{self.name}_command", f"{self.name}_level", f"{self.name}_most"), low)
        return at_low | {f"{self.name}_least": high} | states

    def _states(self, values: tuple[float, ...]) -> list[tuple[int, float]]:
        return list(enumerate(values, start=len(self.formulas.signals)))

    def check(self, final_block: Array) -> None:
        """Raise InputError where the law decided on an input outside its own bounds."""
        least, most = (final_block[self.text.rows[f"{self.name}_{end}"]] for end in EXTREMES)
        decided = np.isfinite(least) & np.isfinite(most)  # a history that grew without bound decided on nothing
        if decided.any():
            check_decided(
                self.controller.law, f"of damper {self.d + 1}", float(least[decided].min()), float(most[decided].max())
            )

    @property
    def needs_ground_velocity(self) -> bool:
        """Whether the ground's velocity is among what the law measures."""
        return bool(np.any(self.control.rows[:, self.text.size] != 0.0))

    def parameters(self, at: str, level: str) -> list[str]:
        """Lines that set the parameters that follow the input at the input ``level``; their names end in ``at``."""
        lines = []
        for k, (count, degree) in enumerate(self.control.pieces):
            if count:
                value = self._piece(k, 0, degree, level)
                for piece in range(1, count):
                    value = f"({self._piece(k, piece, degree, level)}) if {level} >= knot{self.d}_{k}_{piece} else ({value})"
                lines.append(f"p{self.d}_{k}{at} = {value}")
        return lines

    def _piece(self, k: int, piece: int, degree: int, level: str) -> str:
        name, x = f"q{self.d}_{k}_{piece}", f"({level} - knot{self.d}_{k}_{piece})"
        text = f"{name}_{degree}"
        for j in range(degree - 1, -1, -1):
            text = f"({text})*{x} + {name}_{j}"
        return text

    def value(self, k: int, at: str) -> str:
        """The name of a parameter at an instant of the step, a, b, c or d."""
        return f"p{self.d}_{k}{at if self.control.lag > 0.0 and self.control.pieces[k][0] else ''}"

    def coil(self) -> list[str]:
        """Lines at the start of each step: the coil follows its command, and the parameters the coil."""
        if self.control.lag == 0.0:
            return []
        command, gap = f"{self.name}_command", f"{self.name}_gap"
        lines = [f"{gap} = {self.name}_level - {command}"]
        for k, at in enumerate("abcd", start=1):
            share = self.text.number(float(np.exp(-0.25 * k * self.text.step.h / self.control.lag)))
            lines += [f"{self.name}_at_{at} = {command} + {gap}*{share}", *self.parameters(at, f"{self.name}_at_{at}")]
        self.text.carry(f"{self.name}_level", f"{self.name}_at_d")
        return lines

    @property
    def jumps(self) -> bool:
        """Whether the force jumps where the law decides."""
        return self.control.lag == 0.0 and not self.text.compositions[self.d].in_series

    def jump(self) -> tuple[list[str], dict[str, str]]:
        """Lines with the force under the input that was just decided on, and what each row is to hold after them."""
        text, d, composition = self.text, self.d, self.text.compositions[self.d]
        states = [f"s{d}_{k}" for k in range(composition.n_states)]
        values = [f"p{d}_{k}" for k in range(len(composition.parameters))]
        motion = {"x": text.starts[d], "v": text.starts[text.sites + d], "a": "zero"}
        lines = [
            f"force_now{d} = {force_now(composition, f'_now{d}', states, values, motion)}",
            f"middle{d} = mf{d} + force_now{d} - f{d}",
        ]
        return lines, {f"f{d}": f"force_now{d}", f"mf{d}": f"middle{d}"}

    def decision(self) -> list[str]:
        """The loop in which the law measures and decides, and what it remembers."""
        text = self.text
        lines = ["ground_rise = high - low", "a0 = low + ground_rise*part"]
        known = [*(f"z{k}" for k in range(text.size)), "V", "a0", *(f"f{d}" for d in range(text.sites))]
        lines += [
            f"{name} = {text.sum(row, known)}" for name, row in zip(self.measured, self.control.rows, strict=True)
        ]
        more, updates = self.decide()
        return [f"if steps % {self.every} == 0:", *_loop(text, lines + more, updates)]

    @property
    def measured(self) -> list[str]:
        """The names of what the law measures."""
        return [f"{self.name}_m{c}" for c in range(len(self.control.rows))]

    def decide(self) -> tuple[list[str], dict[str, str]]:
        """Lines in which the law decides on what it measured, and what each row is to hold after them."""
        text, name, controller = self.text, self.name, self.controller
        lines, updates, measured = list[str](), dict[str, str](), self.measured
        if not controller.is_ideal:
            measured = [self._sensed(c, lines, updates) for c in range(len(measured))]
        memory = [f"{name}_x{k}" for k in range(len(controller.F))]
        for j, row in enumerate(np.hstack([controller.of_memory, controller.of_measured])):
            lines.append(f"{name}_s{j} = {text.sum(row, [*memory, *measured])}")
        states = [f"{name}_s{j}" for j, _ in self._states(self.formulas.states)]
        if self.formulas.update is not None:
            lines.append(f"{', '.join(f'{state}n' for state in states)} = {self._call(self.formulas.update, '')}")
            updates |= {state: f"{state}n" for state in states}
        decided = self._call(self.formulas.decide, "n")
        if self.control.search is not None:
            lines.append(f"{name}_wanted = {decided}")
            decided = self._input_of_force(f"{name}_wanted", self.control.search)
        lines.append(f"{name}_decided = {decided}")
        lines += [f"{name}_{end}n = {by}({name}_{end}, {name}_decided)" for end, by in EXTREMES.items()]
        updates |= {f"{name}_command": f"{name}_decided"} | {f"{name}_{end}": f"{name}_{end}n" for end in EXTREMES}
        for k, row in enumerate(np.hstack([controller.F, controller.G])):
            lines.append(f"{name}_x{k}n = {text.sum(row, [*memory, *measured])}")
            updates[f"{name}_x{k}"] = f"{name}_x{k}n"
        if self.control.lag == 0.0:
            lines += self.parameters("now", f"{name}_decided")
            updates |= {
                f"p{self.d}_{k}": f"p{self.d}_{k}now" for k, (count, _) in enumerate(self.control.pieces) if count
            }
        return lines, updates

    @property
    def search_function(self) -> str:
        """The name of the search for the input of a force."""
        return f"{self.name}_search"

    def _input_of_force(self, wanted: str, sizes: SearchSizes) -> str:
        """A call of `dampyr.structures.batch.lane_inverse.command_of`."""
        text, law, wide = self.text, self.controller.law, self.text.block_width
        first, second, *_ = [text.rows[row] for row in self.search_rows]
        at = text.own_rows.run(f"~{self.name}_work", range(-(-sizes.workspace // wide)))
        place = f"{first} + site" if text.in_loops else str(first)
        x, v = (f"{self.name}_s{j}" for j in self.formulas.stroke_and_rate)
        numbers = (text.number(value) for value in (law.low, law.high, self.control.left, law.period))
        return (
            f"{self.search_function}(b, l, {wide}, {place}, {second - first}, {at * wide}, "
            f"{', '.join(map(str, sizes[:-1]))}, {sizes.rows}, steps, {wanted}, {x}, {v}, {self.name}_command, "
            f"{', '.join(numbers)})"
        )

    def _sensed(self, c: int, lines: list[str], updates: dict[str, str]) -> str:
        """The name of what the sensor of channel c gives, whose lines are added."""
        text, name = self.text, self.name
        noise, bias, quantum, limit = self.controller.faults[c]
        value, late = f"{name}_m{c}", int(self.controller.delays[c])
        for k in range(late, 0, -1):
            updates[f"{name}_late{c}_{k}"] = f"{name}_late{c}_{k - 1}" if k > 1 else value
        value = f"{name}_late{c}_{late}" if late else value
        if noise > 0.0:
            channel = int(self.controller.channels[c])
            pair = channel // 2
            drawn = f"{name}_n{2 * pair}, {name}_n{2 * pair + 1} = normal_pair("
            if not any(line.startswith(drawn) for line in lines):
                place = text.whole_number(counter(0, self.d, pair))
                first = f"(steps//{self.every})*{counter(1, 0, 0)} + {place}"
                lines.append(f"{drawn}{name}_seed, {first})")
            value += f" + {text.number(noise)}*{name}_n{channel}"
        value += f" + {text.number(bias)}" if bias else ""
        if np.isfinite(limit):
            value = f"min(max({value}, {text.number(-limit)}), {text.number(limit)})"
        if quantum > 0.0:
            value = f"rounded(({value})/{text.number(quantum)})*{text.number(quantum)}"
        lines.append(f"{name}_y{c} = {value}")
        return f"{name}_y{c}"

    def _call(self, formula: Formula, of_states: str) -> str:
        """A formula of the law over the arguments; of the states those that end in ``of_states``."""
        settings, arguments = setting_names(self.cls), self.formulas.arguments
        first = len(self.formulas.signals)
        texts = []
        for argument in formula.arguments:
            if argument in settings:
                texts.append(self.text.number(getattr(self.controller.law, argument)))
            else:
                j = arguments.index(argument)
                texts.append(f"{self.name}_s{j}{of_states if j >= first else ''}")
        return f"{self.prefix}_{formula.name}({', '.join(texts)})"


def jumps(text: Any, laws: dict[int, LawStep]) -> list[str]:
    """The loop in which forces jump with the input of coils without a lag, and the peaks that they raise at once."""
    jumping = [law for law in laws.values() if law.jumps]
    if not jumping:
        return []
    lines, updates = ["ground_rise = high - low", "a0 = low + ground_rise*part"], dict[str, str]()
    for law in jumping:
        some, more = law.jump()
        lines += some
        updates |= more
    known = [f"z{k}" for k in range(text.size)] + [updates.get(f"f{d}", f"f{d}") for d in range(text.sites)] + ["a0"]
    raised = set()
    for quantity, i, row in text.outputs():
        peak = text.peaks[quantity, i]
        if quantity in JUMPING and peak not in raised:
            raised.add(peak)
            lines.append(f"{peak}now = max({peak}, abs({text.sum(row, known)}))")
            updates[peak] = f"{peak}now"
    times = " or ".join(sorted({f"steps % {law.every} == 0" for law in jumping}))
    return [f"if {times}:", *_loop(text, lines, updates)]


def ground_velocity(text: Any) -> list[str]:
    """The loop that carries the ground's velocity over a step."""
    return _loop(text, ["V_now = V + dt*(two*low + (high - low)*(two*part + share))"], {"V": "V_now"}, 0)


def _loop(text: Any, lines: list[str], updates: dict[str, str], indent: int = 4) -> list[str]:
    for row in updates:
        text.rows[row]
    [loop] = Loops(lines, [0, len(lines)], updates, text.rows).written()
    return [" " * indent + line for line in loop]
