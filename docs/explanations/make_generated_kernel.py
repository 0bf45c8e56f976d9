"""The page generated-kernel.md, from a kernel of the batch engine; ``make docs`` writes it."""

from __future__ import annotations

import ast

import numpy as np

from dampyr.models.codegen.composition import compose
from dampyr.structures import Building
from dampyr.structures.batch import assemble
from dampyr.structures.batch.modal import step
from dampyr.structures.batch.run_blocks import CONSTANTS, functions_of

HEAD = """# A generated kernel

An [ensemble](ensembles.md) runs through a kernel that is written for its building and for the parts of its dampers, and then
compiled by numba. This page prints a small one: one floor, a damper of the Dahl model in storey 1, the peak of its
displacement. `make docs` writes this page; a test checks that.

A kernel is written as text because every line of it depends on the case: how many coordinates the building has, which of
their coefficients are 0, which formulas the damper's parts bring. In this form the compiler takes eight histories at a time
([decision 0011](../decisions/0011-ensembles-in-lanes.md)). `dampyr.structures.batch.assemble` writes it. The numbers of the
building are not in the text: they come in `c`, so that buildings of the same pattern share a kernel.
"""
NAMES = """## Names

A block `b` holds a row for each value that a history carries from step to step, and a column `l` for each history; here it is
{width} columns wide, so that `b[{width} + l]` is history `l` in row 1. Arguments: the samples `first` to `last`; `parts` steps
per sample; `ground`, the accelerations of the motions, with `motion` and `scale` of each history; `times`, multiples of
the step; `c`, the coefficients of the building; `ring` and `mask` for the past forces of delayed dampers.

{names}
"""
CALLED = """## What it calls

{constants} are numbers in the precision of the kernel; `tiny` keeps a divisor
above 0. `eighth_over(t)` is 1/(8 t) to 0.3 %, without a division; `exp` is a polynomial. Both are in
`dampyr.structures.batch.branchless_math`. These functions come from the damper's part, with their
derivatives; numba inlines them:

```text
{functions}
```
"""


def page() -> str:
    """The whole page."""
    building = Building(np.array([[100.0]]), np.array([[50.0]]), np.array([[4e4]]))
    compositions = (compose("dahl"),)
    text = assemble.KernelText(step(building, building.connection(1)[None], 0.005), compositions, ("displacement",))
    names = (assemble.__doc__ or "").partition("Names in the text, ")[2]
    sites, _, table = names.partition(":\n\n")
    rows = [line.partition("  ") for line in table.strip().splitlines() if not line.startswith("=")]
    listed = [f"| {name.replace('``', '`')} | {meaning.strip().replace('``', '`')} |" for name, _, meaning in rows]
    constants = ", ".join(f"`{name}`" for name in CONSTANTS)
    parts = [
        HEAD,
        "## The kernel\n\n```text\n" + text.source.rstrip() + "\n```\n",
        NAMES.format(
            width=text.block_width,
            names="\n".join([f"Names {' '.join(sites.split())}:", "", "| name | meaning |", "|---|---|", *listed]),
        ),
        CALLED.format(constants=constants, functions=_called(text.source, functions_of(compositions))),
    ]
    return "\n".join(parts)


def _called(source: str, functions: str) -> str:
    """Those of ``functions`` that ``source`` calls."""
    used = {node.id for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Name)}
    called = [node for node in ast.parse(functions).body if isinstance(node, ast.FunctionDef) and node.name in used]
    return "\n\n".join("\n".join(map(_wrapped, ast.unparse(node).splitlines())) for node in called)


def _wrapped(line: str) -> str:
    """A line that returns several long values with each on a line of its own."""
    if len(line) <= 120:
        return line
    statement = ast.parse(line.strip().removeprefix("return "), mode="eval").body
    assert isinstance(statement, ast.Tuple)
    values = [f"        {ast.unparse(value)},\n" for value in statement.elts]
    return f"    return (\n{''.join(values)}    )"
