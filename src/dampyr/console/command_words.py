"""Commands of the terminal on a page: which are offered, what may be chosen for files, and the words that a request means.

The console lies below the command line and imports nothing of it: it finds the commands where they are registered, as it finds
its own pages. Files are chosen among those of the data folder; what a command writes goes into the folder of its job.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path, PurePosixPath
from typing import Any

from pydantic import BaseModel, Field

from dampyr import studies
from dampyr.console import record_sources, safe_paths
from dampyr.console.building_schemas import MOTION_SUFFIXES, MOTIONS, STRUCTURES
from dampyr.console.dampers import damper_of, list_dampers
from dampyr.console.jobs import FIGURES, FILES, PAGE
from dampyr.console.record_formats import SUFFIXES
from dampyr.console.rigs import rig_file, rig_names
from dampyr.errors import InputError, choose_from
from dampyr.identification.acceptance_tests.device_criteria import available_criteria
from dampyr.records.datasets import available_data_sets

COMMAND_LINE = "dampyr.cli"

GROUPS = {
    "Records": ("records", "records convert", "cycles", "accept", "protocol", "judge", "specimens"),
    "Dampers": ("identify", "validate", "posterior", "plan", "export"),
    "Structures and vehicles": ("simulate", "ensemble", "arena", "ride", "motion", "hybrid"),
    "Published work": ("reproduce", "datasets list", "datasets show"),
    "This installation": ("calibrate", "doctor", "demo", "licences"),
}
"""Titles of the page and the commands below them, in its order."""

PAGES = {
    "run": "bench", "records": "records", "cycles": "records", "accept": "records", "identify": "identify",
    "validate": "identify", "export": "identify", "plan": "campaigns", "simulate": "building", "ensemble": "building",
}  # fmt: skip
"""Command -> the page that has a form of its own for it."""

NOT_OFFERED = {
    "run": "a table is moved from the Bench, which has its limits, its watch and Abort",
    "console": "it is this program",
    "serve": "it answers an OpenSees model that runs beside it, in a terminal",
    "datasets fetch": "it downloads files into a folder of this machine that other users have, too",
    "help": "the documentation is a site and a command of the terminal; each form here holds the help of its command",
}
"""Command -> why it is not offered."""

LEFT_OUT = {
    "calibrate": ("load", "shunt", "yes"),  # of the load cell: the Bench guides through it
    "doctor": ("bring_up", "out", "stand_in", "faults"),  # a person stands at the rig, and answers in a terminal
    "hybrid": ("rig", "out", "dry_run", "real_time", "clock"),  # with a rig: a step of a campaign, on the Bench
    "plan": ("perform", "per_round"),  # the campaign that it writes is run on the Bench
    "reproduce": ("data", "as_list"),
    "ensemble": ("workers", "part", "collect", "read", "cluster"),  # parts of an ensemble are of several machines
    "arena": ("workers", "read", "cluster"),
}
"""Parameters that a page does not offer."""

NEEDS_ONE_OF = {"hybrid": ("delay", "record")}
"""Parameters of which a form needs one, where the command would take none of them: else it would move a table."""

ALWAYS = {"calibrate": ("--yes",), "export": ("--out", FILES), "reproduce": ("--out", FILES), "demo": ("--out", FILES)}
"""Words that are always typed; `FILES` stands for the folder of what is written."""

WRITTEN = ("out", "save", "forces", "demands")
"""Parameters that name a file or folder to write: in the job's folder."""

KIND_OF_FILE = {
    "paths": "records", "records": "records", "record": "records", "card": "dampers",
    "structure": "structures", "motion": "motions",
    "motions": "motions", "file": "motions", "rig": "rigs", "folders": "folders", "folder": "folders",
    "criteria": "criteria", "limits": "files", "design": "files", "loads_file": "files",
    "supports_file": "files", "study": "studies",
    "name": "data sets", "reference": "references",
}  # fmt: skip
"""Parameter -> what is chosen for it from the data folder, or by name from what is published."""

TEXT = (
    ("identify", "model"),
    ("posterior", "model"),
    ("motion", "design"),
    ("arena", "limits"),
    ("ensemble", "limits"),
    ("export", "name"),
)
"""Parameters of these names that are a text nevertheless: a model by its parts, limits of a drift."""
DAMPERS = (("hybrid", "model"),)

LABELS = {
    "records": "Records", "dampers": "Damper", "motions": "Ground motion", "folders": "Folder", "studies": "Study",
    "data sets": "Data set", "references": "Reference",
}  # fmt: skip
"""What is chosen -> what it is called where the command has no flag for it."""

OTHER_FILES = (".toml", ".csv", ".txt", ".json")
MAX_LISTED = 500
MAX_PARAMETERS = 100
MAX_VALUE = 640  # characters: those of a record's key
SEPARATORS = re.compile(r"[=:;,\s]+")


