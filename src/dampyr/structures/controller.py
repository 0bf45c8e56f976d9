"""A control law at its place in a building: what it measures as rows, its filter as matrices, its formulas as text.

`design_controller` works it out once; the kernels of `respond` and `ensemble` take its arrays, and `ControllerRun` is the same
in plain Python, sample by sample.
"""

from __future__ import annotations

import ast
import re
import sys
from collections import deque
from dataclasses import dataclass, fields, replace
from functools import cached_property, lru_cache
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr import registry
from dampyr.errors import InputError, choose_from
from dampyr.models.codegen.formula import Formula, read
from dampyr.structures.building import Building
from dampyr.structures.law_form import LawDesign
from dampyr.structures.sensor_noise import counter, noise
from dampyr.structures.sensors import MEASURES, VECTORS, DamperPlace

Array = NDArray[np.float64]
REGISTRY = "dampyr.structures.control"
FOLLOWED = ("stroke", "rate")  # what the model of the damper follows in a law that asks for a force
MAX_ARGUMENTS = 8  # of what a law's formulas take at a sample: every corner of them is looked at (`take_decision`)


def module_of(law: Any) -> ModuleType:
    """The file of a law or of its class."""
    return sys.modules[(law if isinstance(law, type) else type(law)).__module__]


def asks_force(law: Any) -> bool:
    """Whether a law, or one of a class, decides on a force and leaves the input to the damper's inverse."""
    return getattr(module_of(law), "ASKS", "input") == "force"


def setting_names(cls: Any) -> list[str]:
    """The settings of a law that its formulas may name."""
    return [f.name for f in fields(cls) if f.name not in ("sensors", "seed") and not isinstance(f.default, tuple)]


@dataclass(frozen=True)
class LawFormulas:
    """The formulas of a law's class: ``arguments`` are what they take at a sample, the states last."""

    decide: Formula
    update: Formula | None
    arguments: tuple[str, ...]
    states: tuple[float, ...]  # their values at the start
    asks_force: bool = False

    @property
    def stroke_and_rate(self) -> tuple[int, int]:
        """Where these two stand among the arguments of a law that asks for a force."""
        return self.arguments.index("stroke"), self.arguments.index("rate")

    @property
    def signals(self) -> tuple[str, ...]:
        """The arguments that are signals or measures."""
        return self.arguments[: len(self.arguments) - len(self.states)]


@lru_cache(maxsize=128)
def formulas_of(cls: Any) -> LawFormulas:
    """The formulas in the file of a law's class; InputError for what is no formula."""
    module = module_of(cls)
    states: dict[str, float] = getattr(module, "STATES", {})
    texts = [read(module.decide, "decide"), *([read(module.update, "update")] if states else [])]
    for text in texts:
        _check_expression(cls, text)
    known = (*setting_names(cls), *states)
    asks = asks_force(cls)
    named = [name for text in texts for name in text.arguments if name not in known]
    signals = tuple(dict.fromkeys([*named, *(FOLLOWED if asks else ())]))
    arguments = (*signals, *states)
    if len(arguments) > MAX_ARGUMENTS:
        raise InputError(
            f"{cls.__name__} decides by {len(arguments)} quantities ({', '.join(arguments)}); {MAX_ARGUMENTS} are allowed: "
            "let its design sum up what is linear"
        )
    return LawFormulas(texts[0], texts[1] if states else None, arguments, tuple(map(float, states.values())), asks)


def _check_expression(cls: type, formula: Formula) -> None:
    if len(formula.tree.body) != 1 or not isinstance(formula.tree.body[0], ast.Return):
        raise InputError(
            f"{formula.name} of {cls.__name__} must be one expression, as it is written into kernels: return it at once, and "
            "write a choice as in `high if a > b else low`"
        )


