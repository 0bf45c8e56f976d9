"""The command line that does what a request of a page does: reports name it, so that they can be made again without a browser.

Paths are those in the data folder, where the command is to be run.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from dampyr.console.record_sources import OWN
from dampyr.options import command_words

if TYPE_CHECKING:
    from dampyr.console.building_schemas import (
        BuildingRequest,
        DamperRequest,
        EnsembleRequest,
        MotionRequest,
        ResponseRequest,
    )
    from dampyr.console.identify_schemas import IdentifyRequest, ValidateRequest
    from dampyr.console.proposals import ProposalRequest

WHERE = "in the console's data folder"


def _command(*words: str, note: str = "") -> str:
    return f"{shlex.join(['dampyr', *words])} ({'; '.join([WHERE, *([note] if note else [])])})"


def typed_command(words: Sequence[str]) -> str:
    """A command of these words."""
    return _command(*words)


def _paths(keys: Iterable[str]) -> list[str]:
    return [key.removeprefix(f"{OWN}/") for key in keys]


def identify_command(request: IdentifyRequest) -> str:
    """As ``dampyr identify``."""
    model = ["--model", request.model] if request.model else []
    return _command("identify", *_paths(request.records), *model, *command_words(request.options()))


def validate_command(request: ValidateRequest) -> str:
    """As ``dampyr validate``."""
    return _command("validate", request.card, *_paths(request.records), *command_words(request.options()))


def plan_command(request: ProposalRequest) -> str:
    """As ``dampyr plan``."""
    words = [*_paths(request.records), *(["--card", request.damper] if request.damper else [])]
    words += ["--rig", f"rigs/{request.rig}/rig.toml"] if request.rig else []
    if request.goal == "peak":
        words += ["--structure", request.structure, "--voltage", f"{request.voltage:g}", "--peak", request.of]
    return _command("plan", *words, *command_words(request.options()))


def accept_command(request: Any) -> str:
    """As ``dampyr accept``; a reference of several records is a folder of them there.

    ``request`` is an `dampyr.console.record_acceptance.AcceptanceRequest`.
    """
    several = "the reference is a folder of these records" if len(request.reference) > 1 else ""
    reference = " ".join(_paths(request.reference))
    return _command("accept", reference, *_paths(request.key), *command_words(request.options()), note=several)


def cycles_command(request: Any) -> str:
    """As ``dampyr cycles``; ``request`` is a `dampyr.console.record_cycles.CyclesRequest`."""
    return _command("cycles", *_paths(request.key), *command_words(request.options()))


def response_command(request: ResponseRequest) -> str:
    """As ``dampyr simulate``."""
    words = [*_damper(request.damper), *_structure(request.building), *_motion(request.motion)]
    words += command_words(request.options())
    motion = request.motion
    synthetic = f"a synthetic motion of {motion.duration:g} s, seed {motion.seed}, for El Centro 1940"
    notes = [_building(request.building), synthetic if motion.kind == "kanai_tajimi" else ""]
    return _command("simulate", *words, note="; ".join(filter(None, notes)))


def ensemble_command(request: EnsembleRequest) -> str:
    """As ``dampyr ensemble``."""
    scales = ["--scale", ",".join(f"{scale:g}" for scale in request.scales)]
    words = [*_damper(request.damper), *_structure(request.building), *_motions(request.motion, request.motions)]
    words += [*scales, "--without-damper", *command_words(request.options())]
    return _command("ensemble", *words, note=_building(request.building))


def _damper(request: DamperRequest) -> list[str]:
    inputs = [word for value in request.inputs for word in ("--voltage", f"{value:g}")]
    laws = [word for law in request.laws for word in ("--control", law)]
    storeys = [word for storey in request.storeys for word in ("--storey", str(storey))]
    return [request.name, *inputs, *laws, *(storeys if request.storeys != [1] else [])]  # 1 as usual


def _structure(request: BuildingRequest) -> Sequence[str]:
    if request.kind not in ("published", "file"):
        return []
    return ["--structure", request.name if request.kind == "published" else f"structures/{request.name}"]


def _motion(request: MotionRequest) -> Sequence[str]:
    words = ["--motion", f"motions/{request.file}"] if request.kind == "file" else []
    unit = ["--motion-unit", request.unit] if request.unit else []
    return [*words, *unit, *([] if request.pga is None else [f"--pga={request.pga:g}m/s^2"])]


def _motions(request: MotionRequest, count: int) -> Sequence[str]:
    if request.kind != "kanai_tajimi":
        return _motion(request)
    pga = [] if request.pga is None else [f"--pga={request.pga:g}m/s^2"]
    return ["--synthetic", str(count), "--duration", f"{request.duration:g}", *pga]


def _building(request: BuildingRequest) -> str:
    if request.kind != "shear":
        return ""
    return f"a shear building of {len(request.masses)} storeys, which --structure takes from a file"