class CommandRequest(BaseModel):
    """A command and what its form holds: name of a parameter -> flag, text, or texts; files as `file_choices` names them."""

    command: str = Field(max_length=40)
    values: dict[str, bool | str | list[str]] = Field(default={}, max_length=MAX_PARAMETERS)


@cache
def forms() -> dict[str, dict[str, Any]]:
    """The forms of the commands that are offered, each parameter with what is chosen for it."""
    described: dict[str, dict[str, Any]] = import_module(COMMAND_LINE).command_forms()
    return {name: _offered(name, described[name]) for names in groups().values() for name in names}


@cache
def groups() -> dict[str, tuple[str, ...]]:
    """The commands that are offered by the titles of the page; a new one is offered below those that have a group."""
    listed = {name for names in GROUPS.values() for name in names} | NOT_OFFERED.keys()
    others = tuple(name for name in import_module(COMMAND_LINE).command_forms() if name not in listed)
    return GROUPS | ({"Others": others} if others else {})


def _offered(command: str, form: dict[str, Any]) -> dict[str, Any]:
    left_out = (*LEFT_OUT.get(command, ()), *(word.removeprefix("--") for word in ALWAYS.get(command, ())))
    parameters = [
        parameter
        | {
            "files": (kind := _kind(command, parameter)),
            "label": parameter["label"] if parameter["flag"] else LABELS.get(kind, parameter["label"]),
        }
        for parameter in form["parameters"]
        if parameter["name"] not in left_out
    ]
    return form | {"parameters": parameters, "page": PAGES.get(command, "")}


def _kind(command: str, parameter: Mapping[str, Any]) -> str:
    name, of_a_path = parameter["name"], "files" if parameter["is_file"] else ""
    if (command, name) in DAMPERS:
        return "dampers"
    if name in WRITTEN:
        return "written"
    return "" if (command, name) in TEXT else KIND_OF_FILE.get(name, of_a_path)


def file_choices(data: Path) -> dict[str, list[dict[str, str]]]:
    """What can be chosen for each kind of file but records: the value that a request has, and its words."""
    dampers = [{"value": link["name"], "words": link["title"]} for link in list_dampers(data)]
    files = [name for name in safe_paths.files(data, OTHER_FILES) if not name.startswith("rigs/")][:MAX_LISTED]
    return {
        "dampers": dampers,
        "structures": _named(studies.available_structures()) + _in_folder(data, STRUCTURES, (".toml",)),
        "motions": _in_folder(data, MOTIONS, MOTION_SUFFIXES),
        "rigs": [{"value": name, "words": name} for name in rig_names(data)],
        "folders": [{"value": name, "words": name} for name in _folders(data)],
        "criteria": _named(available_criteria()) + [{"value": name, "words": name} for name in files],
        "files": [{"value": name, "words": name} for name in files],
        "studies": _named(studies.available_studies()),
        "data sets": _named(available_data_sets()),
        "references": dampers + [{"value": name, "words": f"records in {name}"} for name in _folders(data)],
    }


def _named(names: Any) -> list[dict[str, str]]:
    return [{"value": name, "words": f"published: {name}"} for name in names]


def _in_folder(data: Path, folder: str, suffixes: tuple[str, ...]) -> list[dict[str, str]]:
    names = safe_paths.files(data / folder, suffixes)
    return [{"value": f"{folder}/{name}", "words": name} for name in names]


def _folders(data: Path) -> list[str]:
    """The folders with records, the deepest ones."""
    folders = {PurePosixPath(name).parent.as_posix() for name in safe_paths.files(data, SUFFIXES)}
    others = tuple(name.rstrip("/") for name in (*record_sources.NOT_RECORDS, "cards/", "campaigns/", "rigs/"))
    return sorted(folder for folder in folders if folder != "." and not folder.startswith(others))[:MAX_LISTED]


class CommandLine(BaseModel):
    """The words of a command as they are run in the data folder, and as a person types them."""

    run: list[str]
    typed: list[str]


def command_line(request: CommandRequest, data: Path, place: str) -> CommandLine:
    """The command line that a request means; ``place`` is the job's folder, as seen from the data folder.

    Raises InputError for a command that is not offered, a parameter that it does not have, a file that is not in the data
    folder, a text that names a place of this machine, and what the command line itself refuses.
    """
    command = request.command
    if command not in forms():
        why = NOT_OFFERED.get(command)
        known = f"there is no command {command!r}; {choose_from(command, list(forms()))}"
        raise InputError(f"`dampyr {command}` is not offered here: {why}" if why else known)
    form = forms()[command]
    parameters = {parameter["name"]: parameter for parameter in form["parameters"]}
    if (needed := NEEDS_ONE_OF.get(command)) and not any(name in request.values for name in needed):
        labels = " or ".join(parameters[name]["label"] for name in needed)
        raise InputError(f"{labels} is missing; a test on a rig is a step of a campaign, and is run on the Bench")
    for name in request.values:
        if name not in parameters:
            raise InputError(f"`dampyr {command}` has no {name!r} here; {choose_from(name, list(parameters))}")
    options: list[tuple[str, str]] = []  # each word as it is run and as it is typed
    arguments: list[tuple[str, str]] = []
    for name, parameter in parameters.items():
        (options if parameter["flag"] else arguments).extend(
            _parameter_words(data, parameter, request.values.get(name), place)
        )
    if "report" in form["makes"]:
        options.append((f"--report={place}/{PAGE}", f"--report={PAGE}"))
    run = [f"--figures={place}/{FIGURES}"] if "figures" in form["makes"] else []
    run += [f"--figure={place}/{FIGURES}/figure.svg"] if "figure" in form["makes"] else []
    run += ["--details"] if "details" in form["makes"] else []
    always = ALWAYS.get(command, ())
    line = CommandLine(
        run=[
            *command.split(), *(word for word, _ in options), *run,
            *(f"{place}/{FILES}" if word == FILES else word for word in always), *(word for word, _ in arguments),
        ],
        typed=[*command.split(), *(word for _, word in [*options, *arguments])],
    )  # fmt: skip
    import_module(COMMAND_LINE).check_command(line.run)
    return line


