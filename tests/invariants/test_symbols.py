"""Compiled functions whose symbols can be mistaken for one another must be the same function.

Numba makes a symbol of module, name, arguments and a number that it counts in each process; the linker takes what two kept
kernels have of one symbol for one function. So what shares a name must share its text and all that the text reaches.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher

from dampyr.ground_motions import oscillator
from dampyr.identification.search import bounded_least_squares, normal_equations
from dampyr.models import available_parts, path_integration
from dampyr.models.codegen.composition import compose
from dampyr.models.codegen.kernels import bind, compile_cached
from dampyr.models.part import part
from dampyr.rig.simulation import plant
from dampyr.structures import two_storey
from dampyr.structures.batch.engine import engine
from dampyr.structures.batch.run_blocks import compiled
from dampyr.structures.time_history.time_stepping import integrate as coupled

PROBE = """
import sys
import numpy as np
from dampyr.models import available_parts, path_integration
from dampyr.models.part import part
from dampyr.models.codegen.composition import compose
t = np.linspace(0.0, 1.0, 200)
for name in sys.argv[1:]:
    c = compose(name)
    path = (t, 0.005 * np.sin(6.28 * t), 0.0314 * np.cos(6.28 * t), np.zeros(200))
    P = len(c.parameters)
    given = (np.linspace(1.0, 2.0, P), np.zeros(c.n_states), np.sin(t), np.ones(200), np.arange(P), np.ones((1, P)), 1.0)
    sums = path_integration.products_along(c, path, *given, np.array([200]))
    hits = path_integration.bind(path_integration.sum_products, (c,)).stats.cache_hits
    print(repr(float(sums.sum())), sum(hits.values()))
"""


def probed(cache: Path, *names: str) -> list[list[str]]:
    env = os.environ | {
        "DAMPYR_CACHE": str(cache),
        "PYTHONHASHSEED": "0",
    }  # numba writes a set of flags into its symbols
    done = subprocess.run([sys.executable, "-c", PROBE, *names], env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return [line.split() for line in done.stdout.splitlines()]


@pytest.mark.prove
def test_kernels_that_processes_cached_apart_are_right_together(tmp_path: Path) -> None:
    one, other = "dahl", "dahl + spring"
    (first,), (second,) = probed(tmp_path, one), probed(tmp_path, other)
    assert first[1] == second[1] == "0"
    assert probed(tmp_path, one, other) == [[first[0], "1"], [second[0], "1"]]
    assert probed(tmp_path, other, one) == [[second[0], "1"], [first[0], "1"]]


def kernels() -> Iterator[Any]:
    """Of every kind that is cached, those of several dampers."""
    drivers = [
        path_integration.integrate_force,
        path_integration.integrate_jacobian,
        path_integration.sum_products,
        path_integration.sum_products_delayed,
        path_integration.integrate_law_jacobian,
    ]
    dampers = [
        *(name for name in available_parts() if part(name).force),
        "dahl + spring",
        "dahl + delay",
        "bouc_wen + hyperbolic_tangent",
        "dahl + compliance",
    ]
    for one in map(compose, dampers):
        yield from (bind(driver, (one,)) for driver in (*drivers, plant.run, coupled))
        yield bind(coupled, (one, compose("dahl")))
        yield bind(coupled, (one,), "def decide(v): return v")
    yield from map(compile_cached, (*bounded_least_squares.KERNELS, *normal_equations.KERNELS))
    yield compile_cached(oscillator.fill_peaks)
    site = two_storey().connection(1)[None]
    for name in ("dahl", "dahl + spring", "bouc_wen", "hyperbolic_tangent"):
        for precision in (64, 32):
            for together in (False, True):
                given = engine(two_storey(), site, (compose(name),), 0.02, 4, ("drift",), precision, together)
                yield compiled(given.text.source, given.compositions, precision, together)


def content(function: Any) -> tuple[Any, ...]:
    """What a function computes: its code, and by name what it reaches."""
    code, names = function.py_func.__code__, function.py_func.__globals__
    reached = tuple((name, _fingerprint(names[name])) for name in code.co_names if name in names)
    return code.co_code, code.co_consts, code.co_varnames, repr(function.targetoptions.get("forceinline")), reached


def _fingerprint(value: Any) -> Any:
    if isinstance(value, Dispatcher):
        return content(value)
    return (type(value).__name__, value.tobytes()) if isinstance(value, np.generic) else repr(value)


def everything(function: Any) -> Iterator[Any]:
    yield function
    for name in function.py_func.__code__.co_names:
        if isinstance(called := function.py_func.__globals__.get(name), Dispatcher):
            yield from everything(called)


@pytest.mark.prove
def test_functions_of_one_symbol_are_one_function() -> None:
    contents: dict[tuple[str, str], Any] = {}
    for kernel in kernels():
        for function in everything(kernel):
            plain = function.py_func
            assert contents.setdefault((plain.__module__, plain.__qualname__), content(function)) == content(function)
    assert len(contents) > 300


def test_what_reaches_no_part_of_a_damper_is_compiled_once() -> None:
    one, other = ({f.py_func.__name__: f for f in everything(bind(coupled, (compose(c),)))} for c in ("dahl", "spring"))
    for name in ("observe", "correct", "relative_residual", "raise_peaks"):
        assert one[name] is other[name], name
    for name in ("solve_forces", "evaluate", "along", "force", "integrate"):
        assert one[name] is not other[name], name
