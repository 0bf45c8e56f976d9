"""A damper's parts put together: one vector of parameters, one of states, one text of functions.

The text is what the kernels compile (see `dampyr.models.codegen.kernels`); ``compose("dahl + spring").source()`` shows it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

from dampyr.errors import InputError
from dampyr.models.codegen import batched_path, parallel_parts, series
from dampyr.models.codegen.formula import Formula, read
from dampyr.models.codegen.layout import SIGNATURES, Function, Layout
from dampyr.models.part import MultipliedPart, Part, part
from dampyr.units import Quantity

OF_THE_WHOLE = ("phi", "solve", *SIGNATURES)  # the functions that are written over the parts


@dataclass(frozen=True)
class Composition:
    """The parts of a damper in their order; hashable, so that what is built from it can be cached."""

    names: tuple[str, ...]

    def __reduce__(self) -> tuple[type[Composition], tuple[tuple[str, ...]]]:
        return Composition, (self.names,)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The parts."""
        plain = tuple(part(name) for name in self.names)
        by = next((p for p in plain if p.factor), None)
        if by is None:
            return plain
        whole = [p.force is None or p.static or p.needs_acceleration for p in plain]
        return tuple(
            p if apart else MultipliedPart(p.name, p.cls, p.module, by) for p, apart in zip(plain, whole, strict=True)
        )

    @cached_property
    def quantities(self) -> dict[str, Quantity]:
        """Flat parameter names such as ``dahl.kx`` -> what they mean, in the order of the parameter vector.

        In series with something that stretches, the force is proportional to no parameter.
        """
        quantities = {f"{p.name}.{key}": q for p in self.parts for key, q in p.parameters.items()}
        return {n: replace(q, linear=False) for n, q in quantities.items()} if self.in_series else quantities

    @cached_property
    def not_for_buildings(self) -> str:
        """Which parts must not stand in for a damper of a building, why, and what may; empty where all may."""
        return "; ".join(
            f"{p.name} is not for a building: {p.not_for_buildings}" for p in self.parts if p.not_for_buildings
        )

    @cached_property
    def twins(self) -> dict[str, str]:
        """Parameters that do exactly what an earlier one does -> that one, such as two dashpots: only their sum is seen."""
        first: dict[str, str] = {}
        twins = {}
        for p in self.parts:
            for key, motion in p.proportional_to.items():
                name = f"{p.name}.{key}"
                if motion in first:
                    twins[name] = first[motion]
                first.setdefault(motion, name)
        return twins

    @cached_property
    def in_series(self) -> bool:
        """Whether the parts are in series with an element that stretches under the force."""
        return self.layout.in_series

    @cached_property
    def layout(self) -> Layout:
        """Where each part's states and parameters are in the vectors."""
        return Layout(self.parts)

    @cached_property
    def parameters(self) -> tuple[str, ...]:
        """The flat parameter names."""
        return tuple(self.quantities)

    @cached_property
    def states(self) -> dict[str, tuple[float, float]]:
        """Flat state names such as ``dahl.w`` -> their bounds."""
        states = {f"{p.name}.{key}": bounds for p in self.parts for key, bounds in p.states.items()}
        added = [series.RATE] * self.layout.has_rate + [series.FORCE] * self.in_series
        return states | dict.fromkeys(added, (-math.inf, math.inf))

    @cached_property
    def within_stroke(self) -> frozenset[str]:
        """Flat names of the states that are within the stroke at the start of a record (`Part.within_stroke`)."""
        return frozenset(f"{p.name}.{key}" for p in self.parts for key in p.within_stroke)

    @cached_property
    def free_at_start(self) -> tuple[int, ...]:
        """Which states a fit finds at the start of a record: all but those that start at rest, and the rate of a stretch, which
        has none before it."""
        at_rest = {f"{p.name}.{key}" for p in self.parts if p.starts_at_rest for key in p.states}
        return tuple(k for k, name in enumerate(self.states) if name != series.RATE and name not in at_rest)

    @cached_property
    def constant(self) -> frozenset[str]:
        """Flat names of the parameters that do not follow the input (`Part.constant`)."""
        return frozenset(f"{p.name}.{key}" for p in self.parts for key in p.constant)

    @cached_property
    def n_states(self) -> int:
        """How many states there are."""
        return len(self.states)

    @cached_property
    def state0(self) -> tuple[float, ...]:
        """The states at rest."""
        return (0.0,) * self.n_states

    @cached_property
    def path0(self) -> tuple[float, ...]:
        """The states at the start of a path whose past is unknown: no memory, and no rate of a stretch so far."""
        return tuple(series.UNKNOWN if name == series.RATE else 0.0 for name in self.states)

    @cached_property
    def search_starts(self) -> int:
        """From how many points a search of the parameters begins, where nobody says it: as many as a part of it needs."""
        return max(p.search_starts for p in self.parts)

    @cached_property
    def path_only(self) -> bool:
        """Whether every state depends on the path alone."""
        return not self.in_series and all(p.path_only for p in self.parts)

    @cached_property
    def delay(self) -> int | None:
        """Index of the delay in the parameter vector, if there is one."""
        return self._index_of("delay")

    @cached_property
    def lag(self) -> int | None:
        """Index of the lag of the input in the parameter vector, if there is one."""
        return self._index_of("lag")

    def _index_of(self, role: str) -> int | None:
        names = (f"{p.name}.{getattr(p, role)}" for p in self.parts if getattr(p, role))
        return next(map(self.parameters.index, names), None)

    @cached_property
    def has_delay(self) -> bool:
        """Whether one part delays the force."""
        return self.delay is not None

    @cached_property
    def static(self) -> tuple[int, ...]:
        """Indices of the static forces in the parameter vector."""
        flat = [(p, key) for p in self.parts for key in p.parameters]
        return tuple(i for i, (p, _) in enumerate(flat) if p.static)

    @cached_property
    def linear(self) -> tuple[int, ...]:
        """Indices of the parameters to which the force is proportional."""
        return tuple(i for i, q in enumerate(self.quantities.values()) if q.linear)

    def __str__(self) -> str:
        return " + ".join(self.names)

    def formulas(self) -> list[Formula]:
        """What the parts compute, intrinsics first, each name once."""
        formulas: list[Formula] = []
        for p in self.parts:
            for formula in (p.advance, p.force_in_series if self.in_series else p.force, p.stretch):
                if formula is not None:
                    formulas += [*(read(f, n) for n, f in formula.intrinsics().items()), formula]
        _refuse_two_of_one_name([*((f.name, f.source) for f in formulas), *((name, "") for name in OF_THE_WHOLE)])
        return list({f.name: f for f in formulas}.values())

    def functions(self) -> list[Function]:
        """The functions of the whole: ``advance``, ``force`` and their derivatives."""
        return series.functions(self.layout) if self.in_series else parallel_parts.functions(self.layout)

    @cached_property
    def workspace_rows(self) -> int:
        """How many rows of workspace ``step_block`` needs (see `dampyr.models.codegen.batched_path`)."""
        return _step_block(self)[2]

    def source(self, site: int = 0) -> str:
        """The Python text of this composition's functions, their names ending in ``_site{site}``."""
        texts = {f.name: f.source for f in self.formulas()}
        for p in self.parts:
            texts.update(parallel_parts.derivatives(p))
            texts.update(series.derivatives(p) if self.in_series else {})
        called, step_block, _ = _step_block(self)
        whole = [f.python(f"_site{site}") for f in self.functions()]
        return "\n\n".join([*texts.values(), *whole, *called, step_block.python(f"_site{site}")])