def _parameter_words(
    data: Path, parameter: Mapping[str, Any], value: bool | str | list[str] | None, place: str
) -> list[tuple[str, str]]:
    """The words of one parameter, each as it is run and as it is typed; none where nothing is given."""
    flag, label = parameter["flag"], parameter["label"]
    if parameter["kind"] == "bool":
        if not isinstance(value, bool | None):
            raise InputError(f"{label} is ticked or not; give true or false")
        return [(flag, flag)] if value else []
    if isinstance(value, bool):
        raise InputError(f"{label} is a text; enter one, or leave it empty")
    given = [value] if isinstance(value, str) else value or []
    if parameter["required"] and not given:
        raise InputError(f"{label} is missing; choose or enter it")
    if not parameter["several"] and len(given) > 1:
        raise InputError(f"{label} takes one value and not {len(given)}")
    pairs = [_value(data, parameter, text, place) for text in given]
    if flag and parameter["values"] > 1:
        if pairs and len(pairs) != parameter["values"]:
            raise InputError(f"{label} takes {parameter['values']} values; separate them by ;")
        return [(flag, flag), *pairs] if pairs else []
    return [(f"{flag}={real}", f"{flag}={shown}") for real, shown in pairs] if flag else pairs


def _value(data: Path, parameter: Mapping[str, Any], text: str, place: str) -> tuple[str, str]:
    """A value as it is run and as it is typed."""
    label, kind = parameter["label"], parameter["files"]
    if len(text) > MAX_VALUE:
        raise InputError(f"{label} has {len(text)} characters; at most {MAX_VALUE} are taken")
    if text.startswith("-"):
        _check_negative(label, text)
    match kind:
        case "records":
            path = record_sources.place(data, text)
            shown = text.removeprefix(f"{record_sources.OWN}/")
            return (shown if shown != text else str(path)), shown
        case "written":
            safe_paths.check_new_name(text)
            return f"{place}/{FILES}/{text}", text
        case "rigs":
            rig_file(data, text)
            return (f"rigs/{text}/rig.toml",) * 2
        case "references" if safe_paths.inside(data, text).is_dir():
            return text, text
        case "dampers" | "references":
            damper_of(data, text)
            return text, text
        case "files" | "folders":
            _check_in_data(data, label, text)
            return text, text
        case "structures" | "motions" | "criteria" if "/" in text:  # without one it is a published name
            _check_in_data(data, label, text)
            return text, text
    return _checked_text(data, label, text), text


def _check_in_data(data: Path, label: str, text: str) -> None:
    if not safe_paths.inside(data, text).exists():
        raise InputError(f"{label}: {text[:60]!r} is not in the data folder; choose one that is")


def _check_negative(label: str, text: str) -> None:
    try:
        float(text)
    except ValueError:
        raise InputError(f"{label}: {text[:60]!r} begins with -, as an option does; only a number may") from None


def _checked_text(data: Path, label: str, text: str) -> str:
    """The text, in which no file is named but one of the data folder, and no program."""
    if not text.isprintable():
        raise InputError(f"{label}: {text[:60]!r} holds characters that are not printed; leave them out")
    for piece in filter(None, SEPARATORS.split(text)):
        path = PurePosixPath(piece.replace("\\", "/"))
        if path.is_absolute() or piece.startswith("~") or ".." in path.parts or path.suffix == ".py":
            raise InputError(f"{label}: {piece[:60]!r} is a place outside of the data folder; choose a file of it")
        if (data / path).exists():
            safe_paths.inside(data, path.as_posix())
    return text


def command_places() -> Iterator[tuple[str, str, str]]:
    """Every command of the terminal with the page that has it, ``commands`` for all that have no other, and why none has."""
    for name in import_module(COMMAND_LINE).command_forms():
        page = PAGES.get(name, "commands" if name in forms() else "")
        yield name, page, "" if name in forms() else NOT_OFFERED[name]
