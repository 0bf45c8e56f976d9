"""The parts of which dampers are made: one file each, named as in the literature.

A part is a frozen dataclass of its parameters and two short functions in the letters of its equation:

``advance(states..., x0, x1, v0, v1, dt, parameters...)``
    the states after a monotone piece of motion (absent where there is no state);
``force(states..., x, v, a, parameters...)``
    the force in N; positive opposes positive velocity.

Each names only the arguments that it uses. ``STATES`` gives the bounds of each state (rest is 0). Gradients, the kernels
and the exports are derived from these lines (see ``dampyr.models.codegen.formula``). ``starts`` proposes values of
the parameters that are not linear, from where a fit begins.
"""

from __future__ import annotations

from typing import Any

from dampyr import registry


def __getattr__(name: str) -> Any:
    """The class of a part, such as ``Dahl``, from its file."""
    for module_name in registry.names(__name__) if name[:1].isupper() else ():
        if module_name.replace("_", "") == name.lower():
            return getattr(registry.member(__name__, module_name), name)
    raise AttributeError(
        f"module {__name__!r} has no attribute {name!r}; its files are {', '.join(registry.names(__name__))}"
    )