@dataclass(frozen=True, eq=False)
class Controller:
    """A law at its place: with w what a step knows (see `dampyr.structures.sensors`) and y what the sensors give,

    y of ``rows`` (Y, 2n + 2 + N) w; s = ``of_memory`` (S, X) x + ``of_measured`` (S, Y) y; x' = ``F`` x + ``G`` y.
    ``faults`` (Y, 4) are noise, bias, quantum and range of each y, ``delays`` (Y,) samples; ``channels`` (Y,) are their numbers
    among all that the law measures, by which their noise is drawn.
    """

    law: Any
    formulas: LawFormulas
    rows: Array
    faults: Array
    delays: NDArray[np.int64]
    channels: NDArray[np.int64]
    of_memory: Array
    of_measured: Array
    F: Array
    G: Array
    sizes: tuple[tuple[str, int], ...] = ()  # of each measure how many rows, where they are not summed up

    @cached_property
    def err(self) -> NDArray[np.bool_]:
        """Which sensors (Y,) give something else than what they measure."""
        wrong = np.any(self.faults[:, :3], axis=1) | np.isfinite(self.faults[:, 3]) | (self.delays > 0)
        return np.asarray(wrong, dtype=np.bool_)

    @property
    def is_ideal(self) -> bool:
        """Whether all of its sensors give what they measure."""
        return not self.err.any()

    @property
    def module(self) -> ModuleType:
        """The file of the law."""
        return module_of(self.law)

    @cached_property
    def settings(self) -> Array:
        """The numbers of the law that its formulas may name, in the order of `setting_names`."""
        return np.array([getattr(self.law, name) for name in setting_names(type(self.law))], dtype=float)


def design_controller(
    law: Any, building: Building, connections: Array, d: int, summed: bool = True, loads: Any = None
) -> Controller:
    """The controller of damper ``d`` of those at ``connections`` (N, n); InputError where the law's design does not fit.

    What is linear in the measures whose sensors are ideal is ``summed`` up beforehand. ``loads`` are those of the response
    (`dampyr.structures.time_history.loading.Loads`), of which sensors see what they do, and the design knows nothing."""
    cls: Any = type(law)
    place, module = DamperPlace(building, connections, d, loads), module_of(law)
    formulas: LawFormulas = formulas_of(cls)
    names = _measures(law)
    blocks = [MEASURES[name].rows(place) for name in names]
    rows = np.vstack([np.zeros((0, place.width)), *blocks])
    first = dict(zip(names, np.cumsum([0, *map(len, blocks)]).tolist(), strict=False))
    design = module.design(law, building, place.row) if hasattr(module, "design") else LawDesign({})
    F = np.asarray(design.F, dtype=float)
    G = np.zeros((len(F), len(rows))) if design.G is None else np.asarray(design.G, dtype=float)
    memory = len(F)
    if F.shape != (memory, memory) or G.shape != (memory, len(rows)) or not np.all(np.isfinite([*F.flat, *G.flat])):
        raise InputError(
            f"the design of {cls.__name__} has F {F.shape} and G {G.shape}; they must be finite, ({memory}, {memory}) and "
            f"({memory}, {len(rows)})"
        )
    signals = [_signal(cls, name, design, first, memory, len(rows)) for name in formulas.signals]
    table = np.array(signals).reshape(len(signals), memory + len(rows))
    sensors = [law.sensor_of(name) for name, block in zip(names, blocks, strict=True) for _ in block]
    faults = np.array([(s.noise, s.bias, s.quantum, s.range) for s in sensors]).reshape(len(rows), 4)
    delays = np.array([s.delay for s in sensors], dtype=np.int64)
    sizes = tuple((name, len(block)) for name, block in zip(names, blocks, strict=True))
    channels = np.arange(len(rows))
    controller = Controller(
        law, formulas, rows, faults, delays, channels, table[:, :memory], table[:, memory:], F, G, sizes
    )
    return _summed_up(controller) if summed else controller


