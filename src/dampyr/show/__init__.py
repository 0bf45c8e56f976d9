"""What a result shows: its description, its figures, and the faces that are made of them.

`describe` gives the title, the rows, the table and the figure of a result. Its text (``print``), its notebook view and its page
are functions of that `Description`. There is one file for each module that defines results, in the folder of its package, and
it is loaded when such a result is first shown.

A figure takes plain arrays in SI, shows them in the units people read (mm, N, s, V) and returns a matplotlib ``Figure``. A page
is one self-contained HTML file: no network, light and dark, for paper and for a phone.

::

    from dampyr.show.figures.loops import loops

    figure = loops(record.displacement, record.velocity, record.force, {"viscous Dahl": predicted})
    html = page("A damper", [Section("Loops", [FigureBlock(figure, "measured, model")])])
    write_page(html, "out/damper.html")
    write_page(fit, "out/fit.html")  # the page of a result
"""

from importlib import import_module
from typing import Any

_MODULES = {
    "save": "figure_file",
    "FigureBlock": "pages.blocks",
    "Section": "pages.blocks",
    "Table": "table",
    "Text": "pages.blocks",
    "Verdict": "table",
    "made_by": "pages.how_made",
    "page": "pages.html_page",
    "write_page": "pages.result_page",
    "figure_files": "pages.saved_figures",
}
"""The public names and their modules, loaded when they are used: a page needs the package whose result it shows."""


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(_MODULES)


__all__ = list(_MODULES)
