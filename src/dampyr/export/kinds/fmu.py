"""FMU: a functional mock-up unit for co-simulation, FMI 2.0 or 3.0, with native code and no Python in it."""

from __future__ import annotations

import hashlib
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

from dampyr.atomic_write import whole_file
from dampyr.errors import InputError
from dampyr.export import fmi_text
from dampyr.export.c_law import law_files
from dampyr.export.c_text import DOUBLE
from dampyr.export.fmi_law import law_description, law_wrapper
from dampyr.export.kinds.c import c_source, check_name, controlled
from dampyr.models import Damper
from dampyr.source_digest import full_version
from dampyr.structures.building import Building
from dampyr.structures.control_laws import describe_law
from dampyr.structures.controller import Controller

DRIVES = ("both", "displacement", "velocity")
COMPILERS = ("gcc", "clang", "cc")
EPOCH = (1980, 1, 1, 0, 0, 0)  # of every file in the archive, so that one damper gives one FMU, byte for byte


def write(
    damper: Damper,
    folder: Path,
    name: str,
    allow_extrapolation: bool = False,
    *,
    fmi: int = 2,
    drive: str = "both",
    inverse: bool = False,
    control: Any = None,
    structure: Building | None = None,
    place: Any = 1,
) -> list[Path]:
    """Write ``name.fmu``: force [N] from displacement [m], velocity [m/s] and the input at the coil [V or A].

    ``fmi`` is the version of the standard, 2 or 3. ``drive`` says what drives it: "both"; "displacement", whose slope since the
    last step is the velocity; or "velocity", which is integrated by the trapezoidal rule from 0. ``inverse`` takes a wanted
    force [N] in the place of the input, and gives the input that it found beside the force (`dampyr.models.inverse`).
    ``control``, a control law for the damper at ``place`` of ``structure``, adds ``name_law.fmu`` (`dampyr.export.fmi_law`).
    The code of the C export is compiled for this machine and lies in the archive as source too. Raises :class:`InputError` for
    a damper that has no C form, and where no C compiler is installed.
    """
    check_name(name)
    if fmi not in (2, 3):
        raise InputError(f"fmi = {fmi} is not a version that is written; choose 2 or 3")
    if drive not in DRIVES:
        raise InputError(f"drive = {drive!r} is not known; choose from {', '.join(DRIVES)}")
    c = c_source(damper, name, allow_extrapolation, inverse=inverse)
    compiler = next((path for path in map(shutil.which, COMPILERS) if path), None)
    if compiler is None:
        raise InputError("an FMU needs a C compiler, and none is installed; install gcc, or export to c")
    made = controlled(damper, control, structure, place)
    if made is not None and not made[0].sizes:
        raise InputError(
            f"{describe_law(control)} measures nothing, so that its FMU would have no inputs; hold the damper's input instead"
        )
    wrapper = fmi_text.wrapper(damper, name, fmi, drive, inverse)
    description = partial(fmi_text.model_description, damper, name, fmi, drive, version=full_version(), inverse=inverse)
    paths = [
        _archive(folder, name, fmi, {f"{name}.h": c.header, f"{name}.c": c.source}, wrapper, description, compiler)
    ]
    if made is not None:
        paths.append(_law(folder, name, fmi, damper, *made, compiler, allow_extrapolation))
    return paths


def _law(
    folder: Path,
    name: str,
    fmi: int,
    damper: Damper,
    controller: Controller,
    building: Building,
    compiler: str,
    allow_extrapolation: bool,
) -> Path:
    """The FMU of a control law."""
    own, texts = f"{name}_law", law_files(controller, building, damper, name, describe_law(controller.law), DOUBLE)
    sources = {f"{own}.h": texts[f"{own}.h"], f"{own}.c": texts[f"{own}.c"]}
    if controller.formulas.asks_force:  # one file, as both descriptions of the standard list one beside the interface
        c = c_source(damper, name, allow_extrapolation, inverse=True)
        sources |= {f"{name}.h": c.header, f"{own}.c": f"{c.source}\n{sources[f'{own}.c']}"}
    description = partial(law_description, controller, building, damper, own, fmi, version=full_version())
    return _archive(folder, own, fmi, sources, law_wrapper(controller, own, fmi), description, compiler)


def _archive(
    folder: Path,
    name: str,
    fmi: int,
    code: dict[str, str],
    wrapper: str,
    description: Callable[..., str],
    compiler: str,
) -> Path:
    """The FMU of C ``code`` and its interface; ``description(token=)`` gives its XML."""
    # a name of the content, in the form of a GUID
    digest = hashlib.sha256("\n".join((*code.values(), wrapper)).encode()).hexdigest()
    token = "{" + "-".join((digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32])) + "}"
    sources = {**code, f"{name}_fmi.c": f'#define INSTANTIATION_TOKEN "{token}"\n{wrapper}'}
    files: dict[str, str | bytes] = {"modelDescription.xml": description(token=token)}
    files |= {f"sources/{file}": text for file, text in sources.items()}
    if fmi == 3:
        files["sources/buildDescription.xml"] = _build_description(name)
    files[f"binaries/{_platform(fmi)}/{name}{_suffix()}"] = _compiled(compiler, sources, name)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.fmu"
    with whole_file(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
        for file, content in files.items():
            archive.writestr(zipfile.ZipInfo(file, EPOCH), content, zipfile.ZIP_DEFLATED)
    return path


def _compiled(compiler: str, sources: dict[str, str], name: str) -> bytes:
    """The shared library."""
    with tempfile.TemporaryDirectory() as folder:
        for file, text in sources.items():
            (Path(folder) / file).write_text(text, encoding="utf-8")
        library = f"{name}{_suffix()}"
        position_independent = [] if sys.platform == "win32" else ["-fPIC"]
        units = [file for file in sources if file.endswith(".c")]
        command = [
            compiler,
            "-std=c99",
            "-O2",
            "-shared",
            *position_independent,
            "-fvisibility=hidden",
            *units,
            "-o",
            library,
            "-lm",
        ]
        run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if run.returncode:
            reason = " ".join(run.stderr.split())[:300]
            raise InputError(f"{compiler} could not compile the FMU ({reason}); export to c, and compile its sources")
        return (Path(folder) / library).read_bytes()


def _suffix() -> str:
    return {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


def _platform(fmi: int) -> str:
    """The folder of the library, as each version of the standard names it."""
    bits = "64" if sys.maxsize > 2**32 else "32"
    if fmi == 2:
        return {"win32": "win", "darwin": "darwin"}.get(sys.platform, "linux") + bits
    machine = platform.machine().lower()
    chip = {"amd64": "x86_64", "arm64": "aarch64", "i386": "x86", "i686": "x86"}.get(machine, machine)
    return f"{chip}-{ {'win32': 'windows', 'darwin': 'darwin'}.get(sys.platform, 'linux') }"


def _build_description(name: str) -> str:
    """What FMI 3 says of how the sources are compiled."""
    files = "\n".join(f"      <SourceFile name={quoteattr(file)}/>" for file in (f"{name}.c", f"{name}_fmi.c"))
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="{name}">
    <SourceFileSet language="C99">
{files}
    </SourceFileSet>
  </BuildConfiguration>
</fmiBuildDescription>
"""