def _summed_up(controller: Controller) -> Controller:
    """The same with what is linear in ideally measured quantities summed up: after the sensors that err comes one row for each
    signal and one for each number of the memory, those that are not 0."""
    count, memory, err = len(controller.of_measured), len(controller.F), controller.err
    sums = np.vstack([part[:, ~err] @ controller.rows[~err] for part in (controller.of_measured, controller.G)])
    kept, units = np.any(sums != 0.0, axis=1), np.eye(count + memory)
    size = int(kept.sum())
    return replace(
        controller,
        rows=np.vstack([controller.rows[err], sums[kept]]),
        faults=np.vstack([controller.faults[err], np.tile([0.0, 0.0, 0.0, np.inf], (size, 1))]),
        delays=np.append(controller.delays[err], np.zeros(size, dtype=np.int64)),
        channels=np.append(controller.channels[err], np.zeros(size, dtype=np.int64)),
        of_measured=np.hstack([controller.of_measured[:, err], units[:count, kept]]),
        G=np.hstack([controller.G[:, err], units[count:, kept]]),
        sizes=(),
    )


def _measures(law: Any) -> tuple[str, ...]:
    """What a law measures, checked; its sensors must be of these."""
    module = module_of(law)
    names: tuple[str, ...] = tuple(getattr(module, "MEASURES", ()))
    cls = type(law).__name__
    for name in names:
        if name not in MEASURES:
            raise InputError(f"{cls} measures {name!r}, which is no measure; {choose_from(name, list(MEASURES))}")
    missing = [name for name in FOLLOWED if name not in names]
    if missing and asks_force(law):
        raise InputError(
            f"{cls} asks for a force and does not measure {missing[0]}; MEASURES must have {', '.join(FOLLOWED)}"
        )
    for name, _ in law.sensors:
        if name not in names:
            raise InputError(
                f"sensors has one of {name!r}, which {cls} does not measure; it measures {', '.join(names) or 'nothing'}"
            )
    return names


def _signal(cls: type, name: str, design: LawDesign, first: dict[str, int], memory: int, measured: int) -> Array:
    """The row of a signal over memory and measures: of the design, or a measure of one number."""
    if name in design.signals:
        row = np.asarray(design.signals[name], dtype=float)
        if row.shape != (memory + measured,) or not np.all(np.isfinite(row)):
            raise InputError(
                f"the signal {name!r} of {cls.__name__} has shape {row.shape}; it must be {memory + measured} finite numbers: "
                f"{memory} of its memory, {measured} of what it measures"
            )
        return row
    if name in first and name not in VECTORS:
        row = np.zeros(memory + measured)
        row[memory + first[name]] = 1.0
        return row
    scalars = [measure for measure in first if measure not in VECTORS]
    allowed = [*design.signals, *scalars, *getattr(module_of(cls), "STATES", {}), *setting_names(cls)]
    raise InputError(f"decide of {cls.__name__} asks for {name!r}; it may use {', '.join(allowed)}")


