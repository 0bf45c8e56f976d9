"""The gallery: scripts of at most ten lines, each of which draws a figure with the public names of dampyr.

``docs/gallery/SECTION/NAME.py``: its docstring is the title and, below it, what the figure shows. What it draws last is the
figure::

    python tools/gallery.py OUT  # the figure of each, OUT/SECTION/NAME.svg, and OUT/figures.json
"""

from __future__ import annotations

import ast
import json
import sys
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "gallery"
SECTIONS = {
    "dampers": "Dampers",
    "records": "Records",
    "identification": "Identification",
    "earthquakes": "Earthquakes",
    "structures": "Buildings, cars and control",
    "rig": "The rig and its tests",
}
MOST_LINES = 10  # of code, blank lines left out


@dataclass(frozen=True)
class Entry:
    """One script of the gallery."""

    path: Path

    @property
    def name(self) -> str:
        """Such as ``dampers/loops``."""
        return str(self.path.relative_to(FOLDER).with_suffix(""))

    @cached_property
    def text(self) -> str:
        return self.path.read_text(encoding="utf-8")

    @cached_property
    def words(self) -> tuple[str, str]:
        """The title, and what the figure shows."""
        title, _, below = (ast.get_docstring(ast.parse(self.text)) or "").partition("\n")
        return title, " ".join(below.split())

    @cached_property
    def code(self) -> str:
        """The script without its docstring."""
        lines = self.text.splitlines()
        return "\n".join(lines[ast.parse(self.text).body[0].end_lineno or 0 :]).strip() + "\n"

    @property
    def lines(self) -> int:
        """How many lines of code it has."""
        return sum(bool(line.strip()) for line in self.code.splitlines())

    def draw(self) -> Any:
        """Run the script; the figure that its last line draws."""
        from matplotlib.figure import Figure

        from dampyr.errors import DampyrWarning

        tree, names = ast.parse(self.text), dict[str, Any](__name__="__main__")
        last = tree.body.pop()
        if not isinstance(last, ast.Expr):
            raise SystemExit(f"{self.name}: its last line is no expression that draws a figure")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DampyrWarning)
            exec(compile(tree, str(self.path), "exec"), names)
            drawn = eval(compile(ast.Expression(last.value), str(self.path), "eval"), names)
        return drawn if isinstance(drawn, Figure) else drawn[0].figure  # or its axes


def entries() -> list[Entry]:
    """All of them, section by section."""
    return [Entry(path) for section in SECTIONS for path in sorted((FOLDER / section).glob("*.py"))]


def main(arguments: Sequence[str]) -> int:
    """Draw each figure into OUT; 1 where text of one cannot be read."""
    import matplotlib

    matplotlib.use("agg")
    from figure_text import unreadable
    from matplotlib import pyplot
    from page_runner import in_words

    from dampyr.show import save

    out, alts, faults = Path(arguments[0]), {}, []
    for entry in entries():
        figure = entry.draw()
        save(figure, out / f"{entry.name}.svg")
        alts[entry.name] = in_words(figure)
        faults += [f"{entry.name}: {fault}" for fault in unreadable(figure)]
        pyplot.close("all")
    (out / "figures.json").write_text(json.dumps(alts, ensure_ascii=False, indent=1), encoding="utf-8")
    print("\n".join(faults), file=sys.stderr)
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
