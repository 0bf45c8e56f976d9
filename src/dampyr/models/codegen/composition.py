"""A damper's parts put together: one vector of parameters, one of states, one text of functions.

The text is what the kernels compile (see `dampyr.models.codegen.kernels`); ``compose("dahl + spring").source()`` shows it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from dampyr.errors import InputError
from dampyr.models.codegen import batched_path, series
from dampyr.models.codegen.formula import Formula, partials_of, read, tangent, tangents
from dampyr.models.part import Part, part
from dampyr.units import Quantity


@dataclass(frozen=True)
class Composition:
    """The parts of a damper in their order; hashable, so that what is built from it can be kept."""

    names: tuple[str, ...]

    def __reduce__(self) -> tuple[type[Composition], tuple[tuple[str, ...]]]:
        return Composition, (self.names,)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The parts."""
        return tuple(part(name) for name in self.names)

    @cached_property
    def quantities(self) -> dict[str, Quantity]:
        """Flat parameter names such as ``dahl.kx`` -> what they mean, in the order of the parameter vector.

        In series with something that stretches, the force is proportional to no parameter.
        """
        quantities = {f"{p.name}.{key}": q for p in self.parts for key, q in p.parameters.items()}
        return {n: replace(q, linear=False) for n, q in quantities.items()} if self.in_series else quantities

    @cached_property
    def in_series(self) -> bool:
        """Whether the parts stand in series with something that stretches under the force."""
        return any(p.stretch for p in self.parts)

    @cached_property
    def keeps_rate(self) -> bool:
        """Whether the rate of the stretch in series is a state, because a part's states follow its velocity."""
        return self.in_series and any(series.follows_velocity(p) for p in self.parts)

    @cached_property
    def parameters(self) -> tuple[str, ...]:
        """The flat parameter names."""
        return tuple(self.quantities)

    @cached_property
    def states(self) -> dict[str, tuple[float, float]]:
        """Flat state names such as ``dahl.w`` -> their bounds."""
        states = {f"{p.name}.{key}": bounds for p in self.parts for key, bounds in p.states.items()}
        added = [series.RATE] * self.keeps_rate + [series.FORCE] * self.in_series
        return states | dict.fromkeys(added, (-math.inf, math.inf))

    @cached_property
    def free_at_start(self) -> tuple[int, ...]:
        """Which states a fit finds at the start of a record: all but the rate of a stretch, which has none before it."""
        return tuple(k for k, name in enumerate(self.states) if name != series.RATE)

    @property
    def n_states(self) -> int:
        """How many states there are."""
        return len(self.states)

    @property
    def state0(self) -> tuple[float, ...]:
        """The states at rest."""
        return (0.0,) * self.n_states

    @property
    def path0(self) -> tuple[float, ...]:
        """The states at the start of a path whose past is unknown: no memory, and no rate of a stretch so far."""
        return tuple(series.UNKNOWN if name == series.RATE else 0.0 for name in self.states)

    @property
    def path_only(self) -> bool:
        """Whether every state depends on the path alone."""
        return not self.in_series and all(p.path_only for p in self.parts)

    @cached_property
    def delay(self) -> int | None:
        """Where in the parameter vector the delay stands, if there is one."""
        for p in self.parts:
            if p.delay:
                return self.parameters.index(f"{p.name}.{p.delay}")
        return None

    @cached_property
    def lag(self) -> int | None:
        """Where in the parameter vector the lag of the input stands, if there is one."""
        for p in self.parts:
            if p.lag:
                return self.parameters.index(f"{p.name}.{p.lag}")
        return None

    @property
    def has_delay(self) -> bool:
        """Whether one part delays the force."""
        return self.delay is not None

    @cached_property
    def static(self) -> tuple[int, ...]:
        """Where in the parameter vector the static forces stand."""
        flat = [(p, key) for p in self.parts for key in p.parameters]
        return tuple(i for i, (p, _) in enumerate(flat) if p.static)

    @cached_property
    def linear(self) -> tuple[int, ...]:
        """Where the parameters stand to which the force is proportional."""
        return tuple(i for i, q in enumerate(self.quantities.values()) if q.linear)

    def __str__(self) -> str:
        return " + ".join(self.names)

    def formulas(self) -> list[Formula]:
        """What the parts compute, intrinsics first, each name once."""
        formulas: dict[str, Formula] = {}
        for p in self.parts:
            for formula in (p.advance, p.force, p.stretch):
                if formula is not None:
                    formulas.update((n, read(f, n)) for n, f in formula.intrinsics().items())
                    formulas[formula.name] = formula
        return list(formulas.values())

    @cached_property
    def workspace_rows(self) -> int:
        """How many rows ``walk`` needs to itself (see `dampyr.models.codegen.batched_path`)."""
        return batched_path.written(self)[1]

    def source(self, site: int = 0) -> str:
        """The Python text of this composition's functions, their names ending in ``_{site}``."""
        texts = {f.name: f.source for f in self.formulas()}
        for p in self.parts:
            texts.update(_tangents(p))
            texts.update(series.towards(p) if self.in_series else {})
        return "\n\n".join([*texts.values(), *self._glue(site)])

    def _glue(self, site: int) -> list[str]:
        """The functions that drivers know."""
        walk = [text.replace("_SITE(", f"_{site}(") for text in batched_path.written(self)[0]]
        if self.in_series:
            return [*series.sources(self, site), *walk]
        return [*(write(self, site) for write in (_advance, _force, _slopes, _columns, _spread)), *walk]


