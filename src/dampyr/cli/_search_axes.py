"""The axes of a search on the command line: ``voltage=0:3:0.5``, ``clipped_optimal.effort=0.01,0.1``, ``place=1,2,0-2``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dampyr.cli._ensemble import read_range
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.models import Damper

MAX_VALUES = 10_000  # of an axis: more is a mistyped step


def values_of(name: str, text: str) -> list[float]:
    """``0.5,1:2:0.5`` as 0.5, 1, 1.5, 2."""
    return [value for part in text.split(",") for value in read_range(part, f"--search {name}:", MAX_VALUES)]


def places_of(text: str) -> list[Any]:
    """``1,2,0-2`` as 1, 2 and the floors (0, 2)."""
    places: list[Any] = []
    for part in (word.strip() for word in text.split(",")):
        first, dash, second = part.partition("-")
        if dash and first and second:
            places.append((first, second))
        elif part.isdigit():
            places.append(int(part))
        else:
            raise InputError(f"--search place={text}: {part!r} is no place; write a storey, 2, or two floors, 0-2")
    return places


def searched(
    damper: Damper, texts: tuple[str, ...], inputs: list[Any], controls: tuple[str, ...]
) -> tuple[list[Any], Any]:
    """The inputs and the places (None: not said) of the axes ``texts``; ``inputs`` are those of the other options.

    An axis of a law's setting makes a law of each of its values in the place of the one that ``controls`` (or its name alone)
    gives; several of one law make every combination.
    """
    from dampyr.structures.control_laws import law_of

    places: Any = None
    laws: dict[str, list[tuple[str, list[float]]]] = {}
    constant = [value for value in inputs if not hasattr(value, "period")]
    word = {"V": "voltage", "A": "current"}.get(damper.input, "")
    for text in texts:
        name, equals, listed = (part.strip() for part in text.partition("="))
        law, point, setting = name.partition(".")
        if not equals or not listed:
            raise InputError(
                f"--search {text!r} is no axis; write it as in voltage=0:3:0.5, clipped_optimal.effort=0.01,0.1 or place=1,0-2"
            )
        if name == "place":
            places = places_of(listed)
        elif point:
            laws.setdefault(law, []).append((setting, values_of(name, listed)))
        elif name in ("voltage", "current"):
            if name != word:
                raise InputError(
                    f"--search {text}: this damper takes {'a ' + word if word else 'no input'}; leave it out"
                )
            constant += values_of(name, listed)
        else:
            raise InputError(
                f"--search {text!r}: {name!r} is no axis; it may be voltage, current, place or LAW.SETTING"
            )
    bases = list(controls)
    bases += [law for law in laws if law not in [text.partition(":")[0] for text in controls]]
    controls_to_try: list[str] = []
    for base in bases:
        variants = [base]
        for setting, values in laws.get(base.partition(":")[0], []):
            variants = [
                f"{variant}{',' if ':' in variant else ':'}{setting}={value!r}"
                for variant in variants
                for value in values
            ]
        controls_to_try += variants
    return [*constant, *(law_of(text, damper) for text in controls_to_try)], places