@lru_cache(maxsize=256)  # compositions: writing one takes as long as a fit, and processes send equal ones
def _step_block(composition: Composition) -> tuple[list[str], Function, int]:
    return batched_path.write_step_block(composition.layout)


def compose(names: str | Iterable[str]) -> Composition:
    """The composition of parts named as ``"dahl + spring"`` or as a sequence of names."""
    return _composed(tuple(n.strip() for n in names.split("+")) if isinstance(names, str) else tuple(names))


@lru_cache(maxsize=256)  # one object for the same parts, so that what follows from them is worked out once
def _composed(listed: tuple[str, ...]) -> Composition:
    for name in listed:
        part(name)
    twice = sorted({n for n in listed if listed.count(n) > 1})
    if twice:
        raise InputError(f"the part {twice[0]!r} is given twice in {' + '.join(listed)}; name each part once")
    composition = Composition(listed)
    if not any(p.force for p in composition.parts):
        raise InputError(f"{composition} makes no force; add a part that does, such as dahl")
    if composition.in_series and all(p.needs_acceleration for p in composition.parts if p.force):
        raise InputError(f"{composition} has nothing that stretches it; add a part such as dahl")
    by = next((p.name for p in composition.parts if p.factor), None)
    if composition.in_series and by:
        raise InputError(
            f"{by} cannot stand with an element in series, as {composition} has: behind a stretch a force that jumps with "
            "the direction has several roots; leave one of the two out"
        )
    return composition


@lru_cache(maxsize=256)  # each driver asks for it: a sum of products, a force along a path, a building
def text_of(compositions: tuple[Composition, ...]) -> str:
    """The text of several compositions with the functions that choose among them by ``site``."""
    texts = [c.source(site) for site, c in enumerate(compositions)]
    for name, arguments in SIGNATURES.items():
        last = len(compositions) - 1
        lines = [f"if site == {k}: return {name}_site{k}({arguments})" for k in range(last)]
        texts.append(
            "\n    ".join([f"def {name}(site, {arguments}):", *lines, f"return {name}_site{last}({arguments})"])
        )
    text = "\n\n".join(texts)
    functions = re.findall(r"^def (\w+)(.*?)(?=^def |\Z)", text, flags=re.MULTILINE | re.DOTALL)
    _refuse_two_of_one_name((name, rest.strip()) for name, rest in functions)
    return text


def _refuse_two_of_one_name(functions: Iterable[tuple[str, str]]) -> None:
    """All functions of the parts stand in one text, where a later one would take the place of an earlier one of its name."""
    texts: dict[str, str] = {}
    for name, text in functions:
        if texts.setdefault(name, text) != text:
            raise InputError(
                f"two functions that the damper's parts call are named {name!r} and compute different things; "
                f"give the one in the file of your part another name"
            )