def compose(names: str | Iterable[str]) -> Composition:
    """The composition of parts named as ``"dahl + spring"`` or as a sequence of names."""
    listed = [n.strip() for n in names.split("+")] if isinstance(names, str) else list(names)
    for name in listed:
        part(name)
    twice = sorted({n for n in listed if listed.count(n) > 1})
    if twice:
        raise InputError(f"the part {twice[0]!r} stands twice in {' + '.join(listed)}; name each part once")
    composition = Composition(tuple(listed))
    if not any(p.force for p in composition.parts):
        raise InputError(f"{composition} makes no force; add a part that does, such as dahl")
    if composition.in_series and all(series.outside(p) for p in composition.parts if p.force):
        raise InputError(f"{composition} has nothing that stretches it; add a part such as dahl")
    return composition


Argument = Callable[[str], str]


def _slots(composition: Composition) -> Iterator[tuple[Part, Argument, list[int], list[int]]]:
    """Each part with the place of its arguments: states s[k], parameters p[k], the rest by their own name."""
    i, j = 0, 0
    for p in composition.parts:
        states = {name: f"s[{j + k}]" for k, name in enumerate(p.states)}
        values = {name: f"p[{i + k}]" for k, name in enumerate(p.parameters)}
        places = states | values
        own_states = list(range(j, j + len(states)))
        own_values = list(range(i, i + len(values)))
        yield p, lambda name, places=places: places.get(name, name), own_states, own_values  # type: ignore[misc]
        i, j = i + len(values), j + len(states)


def _call(formula: Formula, place: Argument, tangents: str = "", suffix: str = "") -> str:
    arguments = ", ".join(place(a) for a in formula.arguments)
    return f"{formula.name}{suffix}({arguments}{tangents})"


def _tangents(p: Part) -> dict[str, str]:
    """Derivatives of a part's two formulas: along its states, and along one more argument at a time."""
    texts: dict[str, str] = {}
    for formula in (p.advance, p.force):
        if formula is None:
            continue
        states = [s for s in p.states if s in formula.arguments]
        for name, function in partials_of(formula).items():
            for inner, f in read(function, name).intrinsics().items():
                texts.setdefault(inner, read(f, inner).source)
            texts[name] = read(function, name).source
        if formula is p.force:
            for unit in (None, *(a for a in formula.arguments if a not in p.states)):
                name = f"{formula.name}_by_{unit or 'states'}"
                texts[name] = tangent(formula, name, states, unit)
    if p.advance is not None:
        texts[f"{p.advance.name}_and_slopes"] = _at_end(p)
        texts[f"{p.advance.name}_and_tangents"] = _all_ways(p)
    return texts


def _define(name: str, site: int, arguments: str, lines: list[str]) -> str:
    return "\n    ".join([f"def {name}_{site}({arguments}):", *lines])


def _targets(states: list[int], array: str = "s") -> str:
    return ", ".join(f"{array}[{k}]" for k in states)


def _advance(composition: Composition, site: int) -> str:
    lines = [
        f"{_targets(states)} = {_call(p.advance, place)}" for p, place, states, _ in _slots(composition) if p.advance
    ]
    return _define("advance", site, "s, x0, x1, v0, v1, dt, p", [*lines, "return"])


def _force(composition: Composition, site: int) -> str:
    terms = [_call(p.force, place) for p, place, _, _ in _slots(composition) if p.force]
    return _define("force", site, "s, x, v, a, p", ["return " + " + ".join(terms)])


def _slopes(composition: Composition, site: int) -> str:
    """dF/dx1 and dF/dv1 of the force at the end of a piece, through the states and directly."""
    lines = ["fx, fv, x, v, a = 0.0, 0.0, x1, v1, 0.0"]
    for p, place, states, _ in _slots(composition):
        if p.force is None:
            continue
        ends = {name: f"e{k}" for name, k in zip(p.states, states, strict=True)}
        if p.advance:
            lines.append(_ends(p, place, states))
        at_end = lambda name, ends=ends, place=place: ends.get(name) or place(name)  # noqa: E731
        for axis, total in (("x", "fx"), ("v", "fv")):
            tangents = _end_tangents(p, axis, states) if axis in _axes(p) else ""
            if axis in p.force.arguments or tangents:
                suffix = f"_by_{axis}" if axis in p.force.arguments else "_by_states"
                lines.append(f"{total} += {_call(p.force, at_end, tangents or _zeros(p), suffix)}")
    return _define("slopes", site, "s, x0, x1, v0, v1, dt, p", [*lines, "return fx, fv"])


