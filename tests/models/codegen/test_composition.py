"""Compositions of parts: what they hold, what has the same effect, and what is written once."""

import itertools

import numpy as np
import pytest
from tests.models.dahl_of_chapter_4 import T, V, X

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.models.codegen import batched_path
from dampyr.models.codegen.composition import compose


@pytest.mark.prove
def test_the_parts_of_a_composition_add_up_in_any_order() -> None:
    laws = {"dahl.kx": 800.0, "dahl.kw": 50.0, "dahl.rho": 9000.0, "spring.k0": 700.0}
    laws |= {"hyperbolic_tangent.c": 10.0, "hyperbolic_tangent.ft": 80.0}
    laws |= {"hyperbolic_tangent.v0": 0.01, "hyperbolic_tangent.s": 0.3}
    names = ("dahl", "spring", "hyperbolic_tangent")
    alone = sum(
        Damper(n, {k: v for k, v in laws.items() if k.startswith(n + ".")}).force(T, X, voltage=0.0, velocity=V)
        for n in names
    )
    for order in itertools.permutations(names):
        np.testing.assert_allclose(Damper(order, laws).force(T, X, voltage=0.0, velocity=V), alone, rtol=1e-12)


def test_a_composition_can_be_read() -> None:
    text = compose("dahl + spring").source()
    assert "def advance_0(s, x0, x1, v0, v1, dt, p):" in text
    compile(text, "<test>", "exec")


def test_what_has_the_same_effect_is_seen_from_the_formulas() -> None:
    assert compose("dahl + hyperbolic_tangent").twins == {"hyperbolic_tangent.c": "dahl.kx"}
    assert compose("bouc_wen + spring").twins == {"spring.k0": "bouc_wen.k0"}
    assert compose("dahl + biviscous + sigmoid").twins == {"biviscous.c": "dahl.kx"}
    assert compose("dahl + spring + inertia + compliance + delay").twins == {}


def test_something_must_push() -> None:
    with pytest.raises(InputError, match="nothing that stretches it"):
        compose("inertia + compliance")


def test_a_composition_is_written_once(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = compose("dahl + spring").workspace_rows
    monkeypatch.setattr(batched_path, "write_step_block", lambda layout: pytest.fail("written again"))
    assert compose("dahl + spring").workspace_rows == rows
