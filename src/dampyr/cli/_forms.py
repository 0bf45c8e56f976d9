"""Commands as forms: what each takes, for a page that offers it; and a command that is performed for a page."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._frame import cli, with_notes
from dampyr.cli._options import OptionsCommand
from dampyr.cli._output import CollectedOutput, output_collected
from dampyr.cli._progress import Show, followed
from dampyr.cli._report import LOOKS
from dampyr.errors import FindingWarning, InputError

if TYPE_CHECKING:
    from dampyr.options import Option

OF_A_PAGE = ("report", "figures", "figure", "details")
"""Parameters that whoever shows a form gives himself: where the page and the figures go, and that all tables are told."""
OF_A_TERMINAL = ("as_json", *LOOKS, *OF_A_PAGE)
"""Parameters that a form leaves out."""
READING = "Reading of files"


def command_forms() -> dict[str, dict[str, Any]]:
    """What each command takes, by the words that call it, such as ``datasets show``.

    ``title`` is the first sentence of its help, ``words`` are its further paragraphs, and ``parameters`` make a form: name,
    ``flag`` (empty for what is typed without one), label, words, ``kind`` (``bool`` or ``str``: what the terminal reads),
    how many values, the choices and the group. ``makes`` are those of `OF_A_PAGE` that the command has.
    """
    return {name: _form(command) for name, command in _commands()}


def perform_command(words: Sequence[str], typed: Sequence[str], show: Show) -> CollectedOutput:
    """What the command of these words prints; pages that it writes say that those ``typed`` made them.

    ``show(stage, fraction done)`` is told of progress. InputError for what the command line would refuse.
    """
    try:
        with followed(show), output_collected() as output, warnings.catch_warnings():
            warnings.simplefilter("ignore", FindingWarning)  # the tables say it
            click.Group.main(cli, list(words), "dampyr", standalone_mode=False, obj=tuple(typed))
    except click.ClickException as problem:
        raise InputError(problem.format_message().rstrip(".?")) from None
    except InputError as problem:
        raise InputError(with_notes(problem)) from None
    return output


def check_command(words: Sequence[str]) -> None:
    """Raise InputError for words that the command line would refuse; nothing is read or computed."""
    name, command = next(
        (name, command)
        for name, command in sorted(_commands(), key=lambda pair: -len(pair[0]))
        if list(words[: len(name.split())]) == name.split()
    )
    try:
        context = command.make_context(f"dampyr {name}", list(words[len(name.split()) :]))
    except click.ClickException as problem:
        raise InputError(problem.format_message().rstrip(".?")) from None
    if isinstance(command, OptionsCommand):
        command.chosen(context.params)


def _commands() -> Iterator[tuple[str, click.Command]]:
    context = click.Context(cli)
    for name in cli.list_commands(context):
        command = cli.get_command(context, name)
        assert command is not None
        if not isinstance(command, click.Group):
            yield name, command
        for inner, other in getattr(command, "commands", {}).items():
            yield f"{name} {inner}", other


def _form(command: click.Command) -> dict[str, Any]:
    first, *others = (command.help or "").split("\n\n")
    described: dict[str, tuple[Option, str]] = {}
    if isinstance(command, OptionsCommand):
        for cls in command.classes.values():
            reads = cls.__name__.endswith("ReadOptions")
            for option in command.options_of(cls):
                described[option.name] = option, READING if reads else option.group
    return {
        "title": " ".join(first.split()),
        "words": [" ".join(paragraph.split()) for paragraph in others],
        "makes": [parameter.name for parameter in command.params if parameter.name in OF_A_PAGE],
        "parameters": [
            _parameter(parameter, *described.get(parameter.name or "", (None, "")))
            for parameter in command.params
            if parameter.name not in OF_A_TERMINAL and not getattr(parameter, "hidden", False)
        ],
    }


def _parameter(parameter: click.Parameter, option: Option | None, group: str) -> dict[str, Any]:
    flag = parameter.opts[0] if isinstance(parameter, click.Option) else ""
    name = re.sub(r"^-+", "", flag) or str(parameter.name)
    is_flag = bool(getattr(parameter, "is_flag", False))
    choices = _choices(parameter, option)
    several = parameter.multiple or parameter.nargs != 1
    default = option.default if option is not None and choices and several and not option.adds else None
    help_text = getattr(parameter, "help", "") or ""
    return {
        "name": parameter.name,
        "flag": flag,
        "label": name.replace("-", " ").replace("_", " ").capitalize(),
        "words": help_text.rstrip("."),
        "kind": "bool" if is_flag else "str",
        "several": several,
        "values": parameter.nargs,
        "pairs": False,
        "for_all": False,
        "optional": True,
        "required": parameter.required,
        "is_file": isinstance(parameter.type, click.Path),
        "choices": None if choices is None else [[choice, words] for choice, words in choices],
        "default": False if is_flag else list(default or []) if several else None,
        "unit": "",
        "factor": 1,
        "group": group,
        "placeholder": (parameter.metavar or "").strip("[]"),
    }


def _choices(parameter: click.Parameter, option: Option | None) -> Iterable[tuple[str, str]] | None:
    if isinstance(parameter.type, click.Choice):
        return [(str(choice), "") for choice in parameter.type.choices]
    if option is None or option.choices is None or option.pairs or option.adds or option.kind is float:
        return None
    return [(str(choice), words) for choice, words in option.choices.items()]
