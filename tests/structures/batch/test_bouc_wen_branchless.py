"""The Bouc-Wen state in lanes against stiff integration, the exact flow, and ensembles that take the exact one."""

from concurrent.futures import ThreadPoolExecutor
from unittest.mock import patch

import numpy as np
import pytest
from numba import njit
from scipy.integrate import solve_ivp
from tests.structures.batch.uncompiled import uncompiled

from dampyr.ground_motions import el_centro
from dampyr.models import Damper
from dampyr.models.codegen.composition import compose
from dampyr.models.numerics import bouc_wen_exact as exact
from dampyr.structures import ensemble, respond, two_storey
from dampyr.structures.batch import bouc_wen_branchless
from dampyr.structures.batch.run_blocks import _parts

SHAPE = {"c0": 1400.0, "k0": 0.0, "kw": 200.0, "rho": 2e4}


def damper(n, sigma, **other):
    return Damper("bouc_wen", {f"bouc_wen.{k}": v for k, v in (SHAPE | {"sigma": sigma, "n": n} | other).items()})


@pytest.fixture(
    scope="module",
    params=[
        (64, False),
        (32, False),
        pytest.param((64, True), marks=pytest.mark.prove),  # it takes long to compile
        pytest.param((32, True), marks=pytest.mark.prove),
    ],
    ids=lambda param: f"{param[0]}{' compiled' if param[1] else ''}",
)
def walk(request):
    """Many flows of one precision, as the kernels write them; by Python itself, which takes longer, of fewer cases."""
    precision, compile_them = request.param
    kind = np.float64 if precision == 64 else np.float32
    names = _parts(compose("bouc_wen").source() + "\n\n" + bouc_wen_branchless.source(), precision)
    names = names if compile_them else uncompiled(names)
    loop = "def many(y, xi, n, c, out, by):\n    for l in range(y.size):\n"
    loop += "        out[l] = flow(y[l], xi[l], n[l], c[l])\n        by[l] = rate(out[l], n[l], c[l])\n"
    exec(loop, names)
    many = names["many"]
    if compile_them:
        many = njit(error_model="numpy", fastmath={"contract", "nsz", "arcp", "nnan", "ninf"})(many)

    def run(*arguments):
        given = [np.asarray(a, kind) for a in arguments]
        out, by = np.empty_like(given[0]), np.empty_like(given[0])
        with np.errstate(all="ignore"):  # as in a kernel, where bits are shifted and nothing is looked at
            many(*given, out, by)
        return out.astype(float), by.astype(float)

    run.rounding = float(np.finfo(kind).eps)
    run.count = 3000 if compile_them else 420
    return run


def cases(count, shapes, seed=3):
    """States everywhere, also at 0 and at the limits; paths of nothing, of a millionth and of a thousand."""
    rng = np.random.default_rng(seed)
    y, xi = rng.uniform(-1, 1, count), 10 ** rng.uniform(-6, 3, count)
    y[::7], y[1::7], y[2::7], xi[::5] = 0.0, 1.0, -1.0, 0.0
    (n, m), (c, d) = shapes
    return y, xi, rng.uniform(n, m, count), rng.uniform(c, d, count)


@pytest.mark.parametrize(
    ("shapes", "tolerance"),
    [(((1, 1), (0, 1)), 1e-6), (((2, 2), (0, 1)), 5e-6), (((1, 2), (0, 1)), 5e-6), (((1, 3), (-0.3, 1.5)), 2e-4)],
)
def test_it_is_the_exact_flow(walk, shapes, tolerance):
    y, xi, n, c = cases(walk.count, shapes)
    states, rates = walk(y, xi, n, c)
    wanted = np.array([exact.flow(*one) for one in zip(y, xi, n, c)])
    assert np.abs(states - wanted).max() < tolerance
    assert np.abs(rates - [exact.rate(*one) for one in zip(wanted, n, c)]).max() < 4 * tolerance
    still = xi == 0
    assert np.abs(states - y)[still].max() < max(4 * walk.rounding, 1e-10)


@pytest.mark.parametrize(
    ("y", "xi", "n", "c"), [(-1, 3, 1.5, 1), (-0.7, 0.4, 2.5, 0.3), (0, 2, 1.2, 0), (0.4, 1, 3, 1)]
)
def test_it_is_what_a_stiff_integration_finds(walk, y, xi, n, c):
    def slope(_, state):
        u = state[0]
        return [1 + c * abs(u) ** n if u < 0 else 1 - abs(u) ** n]

    done = solve_ivp(slope, (0, xi), [y], method="Radau", rtol=1e-10, atol=1e-12)
    assert walk([y], [xi], [n], [c])[0][0] == pytest.approx(done.y[0, -1], abs=2e-5)


@pytest.mark.parametrize(
    ("n", "sigma"),
    [(1.5, 0.5), *(pytest.param(*case, marks=pytest.mark.by_hand) for case in ((1.0, 1.0), (2.0, 0.8), (3.0, 1.2)))],
)
@pytest.mark.prove
def test_peaks_are_those_of_the_exact_state(n, sigma):
    def peaks():
        with ThreadPoolExecutor(1) as one:
            return ensemble(
                two_storey(), el_centro(), damper(n, sigma), [0.0], [0.05, 1.0], one, quantities=("drift",)
            ).dataset

    dataset = peaks()
    with patch("dampyr.structures.ensembles.ensemble_batches.bouc_wen_branchless.is_vectorisable", lambda _: False):
        wanted = peaks()
    assert not dataset.identical(wanted)  # they did run differently
    np.testing.assert_allclose(dataset.drift, wanted.drift, rtol=2e-6)


@pytest.mark.prove  # its kernels take long to compile
def test_strict_is_respond():
    motion, one = el_centro(), damper(1.5, 0.7)
    dataset = ensemble(two_storey(), motion, one, [0.0], 1.0, accuracy="strict", quantities=("drift",)).dataset
    single = respond(two_storey(), motion, {1: one}, 0.0, accuracy="strict")
    np.testing.assert_allclose(dataset.drift.squeeze(), single.peak_drift, rtol=1e-3)


@pytest.mark.parametrize(
    ("name", "values", "together"),
    [
        ("bouc_wen", {"n": 1.5, "sigma": 1.0}, True),
        ("bouc_wen", {"n": 3.5, "sigma": 1.0}, False),
        ("bouc_wen", {"n": 1.5, "sigma": 0.3}, False),
        ("dahl + bouc_wen", {"n": 1.5, "sigma": 1.0}, True),
        ("dahl", {}, False),
        ("modified_bouc_wen", {"n": 1.5, "sigma": 1.0}, False),
    ],
)
def test_which_states_walk_together(name, values, together):
    composition = compose(name)
    given = np.array([values.get(key.split(".")[1], 1.0) for key in composition.parameters])
    assert bouc_wen_branchless.is_vectorisable([(composition, given)]) is together


def test_one_that_cannot_keeps_all_apart():
    composition = compose("bouc_wen")
    usual, sharp = np.array([1, 1, 1, 1, 1, 1.5]), np.array([1, 1, 1, 1, 1, 9.0])
    assert bouc_wen_branchless.is_vectorisable([(composition, usual), (composition, usual)])
    assert not bouc_wen_branchless.is_vectorisable([(composition, usual), (composition, sharp)])
