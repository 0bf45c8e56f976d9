"""Published data sets: what there is, and getting it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from dampyr.cli._output import as_json_option, print_json, print_table


@click.group()
def command() -> None:
    """List published data sets, or fetch one."""


@command.command("list")
@as_json_option
def list_(as_json: bool) -> None:
    """List data sets: where they are, how to cite them."""
    from dampyr.records.datasets import DATA_SETS

    datasets = [_described(each) for each in DATA_SETS]
    if as_json:
        print_json(datasets)
        return
    rows = [[each["name"], each["state"], each["folder"], each["licence"], each["citation"]] for each in datasets]
    print_table("Data sets", ["name", "state", "folder", "licence", "cite as"], rows)


@command.command()
@click.argument("name")
@click.option("--to", "folder", type=click.Path(path_type=Path), help="Where to; by default below DAMPYR_DATA.")
@click.option("--from", "source", help="Another address, or a local folder, with the same files.")
@as_json_option
def fetch(name: str, folder: Path | None, source: str | None, as_json: bool) -> None:
    """Fetch a data set.

    Each file of the data set NAME is checked by its sha256; what is there and right is kept.
    """
    from rich.console import Console

    from dampyr import records
    from dampyr.records.datasets import data_set

    dataset = data_set(name)
    with Console(stderr=True).status(f"fetching {name}") as status:
        target = records.fetch(name, folder, source, progress=lambda file: status.update(f"{name}: {file}"))
    files = sorted(path.name for path in target.iterdir() if path.is_file())
    if as_json:
        print_json({"name": name, "folder": target, "files": files, "doi": dataset.doi, "citation": dataset.citation})
    else:
        click.echo(f"{name}: {len(files)} files in {target}\nplease cite: {dataset.citation}")


def _described(dataset: Any) -> dict[str, Any]:
    """A data set and its state on this machine."""
    from dampyr import records
    from dampyr.errors import MissingData
    from dampyr.records.datasets import missing_files

    folder, missing = None, None
    try:
        folder = records.locate(dataset.name)
        missing = missing_files(folder)
        state = f"{len(missing)} files missing" if missing else "complete"
    except MissingData:
        state = f"absent; dampyr datasets fetch {dataset.name}"
    fields = {key: getattr(dataset, key) for key in ("name", "doi", "citation", "licence")}
    return fields | {"state": state, "folder": folder, "missing_files": missing}
