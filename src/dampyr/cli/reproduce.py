"""Published studies run again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from dampyr.cli._examples import examples
from dampyr.cli._output import as_json_option, print_json, print_result, state_origin
from dampyr.cli._progress import stages
from dampyr.cli._report import figures_option
from dampyr.errors import InputError, MissingData

DEFAULT, HYBRID = "raminelli_2020", "vrths_2020"
PLANTS = 1000


@click.command(epilog=examples("dampyr reproduce --out reproduce", "dampyr reproduce --all --out reproduce"))
@click.argument("study", required=False)
@click.option("--list", "as_list", is_flag=True, help="Only list the studies.")
@click.option("--all", "every", is_flag=True, help="Run every study; those whose data are not there are named.")
@click.option(
    "--data",
    type=click.Path(path_type=Path),
    help="The folder of the study's data; by default where dampyr finds them.",
)
@click.option(
    "--plants",
    type=click.IntRange(0),
    help=f"For vrths_2020: number of random plants that each case is run on.  [default: {PLANTS}]",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("dampyr-reproduce"),
    show_default=True,
    help="The folder for the page and its numbers.",
)
@figures_option
@as_json_option
def command(
    study: str | None, as_list: bool, every: bool, data: Path | None, plants: int | None, out: Path, as_json: bool
) -> None:
    """Run a published study again, with a verdict on each number.

    STUDY is one of --list; raminelli_2020, the dissertation with its campaign, is the default. The published value stands
    beside ours.

    Writes a page and its numbers: reproduce.html and reproduce.json, of another study STUDY.html and STUDY.json. Without the
    measured files of raminelli_2020 all that needs none is done, and what was left out is said.
    """
    from dampyr import studies

    known = studies.available_studies()
    if as_list:
        _list(known, as_json)
        return
    _check(study, known, every, data, plants)
    if every:
        _run_all(known, out, plants, as_json)
        return
    result = _run(study or DEFAULT, data, out, plants)
    if hasattr(result, "origin"):
        state_origin(result.origin)
    if as_json:
        print_json(result.as_dict())
    else:
        print_result(result)
        click.echo(f"page: {result.page}")


def _check(study: str | None, known: list[str], every: bool, data: Path | None, plants: int | None) -> None:
    """Refuse a study that is none, and options that do not go together."""
    if every and study is not None:
        raise InputError(f"{study} and --all are both given; leave one of them out")
    if study is not None and study not in known:
        raise InputError(f"{study!r} is not a study; choose from {', '.join(known)}")
    if plants is not None and not every and study != HYBRID:
        raise InputError(f"--plants is of {HYBRID}; leave it out")
    if every and data is not None:
        raise InputError("--data is of one study; with --all set DAMPYR_DATA to the folder that holds the data of all")


def _list(known: list[str], as_json: bool) -> None:
    from dampyr import registry, studies

    about = {name: registry.summary(registry.member(studies.__name__, name)) for name in known}
    if as_json:
        print_json(about)
        return
    for name, words in about.items():
        click.echo(f"{name}\n    {words}")


def _run_all(known: list[str], out: Path, plants: int | None, as_json: bool) -> None:
    """Every study whose data are there, a row for each."""
    results: dict[str, Any] = {}
    absent: dict[str, str] = {}
    for name in known:
        try:
            results[name] = _run(name, None, out, plants)
        except MissingData as problem:
            absent[name] = str(problem)
    if as_json:
        print_json({"studies": {name: result.as_dict() for name, result in results.items()}, "left_out": absent})
        return
    from dampyr.show.table import Table
    from dampyr.studies._study_run import OUTCOMES

    rows = []
    for name, result in results.items():
        verdicts = [value.verdict for value in result.compared]
        origin = result.origin.kind if hasattr(result, "origin") else None
        rows.append([name, *(verdicts.count(kind) for kind in OUTCOMES), origin, result.page.name])
    print_result(Table(("study", *OUTCOMES, "origin", "page"), rows, caption=f"Studies run again, pages in {out}."))
    for name, why in absent.items():
        click.echo(f"Left out: {name}: {why}.")


def _run(name: str, data: Path | None, out: Path, plants: int | None) -> Any:
    """The result of a study, with its page."""
    from dampyr import registry, studies

    more = {"plants": PLANTS if plants is None else plants} if name == HYBRID else {}
    with stages() as progress:
        return registry.member(studies.__name__, name).reproduce(data, out, progress=progress, **more)
