"""The formula language and its derivatives."""

from math import atan, copysign, cos, exp, log, sin, sqrt, tanh

import numpy as np
import pytest

from dampyr.models.codegen.formula import partials_of, read, tangent, tangents
from dampyr.models.numerics.bouc_wen_exact import flow

K = 3.0


def everything(w, x, v, p):
    a = sin(w) * cos(x) + tanh(v) / (1.0 + p**2)
    if v > 0.5:
        b = exp(-a) - K * sqrt(p)
    else:
        b = log(p) + abs(x) * copysign(1.0, w)
        a = -a
    return a * b + atan(w * x) ** 3


def two_states(w, z, x1, p):
    w1 = w + p * x1
    return w1, z * w1


def with_intrinsic(w, p):
    return flow(w, p * 0.3, 1.4, 2.0 * p)


def numeric(function, arguments, k):
    up, down = list(arguments), list(arguments)
    up[k] += 1e-6
    down[k] -= 1e-6
    return (np.array(function(*up)) - np.array(function(*down))) / 2e-6


def derived(function, active, unit):
    formula = read(function, "f")
    names = dict(function.__globals__) | partials_of(formula)
    exec(tangent(formula, "derivative", active, unit), names)
    return names["derivative"]


@pytest.mark.parametrize("unit", ["w", "x", "v", "p"])
@pytest.mark.parametrize("v", [0.9, 0.1])
def test_derivatives_of_every_construct(unit: str, v: float) -> None:
    arguments = (0.4, -0.7, v, 1.3)
    k = ["w", "x", "v", "p"].index(unit)
    assert derived(everything, [], unit)(*arguments) == pytest.approx(numeric(everything, arguments, k), rel=1e-7)


def test_tangents_of_states_come_in_and_go_out() -> None:
    arguments = (0.4, -0.7, 1.1, 1.3)
    derivative = derived(two_states, ["w", "z"], "p")(*arguments, 0.5, -2.0)
    expected = numeric(two_states, arguments, 0) * 0.5 + numeric(two_states, arguments, 1) * -2.0
    np.testing.assert_allclose(derivative, expected + numeric(two_states, arguments, 3), rtol=1e-7)


@pytest.mark.parametrize("w", [-0.8, -0.05, 0.0, 0.3, 0.95])
def test_the_chain_goes_through_intrinsics(w: float) -> None:
    arguments = (w, 0.9)
    assert derived(with_intrinsic, ["w"], "p")(*arguments, 0.0) == pytest.approx(
        numeric(with_intrinsic, arguments, 1), abs=1e-6
    )


def test_what_a_formula_cannot_contain_is_refused() -> None:
    def looping(w):
        while w > 1:
            w = w / 2
        return w

    with pytest.raises(TypeError, match="cannot contain"):
        tangent(read(looping, "f"), "d", ["w"])


def test_several_directions_at_once_come_with_the_values() -> None:
    formula = read(everything, "f")
    names = dict(everything.__globals__)
    exec(tangents(formula, "both", ["w", "x"], ["p", None]), names)
    for v in (0.9, 0.1):
        arguments = (0.4, -0.7, v, 1.3)
        value, by_p, along = names["both"](*arguments, 0.0, 0.0, 2.0, -0.5)
        assert value == everything(*arguments)
        assert by_p == pytest.approx(numeric(everything, arguments, 3), rel=1e-7)
        expected = 2.0 * numeric(everything, arguments, 0) - 0.5 * numeric(everything, arguments, 1)
        assert along == pytest.approx(expected, rel=1e-7)
