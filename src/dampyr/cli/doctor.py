"""Doctor: what this machine has of what dampyr uses."""

from __future__ import annotations

import os
import platform
import shutil
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

import click

from dampyr.cli._examples import examples
from dampyr.cli._output import as_json_option, print_json, print_table
from dampyr.source_digest import full_version

LIBRARIES = ("numpy", "scipy", "numba", "h5py", "xarray", "pint", "matplotlib")


@click.command(
    epilog=examples(
        "dampyr doctor",
        "dampyr doctor --rig rig.toml",
    )
)
@click.option("--rig", type=click.Path(path_type=Path), help="A rig.toml: look at its instruments too; nothing moves.")
@click.option("--simulated", is_flag=True, help="Look at the simulated rig.")
@as_json_option
def command(rig: Path | None, simulated: bool, as_json: bool) -> None:
    """Tell what this machine and its rig have, and what they lack."""
    from dampyr.models.codegen.kernels import cache_folder

    compiler = next((path for path in map(shutil.which, ("gcc", "clang", "cc")) if path), None)
    findings = [
        *_machine(),
        *(_library(name) for name in LIBRARIES),
        ["compiled kernels", str(cache_folder()), None],
        ["C compiler", compiler or "none", None if compiler else "install gcc or clang; only exported C code needs it"],
        *_extras(),
        *_data(),
    ]
    if rig or simulated:
        from dampyr.rig.diagnosis import diagnose

        findings += [[finding.what, finding.observed, finding.repair] for finding in diagnose(rig)]
    if as_json:
        print_json([dict(zip(("what", "found", "repair"), finding, strict=True)) for finding in findings])
        return
    print_table(f"dampyr {full_version()}", ["what", "found", "to repair it"], findings)


def _machine() -> list[list[Any]]:
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return [
        ["Python", platform.python_version(), None],
        ["interpreter", sys.executable, None],
        ["machine", f"{platform.system()} {platform.machine()}", None],
        ["processor cores", str(cores), None],
    ]


def _library(name: str) -> list[Any]:
    try:
        return [name, metadata.version(name), None]
    except metadata.PackageNotFoundError:
        return [name, "missing", f"pip install {name}"]


def _extras() -> list[list[Any]]:
    """Each extra of dampyr: installed, or which of its packages are missing."""
    from packaging.requirements import Requirement

    from dampyr.errors import install_line

    try:
        about, needed = metadata.metadata("dampyr"), [Requirement(line) for line in metadata.requires("dampyr") or ()]
    except metadata.PackageNotFoundError:  # run from its sources, without an installation
        return []
    findings: list[list[Any]] = []
    for extra in about.get_all("Provides-Extra") or ():
        packages = [package.name for package in needed if package.marker and package.marker.evaluate({"extra": extra})]
        missing = [name for name in packages if not _is_installed(name)]
        state = f"missing: {', '.join(missing)}" if missing else ", ".join(packages)
        findings.append([f"extra {extra}", state, install_line(extra) if missing else None])
    return findings


def _is_installed(name: str) -> bool:
    try:
        metadata.version(name)
    except metadata.PackageNotFoundError:
        return False
    return True


def _data() -> list[list[Any]]:
    """The campaign, which tests and studies read, and those of the other data sets that are here."""
    from dampyr.records import datasets

    findings: list[list[Any]] = []
    for name in sorted(datasets.available_data_sets(), key=lambda name: (name != "labcontrol", name)):
        described = datasets.describe(name)
        repair = f"dampyr datasets fetch {name}"
        if described["folder"] is None:
            findings += [[f"data set {name}", "absent", repair]] if name == "labcontrol" else []
            continue
        missing = f", {len(described['missing_files'])} files missing" if described["missing_files"] else ""
        findings.append([f"data set {name}", f"{described['folder']}{missing}", repair if missing else None])
    return findings
