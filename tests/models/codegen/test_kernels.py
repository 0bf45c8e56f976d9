"""Compiled kernels: cached on disk, never out of date."""

import gc
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from itertools import count
from pathlib import Path

import pytest
from numba import float64, njit
from numba.core.errors import TypingError
from numba.extending import overload

import dampyr
from dampyr.models import path_integration
from dampyr.models.codegen import kernel_cache, kernels
from dampyr.models.codegen.composition import compose
from dampyr.structures.time_history import time_stepping

PROBE = """
import sys, numpy as np
from dampyr.models import Damper
from dampyr.models.codegen.kernels import bind
from dampyr.models import path_integration
d = Damper("dahl", {"dahl.kx": 0.0, "dahl.kw": 1.0, "dahl.rho": 100.0})
f = d.force(np.array([0.0, 1.0]), np.array([0.0, 0.01]), voltage=0.0, velocity=np.zeros(2))
stats = bind(path_integration.integrate_force, (d.composition,)).stats
print(repr(float(f[-1])), sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""


def run(package: Path, cache: Path) -> tuple[float, int, int]:
    env = os.environ | {"DAMPYR_CACHE": str(cache), "PYTHONPATH": str(package.parent)}
    done = subprocess.run([sys.executable, "-c", PROBE], env=env, capture_output=True, text=True, check=True)
    force, hits, misses = done.stdout.split()
    return float(force), int(hits), int(misses)


@pytest.mark.prove
def test_a_kernel_is_cached_and_an_edited_model_is_compiled_anew(tmp_path: Path) -> None:
    package, cache = tmp_path / "dampyr", tmp_path / "cache"
    shutil.copytree(Path(dampyr.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__"))
    first, hits, misses = run(package, cache)
    assert (hits, misses) == (0, 1)
    again, hits, misses = run(package, cache)
    assert (again, hits, misses) == (first, 1, 0)
    part = package / "models" / "parts" / "dahl.py"
    part.write_text(part.read_text().replace("return kx * v + kw * w", "return kx * v + 2.0 * kw * w"))
    edited, hits, misses = run(package, cache)
    assert edited == 2 * first
    assert (hits, misses) == (0, 1)


@pytest.fixture
def no_kernels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A folder without kernels in the place of the user's."""
    monkeypatch.setenv("DAMPYR_CACHE", str(tmp_path))
    kernel_cache.cache_folder.cache_clear()
    yield
    kernel_cache.cache_folder.cache_clear()


@pytest.mark.usefixtures("no_kernels")
def test_the_garbage_collector_rests_while_a_kernel_is_compiled_and_works_again_after_it() -> None:
    resting: list[bool] = []

    @overload(_doubled)
    def text_of_doubled(x):  # type: ignore[no-untyped-def]
        resting.append(not gc.isenabled())  # numba asks for this text while it compiles
        return lambda x: 2.0 * x

    def kernel(x: float) -> float:
        return _doubled(x)

    def wrong(x: float) -> float:
        return _unknown(x)  # type: ignore[name-defined, no-any-return]  # noqa: F821

    assert gc.isenabled()
    assert kernels.jit(kernels.named(kernel, __name__, "looked at"), keep=True)(1.5) == 3.0
    assert resting
    assert all(resting)
    assert gc.isenabled()
    with pytest.raises(TypingError):
        kernels.jit(kernels.named(wrong, __name__, "wrong"), keep=True)(1.5)
    assert gc.isenabled()
    gc.disable()  # where the caller has switched it off it stays off
    try:
        kernels.jit(kernels.named(kernel, __name__, "looked at again"), keep=True)(2)
        assert not gc.isenabled()
    finally:
        gc.enable()


def _doubled(x):  # type: ignore[no-untyped-def]
    return 2.0 * x


def test_inner_functions_are_written_into_their_callers_and_have_no_machine_code_of_their_own() -> None:
    def formula(x: float) -> float:
        return 2.0 * x

    def step(x: float) -> float:
        return formula(x) + 1.0

    formula = kernels.jit(kernels.named(formula, __name__, "of a part"))
    step = kernels.jit(kernels.named(step, __name__, "of a driver"), inline=True)
    driver = njit(lambda x: step(x) - 0.5)
    assert driver(3.0) == 6.5
    [compiled_step], [compiled_formula] = step.overloads.values(), formula.overloads.values()
    assert compiled_step.fndesc.inline
    assert not compiled_formula.fndesc.inline  # numba hands the setting of a caller on, unless told
    engine = driver.overloads[(float64,)].library.codegen._engine
    assert engine.is_symbol_defined(driver.overloads[(float64,)].fndesc.mangled_name)
    for inner in (compiled_step, compiled_formula):
        assert not engine.is_symbol_defined(inner.fndesc.mangled_name)


def test_a_kernel_is_bound_once_for_all_compositions_whose_functions_it_calls_are_the_same() -> None:
    """A delay has no formula; the derivatives by the parameters, of which it is one, are of no concern to a building."""
    dahl, late, stiff = (compose(names) for names in ("dahl", "dahl + delay", "dahl + spring"))
    for driver in (time_stepping.integrate, path_integration.integrate_force):
        assert kernels.bind(driver, (late,)) is kernels.bind(driver, (dahl,))
        assert kernels.bind(driver, (stiff,)) is not kernels.bind(driver, (dahl,))
    of_fit = path_integration.integrate_jacobian
    assert kernels.bind(of_fit, (late,)) is not kernels.bind(of_fit, (dahl,))


def test_where_the_cache_cannot_be_written_kernels_go_to_a_temporary_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blocked = tmp_path / "a-file"
    blocked.write_text("")
    monkeypatch.setenv("DAMPYR_CACHE", str(blocked))
    kernel_cache.cache_folder.cache_clear()
    try:
        folder = kernel_cache.cache_folder()
    finally:
        kernel_cache.cache_folder.cache_clear()
    assert folder.is_dir()
    assert blocked not in folder.parents
    assert blocked.read_text() == ""
    folder.rmdir()


@pytest.mark.prove
def test_a_cache_that_cannot_be_written_is_no_obstacle(tmp_path: Path) -> None:
    blocked = tmp_path / "a-file"
    blocked.write_text("")
    force, _, _ = run(Path(dampyr.__file__).parent, blocked)
    assert force > 0


def test_two_processes_that_save_at_once_never_exchange_their_code(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both look before either has written; the second writes its code while the first is about to write its own."""

    def plain() -> None:
        """A kernel."""

    plain.settings = ()  # type: ignore[attr-defined]
    first, second = (kernel_cache.cache_class()(plain)._cache_file for _ in range(2))
    first.flush()
    write, look, looks = first._save_data, second._load_index, count()

    def late(name: str, code: str) -> None:
        monkeypatch.setattr(second, "_load_index", lambda: look() if next(looks) else {})
        second.save("float32", "code of float32")
        write(name, code)

    monkeypatch.setattr(first, "_save_data", late)
    first.save("float64", "code of float64")
    for signature in ("float64", "float32"):
        assert first.load(signature) in (None, f"code of {signature}")
    assert look()
