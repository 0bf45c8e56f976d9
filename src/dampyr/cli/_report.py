"""The page that a command writes for people, and its figures as files of their own."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import wraps
from pathlib import Path
from typing import Any

import click

from dampyr.errors import InputError

Command = Callable[..., Any]
READ = ("card", "reference", "motion", "motions", "file", "campaign", "rig", "read", "criteria", "design")
"""Parameters of commands that name files which are read; records state theirs themselves."""


LOOKS = ("width", "font", "grey", "decimal_comma")
"""Parameters that say how the figures look in their files: the fields of `dampyr.show.journal_style.JournalStyle`."""


def figures_option(command: Command) -> Command:
    """``--figures DIR`` and how they look: the page that is made within the command leaves its figures there.

    The page says what was typed.
    """

    @click.option(
        "--figures",
        type=click.Path(path_type=Path, file_okay=False),
        metavar="DIR",
        help="Write the page's figures into DIR too: SVG, PDF, CSV.",
    )
    @click.option("--width", metavar="LENGTH", help="Width of these figures, such as 88mm.")
    @click.option("--font", metavar="NAME", help="Font of these figures, such as 'DejaVu Serif'.")
    @click.option("--grey", is_flag=True, help="Draw these figures in greys, told apart by dashes.")
    @click.option("--decimal-comma", is_flag=True, help="Write 0,5 for 0.5 in these figures.")
    @wraps(command)
    def wrapped(*rest: Any, figures: Path | None, **options: Any) -> Any:
        looks = {name: options.pop(name) for name in LOOKS}
        page_is_written = options.get("report", True) is not None
        if figures is not None and not page_is_written:
            raise InputError("--figures are those of a page; give --report HTML too")
        if figures is None and (idle := [name for name, value in looks.items() if value]):
            raise InputError(f"--{idle[0].replace('_', '-')} is of the figures that --figures DIR writes; give it too")
        if not page_is_written:
            return command(*rest, **options)
        from dampyr.show.pages.how_made import made_by
        from dampyr.show.pages.saved_figures import figure_files

        context = click.get_current_context()
        with ExitStack() as stack:
            stack.enter_context(made_by(typed(context), _files_read(context)))
            if figures is not None:
                stack.enter_context(figure_files(figures, **looks))
            return command(*rest, **options)

    return wrapped


def typed(context: click.Context) -> str:
    """The command line of ``context``, as it was typed."""
    words = context.find_root().obj
    return shlex.join(["dampyr", *words]) if isinstance(words, tuple) else context.command_path


def _files_read(context: click.Context) -> Iterator[Path]:
    for name in READ:
        value = context.params.get(name)
        for path in value if isinstance(value, tuple) else (value,):
            if isinstance(path, str | Path) and Path(path).is_file():
                yield Path(path)


def report_options(what: str = "Write a page with figures.") -> Callable[[Command], Command]:
    """``--report HTML``, which comes as ``report``, and ``--figures DIR`` with what says how they look."""

    def add(command: Command) -> Command:
        report = click.option("--report", type=click.Path(path_type=Path), metavar="HTML", help=what)
        return report(figures_option(command))

    return add
