"""Output of commands: a table for people, JSON for machines."""

from __future__ import annotations

import io
import json
import os
import sys
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, redirect_stdout, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import click

from dampyr.errors import FindingWarning
from dampyr.findings import Finding, besides
from dampyr.to_json import plain

if TYPE_CHECKING:
    from pathlib import Path

    from dampyr.origin import Origin  # loads numpy, which help does without
    from dampyr.show.table import Table

as_json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON for machines, in SI units.")
"""The option that every command takes; it comes as ``as_json``."""

in_process_option = click.option("--in-process", is_flag=True, hidden=True, expose_value=False)
"""Has no effect since 0.4.0: a simulated rig has no wires. To go in 0.5.0."""

DASH = "–"
NOTICE = "dampyr.origin"  # what the running command has to say of what it prints
EXIT_CODES = {"passed": 0, "failed": 1, "not judged": 3}  # of a verdict; 2 is a wrong request
WIDTH_OF_A_FILE = 240  # characters: more than the widest table takes


@dataclass
class CollectedOutput:
    """What a command would have printed on stdout, in its order: lines and tables; ``notice`` is what its origin says."""

    entries: list[str | Table] = field(default_factory=list)
    notice: str = ""


_collected: ContextVar[CollectedOutput | None] = ContextVar("where output goes instead of stdout", default=None)


@contextmanager
def output_collected() -> Iterator[CollectedOutput]:
    """Within it, what commands print on stdout is collected."""
    output = CollectedOutput()
    before = _collected.set(output)
    try:
        with redirect_stdout(_Lines(output)):
            yield output
    finally:
        _collected.reset(before)


class _Lines(io.StringIO):
    """A stdout whose lines are collected."""

    def __init__(self, output: CollectedOutput) -> None:
        super().__init__()
        self._output = output

    def write(self, text: str) -> int:
        """Keep the lines of a text; ``click.echo`` ends each of its own with a newline."""
        written = super().write(text)  # refuses bytes, by which ``click.echo`` tells a stream of text
        self._output.entries += [line.rstrip() for line in text.splitlines() if line.strip()]
        return written


def state_origin(origin: Origin) -> None:
    """Have every table that the running command prints begin with what an origin that is not measured says."""
    if text := origin.notice:
        click.get_current_context().meta[NOTICE] = text
        if (collected := _collected.get()) is not None:
            collected.notice = text


