"""Write models.md from the docstrings of the parts: ``python docs/reference/make_models.py``."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

from dampyr.models import available_parts, part

PAGE = Path(__file__).with_name("models.md")
HEAD = """# Models

A damper is made of parts, written as `"dahl + spring + delay"`. Each part is one file of `dampyr/models/parts`, and this
page is written from these files. The force is the sum over the parts, delayed by the `delay` where there is one. x is the
displacement in m (extension positive), v the velocity in m/s; a positive force opposes positive velocity. Each parameter
follows the coil's voltage (or current) by a law: see [card](card.md). `compliance` and `free_play` have no force of their
own: they are in series with all other parts, which then feel the motion less the stretch. In Python a damper is made of
names and laws, or of part objects with their numbers: `Damper([Dahl(kx=800.0, kw=50.0, rho=900.0), Spring(k0=200.0)])`, with
`from dampyr.models.parts import Dahl, Spring`.

A parameter is *linear* where the force is proportional to it; a fit solves for these by linear least squares
(in series with a stretch none is). A state is 0 at rest.

What goes together: most parts have a dashpot of their own, and two of them in one composition are one too many. Fix one,
such as `--fix hyperbolic_tangent.c=0` beside `dahl.kx`; likewise `bouc_wen.k0` and `spring.k0` are the same spring. A fit
gives every record an offset of its own, so the part `offset` is for dampers that are simulated; in a fit it means one offset
for all records. A building leaves it out: it is at rest in its equilibrium with it.
"""


def page() -> str:
    """The whole page."""
    return "\n".join([HEAD, *map(section, available_parts())])


def section(name: str) -> str:
    """The section of one part: its docstring, its states and its parameters."""
    p = part(name)
    states = ", ".join(f"`{key}` in [{low:g}, {high:g}]" for key, (low, high) in p.states.items()) or "none"
    rows = [
        f"| `{key}` | {q.unit or '1'} | {q.range_in_words()} | {'yes' if q.linear else 'no'} |"
        for key, q in p.parameters.items()
    ]
    table = ["| parameter | unit | allowed | linear |", "|---|---|---|---|", *rows]
    text = markdown(inspect.getdoc(p.module) or "")
    return "\n".join([f"## `{name}`", "", text, "", f"State: {states}.", "", *table, ""])


def markdown(text: str) -> str:
    """A docstring of these files as Markdown: displayed equations, mathematics in a line, code."""
    text = re.sub(r"^\.\. math:: (.*(?:\n[ ]+\S.*)*)", lambda m: "$$" + " ".join(m[1].split()) + "$$", text, flags=re.M)
    text = re.sub(r":math:`([^`]+)`", r"$\1$", text)
    return re.sub(r"``([^`]+)``", r"`\1`", text)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
