"""Arguments of the wrong kind, or swapped: one sentence that says what was given and what to write.

A call that takes the objects of another one is easily given a file's name, an array, or its arguments in the other order::

    check_kinds("score", Argument("damper", damper, (Damper,), DAMPER), Argument("record", record, (Record,), RECORD))
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dampyr.errors import InputError

DAMPER = "give a Damper, such as fit.damper or dampyr.models.Damper.load('card.toml')"
RECORD = "give a Record, such as dampyr.records.read('test.csv')"
RECORDS = "give records, or the path of a file or of a folder of them, such as 'test.csv'"
MOTION = "give a GroundMotion, such as dampyr.ground_motions.read('motion.AT2') or GroundMotion(acceleration, dt)"
BUILDING = "give a Building, such as dampyr.structures.two_storey() or dampyr.structures.load('frame.toml')"
MODEL = "give the name of a model, such as 'dahl', or a Damper"
MAX_SHOWN = 40  # characters of a text that a message repeats


@dataclass(frozen=True)
class Argument:
    """An argument of a call, in the call's order: what it must be, and the repair; ``several`` takes a list of it too."""

    name: str
    value: Any
    kinds: tuple[type, ...]
    repair: str
    several: bool = False

    def takes(self, value: Any) -> bool:
        """Whether ``value`` is of a kind that this argument takes."""
        if isinstance(value, self.kinds):
            return True
        listed = self.several and isinstance(value, Iterable) and not isinstance(value, str | bytes | Path | Mapping)
        return listed and (iter(value) is value or all(isinstance(item, self.kinds) for item in value))


def check_kinds(call: str, *arguments: Argument) -> None:
    """Raise :class:`~dampyr.errors.InputError` for the first argument that is of no kind it may be; ``call`` names the call."""
    wrong = [argument for argument in arguments if not argument.takes(argument.value)]
    if not wrong:
        return
    order = ", ".join(argument.name for argument in arguments)
    if len(arguments) == 2 and all(a.takes(b.value) for a, b in zip(arguments, reversed(arguments), strict=True)):
        raise InputError(f"the arguments of {call} are swapped; write {call}({order})")
    first = wrong[0]
    raise InputError(f"{call}({order}): {first.name} is {described(first.value)}; {first.repair}")


def described(value: Any) -> str:
    """What a value is, in words."""
    if isinstance(value, str | Path):
        text = str(value)
        return f"the text {text[:MAX_SHOWN] + '...' if len(text) > MAX_SHOWN else text!r}"
    if isinstance(value, list | tuple) and value:
        return f"a {type(value).__name__} that holds {described(value[0])}"
    return "missing (None)" if value is None else f"of the type {type(value).__name__}"
