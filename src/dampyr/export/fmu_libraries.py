"""The shared libraries of an FMU: for this machine by its C compiler, for other platforms by Zig's.

Zig's C compiler (the extra ``fmu``) brings the C library of each platform along, so that one machine makes all of them. Its
first library for Windows takes about a minute, as it compiles the MinGW runtime first, and keeps it. Linux ones name a glibc of
2.17, which every Linux of the last ten years has.
"""

from __future__ import annotations

import platform
import shutil
import struct
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from dampyr.errors import InputError, install_line

COMPILERS = ("gcc", "clang", "cc")
ALL = "all"


@dataclass(frozen=True)
class _Build:
    """A target of Zig, the folder of its library in FMI 3, and the suffix."""

    target: str
    folder: str
    suffix: str


PLATFORMS: dict[str, tuple[_Build, ...]] = {
    "linux64": (_Build("x86_64-linux-gnu.2.17", "x86_64-linux", ".so"),),
    "win64": (_Build("x86_64-windows-gnu", "x86_64-windows", ".dll"),),
    "darwin64": (
        _Build("x86_64-macos", "x86_64-darwin", ".dylib"),
        _Build("aarch64-macos", "aarch64-darwin", ".dylib"),
    ),
    "linux-arm64": (_Build("aarch64-linux-gnu.2.17", "aarch64-linux", ".so"),),
}
WITHOUT_NAME = ("linux-arm64",)  # in FMI 2.0
# Of a universal binary of macOS (mach-o/fat.h): its mark, the processors' types, and the alignment of the parts.
FAT_MAGIC, FAT_ALIGNMENT = 0xCAFEBABE, 14
FAT_PROCESSORS = {"x86_64-macos": (0x01000007, 3), "aarch64-macos": (0x0100000C, 0)}


def check_platforms(platforms: Sequence[str], fmi: int) -> tuple[str, ...]:
    """The platforms in their order, each once; ``"all"`` are those that the version of the standard names. Raises
    :class:`InputError` for one that is not known, and where no compiler is installed."""
    named = tuple(name for name in PLATFORMS if fmi == 3 or name not in WITHOUT_NAME)
    wanted = named if ALL in platforms else tuple(dict.fromkeys(platforms))
    for name in wanted:
        if name not in PLATFORMS:
            raise InputError(f"platform {name!r} is not known; choose from {', '.join((*PLATFORMS, ALL))}")
        if name not in named:
            raise InputError(f"FMI 2.0 has no name for {name}; write FMI 3 (fmi=3, --fmi 3), or leave it out")
    if wanted and find_spec("ziglang") is None:
        raise InputError(f"libraries for named platforms need Zig's C compiler; install it: {install_line('fmu')}")
    if not wanted and _find_compiler() is None:
        raise InputError(
            f"an FMU needs a C compiler, and none is installed; install gcc, or {install_line('fmu')} and name platforms "
            "(platforms=, --platform), or export to c"
        )
    return wanted


def compile_libraries(sources: dict[str, str], name: str, fmi: int, platforms: Sequence[str] = ()) -> dict[str, bytes]:
    """The libraries of these C ``sources`` by their path in the archive: of this machine, or of the ``platforms``."""
    if not platforms:
        compiler = _find_compiler() or COMPILERS[0]
        return {f"{_folder_here(fmi)}/{name}{_suffix_here()}": _compile([compiler], sources, _suffix_here())}
    libraries = {}
    for chosen in platforms:
        made = {
            build: _compile(
                [sys.executable, "-m", "ziglang", "cc", "-target", build.target, "-s"], sources, build.suffix
            )
            for build in PLATFORMS[chosen]
        }
        if fmi == 2:
            parts = [(FAT_PROCESSORS[build.target], library) for build, library in made.items() if len(made) > 1]
            library = _join_universal(parts) if parts else next(iter(made.values()))
            libraries[f"{chosen}/{name}{PLATFORMS[chosen][0].suffix}"] = library
        else:
            libraries |= {f"{build.folder}/{name}{build.suffix}": library for build, library in made.items()}
    return libraries


def _find_compiler() -> str | None:
    return next((path for path in map(shutil.which, COMPILERS) if path), None)


def _compile(compiler: Sequence[str], sources: dict[str, str], suffix: str) -> bytes:
    """The shared library."""
    with tempfile.TemporaryDirectory() as folder:
        for file, text in sources.items():
            (Path(folder) / file).write_text(text, encoding="utf-8")
        library = f"library{suffix}"
        units = [file for file in sources if file.endswith(".c")]
        # every address in a library for Windows may move: its compilers warn of the switch that says so
        independent = [] if suffix == ".dll" else ["-fPIC"]
        command = [*compiler, "-std=c99", "-O2", "-shared", *independent, "-fvisibility=hidden", *units]
        run = subprocess.run([*command, "-o", library, "-lm"], cwd=folder, capture_output=True, text=True, check=False)
        if run.returncode:
            reason = " ".join(run.stderr.split())[:300]
            raise InputError(
                f"{' '.join(compiler)} could not compile the FMU ({reason}); export to c, and compile its sources"
            )
        return (Path(folder) / library).read_bytes()


def _join_universal(parts: Sequence[tuple[tuple[int, int], bytes]]) -> bytes:
    """The libraries of several processors as one of macOS: a header that says where each begins, big-endian."""
    step = 1 << FAT_ALIGNMENT
    header, body = struct.pack(">II", FAT_MAGIC, len(parts)), b""
    begin = step
    for (processor, variant), library in parts:
        header += struct.pack(">5I", processor, variant, begin, len(library), FAT_ALIGNMENT)
        padded = library + bytes(-len(library) % step)
        body, begin = body + padded, begin + len(padded)
    return header + bytes(step - len(header)) + body


def _suffix_here() -> str:
    return {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


def _folder_here(fmi: int) -> str:
    """The folder of this machine's library, as each version of the standard names it."""
    bits = "64" if sys.maxsize > 2**32 else "32"
    if fmi == 2:
        return {"win32": "win", "darwin": "darwin"}.get(sys.platform, "linux") + bits
    machine = platform.machine().lower()
    chip = {"amd64": "x86_64", "arm64": "aarch64", "i386": "x86", "i686": "x86"}.get(machine, machine)
    return f"{chip}-{ {'win32': 'windows', 'darwin': 'darwin'}.get(sys.platform, 'linux') }"
