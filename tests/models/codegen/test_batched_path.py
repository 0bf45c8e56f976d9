"""The walk over several samples at once, against the one sample by sample, for what a fit sums."""

import numpy as np
import pytest

from dampyr.models import compose
from dampyr.models.codegen.batched_path import write_step_block
from dampyr.models.part import REGISTRY, part
from dampyr.models.path_integration import along_with_columns, products_along
from dampyr.registry import names

N = 700  # more than five blocks
SIZES = {"N": 60.0, "N s/m": 700.0, "N/m": 500.0, "1/m": 900.0, "m/s": 0.02, "s": 0.0, "1/s": 0.3, "kg": 3.0, "m": 0.1}
TOGETHER = ["dahl + hyperbolic_tangent + spring", "bouc_wen + sigmoid + offset", "dahl + compliance"]
ALONE = [name for name in names(REGISTRY) if part(name).force and not part(name).add_on]


CONSTANT = [(name, False) for name in (*ALONE, *TOGETHER)]
# a fit stores the columns of states that remember an input
VARYING = [(name, True) for name, _ in CONSTANT if not compose(name).n_states]


@pytest.mark.prove  # its kernels take long to compile
@pytest.mark.parametrize(("name", "varying"), [*CONSTANT, *VARYING])
def test_sums_of_products_are_those_of_the_stored_columns(name: str, varying: bool) -> None:
    composition = compose(name)
    t = 0.004 * np.arange(N)
    x = 0.008 * np.sin(7.0 * t) + 0.002 * np.sin(31.0 * t)
    v = np.gradient(x, t)
    plain = 0.0 if any(p.unbounded for p in composition.parts) else 1.3  # no hardening: a force that is finite
    sizes = [min(max(SIZES.get(q.unit, plain), q.low), q.high) for q in composition.quantities.values()]
    p = np.array(
        [
            size if size or not q.open_low else 0.01
            for size, q in zip(sizes, composition.quantities.values(), strict=True)
        ]
    )
    p = p * (1.0 + 0.1 * np.sin(t)[:, None]) if varying else p
    state0 = np.full(composition.n_states, 0.2)
    force, weight = 100.0 * np.cos(5.0 * t), np.array([0.01])
    path = (t, x, v, np.gradient(v, t))
    F, J = along_with_columns(composition, t, x, v, p, state0)
    source = np.arange(J.shape[1] + 2)
    table = weight * np.column_stack((J, F, np.ones(N), force - F))
    ends = np.array([1, 129, 400, N])
    products = products_along(composition, path, p, state0, force, weight, source, np.ones((1, source.size)), 1.0, ends)
    expected = np.stack([part.T @ part for part in np.split(table, ends[:-1])])
    scale = np.sqrt(np.einsum("gii->gi", expected)) + 1e-100
    assert np.max(np.abs(products - expected) / (scale[:, :, None] * scale[:, None, :])) < 1e-11


def test_what_no_state_enters_is_computed_ahead() -> None:
    called, step_block, _ = write_step_block(compose("dahl + hyperbolic_tangent").layout)
    text = "\n".join([*called, step_block.python()])
    assert text.count("quick_exp(") == 1
    assert text.count("quick_tanh(") == 1
    assert "exp(" not in text.replace("quick_exp(", "")
