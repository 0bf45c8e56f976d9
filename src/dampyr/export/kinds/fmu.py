"""FMU: a functional mock-up unit for co-simulation or model exchange, FMI 2.0 or 3.0, in native code without Python."""

from __future__ import annotations

import hashlib
import zipfile
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

from dampyr.atomic_write import whole_file
from dampyr.errors import InputError
from dampyr.export import fmi_exchange, fmi_text
from dampyr.export.c_law import law_files
from dampyr.export.c_text import DOUBLE
from dampyr.export.fmi_law import law_description, law_wrapper
from dampyr.export.fmu_libraries import check_platforms, compile_libraries
from dampyr.export.kinds.c import c_source, check_name, design_exported
from dampyr.models import Damper
from dampyr.source_digest import full_version
from dampyr.structures.building import Building
from dampyr.structures.control_laws import describe_law
from dampyr.structures.controller import Controller

DRIVES = ("both", "displacement", "velocity")
EPOCH = (1980, 1, 1, 0, 0, 0)  # of every file in the archive, so that one damper gives one FMU, byte for byte


def write(
    damper: Damper,
    folder: Path,
    name: str,
    allow_extrapolation: bool = False,
    *,
    fmi: int = 2,
    drive: str = "both",
    model_exchange: bool = False,
    inverse: bool = False,
    platforms: Sequence[str] = (),
    control: Any = None,
    structure: Building | None = None,
    place: Any = 1,
) -> list[Path]:
    """Write ``name.fmu``: force [N] from displacement [m], velocity [m/s] and the input at the coil [V or A].

    ``fmi`` is the version of the standard, 2 or 3. ``drive`` says what drives it: "both"; "displacement", whose slope since the
    last step is the velocity; or "velocity", which is integrated by the trapezoidal rule from 0. ``model_exchange`` writes the
    differential equation for the master's own solver (`dampyr.export.fmi_exchange`) in the place of steps. ``inverse`` takes
    a wanted force [N] in the place of the input, and gives the input that it found beside it (`dampyr.models.inverse`).
    ``control``, a control law for the damper at ``place`` of ``structure``, adds ``name_law.fmu`` (`dampyr.export.fmi_law`).
    The code of the C export is compiled for this machine, or for the ``platforms`` (`dampyr.export.fmu_libraries`): "linux64",
    "win64", "darwin64", "linux-arm64" of FMI 3, or "all"; it lies in the archive as source too. Raises :class:`InputError` for
    a damper that has no C form, and where no C compiler is installed.
    """
    check_name(name)
    if fmi not in (2, 3):
        raise InputError(f"fmi = {fmi} is not a version that is written; choose 2 or 3")
    if drive not in DRIVES:
        raise InputError(f"drive = {drive!r} is not known; choose from {', '.join(DRIVES)}")
    if model_exchange:
        code = _exchange_code(damper, name, allow_extrapolation, drive, inverse, control)
    else:
        c = c_source(damper, name, allow_extrapolation, inverse=inverse)
        code = {f"{name}.h": c.header, f"{name}.c": c.source}
    if isinstance(platforms, str):
        raise InputError(f"platforms = {platforms!r} is one name; give a list of names, such as ['{platforms}']")
    compile_for = partial(compile_libraries, fmi=fmi, platforms=check_platforms(platforms, fmi))
    designed = design_exported(damper, control, structure, place)
    if designed is not None and not designed[0].sizes:
        raise InputError(
            f"{describe_law(control)} measures nothing, so that its FMU would have no inputs; hold the damper's input instead"
        )
    about: Callable[..., str]
    if model_exchange:
        wrapper = fmi_exchange.exchange_wrapper(damper, name, fmi, drive)
        about = fmi_exchange.exchange_description
    else:
        wrapper = fmi_text.wrapper(damper, name, fmi, drive, inverse)
        about = partial(fmi_text.model_description, inverse=inverse)
    description = partial(about, damper, name, fmi, drive, version=full_version())
    paths = [_archive(folder, name, fmi, code, wrapper, description, compile_for)]
    if designed is not None:
        paths.append(_law(folder, name, fmi, damper, *designed, compile_for, allow_extrapolation))
    return paths


def _exchange_code(
    damper: Damper, name: str, allow_extrapolation: bool, drive: str, inverse: bool, control: Any
) -> dict[str, str]:
    """The sources for model exchange; InputError for what only steps can do."""
    if drive == "displacement":
        raise InputError(
            "drive = 'displacement' has no velocity, which model exchange needs at every time; choose both or velocity"
        )
    if inverse or control is not None:
        which = "the inverse is" if inverse else "a control law is"
        raise InputError(f"{which} found step by step, and has no model exchange; write it for co-simulation")
    return fmi_exchange.exchange_source(damper, name, allow_extrapolation)


def _law(
    folder: Path,
    name: str,
    fmi: int,
    damper: Damper,
    controller: Controller,
    building: Building,
    compile_for: Callable[..., dict[str, bytes]],
    allow_extrapolation: bool,
) -> Path:
    """The FMU of a control law."""
    own, texts = f"{name}_law", law_files(controller, building, damper, name, describe_law(controller.law), DOUBLE)
    sources = {f"{own}.h": texts[f"{own}.h"], f"{own}.c": texts[f"{own}.c"]}
    if controller.formulas.asks_force:  # one file, as both descriptions of the standard list one beside the interface
        c = c_source(damper, name, allow_extrapolation, inverse=True)
        sources |= {f"{name}.h": c.header, f"{own}.c": f"{c.source}\n{sources[f'{own}.c']}"}
    description = partial(law_description, controller, building, damper, own, fmi, version=full_version())
    return _archive(folder, own, fmi, sources, law_wrapper(controller, own, fmi), description, compile_for)


def _archive(
    folder: Path,
    name: str,
    fmi: int,
    code: dict[str, str],
    wrapper: str,
    description: Callable[..., str],
    compile_for: Callable[..., dict[str, bytes]],
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
    files |= {f"binaries/{path}": library for path, library in compile_for(sources, name).items()}
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.fmu"
    with whole_file(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
        for file, content in files.items():
            archive.writestr(zipfile.ZipInfo(file, EPOCH), content, zipfile.ZIP_DEFLATED)
    return path


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
