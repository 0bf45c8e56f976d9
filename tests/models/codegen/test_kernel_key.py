"""Key of a kernel: it changes with whatever the machine code depends on, and with nothing else."""

import math
from collections.abc import Callable
from types import FunctionType, ModuleType

import numpy as np
import pytest
from numba import njit

from dampyr import source_digest
from dampyr.models.codegen import kernel_key
from dampyr.models.codegen.composition import compose, text_of

MODULE = '''
"""A module with a kernel."""
from math import exp
RATE = 2.0
SHAPE = (1, 2)
LEVELS = np.array([0.5, 1.5])

def unrelated(x):
    return x - 1.0

def weight(x, power=3.0):
    """What it weighs."""
    return RATE * x ** power + SHAPE[1]

@njit(fastmath={"contract"})
def inner(x):
    return exp(x) + LEVELS[0]

def kernel(x):
    # a loop
    for i in range(4):
        x += weight(x) + inner(x)
    return x
'''
CHANGES = {
    "an instruction of the kernel": ("x += weight(x) + inner(x)", "x += weight(x) - inner(x)"),
    "a number within it": ("range(4)", "range(5)"),
    "a function that it calls": ("RATE * x ** power", "RATE + x ** power"),
    "a default of that": ("power=3.0", "power=2.0"),
    "a number of the module": ("RATE = 2.0", "RATE = 2.5"),
    "its kind": ("RATE = 2.0", "RATE = np.float32(2.0)"),
    "a tuple of the module": ("SHAPE = (1, 2)", "SHAPE = (1, 3)"),
    "an array of the module": ("np.array([0.5", "np.array([0.25"),
    "a compiled function that it calls": ("exp(x) + LEVELS", "exp(x) * LEVELS"),
    "a setting of the compiler": ('{"contract"}', '{"contract", "reassoc"}'),
    "a function of another package": ("from math import exp", "from math import expm1 as exp"),
}
NO_CHANGES = {
    "a comment": ("# a loop", "# another\n    # comment"),
    "a docstring": ("What it weighs", "What it measures"),
    "a function that it does not call": ("x - 1.0", "x - 2.0"),
}


def key_of(text: str) -> str:
    module = ModuleType("module_with_a_kernel")
    module.__dict__.update(np=np, njit=njit, math=math)
    exec(compile(text, "module", "exec"), module.__dict__)
    return kernel_key.kernel_key(module.__dict__["kernel"])


@pytest.mark.parametrize("what", CHANGES)
def test_what_a_kernel_depends_on_gives_it_another_key(what: str) -> None:
    old, new = CHANGES[what]
    assert MODULE.count(old) == 1
    assert key_of(MODULE.replace(old, new)) != key_of(MODULE)


@pytest.mark.parametrize("what", NO_CHANGES)
def test_what_it_does_not_depend_on_leaves_its_key(what: str) -> None:
    old, new = NO_CHANGES[what]
    assert MODULE.count(old) == 1
    assert key_of(MODULE.replace(old, new)) == key_of(MODULE)


def test_a_variable_of_an_enclosing_function_is_in_the_key() -> None:
    def made(factor: float) -> Callable[[float], float]:
        return lambda x: factor * x

    assert kernel_key.kernel_key(made(2.0)) != kernel_key.kernel_key(made(3.0))
    assert kernel_key.kernel_key(made(2.0)) == kernel_key.kernel_key(made(2.0))


def test_functions_that_call_each_other_have_a_key() -> None:
    names: dict[str, FunctionType] = {}
    exec("def kernel(n):\n    return odd(n)\ndef odd(n):\n    return n and kernel(n - 1)\n", names)
    assert len(kernel_key.kernel_key(names["kernel"])) == 64


def test_an_object_that_is_not_known_stands_for_all_sources(monkeypatch: pytest.MonkeyPatch) -> None:
    names = {"held": object()}
    exec("def kernel(x):\n    return held(x)\n", names)
    before = kernel_key.kernel_key(names["kernel"])  # type: ignore[arg-type]
    monkeypatch.setattr(kernel_key, "source_digest", lambda: "edited")
    assert source_digest.source_digest() != "edited"
    assert kernel_key.kernel_key(names["kernel"]) != before  # type: ignore[arg-type]


@pytest.mark.parametrize("model", ["dahl", "bouc_wen", "tan"])
def test_formulas_of_parts_reach_the_key_by_their_text(model: str) -> None:
    if model == "tan":
        model = "hyperbolic_tangent + spring"
    text, names = text_of((compose(model),)), {"tanh": math.tanh, "exp": math.exp}
    exec(text, names)
    functions = [value for value in names.values() if isinstance(value, FunctionType)]
    assert len({kernel_key.kernel_key(function) for function in functions}) == len(functions)
