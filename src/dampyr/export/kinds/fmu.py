"""FMU: a functional mock-up unit for co-simulation, FMI 2.0 or 3.0, with native code and no Python in it."""

from __future__ import annotations

import hashlib
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from xml.sax.saxutils import quoteattr

from dampyr.atomic_write import whole_file
from dampyr.errors import InputError
from dampyr.export import fmi_text
from dampyr.export.kinds.c import c_source, check_name
from dampyr.models import Damper
from dampyr.source_digest import full_version

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
) -> list[Path]:
    """Write ``name.fmu``: force [N] from displacement [m], velocity [m/s] and the input at the coil [V or A].

    ``fmi`` is the version of the standard, 2 or 3. ``drive`` says what drives it: "both"; "displacement", whose slope since the
    last step is the velocity; or "velocity", which is integrated by the trapezoidal rule from 0. ``inverse`` takes a wanted
    force [N] in the place of the input, and gives the input that it found beside the force (`dampyr.models.inverse`). The code
    of the C export is compiled for this machine and lies in the archive as source too. Raises :class:`InputError` for a damper
    that has no C form, and where no C compiler is installed.
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
    wrapper = fmi_text.wrapper(damper, name, fmi, drive, inverse)
    # a name of the content, in the form of a GUID
    digest = hashlib.sha256("\n".join((c.header, c.source, wrapper)).encode()).hexdigest()
    token = "{" + "-".join((digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32])) + "}"
    sources = {
        f"{name}.h": c.header,
        f"{name}.c": c.source,
        f"{name}_fmi.c": f'#define INSTANTIATION_TOKEN "{token}"\n{wrapper}',
    }
    files: dict[str, str | bytes] = {
        "modelDescription.xml": fmi_text.model_description(damper, name, fmi, drive, token, full_version(), inverse)
    }
    files |= {f"sources/{file}": text for file, text in sources.items()}
    if fmi == 3:
        files["sources/buildDescription.xml"] = _build_description(name)
    files[f"binaries/{_platform(fmi)}/{name}{_suffix()}"] = _compiled(compiler, sources, name)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.fmu"
    with whole_file(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
        for file, content in files.items():
            archive.writestr(zipfile.ZipInfo(file, EPOCH), content, zipfile.ZIP_DEFLATED)
    return [path]


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
