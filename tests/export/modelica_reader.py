"""A reader of the Modelica that dampyr writes: its own tokens and grammar, and SciPy for the time.

Nothing of the writer is in it.

It knows the part of the language that stands in such a package: one model with equations that can be put in an order, functions
with assignments and branches, ``noEvent``, ``assert`` and the built-in functions of one argument.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

TOKEN = re.compile(
    r'//[^\n]*|\s+|"[^"]*"|\d+(?:\.\d*)?(?:[eE][+-]?\d+)?|[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*|<=|>=|==|<>|:=|[-+*/^()=<>,;]'
)
BUILT_IN: dict[str, Any] = {
    "abs": abs, "exp": math.exp, "log": math.log, "sqrt": math.sqrt, "tanh": math.tanh, "sin": math.sin, "cos": math.cos,
    "atan": math.atan, "min": min, "max": max, "noEvent": lambda value: value,
}  # fmt: skip
Values = dict[str, Any]
Expression = Callable[[Values], Any]


class Reader:
    """Tokens, and what is read from them."""

    def __init__(self, text: str) -> None:
        self.tokens, at = [], 0
        while at < len(text):
            match = TOKEN.match(text, at)
            assert match, f"not Modelica at: {text[at : at + 40]!r}"
            if not match[0].isspace() and not match[0].startswith("//"):
                self.tokens.append(match[0])
            at = match.end()
        self.at = 0
        self.functions: dict[str, Any] = dict(BUILT_IN)

    def peek(self) -> str:
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def take(self, *wanted: str) -> str:
        token = self.peek()
        assert not wanted or token in wanted, (
            f"{token!r} for {wanted}: {' '.join(self.tokens[self.at - 5 : self.at + 5])}"
        )
        self.at += 1
        return token

    def skip(self, *wanted: str) -> bool:
        if self.peek() in wanted:
            self.at += 1
            return True
        return False

    def expression(self) -> Expression:
        if self.skip("if"):
            test = self.expression()
            self.take("then")
            yes = self.expression()
            self.take("else")
            no = self.expression()
            return lambda v: yes(v) if test(v) else no(v)
        terms = [self.relation()]
        while self.skip("and"):
            terms.append(self.relation())
        return terms[0] if len(terms) == 1 else lambda v: all(term(v) for term in terms)

    def relation(self) -> Expression:
        left, sign = self.sum(), self.peek()
        compare = {"<": "__lt__", "<=": "__le__", ">": "__gt__", ">=": "__ge__", "==": "__eq__", "<>": "__ne__"}
        if sign not in compare:
            return left
        self.take()
        right = self.sum()
        return lambda v: getattr(float(left(v)), compare[sign])(float(right(v)))

    def sum(self) -> Expression:
        """A sign may stand before the first term alone."""
        negative = self.skip("-")
        first = self.term()
        value: Expression = (lambda v: -first(v)) if negative else first
        while self.peek() in ("+", "-"):
            value = self._joined(value, self.take(), self.term())
        return value

    def term(self) -> Expression:
        value = self.power()
        while self.peek() in ("*", "/"):
            value = self._joined(value, self.take(), self.power())
        return value

    def _joined(self, a: Expression, sign: str, b: Expression) -> Expression:
        return {
            "+": lambda v: a(v) + b(v), "-": lambda v: a(v) - b(v), "*": lambda v: a(v) * b(v), "/": lambda v: a(v) / b(v),
        }[sign]  # fmt: skip

    def power(self) -> Expression:
        base = self.primary()
        if not self.skip("^"):
            return base
        exponent = self.primary()
        return lambda v: base(v) ** exponent(v)

    def primary(self) -> Expression:
        token = self.take()
        if token == "(":
            inner = self.expression()
            self.take(")")
            return inner
        if token[0].isdigit():
            return lambda v: float(token)
        assert re.match(r"[A-Za-z_]", token), token
        if not self.skip("("):
            return lambda v: v[token]
        arguments = [self.expression()]
        while self.skip(","):
            arguments.append(self.expression())
        self.take(")")
        if token == "der":
            raise AssertionError("der() inside an expression")
        return lambda v: self.functions[token](*(argument(v) for argument in arguments))

    def attributes(self) -> Values:
        found: Values = {}
        while self.peek() not in (")", ""):
            name = self.take()
            self.take("=")
            token = self.peek()
            found[name] = self.take() if token[0] == '"' or token in ("true", "false") else self.expression()({})
            if not self.skip(","):
                break
        self.take(")")
        return found

    def declaration(self) -> tuple[str, str, Values]:
        """The kind ("parameter", "input", "output" or ""), the name and the attributes, with ``value``."""
        kind = self.take() if self.peek() in ("parameter", "input", "output") else ""
        self.take("Real")
        name = self.take()
        attributes = self.attributes() if self.skip("(") else {}
        if self.skip("="):
            attributes["value"] = self.expression()({})
        if self.peek().startswith('"'):
            self.take()
        self.take(";")
        return kind, name, attributes

    def function(self) -> None:
        name = self.take()
        inputs, outputs = [], []
        while self.peek() in ("input", "output"):
            kind, variable, _ = self.declaration()
            (inputs if kind == "input" else outputs).append(variable)
        if self.skip("protected"):
            while self.peek() == "Real":
                self.declaration()
        self.take("algorithm")
        run = self.statements()
        self.take("end")
        self.take(name)
        self.take(";")

        def call(*values: float) -> Any:
            assert len(values) == len(inputs), name
            local: Values = dict(zip(inputs, values, strict=True))
            run(local)
            results = tuple(local[output] for output in outputs)
            return results if len(results) > 1 else results[0]

        self.functions[name] = call

    def statements(self) -> Callable[[Values], None]:
        steps: list[Callable[[Values], None]] = []
        while self.peek() not in ("end", "else"):
            if self.skip("if"):
                steps.append(self._branch())
                continue
            target = self.take()
            self.take(":=")
            steps.append(self._assignment(target, self.expression()))
            self.take(";")

        def run(local: Values) -> None:
            for step in steps:
                step(local)

        return run

    def _assignment(self, target: str, value: Expression) -> Callable[[Values], None]:
        return lambda local: local.__setitem__(target, value(local))

    def _branch(self) -> Callable[[Values], None]:
        test = self.expression()
        self.take("then")
        yes, no = self.statements(), None
        if self.skip("else"):
            no = self.statements()
        self.take("end")
        self.take("if")
        self.take(";")

        def run(local: Values) -> None:
            if test(local):
                yes(local)
            elif no is not None:
                no(local)

        return run


class Model:
    """The model ``Equations`` of a package: parameters, states and what the equations give, as Python."""

    def __init__(self, text: str) -> None:
        reader = Reader(text)
        reader.take("package")
        self.name = reader.take()
        reader.take()
        while reader.skip("function"):
            reader.function()
        reader.take("model")
        reader.take("Equations")
        reader.take()
        self.declared: dict[str, tuple[str, Values]] = {}
        while reader.peek() not in ("equation", "initial"):
            if reader.skip("protected"):
                continue
            kind, name, attributes = reader.declaration()
            self.declared[name] = (kind, attributes)
        self.initial: dict[str, Expression] = {}
        if reader.skip("initial"):
            reader.take("equation")
            name = reader.take()
            reader.take("=")
            self.initial[name] = reader.expression()
            reader.take(";")
        reader.take("equation")
        self.equations: list[tuple[tuple[str, ...], Expression]] = []
        self.slopes: dict[str, Expression] = {}
        self.checks: list[Expression] = []
        while reader.peek() != "end":
            self._equation(reader)
        reader.take("end")
        reader.take("Equations")
        self.states = tuple(self.slopes)

    def _equation(self, reader: Reader) -> None:
        if reader.skip("assert"):
            reader.take("(")
            self.checks.append(reader.expression())
            reader.take(",")
            reader.take()
            reader.take(")")
        elif reader.skip("der"):
            reader.take("(")
            name = reader.take()
            reader.take(")")
            reader.take("=")
            self.slopes[name] = reader.expression()
        else:
            names = []
            if reader.skip("("):
                names.append(reader.take())
                while reader.skip(","):
                    names.append(reader.take())
                reader.take(")")
            else:
                names.append(reader.take())
            reader.take("=")
            self.equations.append((tuple(names), reader.expression()))
        reader.take(";")

    def values(self, states: np.ndarray, inputs: Values) -> Values:
        """All variables at these states and inputs, the derivatives as ``der(NAME)``."""
        known: Values = {name: about["value"] for name, (kind, about) in self.declared.items() if kind == "parameter"}
        known |= dict(zip(self.states, map(float, states), strict=True)) | inputs
        assert all(check(known) for check in self.checks), "an assertion of the model fails"
        waiting = list(self.equations)
        while waiting:
            left = []
            for names, expression in waiting:
                try:
                    value = expression(known)
                except KeyError:  # of a variable whose equation comes later
                    left.append((names, expression))
                    continue
                known |= dict(zip(names, value if len(names) > 1 else (value,), strict=True))
            assert len(left) < len(waiting), f"no order of the equations of {[names for names, _ in left]}"
            waiting = left
        return known | {f"der({name})": slope(known) for name, slope in self.slopes.items()}

    def force(self, t: np.ndarray, signals: Callable[[float], Values], tolerance: float) -> np.ndarray:
        """The force at the times, between which the motion does not turn round: each piece is integrated by itself."""
        from scipy.integrate import solve_ivp

        start = signals(float(t[0]))
        state = np.array(
            [
                self.initial[name](start) if name in self.initial else self.declared[name][1]["start"]
                for name in self.states
            ]
        )
        sizes = np.array([self.declared[name][1].get("nominal", 1.0) for name in self.states])

        def slope(at: float, s: np.ndarray) -> list[float]:
            known = self.values(s, signals(at))
            return [known[f"der({name})"] for name in self.states]

        force = [self.values(state, start)["force"]]
        for begin, end in pairwise(t):
            if self.states:
                found = solve_ivp(slope, (begin, end), state, "DOP853", rtol=tolerance, atol=tolerance * sizes)
                state = found.y[:, -1]
            force.append(self.values(state, signals(float(end)))["force"])
        return np.array(force)
