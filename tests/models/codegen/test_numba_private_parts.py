"""The parts of numba that are not public and that the kernels rest on: all are listed here, and the installed numba has them.

A numba that moves one of them fails here, by its name, before a kernel does something else than it did. `pyproject.toml` holds
numba below the first minor version that nobody has run these tests with.
"""

import ast
import inspect
import re
import tomllib
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numba
import pytest

ROOT = Path(__file__).resolve().parents[3]
PRIVATE = {
    "numba.core.caching._CacheLocator": ("ensure_cache_path", "get_cache_path", "get_source_stamp", "get_disambiguator"),
    "numba.core.caching.CompileResultCacheImpl": ("_locator_classes", "locator", "filename_base"),
    "numba.core.caching.IndexDataCacheFile": ("save", "load", "_load_index", "_save_index", "_data_name", "_save_data"),
    "numba.core.caching.FunctionCache": ("_impl_class", "load_overload", "save_overload"),
    "numba.core.codegen.JITCodeLibrary": (
        "_optimize_final_module", "_finalize_final_module", "_ensure_finalized", "get_pointer_to_function", "codegen",
        "_final_module", "_codegen", "enable_object_caching", "finalize",
    ),
    "numba.core.compiler.Compiler": ("define_pipelines",),
    "numba.core.compiler.compile_result": (),
    "numba.core.compiler_lock.global_compiler_lock": (),
    "numba.core.event.register": (),
    "numba.core.serialize.dumps": (),
    "numba.core.event.Listener": ("on_start", "on_end"),
}  # fmt: skip
"""What `dampyr.models.codegen` imports, and of each class what it overrides or calls."""
GIVEN = {
    "numba.core.codegen.JITCPUCodegen": ("_module_pass_manager", "set_env"),
    "numba.core.compiler.CompileResult": ("_reduce",),
}
"""The classes of objects that numba hands out, and what is called of them."""
OPTIONS = ("_nrt", "forceinline", "no_cpython_wrapper", "no_cfunc_wrapper", "error_model", "fastmath", "nogil")


def imports_of_numba() -> set[str]:
    """What dampyr's files name of numba beyond its public face: ``numba.core...``, as dotted names."""
    found = set()
    for path in (ROOT / "src").rglob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        modules = {}
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("numba."):
                modules |= {(each.asname or each.name): f"{node.module}.{each.name}" for each in node.names}
        for name, dotted in modules.items():
            used = {
                n.attr for n in ast.walk(tree) if isinstance(n, ast.Attribute) and getattr(n.value, "id", "") == name
            }
            is_module = isinstance(_imported(dotted), ModuleType)
            found |= {f"{dotted}.{attribute}" for attribute in used} if is_module else {dotted}
    return found


def _imported(dotted: str) -> Any:
    module, _, name = dotted.rpartition(".")
    found = getattr(import_module(module), name, None)
    return found or import_module(dotted)


def test_every_private_part_that_is_used_is_listed() -> None:
    assert imports_of_numba() == set(PRIVATE)


@pytest.mark.parametrize("dotted", PRIVATE | GIVEN)
def test_the_installed_numba_has_it(dotted: str) -> None:
    module, _, name = dotted.rpartition(".")
    assert hasattr(import_module(module), name), f"numba {numba.__version__} has no {dotted}"
    cls = getattr(import_module(module), name)
    for member in (PRIVATE | GIVEN)[dotted]:
        assert hasattr(cls, member) or f"self.{member}" in _source(cls), (
            f"numba {numba.__version__}: {dotted} has no {member}"
        )


def _source(cls: type) -> str:
    return "".join(inspect.getsource(each) for each in cls.__mro__ if each.__module__.startswith("numba"))


def test_a_kernels_options_are_known() -> None:
    from numba.core.cpu import CPUTargetOptions

    for option in OPTIONS:
        assert hasattr(CPUTargetOptions, option), f"numba {numba.__version__} has no option {option}"


def test_numba_is_held_below_what_nobody_has_tried() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    [wanted] = [each for each in project["dependencies"] if re.match(r"numba\b", each)]
    limits = re.fullmatch(r"numba>=0\.(\d+),<0\.(\d+)", wanted)
    assert limits, wanted
    assert int(limits[1]) <= int(numba.__version__.split(".")[1]) < int(limits[2])
