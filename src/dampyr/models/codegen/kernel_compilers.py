"""Numba's compiler, as kernels and the functions within them are compiled.

Numba's front end infers the types of a kernel and of the functions within it and writes LLVM's bitcode, which does not depend
on the processor. LLVM optimises this bitcode and makes machine code of it. So bitcode that comes with a wheel
(`dampyr.models.codegen.shipped_kernels`) gives the same machine code as that of a kernel compiled from its source.
"""

from __future__ import annotations

import gc
from functools import lru_cache
from typing import Any

QUICK_LEVEL = 2  # LLVM's; of a kernel whose loops are short the third gains nothing, and takes a third more time


@lru_cache(maxsize=1)
def inner_compiler() -> Any:
    """Numba's compiler for functions that kernels alone call: to the compiler's own language, no further.

    Numba optimises every function with all that it calls, makes machine code of it, and does so again in each caller. Of an
    inner function no machine code is ever run: the kernel takes its text, and is optimised as a whole, once.
    """
    from numba.core.codegen import JITCodeLibrary
    from numba.core.compiler import Compiler

    class UncompiledLibrary(JITCodeLibrary):
        def _optimize_final_module(self) -> None:
            pass

        def _finalize_final_module(self) -> None:
            self._finalized = True

        def get_pointer_to_function(self, name: str) -> int:
            self._ensure_finalized()
            return 0  # as numba says of a function without a wrapper for Python

        @property
        def codegen(self) -> Any:
            return self

        def set_env(self, name: str, environment: Any) -> None:
            """There is no machine code that could hold the Python objects of an error."""

    class InnerCompiler(Compiler):
        def __init__(self, typing: Any, target: Any, library: Any, *more: Any) -> None:
            super().__init__(typing, target, UncompiledLibrary(target.codegen(), "inner"), *more)

    return InnerCompiler


@lru_cache(maxsize=2)
def kernel_compiler(vectorised: bool) -> Any:
    """Numba's compiler for a kernel; ``vectorised`` lets LLVM take several turns of a loop at a time."""
    from numba.core.compiler import Compiler

    class KernelCompiler(Compiler):
        def __init__(self, typing: Any, target: Any, library: Any, *more: Any) -> None:
            super().__init__(typing, target, _new_library(target, vectorised), *more)

    return KernelCompiler


def unoptimised(compiled: Any) -> tuple[Any, ...]:
    """What numba's front end has made of a kernel that was compiled in this process, as `optimised` takes it."""
    library = compiled.library
    return library.vectorised, library.bitcode, compiled._reduce()[1:]


def optimised(kernel: tuple[Any, ...], target: Any) -> Any:
    """An `unoptimised` kernel, compiled for this processor."""
    from numba.core.compiler import compile_result
    from numba.core.compiler_lock import global_compiler_lock

    vectorised, bitcode, of_signature = kernel
    description, environment, signature, objectmode, lifted, annotation, reload, environments = of_signature
    with global_compiler_lock:
        library = _new_library(target, vectorised)
        library.read(bitcode)
        library.finalize()
        entry_point = target.get_executable(library, description, environment)
        for each in environments:
            library.codegen.set_env(each.env_name, each)
    return compile_result(
        target_context=target,
        typing_context=target.typing_context,
        library=library,
        environment=environment,
        entry_point=entry_point,
        fndesc=description,
        type_annotation=annotation,
        signature=signature,
        objectmode=objectmode,
        lifted=lifted,
        typing_error=None,
        call_helper=None,
        metadata=None,
        reload_init=reload,
        referenced_envs=environments,
    )


def _new_library(target: Any, vectorised: bool) -> Any:
    """What holds a kernel's bitcode and then its machine code."""
    library = _library_class()(target.codegen(), "kernel")
    library.vectorised = vectorised
    library.enable_object_caching()
    return library


@lru_cache(maxsize=1)
def _library_class() -> Any:
    from llvmlite.binding import parse_bitcode
    from numba.core.codegen import JITCodeLibrary

    class KernelLibrary(JITCodeLibrary):
        bitcode: bytes | None = None  # not optimised
        vectorised = True

        def read(self, bitcode: bytes) -> None:
            self.bitcode, self._final_module = bitcode, parse_bitcode(bitcode)

        def _optimize_final_module(self) -> None:
            if self.bitcode is None:  # read again, as that of a wheel is: not a bit of the result may differ
                self.read(self._final_module.as_bitcode())
            if self.vectorised:
                super()._optimize_final_module()
                return
            passes, builder = self._codegen._module_pass_manager(opt=QUICK_LEVEL, loop_vectorize=False)
            passes.run(self._final_module, builder)

    return KernelLibrary


@lru_cache(maxsize=1)
def pause_garbage_collection() -> None:
    """Let Python's collector rest while numba compiles: a tenth of that time went into looking through what is still in use."""
    from numba.core.event import Listener, register

    class Pause(Listener):
        depth, resumes = 0, False  # functions that are being compiled, one within another; whether the collector was on

        def on_start(self, event: Any) -> None:
            if self.depth == 0:
                self.resumes = gc.isenabled()
                gc.disable()
            self.depth += 1

        def on_end(self, event: Any) -> None:
            self.depth -= 1
            if self.depth == 0 and self.resumes:
                gc.enable()

    register("numba:compile", Pause())
