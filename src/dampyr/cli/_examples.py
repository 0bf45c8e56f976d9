"""Examples in the help of a command: lines to paste, which a test runs."""

from __future__ import annotations

import click

HEADING = "Examples:"


def examples(*lines: str) -> str:
    """The ``epilog`` of a command whose help ends with these lines, none of them folded.

    They may name ``damper.toml`` (a card), ``tests`` (a folder of records), ``rig.toml``, ``campaign.toml`` and what
    ``tests/cli/test_examples.py`` makes beside these: it runs every line.
    """
    return "\n".join(["\b", HEADING, *(f"  {line}" for line in lines)])


def examples_of(command: click.Command) -> tuple[str, ...]:
    """The examples in the help of a command."""
    heading, _, text = (command.epilog or "").partition(f"{HEADING}\n")
    return tuple(line.strip() for line in text.splitlines()) if heading.strip() == "\b" else ()
