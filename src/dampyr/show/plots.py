"""The figures of a result, drawn with pyplot: ``result.plot()`` and the methods of ``result.plot``."""

from __future__ import annotations

from dataclasses import dataclass
from functools import singledispatch
from typing import Any

from dampyr.errors import InputError
from dampyr.origin import NOT_STATED
from dampyr.show.descriptions import description_of, load_descriptions
from dampyr.show.figures import style


@dataclass(frozen=True)
class Plots:
    """The figures of ``result``; called, the one that a notebook shows. Each method draws one and returns its axes ``(k,)``."""

    result: Any

    def __call__(self) -> Any:
        """Draw the figure that stands for the result; its matplotlib axes ``(k,)``."""
        return style.in_pyplot(_figure_of, self.result, origin=getattr(self.result, "origin", NOT_STATED))


def _figure_of(result: Any) -> Any:
    draw = description_of(result).figure
    figure = draw() if draw else None
    if figure is None:
        raise InputError(f"this {type(result).__name__} has nothing to draw")
    return figure


@singledispatch
def plots(result: Any) -> Plots | None:
    """The figures registered for the type of ``result`` (``@plots.register``); else that of its description, if any."""
    return Plots(result) if description_of(result).figure else None


def plots_of(result: Any) -> Plots | None:
    """The figures of ``result``, found in the file that describes its type; None where it has none."""
    load_descriptions(type(result))
    return plots(result)
