"""Compositions of parts: what they hold, what has the same effect, and what is written once."""

import importlib
import itertools
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from tests.models.dahl_of_chapter_4 import T, V, X

from dampyr.errors import InputError
from dampyr.models import Damper, parts
from dampyr.models.codegen import batched_path
from dampyr.models.codegen.composition import compose, text_of


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
    assert "def advance_site0(s, x0, x1, v0, v1, dt, p):" in text
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


PART = """
from dataclasses import dataclass
from typing import Annotated

from dampyr.models.codegen.formula import intrinsic
from dampyr.units import Quantity


@dataclass(frozen=True)
class {name}:
    c: Annotated[float, Quantity("N s/m")]


@intrinsic()
def {helper}(v: float) -> float:
    return {factor} * v


def force(v: float, c: float) -> float:
    return c * {helper}(v)
"""


@pytest.fixture
def own_part(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[[str, str, float], None]:
    """Writes the file of a part whose force is ``factor`` times c v, by a function called ``helper``."""
    monkeypatch.setattr(parts, "__path__", [*parts.__path__, str(tmp_path)])

    def write(name: str, helper: str, factor: float) -> None:
        (tmp_path / f"{name}.py").write_text(
            PART.format(name=name.title().replace("_", ""), helper=helper, factor=factor)
        )
        monkeypatch.setitem(sys.modules, f"{parts.__name__}.{name}", None)
        monkeypatch.delitem(sys.modules, f"{parts.__name__}.{name}")
        importlib.invalidate_caches()

    return write


def test_functions_of_two_parts_under_one_name_do_not_take_each_others_place(own_part: Callable[..., None]) -> None:
    own_part("twofold", "times", 2.0)
    own_part("threefold", "times", 3.0)
    with pytest.raises(InputError, match=r"two functions .* named 'times' .*another name"):
        compose("twofold + threefold").source()
    with pytest.raises(InputError, match="named 'times'"):
        text_of((compose("twofold"), compose("threefold")))


@pytest.mark.parametrize("name", ["phi", "solve", "advance"])
def test_a_function_of_a_part_is_not_called_as_one_of_the_whole(own_part: Callable[..., None], name: str) -> None:
    own_part(f"with_{name}", name, 2.0)
    with pytest.raises(InputError, match=f"named '{name}'"):
        compose(f"with_{name}").formulas()


def test_a_function_of_a_part_may_end_in_a_number_as_those_of_sites_do(own_part: Callable[..., None]) -> None:
    own_part("numbered", "phi_1", 2.0)
    text = text_of((compose("numbered"), compose("numbered + compliance")))
    names: dict[str, object] = {}
    exec(text, names)
    assert names["force"](0, np.zeros(0), 0.0, 0.5, 0.0, np.array([100.0])) == 100.0
    assert names["force"](1, np.array([7.0]), 0.0, 0.5, 0.0, np.array([100.0, 1e9])) == 7.0
