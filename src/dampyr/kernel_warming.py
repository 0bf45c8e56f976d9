"""Kernels compiled ahead: what a fresh machine would compile at the first use of each of the usual commands.

Compiled code is kept on disk (`dampyr.models.codegen.kernel_cache`); the first command that needs a kernel waits for it, two
to six seconds each. `warm_kernels` runs small examples of the usual work, so that all of these wait once, together.
"""

from __future__ import annotations

import json
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from dampyr.atomic_write import write_whole
from dampyr.errors import DampyrError
from dampyr.input_kinds import input_arguments
from dampyr.source_digest import source_digest

if TYPE_CHECKING:
    from pathlib import Path

    from dampyr.models import Damper
    from dampyr.records import Record

Progress = Callable[[str, float], None]

INPUTS = (0.0, 0.9, 1.98)  # V, of the records that are fitted: three, so that every law of a parameter has its numbers
AMPLITUDE, FREQUENCY = 0.008, 1.0  # m, Hz
SAMPLES, RATE = 400, 100.0  # 1/s: four cycles, of which a fit sees the first
DURATION = 1.0  # s of the motion under the buildings
MODEL = "dahl"  # of the fit
STEPS = 2  # of each fit of the search: every kernel of it has run
LAWS = ("on_off", "skyhook")
DONE = "warm.json"


@dataclass(frozen=True)
class WarmedKernels:
    """What `warm_kernels` found and did: the ``kernels`` that the usual work needs, those that were ``compiled`` just now,
    the ``seconds`` that it took, and the ``folder`` that holds them."""

    kernels: int
    compiled: int
    seconds: float
    folder: Path


def warm_kernels(progress: Progress | None = None) -> WarmedKernels:
    """Compile what the usual commands need into the cache of kernels, and say what that was.

    The usual work is: the force of every published damper along a path; a building of two storeys with each of them at a
    constant input, and with that of the thesis under control laws; an ensemble with each of them; a fit, and each
    model that the search of models begins with. Where that was done by the same sources on this machine, and nothing was
    removed since, nothing is run.
    Examples that cannot be computed are left out: the command that would need them says why.

    Parameters
    ----------
    progress
        called with what is compiled and the fraction that is done, 0 to 1.

    Returns
    -------
    WarmedKernels
        how many kernels the usual work needs, and how many were compiled in how many seconds.

    Examples
    --------
    >>> from dampyr.kernel_warming import warm_kernels
    >>> warm_kernels().compiled  # doctest: +SKIP
    57
    """
    from dampyr.models.codegen.kernel_cache import cache_folder, used_kernels

    start, folder = time.perf_counter(), cache_folder()
    before = {file.name for file in folder.glob("*.nbi")}
    done = folder / DONE
    needed = _read_done(done)
    if needed and needed <= before:
        return WarmedKernels(len(needed), 0, time.perf_counter() - start, folder)
    for name, run in _usual_work():
        if progress:
            progress(name, 0.0)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the examples are short, and their numbers of no concern to anyone
            with suppress(DampyrError):
                run()
        if progress:
            progress(name, 1.0)
    needed = used_kernels()
    write_whole(done, json.dumps({"sources": _sources(), "kernels": sorted(needed)}))
    return WarmedKernels(len(needed), len(needed - before), time.perf_counter() - start, folder)


def _sources() -> str:
    """What the list of kernels hangs on: the sources, and the machine for which the compiler writes."""
    import llvmlite.binding as llvm

    return f"{source_digest()} {llvm.get_host_cpu_name()}"


def _read_done(file: Path) -> set[str]:
    """The kernels that the usual work of these sources was found to need; empty where it was not looked at."""
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
        return set(found["kernels"]) if found["sources"] == _sources() else set()
    except (OSError, ValueError, KeyError, TypeError):  # not there, or another process is writing it
        return set()


def _usual_work() -> list[tuple[str, Callable[[], Any]]]:
    """Small examples of the usual work, each with what it is."""
    from dampyr import studies
    from dampyr.identification.model_choice.leaderboard import first_models

    records = _records()
    dampers = {name: studies.published_damper(name) for name in studies.available_dampers()}
    thesis = dampers[studies.THESIS]
    return [
        *((f"force of {name}", partial(_force, damper)) for name, damper in dampers.items()),
        *((f"building with {name}", partial(_respond, damper, _middle(damper))) for name, damper in dampers.items()),
        *((f"building under {law}", partial(_respond_under, thesis, law)) for law in LAWS),
        *((f"ensemble with {name}", partial(_ensemble, damper)) for name, damper in dampers.items()),
        (f"fit of {MODEL}", partial(_fit, records)),
        *((f"search with {model}", partial(_search, records, model)) for model in first_models()),
    ]


def _middle(damper: Damper) -> float:
    """The middle of the inputs that a damper was calibrated over."""
    return sum(damper.range) / 2


def _path() -> tuple[Any, Any, Any]:
    """Time s, displacement m and velocity m/s of a sine."""
    import numpy as np

    t, omega = np.arange(SAMPLES) / RATE, 2 * np.pi * FREQUENCY
    return t, AMPLITUDE * np.sin(omega * t), AMPLITUDE * omega * np.cos(omega * t)


def _records() -> list[Record]:
    """Records of a published damper, as measured ones are: with a force at each of some inputs."""
    from dampyr import studies
    from dampyr.records import Record

    t, x, v = _path()
    damper = studies.published_damper(studies.THESIS)
    return [
        Record(t, x, damper.force(t, x, voltage=u, velocity=v), velocity=v, voltage=u, name=f"{u:g} V") for u in INPUTS
    ]


def _force(damper: Damper) -> None:
    t, x, v = _path()
    damper.force(t, x, velocity=v, **input_arguments(damper.input, _middle(damper)))


def _respond(damper: Damper, value: Any) -> None:
    from dampyr import structures

    structures.respond(structures.two_storey(), _motion(), damper, **input_arguments(damper.input, value))


def _respond_under(damper: Damper, law: str) -> None:
    from dampyr.structures.control_laws import law_of

    _respond(damper, law_of(law, damper))


def _ensemble(damper: Damper) -> None:
    from dampyr import structures

    structures.ensemble(structures.two_storey(), _motion(), damper, **input_arguments(damper.input, _middle(damper)))


def _motion() -> Any:
    from dampyr import ground_motions

    return ground_motions.kanai_tajimi(DURATION, 1 / RATE, seed=(1, 1), pga=1.0)


def _fit(records: list[Record]) -> None:
    from dampyr import identification

    identification.fit(records, MODEL)


def _search(records: list[Record], model: str) -> None:
    """What a search of models does first with each of them, in few steps."""
    from dampyr.identification import FitOptions
    from dampyr.identification.model_choice.parameter_laws import list_held
    from dampyr.identification.scoring.validation import cross_validate

    cross_validate(records, model, "record", FitOptions(folds=2, steps=STEPS, starts=1, fixed=list_held(model)))