@contextmanager
def findings_below() -> Iterator[None]:
    """Within it, what the result's findings say is not warned of, too: the command prints them below its table."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FindingWarning)
        yield


def print_notice(findings: Iterable[Finding] = ()) -> None:
    """Say on stderr what `state_origin` was told, and ``findings``, where a command prints no table."""
    if text := click.get_current_context().meta.get(NOTICE):
        click.echo(text, err=True)
    for finding in findings:
        click.echo(finding.sentence, err=True)


def print_json(data: Any) -> None:
    """Print data as JSON on stdout.

    For dataclasses, arrays, NaN and infinity see :func:`dampyr.to_json.plain`.
    """
    click.echo(json.dumps(plain(data), indent=2, ensure_ascii=False, allow_nan=False))


def print_table(
    title: str,
    columns: Sequence[str],
    rows: Sequence[Sequence[Any]],
    units: Sequence[str] | None = None,
    digits: int = 4,
    notes: Sequence[str] = (),
    findings: Iterable[Finding] = (),
) -> None:
    """Print a table on stdout: numbers to the right with ``digits`` significant digits, None as a dash.

    ``units`` stand under the names of the columns; below the table stand the ``findings``, the worst first, and ``notes``,
    sentences. Above the title stands what `state_origin` was told.
    """
    below = [*(finding.sentence for finding in findings), *notes]
    if (collected := _collected.get()) is not None:
        from dampyr.show.table import Table

        cells = [[cell if _is_number(cell) or cell is None else _text(cell, digits) for cell in row] for row in rows]
        collected.entries.append(Table(columns, cells, units or (), caption=title, notes=below, digits=digits))
        return
    from rich import box
    from rich.markup import escape
    from rich.table import Table as RichTable

    table = RichTable(box=box.SIMPLE_HEAD, show_header=any(columns))
    for k, name in enumerate(columns):
        unit = f"\n[dim]{escape(units[k])}[/dim]" if units and any(units) else ""
        filled = [row[k] for row in rows if row[k] is not None]
        numeric = bool(filled) and all(map(_is_number, filled))
        side = "right" if numeric else "left"
        table.add_column(escape(name) + unit, justify=side, no_wrap=numeric, overflow="fold")  # type: ignore[arg-type]
    for row in rows:
        table.add_row(*(escape(_text(cell, digits)) for cell in row))
    context = click.get_current_context(silent=True)
    notice = None if context is None else context.meta.get(NOTICE)
    first = [f"[bold red]{escape(notice)}[/bold red]"] if notice else []
    _print(*first, f"[bold]{escape(title)}[/bold]", table, *map(escape, below))


details_option = click.option("--details", is_flag=True, help="Print all tables and all findings, not the first ones.")
"""For commands whose answer is longer than a screen; it comes as ``details``."""


def print_result(result: Any, tables: int | None = None, findings: int | None = None) -> None:
    """Print what a result shows: how it came out and its findings, the worst first, below its first table, then the others.

    ``tables`` and ``findings`` print the first of them only, and say how many more there are with ``--details``.
    """
    from dampyr.phrases import counted
    from dampyr.show.descriptions import description_of

    description = description_of(result)
    sentences = [finding.sentence for finding in besides(getattr(result, "findings", ()), description.verdict)]
    left = {
        "more finding": 0 if findings is None else len(sentences[findings:]),
        "more table": 0 if tables is None else len(description.tables[tables:]),
    }
    more = " and ".join(counted(number, noun) for noun, number in left.items() if number)
    first, *others = description.tables[:tables]
    print_shown(first(), [*description.verdict, *sentences[:findings], *([f"{more}: add --details."] if more else [])])
    for table in filter(lambda table: table.rows, (make() for make in others)):
        click.echo()
        print_shown(table)


def print_answer(result: Any, as_json: bool, tables: int | None = None) -> None:
    """Print a result for machines or for people, with what its origin says; ``tables`` is as that of `print_result`."""
    state_origin(result.origin)
    if as_json:
        print_json(result.as_dict())
    else:
        print_result(result, tables)


def answer(result: Any, report: Path | None, as_json: bool) -> None:
    """Write the page of a result where one is asked for, print the result, and say where the page is."""
    if report:
        from dampyr.show.pages.result_page import write_page

        write_page(result, report)
    print_answer(result, as_json)
    if report and not as_json:
        click.echo(f"page: {report}")


def print_shown(table: Table, notes: Sequence[str] = ()) -> None:
    """Print a table of a description, its caption as the title, and below it ``notes`` and its own."""
    title, units = table.caption.removesuffix("."), table.units or None
    print_table(title, table.columns, table.rows, units, table.digits, [*notes, *table.notes])


def _print(*parts: Any) -> None:
    """Print on stdout: as wide as the terminal, or, into a file or a pipe, as wide as it needs to be."""
    from rich.console import Console

    if sys.stdout.isatty():
        Console().print(*parts, sep="\n", highlight=False)
        return
    page = io.StringIO()
    Console(file=page, width=WIDTH_OF_A_FILE).print(*parts, sep="\n", highlight=False)
    click.echo("\n".join(line.rstrip() for line in page.getvalue().rstrip().splitlines()))


def drop_unwritten() -> None:
    """Let go of output that cannot be written, so that Python does not try again when it ends."""
    try:
        sys.stdout.flush()
    except (OSError, ValueError):
        with suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _is_number(cell: Any) -> bool:
    return hasattr(cell, "__float__") and not isinstance(cell, bool)


def _text(cell: Any, digits: int) -> str:
    if cell is None:
        return DASH
    if isinstance(cell, bool):
        return "yes" if cell else "no"
    if isinstance(cell, int):
        return str(cell)
    return f"{float(cell):.{digits}g}" if _is_number(cell) else str(cell)
