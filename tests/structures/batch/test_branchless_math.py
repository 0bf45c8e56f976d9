"""Functions without branches against those of numpy, within what their series promise."""

import numpy as np
import pytest
from tests.structures.batch.uncompiled import uncompiled

from dampyr.structures.batch import branchless_math

LIMITS = {64: (1e-8, 1e-8, 5e-9), 32: (4e-6, 6e-7, 1e-6)}  # relative of exp, absolute of tanh, relative of log


@pytest.fixture(scope="module", params=[64, 32])
def named(request: pytest.FixtureRequest) -> dict:
    """The functions of one precision as plain Python, and its type under "kind"."""
    names = uncompiled(branchless_math.functions(request.param))
    return names | {"kind": np.float64 if request.param == 64 else np.float32, "limits": LIMITS[request.param]}


def values(named: dict, name: str, x: np.ndarray) -> np.ndarray:
    with np.errstate(over="ignore"):  # bits are shifted as whole numbers
        return np.array([named[name](named["kind"](value)) for value in x], float)


def test_exp_tanh_and_log(named: dict) -> None:
    rng, kind = np.random.default_rng(1), named["kind"]
    relative, absolute, of_log = named["limits"]
    x = np.append(rng.uniform(-20.0, 20.0, 400), [0.0, -1e-9, 1e-9]).astype(kind).astype(float)
    np.testing.assert_allclose(values(named, "exp", x), np.exp(x), rtol=relative)
    assert named["exp"](kind(0.0)) == 1.0
    assert 0.0 < named["exp"](kind(-1e4)) < 1e-37
    t = x / 20.0
    np.testing.assert_allclose(values(named, "tanh", t), np.tanh(t.astype(kind).astype(float)), atol=absolute, rtol=0)
    positive = (10 ** rng.uniform(-12.0, 12.0, 400)).astype(kind).astype(float)
    np.testing.assert_allclose(values(named, "log", positive), np.log(positive), rtol=of_log, atol=of_log)


def test_a_sign_is_copied_and_an_eighth_is_divided_roughly(named: dict) -> None:
    x = np.array([2.5, -2.5, 0.0, -1e-20, 1e20])
    positive = np.geomspace(1e-20, 1e20, 301)
    np.testing.assert_allclose(values(named, "eighth_over", positive) * 8 * positive, 1.0, atol=3e-3)
    kind = named["kind"]
    for value in x:
        assert named["copysign"](kind(3.0), kind(value)) == np.copysign(3.0, value)
        assert named["copysign"](kind(-3.0), kind(value)) == np.copysign(3.0, value)
