"""Licences: under which terms dampyr and what it installs may be used."""

from __future__ import annotations

from importlib import metadata
from typing import Any

import click

from dampyr.cli._examples import examples
from dampyr.cli._output import as_json_option, print_json, print_table

LONG = 60  # characters: some packages give the whole text in the place of the licence's name


@click.command(
    epilog=examples(
        "dampyr licences",
        "dampyr licences --extra console",
    )
)
@click.option(
    "--extra",
    "extras",
    multiple=True,
    metavar="NAME",
    help="List those of an extra too, such as console; may be repeated.",
)
@as_json_option
def command(extras: tuple[str, ...], as_json: bool) -> None:
    """List the licences of dampyr and of the packages it needs.

    They are what the installed packages state of themselves; a package that is not installed says so.
    """
    from dampyr.errors import InputError

    offered = sorted(metadata.metadata("dampyr").get_all("Provides-Extra") or [])
    unknown = [extra for extra in extras if extra not in offered]
    if unknown:
        raise InputError(f"there is no extra {unknown[0]!r}; choose from {', '.join(offered)}")
    rows = [[name, *_stated(name)] for name in _needed(extras)]
    if as_json:
        print_json([dict(zip(("name", "version", "licence"), row, strict=True)) for row in rows])
        return
    notes = [f"extras: {', '.join(offered)} (--extra NAME)"] if len(extras) < len(offered) else []
    print_table("Licences", ["package", "version", "licence"], rows, notes=notes)


def _needed(extras: tuple[str, ...]) -> list[str]:
    """dampyr, and all that it needs on this machine, in the order of the alphabet."""
    from packaging.requirements import Requirement
    from packaging.utils import canonicalize_name

    wanted: dict[str, set[str]] = {}
    waiting = [("dampyr", frozenset(extras))]
    while waiting:
        name, more = waiting.pop()
        if name in wanted and more <= wanted[name]:
            continue
        wanted.setdefault(name, set()).update(more)
        try:
            lines = metadata.requires(name) or []
        except metadata.PackageNotFoundError:
            continue
        for package in map(Requirement, lines):
            if package.marker is None or any(package.marker.evaluate({"extra": extra}) for extra in ("", *more)):
                waiting.append((canonicalize_name(package.name), frozenset(package.extras)))
    return ["dampyr", *sorted(set(wanted) - {"dampyr"})]


def _stated(name: str) -> tuple[str | None, str]:
    """The version and the licence that an installed package states."""
    try:
        about: Any = metadata.metadata(name)
    except metadata.PackageNotFoundError:
        return None, "not installed"
    words = [line.rpartition(" :: ")[2] for line in about.get_all("Classifier") or [] if line.startswith("License ::")]
    text = (about.get("License-Expression") or about.get("License") or "").strip()
    if words and (not text or "\n" in text or len(text) > LONG):
        text = ", ".join(words)
    return about.get("Version"), text.partition("\n")[0][:LONG] or "none stated"
