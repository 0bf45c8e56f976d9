"""A step cut into several loops gives what it gives in one."""

from itertools import combinations

import numpy as np
import pytest

from dampyr.structures.batch.loop_fission import Loops

LINES = [
    "speed = v + h * a",
    "path = x + h * speed",
    "force = k * path",
    "force += c * speed",
    "a1 = -force",
    "work = force * (path - x)",
]
ROWS = ("x", "v", "a", "k", "c", "~speed", "~path", "~force", "~a1", "w", "~work")
UPDATES = {"x": "path", "v": "speed", "a": "a1", "w": "work"}


class Rows:
    """Rows of a block by name, as the kernel's text reaches them."""

    names = ROWS
    block_width = 3

    def at(self, name: str) -> str:
        return f"block[{ROWS.index(name)}, l]"


@pytest.mark.parametrize("inner", [cuts for n in range(4) for cuts in combinations(range(1, len(LINES)), n)])
def test_it_does_not_matter_where_a_step_is_cut(inner: tuple[int, ...]) -> None:
    """Two steps, in numbers of the test's own; a row is overwritten only after nothing reads its old value."""
    block = np.random.default_rng(1).normal(size=(len(ROWS), 3))
    x, v, a, k, c = block[:5].copy()
    h = 0.1
    loops = Loops(LINES, [0, *inner, len(LINES)], UPDATES, Rows()).written()
    assert len(loops) == len(inner) + 1
    text = "\n".join(line for loop in loops for line in loop)
    for _ in range(2):
        exec(text, {"block": block, "h": h})
        v = v + h * a
        force = k * (x + h * v) + c * v
        work, x, a = force * h * v, x + h * v, -force
    np.testing.assert_allclose(block[[*range(3), ROWS.index("w")]], [x, v, a, work], rtol=1e-10)
