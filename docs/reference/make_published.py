"""Write published.md from the files of the sets: ``python docs/reference/make_published.py``."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from textwrap import fill

from dampyr.models import published

PAGE = Path(__file__).with_name("published.md")
HEAD = """# Published parameter sets

```python
import dampyr as dp

damper = dp.models.published.damper("spencer_1997")  # a damper like any other: force, respond, export, save
about = dp.models.published.about("spencer_1997")  # paper, where, read, device, printed, limits, notes, differs
```

The sets are the TOML files of `dampyr/models/published`, with the numbers as printed, and this page is written from these
files. "Read" says what was read: for all but `tan_agrawal_2004`, whose own files were, it is somebody's
quotation or program and not the paper, and the notes name where it may be wrong. Sets that claim the same source and
differ are all here and name each other. The damper of Raminelli (2020), read in the dissertation itself, is
`dp.studies.raminelli_2020.damper()`.

Where a set has a rate eta, the source passes the command V through u' = -eta (u - V) first and lets the parameters follow u.
The damper has this as the part [`lag`](models.md#lag), tau = 1/eta, and takes the command. A constant voltage lags behind
nothing. The part counts once: with a control law that has a `lag` of its own, and for C code, which takes u itself, leave it
out first with `damper.without("lag")`, and filter the command outside.

A test integrates the equations of each set in its own units and letters and compares the force.
"""


def page() -> str:
    """The whole page."""
    return "\n".join([HEAD, listing(), *map(section, published.available_sets())])


def listing() -> str:
    """One row per set."""
    rows = ["| set | claims | input | differs from |", "|---|---|---|---|"]
    for name in published.available_sets():
        about = published.about(name)
        low, high = about.limits
        others = ", ".join(f"`{other}`" for other in about.differs) or "-"
        rows.append(f"| [`{name}`](#{name}) | {about.claims} | {low:g} to {high:g} {about.input} | {others} |")
    return "\n".join([*rows, ""])


def section(name: str) -> str:
    """The section of one set, with its numbers as printed."""
    about = published.about(name)
    items = [
        f"**Paper:** {about.paper}; {about.where}.",
        f"**Read:** {about.read}.",
        f"**Device:** {about.device}.",
        f"**Input:** {about.limits[0]:g} to {about.limits[1]:g} {about.input}: {about.limits_from}.",
        *(f"**Note:** {note}." for note in about.notes),
        *(f"**Differs:** `{other}` {what}." for other, what in about.differs.items()),
    ]
    rows = [f"| `{letter}` | {number:.15g} | {unit} |" for letter, (number, unit) in about.printed.items()]
    table = ["| as printed | number | unit |", "|---|---|---|", *rows]
    text = markdown(about.description)
    lines = [fill(item, 118, subsequent_indent="  ", break_long_words=False, initial_indent="- ") for item in items]
    return "\n".join([f"## `{name}`", "", text, "", *lines, "", *table, ""])


def markdown(text: str) -> str:
    """A description of these files as Markdown: displayed equations, mathematics in a line."""
    text = re.sub(r"^\.\. math:: (.*(?:\n[ ]+\S.*)*)", lambda m: "$$" + " ".join(m[1].split()) + "$$", text, flags=re.M)
    text = re.sub(r":math:`([^`]+)`", r"$\1$", text)
    return text.replace("\\|v\\|", "|v|")


if __name__ == "__main__":
    sys.stdout.write(f"{PAGE.write_text(page(), encoding='utf-8')} characters\n")