def _zeros(p: Part) -> str:
    """Zero tangents of the states that the force of a part uses."""
    assert p.force is not None
    return ", 0.0" * sum(s in p.force.arguments for s in p.states)


def _axes(p: Part) -> list[str]:
    """What the states at the end of a piece change with: x1, v1 or both."""
    return [axis for axis in "xv" if p.advance is not None and f"{axis}1" in p.advance.arguments]


def _ends(p: Part, place: Argument, states: list[int]) -> str:
    """The line with a part's states at the end and how they change with x1 and v1, in one call."""
    assert p.advance is not None
    seeds = ", 0.0" * (len(_axes(p)) * sum(s in p.advance.arguments for s in p.states))
    targets = [f"e{k}" for k in states] + [f"d{axis}{k}" for axis in _axes(p) for k in states]
    return f"{', '.join(targets)} = {_call(p.advance, place, seeds, '_and_slopes')}"


def _end_tangents(p: Part, axis: str, states: list[int]) -> str:
    """The tangents by the end of an axis that the force of a part takes."""
    assert p.force is not None
    return "".join(f", d{axis}{k}" for s, k in zip(p.states, states, strict=True) if s in p.force.arguments)


def _columns(composition: Composition, site: int) -> str:
    """dF/dp_k and dF/ds_j(start), from the tangents D of the states."""
    lines = []
    offset = len(composition.parameters)
    for p, place, states, values in _slots(composition):
        if p.force is None:
            continue
        used = [k for s, k in zip(p.states, states, strict=True) if s in p.force.arguments]
        for name, k in zip(p.parameters, values, strict=True):
            direct = name in p.force.arguments
            if direct or used:
                suffix = f"_by_{name}" if direct else "_by_states"
                seeds = "".join(f", D[{j}, {k}]" for j in used)
                lines.append(f"J[{k}] = {_call(p.force, place, seeds, suffix)}")
        for start in states:
            seeds = "".join(f", D[{j}, {offset + start}]" for j in used)
            lines.append(f"J[{offset + start}] = {_call(p.force, place, seeds, '_by_states')}")
    return _define("columns", site, "s, D, x, v, a, p, J", [*lines, "return"])


def _spread(composition: Composition, site: int) -> str:
    """Move the states and their tangents D along one piece."""
    lines = []
    offset = len(composition.parameters)
    for p, place, states, values in _slots(composition):
        if p.advance is None:
            continue
        used = [k for s, k in zip(p.states, states, strict=True) if s in p.advance.arguments]
        columns = [k for name, k in zip(p.parameters, values, strict=True) if name in p.advance.arguments]
        columns += [offset + start for start in states]
        seeds = "".join(f", D[{j}, {column}]" for column in columns for j in used)
        targets = [f"s[{k}]" for k in states] + [f"D[{k}, {column}]" for column in columns for k in states]
        lines.append(f"{', '.join(targets)} = {_call(p.advance, place, seeds, '_and_tangents')}")
    return _define("spread", site, "s, D, x0, x1, v0, v1, dt, p", [*lines, "return"])


def _at_end(p: Part) -> str:
    """The advance of a part with its derivatives by the displacement and the velocity at the end."""
    assert p.advance is not None
    used = [s for s in p.states if s in p.advance.arguments]
    return tangents(p.advance, f"{p.advance.name}_and_slopes", used, [f"{axis}1" for axis in _axes(p)])


def _all_ways(p: Part) -> str:
    """The advance of a part with its derivatives by its parameters, and by each state at the start."""
    assert p.advance is not None
    used = [s for s in p.states if s in p.advance.arguments]
    units = [name for name in p.parameters if name in p.advance.arguments]
    return tangents(p.advance, f"{p.advance.name}_and_tangents", used, [*units, *(None for _ in p.states)])


def namespace_of(compositions: tuple[Composition, ...]) -> tuple[str, dict[str, Any]]:
    """The text of several compositions with the functions that choose among them by ``site``, and its names."""
    texts = [c.source(site) for site, c in enumerate(compositions)]
    for name, arguments in (
        ("advance", "s, x0, x1, v0, v1, dt, p"),
        ("force", "s, x, v, a, p"),
        ("slopes", "s, x0, x1, v0, v1, dt, p"),
        ("columns", "s, D, x, v, a, p, J"),
        ("spread", "s, D, x0, x1, v0, v1, dt, p"),
        ("walk", batched_path.ARGUMENTS),
    ):
        last = len(compositions) - 1
        lines = [f"if site == {k}: return {name}_{k}({arguments})" for k in range(last)]
        texts.append("\n    ".join([f"def {name}(site, {arguments}):", *lines, f"return {name}_{last}({arguments})"]))
    return "\n\n".join(texts), {"__name__": __name__}
