"""Published data sets: what there is, and getting it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from dampyr.cli._examples import examples
from dampyr.cli._output import as_json_option, print_json, print_table


@click.group(
    epilog=examples(
        "dampyr datasets list",
        "dampyr datasets fetch labcontrol",
    )
)
def command() -> None:
    """List open data sets, show one, or fetch one."""


@command.command("list", epilog=examples("dampyr datasets list", "dampyr datasets list --json"))
@as_json_option
def list_(as_json: bool) -> None:
    """List data sets: what they are of, their licences, what is here."""
    from dampyr.records import datasets

    described = [datasets.describe(name) for name in datasets.available_data_sets()]
    if as_json:
        print_json(described)
        return
    rows = [
        [
            data_set["name"],
            data_set["kind"],
            str(data_set["licence"]).partition(",")[0],
            data_set["count"],
            _size(data_set["size"]),
            "absent" if data_set["folder"] is None else str(data_set["state"]),
        ]
        for data_set in described
    ]
    print_table(
        "Data sets",
        ["name", "of", "licence", "files", "size", "here"],
        rows,
        notes=[
            "all of one: `dampyr datasets show NAME`; get one: `dampyr datasets fetch NAME`, such as",
            "`dampyr datasets fetch labcontrol`. Where no licence is stated, files may be used only as the law or",
            "their owner allows.",
        ],
    )


@command.command(epilog=examples("dampyr datasets show quiroz_2022"))
@click.argument("name")
@as_json_option
def show(name: str, as_json: bool) -> None:
    """Show all that is known of the data set NAME."""
    from dampyr.phrases import counted
    from dampyr.records import datasets

    described = datasets.describe(name)
    if as_json:
        print_json(described)
        return
    count, folder = described["count"], described["folder"]
    number = "number unknown" if count is None else counted(count, "file")
    click.echo(f"{name}: {described['title']}\n")
    lines = {
        "of": described["kind"],
        "specimen": described["specimen"],
        "holds": described["holds"],
        "good for": described["good_for"],
        "format": described["format"],
        "licence": f"{described['licence']} ({described['licence_from']})",
        "cite as": described["citation"],
        "doi": described["doi"] or "none",
        "page": described["page"],
        "files": f"{number}, {_size(described['size']) or 'size unknown'}",
        "checksums": _checksums(described["files"]),
        "here": "absent" if folder is None else f"{described['state']}, in {folder}",
    }
    for what, text in lines.items():
        click.echo(_wrapped(what, text))
    for note in described["notes"]:
        click.echo(_wrapped("note", note))


@command.command(epilog=examples("dampyr datasets fetch labcontrol --to data/labcontrol-mr-damper"))
@click.argument("name")
@click.option("--to", "folder", type=click.Path(path_type=Path), help="The folder; by default one below DAMPYR_DATA.")
@click.option("--from", "source", help="Another address, or a local folder, that has the same files.")
@click.option("--accept-no-licence", is_flag=True, help="Download a set although no licence is stated.")
@as_json_option
def fetch(name: str, folder: Path | None, source: str | None, accept_no_licence: bool, as_json: bool) -> None:
    """Fetch a data set.

    Each file of the data set NAME is checked by its sha256; what is there and right is kept. Files whose sha256 nobody gives
    are recorded in SHA256SUMS at the first fetch, and checked against that from then on.
    """
    from rich.console import Console

    from dampyr import records
    from dampyr.phrases import counted
    from dampyr.records.datasets import data_set

    dataset = data_set(name)
    with Console(stderr=True).status(f"fetching {name}") as status:

        def progress(file: str) -> None:
            status.update(f"{name}: {file}")

        target = records.fetch(name, folder, source, progress=progress, accept_no_licence=accept_no_licence)
    files = sorted(path.name for path in target.iterdir() if path.is_file())
    if as_json:
        described = {"doi": dataset.doi, "citation": dataset.citation, "licence": dataset.licence_in_words}
        print_json({"name": name, "folder": target, "files": files} | described)
        return
    click.echo(f"{name}: {counted(len(files), 'file')} in {target}")
    click.echo(f"licence: {dataset.licence_in_words} ({dataset.licence_from})\nplease cite: {dataset.citation}")
    if not dataset.licence:
        click.echo("without a licence the files may be used only as the law or their owner allows")


def _size(size: int | None) -> str | None:
    return None if size is None else f"{size / 1e6:.2f} MB" if size >= 1e6 else f"{size / 1e3:.0f} kB"


def _checksums(files: list[dict[str, Any]]) -> str:
    """How many of the files have a sha256 that is in dampyr."""
    if not files:
        return "none: dampyr does not know the files one by one"
    number = sum(bool(file["sha256"]) for file in files)
    if number == len(files):
        return f"sha256 of {'the file' if number == 1 else f'all {number} files'} in dampyr"
    return f"sha256 of {number} of {len(files)} files in dampyr; the others are recorded at the first fetch and checked then"


def _wrapped(what: str, text: str) -> str:
    """A line of the form ``what  text``, folded to the width of a page."""
    from textwrap import fill

    return fill(
        text,
        100,
        initial_indent=f"{what:<11}",
        subsequent_indent=" " * 11,
        break_long_words=False,
        break_on_hyphens=False,
    )
