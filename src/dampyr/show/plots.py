"""The figures of a result, drawn with pyplot: ``result.plot()`` and the methods of ``result.plot``."""

from __future__ import annotations

from collections.abc import Callable
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
        figure = description_of(self.result).figure
        assert figure is not None
        return style.in_pyplot(_drawn, figure, type(self.result).__name__, origin=_origin(self.result))


def _drawn(figure: Callable[[], Any], name: str) -> Any:
    drawn = figure()
    if drawn is None:
        raise InputError(f"this {name} has nothing to draw")
    return drawn


def _origin(result: Any) -> Any:
    return getattr(result, "origin", NOT_STATED)


@singledispatch
def plots(result: Any) -> Plots | None:
    """The figures registered for the type of ``result`` (``@plots.register``); else that of its description, if any."""
    return Plots(result) if description_of(result).figure else None


def plots_of(result: Any) -> Plots | None:
    """The figures of ``result``, found in the file that describes its type; None where it has none."""
    load_descriptions(type(result))
    return plots(result)
