"""The page that a command writes for people, and its figures as files of their own."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

import click

from dampyr.errors import InputError

Command = Callable[..., Any]


def figures_option(command: Command) -> Command:
    """``--figures DIR``: the page that is made within the command leaves its figures there."""

    @click.option(
        "--figures",
        type=click.Path(path_type=Path, file_okay=False),
        metavar="DIR",
        help="Write the page's figures into DIR too, as SVG and PDF.",
    )
    @wraps(command)
    def wrapped(*rest: Any, figures: Path | None, **given: Any) -> Any:
        if figures is None:
            return command(*rest, **given)
        if given.get("report", True) is None:
            raise InputError("--figures are those of a page; give --report HTML too")
        from dampyr.report import figure_files

        with figure_files(figures):
            return command(*rest, **given)

    return wrapped


def report_options(what: str = "Write a page with figures.") -> Callable[[Command], Command]:
    """``--report HTML``, which comes as ``report``, and ``--figures DIR``."""

    def add(command: Command) -> Command:
        report = click.option("--report", type=click.Path(path_type=Path), metavar="HTML", help=what)
        return report(figures_option(command))

    return add