class ControllerRun:
    """A controller sample by sample, in plain Python: as the kernels compute it, for other programs and for checks."""

    def __init__(self, controller: Controller, site: int = 0, inverse: Any = None) -> None:
        """``inverse`` finds the input of a law that asks for a force (`dampyr.structures.wanted_force.FollowedInverse`)."""
        if controller.formulas.asks_force and inverse is None:
            raise ValueError(f"{type(controller.law).__name__} asks for a force; give the inverse of its damper")
        self.inverse, self.reason = inverse, ""
        self.controller, self.site, self.sample = controller, site, 0
        self.memory = np.zeros(len(controller.F))
        self.states = np.array(controller.formulas.states)
        depth = int(controller.delays.max(initial=0)) + 1
        self.past: deque[Array] = deque([np.zeros(len(controller.rows))] * depth, maxlen=depth)
        names: dict[str, Any] = {name: getattr(np, name) for name in ("exp", "sqrt", "tanh", "copysign")}
        exec(compile(law_source((controller.law,))[0], "<laws>", "exec"), names)
        self.functions = names
        self.kind = law_source((controller.law,))[1][0]

    def measured(self, known: Array) -> Array:
        """What the sensors give of w (2n + 2 + N,) at this sample."""
        self.past.append(self.controller.rows @ known)
        y = np.array([self.past[-1 - late][c] for c, late in enumerate(self.controller.delays)])
        for c, (spread, bias, quantum, limit) in enumerate(self.controller.faults):
            if spread > 0.0:
                number = int(self.controller.channels[c])
                y[c] += (
                    spread * noise(self.controller.law.seed, counter(self.sample, self.site, number // 2))[number % 2]
                )
            y[c] = min(max(y[c] + bias, -limit), limit)
            y[c] = quantum * np.floor(y[c] / quantum + 0.5) if quantum > 0.0 else y[c]
        return y

    def decide(self, known: Array) -> float:
        """The input [V or A] from this sample on, of w (2n + 2 + N,)."""
        return self.decide_on(self.measured(known))

    def decide_on(self, y: Array) -> float:
        """The same of what the sensors give (Y,)."""
        controller = self.controller
        arguments = np.concatenate([controller.of_memory @ self.memory + controller.of_measured @ y, self.states])
        self.functions["remember"](self.kind, arguments, controller.settings)
        self.states = arguments[len(controller.formulas.signals) :].copy()
        u = float(self.functions["decide"](self.kind, arguments, controller.settings))
        if controller.formulas.asks_force:
            found = self.inverse.find(*arguments[list(controller.formulas.stroke_and_rate)], u)
            u, self.reason = found.input, found.reason
        self.memory = controller.F @ self.memory + controller.G @ y
        self.sample += 1
        return u


def law_source(laws: tuple[Any, ...]) -> tuple[str, list[int]]:
    """The Python text of ``decide(kind, s, p)`` and ``remember(kind, s, p)``, which choose among the laws, and the kind of
    each; None stands for no law. s are the arguments of `LawFormulas`, p the settings; ``remember`` updates the states in s.

    All registered laws are in it, so that what is compiled once serves every one of them.
    """
    classes = _registered()
    classes += tuple(c for c in dict.fromkeys(type(law) for law in laws if law) if c not in classes)
    return _text(classes), [classes.index(type(law)) if law else -1 for law in laws]


@lru_cache(maxsize=1)
def _registered() -> tuple[type, ...]:
    """The classes of the registered laws."""
    return tuple(class_in(module) for _, module in registry.members(REGISTRY))


def class_in(module: ModuleType) -> type:
    """The class of a law in its file: the one that is called as the file."""
    wanted = module.__name__.rpartition(".")[2].replace("_", "")
    return next(cls for name, cls in vars(module).items() if isinstance(cls, type) and name.lower() == wanted)


def law_texts(cls: type, prefix: str) -> list[str]:
    """The formulas of a law as the functions ``{prefix}_decide`` and ``{prefix}_update``, with what they call.

    The prefix stands before the names of all of them, as the files of two laws may each have a function of one name.
    """
    formulas, texts = formulas_of(cls), dict[str, str]()
    for formula in (formulas.decide, formulas.update):
        if formula is not None:
            functions = formula.intrinsics() | {formula.name: getattr(module_of(cls), formula.name)}
            for name, function in functions.items():
                names = "|".join(map(re.escape, functions))
                texts[name] = re.sub(rf"\b({names})\(", rf"{prefix}_\1(", read(function, name).source)
    return list(texts.values())


@lru_cache(maxsize=16)
def _text(classes: tuple[type, ...]) -> str:
    texts: list[str] = []
    decisions: list[str] = []
    updates: list[str] = []
    for kind, cls in enumerate(classes):
        formulas = formulas_of(cls)
        texts += law_texts(cls, f"law_{kind}")
        for formula, lines in ((formulas.decide, decisions), (formulas.update, updates)):
            if formula is None:
                continue
            call = f"law_{kind}_{formula.name}({', '.join(_places(cls, formulas, formula))})"
            first = len(formulas.signals)
            states = ", ".join(f"s[{first + k}]" for k in range(len(formulas.states)))
            lines.append(f"if kind == {kind}: " + (f"return {call}" if lines is decisions else f"{states} = {call}"))
    bodies = {"decide": [*decisions, "return 0.0"], "remember": [*updates, "return"]}
    heads = ["\n    ".join([f"def {name}(kind, s, p):", *lines]) for name, lines in bodies.items()]
    return "\n\n".join([*texts, *heads])


def _places(cls: type, formulas: LawFormulas, formula: Formula) -> list[str]:
    known = setting_names(cls)
    return [
        f"p[{known.index(name)}]" if name in known else f"s[{formulas.arguments.index(name)}]"
        for name in formula.arguments
    ]
