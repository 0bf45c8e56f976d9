"""What a result shows is written in `dampyr.show`, a file for each module that defines results, and is found by its type."""

from __future__ import annotations

from importlib import import_module
from typing import Any


def _show(name: str) -> Any:
    """A module of `dampyr.show`, which stands above whatever it describes and is loaded when something is first shown."""
    return import_module(f"dampyr.show.{name}")


class Shown:
    """A class whose objects are described in `dampyr.show`.

    ``print`` and a prompt show the title and the rows of the `dampyr.show.Description`, a notebook its table and its figure,
    too; ``plot`` draws. A dataclass is declared with ``repr=False``, or it would have a repr of its own.
    """

    __slots__ = ()

    def __repr__(self) -> str:
        text: str = _show("text").as_text(self)
        return text

    def _repr_html_(self) -> str:
        html: str = _show("notebook").as_html(self)
        return html

    def as_dict(self) -> dict[str, Any]:
        """What JSON holds of it, by name and in SI units, for `dampyr.to_json`."""
        data: dict[str, Any] = _show("data").as_dict(self)
        return data

    def to_dataframe(self) -> Any:
        """A ``pandas.DataFrame`` of it; :class:`~dampyr.errors.InputError` where it is not a table or pandas is missing."""
        return _show("data").as_frame(self)

    @property
    def plot(self) -> Any:
        """Figures: called, it draws the one that a notebook shows; its methods draw others. Each gives axes ``(k,)``."""
        plots = _show("plots").plots_of(self)
        if plots is None:
            raise AttributeError(f"{type(self).__name__} has no figure to plot")
        return plots
