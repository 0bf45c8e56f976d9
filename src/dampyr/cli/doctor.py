"""Doctor: what this machine has of what dampyr uses."""

from __future__ import annotations

import os
import platform
import shutil
import sys
from importlib import metadata
from pathlib import Path
from typing import Any, cast

import click

from dampyr.cli._examples import examples
from dampyr.cli._output import as_json_option, print_json, print_table
from dampyr.cli._progress import stages
from dampyr.errors import InputError
from dampyr.source_digest import full_version

FAILED, ENDED = 3, 130  # exit codes of a bring-up
LIBRARIES = ("numpy", "scipy", "numba", "h5py", "xarray", "pint", "matplotlib")


@click.command(
    epilog=examples(
        "dampyr doctor",
        "dampyr doctor --rig rig.toml",
        "dampyr doctor --rig rig.toml --bring-up",
        "dampyr doctor --simulated --bring-up --stand-in --out simulated.json",
        "dampyr doctor --warm",
    )
)
@click.option("--rig", type=click.Path(path_type=Path), help="A rig.toml: look at its instruments too; nothing moves.")
@click.option("--simulated", is_flag=True, help="Look at the simulated rig.")
@click.option(
    "--bring-up",
    is_flag=True,
    help="Bring the rig's first boards up, step by step; asks before each, and before anything is energised.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("bring-up.json"),
    show_default=True,
    help="With --bring-up: the file of what was seen; a further run goes on where it ends.",
)
@click.option("--stand-in", is_flag=True, help="With --bring-up at a simulated rig: answer for the operator.")
@click.option(
    "--fault", "faults", multiple=True, help="With --bring-up: give a simulated rig a fault, as `dampyr run` does."
)
@click.option("--warm", is_flag=True, help="Compile what the usual commands need, so that none of them waits for it.")
@as_json_option
def command(
    rig: Path | None,
    simulated: bool,
    bring_up: bool,
    out: Path,
    stand_in: bool,
    faults: tuple[str, ...],
    warm: bool,
    as_json: bool,
) -> int:
    """Tell what this machine and its rig have, and what they lack.

    With --bring-up the exit code is 3 where a step has failed, and 130 where it was ended before the last one.
    """
    if warm and (rig or simulated or bring_up or stand_in or faults):
        raise InputError("--warm looks at no rig; give it alone, and ask for the rig in a second call")
    if warm:
        return _warm(as_json)
    if bring_up:
        return _bring_up(rig, simulated, out, stand_in, faults, as_json)
    if stand_in or faults:
        raise InputError("--stand-in and --fault belong to --bring-up; add that, or leave them out")
    from dampyr.models.codegen.kernel_cache import cache_folder

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
        return 0
    print_table(f"dampyr {full_version()}", ["what", "found", "to repair it"], findings)
    return 0


def _warm(as_json: bool) -> int:
    """Compile the usual kernels ahead; the exit code."""
    from dampyr.kernel_warming import warm_kernels

    with stages() as progress:
        warmed = warm_kernels(progress)
    if as_json:
        print_json(warmed)
    else:
        done = f"compiled {warmed.compiled}" if warmed.compiled else "nothing to compile"
        click.echo(f"{warmed.kernels} kernels of the usual commands, {done}, {warmed.seconds:.1f} s: {warmed.folder}")
    return 0


def _bring_up(
    settings: Path | None, simulated: bool, out: Path, stand_in: bool, faults: tuple[str, ...], as_json: bool
) -> int:
    """Go through the steps of a bring-up with a person, or with a stand-in for one; the exit code."""
    from dampyr.cli._bring_up import TerminalOperator
    from dampyr.rig.bring_up import STEPS, Operator, bring_up
    from dampyr.rig.connecting import open_rig
    from dampyr.rig.connecting import simulated as simulated_rig
    from dampyr.rig.simulation.stand_in import OperatorStandIn

    if not (settings or simulated):
        raise InputError("--bring-up needs a rig: give --rig rig.toml, or --simulated")
    if stand_in and not simulated:
        raise InputError("--stand-in answers at a simulated rig only; add --simulated, or leave it out")
    operator: Operator = TerminalOperator()
    with simulated_rig(settings, faults=faults) if simulated else open_rig(settings, faults=faults) as rig:
        if rig.simulated:  # whose screw no person can turn
            begin = (lambda _: "go") if stand_in else operator.begin
            operator = OperatorStandIn(cast(Any, rig.board).simulator, begin, operator.show)
        outcomes = bring_up(rig, out, operator)
    failed = any(outcome.verdict == "failed" for outcome in outcomes)
    if as_json:
        print_json(outcomes)
    else:
        rows = [[outcome.step, outcome.verdict, outcome.cause] for outcome in outcomes]
        print_table("Bring-up", ["step", "verdict", "cause and repair"], rows, notes=[f"written: {out}"])
    return FAILED if failed else (0 if len(outcomes) == len(STEPS) else ENDED)


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
