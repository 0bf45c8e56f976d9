"""Validate: how well a card predicts records."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._output import as_json_option, print_json, print_table
from dampyr.cli._records import Reading, gather, reading_options, role_option
from dampyr.cli._report import report_options
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.identification import Score
    from dampyr.models import Damper
    from dampyr.records import Record

NAMES = ["record", "input", "fitted on", "L1", "NRMSE", "R²", "pointwise", "peak force", "energy", "window"]


@click.command()
@click.argument("card", type=click.Path(path_type=Path))
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path))
@role_option()
@click.option("--settling", default=2.0, show_default=True, help="s after the motion starts that are not scored.")
@click.option(
    "--forces", type=click.Path(path_type=Path), metavar="DIR", help="Write measured and predicted forces as CSV."
)
@report_options()
@reading_options
@click.option("--allow-extrapolation", is_flag=True, help="Also inputs that the card was not calibrated on.")
@as_json_option
def command(
    card: Path,
    paths: tuple[Path, ...],
    role: str | None,
    settling: float,
    forces: Path | None,
    report: Path | None,
    reading: Reading,
    allow_extrapolation: bool,
    as_json: bool,
) -> None:
    """Score a card on records that it predicts.

    The card runs freely along each record of PATHS (files or folders of them); only the offset is taken from the record.
    Records that the card was fitted on are marked. --forces writes NAME.csv for each record, with its time, displacement,
    measured force and predicted force; files that this command wrote before are replaced, others never.
    """
    from dampyr.identification import compare, prediction
    from dampyr.models import Damper

    damper = Damper.load(card)
    records = gather(paths, role, reading, reference_inputs=damper.range)
    _check_names(records)
    predicted = {r.name: prediction(damper, r, allow_extrapolation) for r in records}
    scores = {r.name: compare(r, predicted[r.name], settling) for r in records}
    written = _write_forces(records, predicted, scores, forces) if forces else []
    if report:
        from dampyr.report.validate_page import write_validate_page

        write_validate_page(damper, records, scores, report, card=str(card))
    seen = {name.strip() for name in damper.provenance.get("records", "").split(",")}
    if as_json:
        scores_by_record = {name: s.as_dict() | {"fitted_on": name in seen} for name, s in scores.items()}
        by_input = [dict(zip(("input", "records", "mean_l1", "worst_l1"), row)) for row in _by_input(records, scores)]
        print_json({"card": card, "scores": scores_by_record, "by_input": by_input, "forces": written})
        return
    _print(f"{card}: {damper.composition}", damper, records, scores, seen)
    if written:
        click.echo(f"forces: {_count(len(written), 'file')} in {forces}")
    if report:
        click.echo(f"page: {report}")


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _check_names(records: list[Record]) -> None:
    name, count = Counter(record.name for record in records).most_common(1)[0]
    if count > 1:
        raise InputError(
            f"{count} records are called {name!r}; rename the files of all but one, or validate them one by one"
        )


def _write_forces(
    records: list[Record], predicted: dict[str, Any], scores: dict[str, Score], folder: Path
) -> list[Path]:
    """One file per record, none where one of them is in the way of somebody else's."""
    from dampyr.records import write_comparison
    from dampyr.records.comparison import check_free, file_name

    folder.mkdir(parents=True, exist_ok=True)
    for record in records:
        check_free(folder / file_name(record))
    return [
        write_comparison(r, predicted[r.name], folder / file_name(r), offset=scores[r.name].offset) for r in records
    ]


def _by_input(records: list[Record], scores: dict[str, Score]) -> list[tuple[float | None, int, float, float]]:
    """Input, number of records, mean and worst L1, the inputs in rising order."""
    groups: dict[float | None, list[float]] = {}
    for record in records:
        groups.setdefault(record.input_value, []).append(scores[record.name].l1)
    order = sorted(groups, key=lambda u: math.inf if u is None else u)
    return [(u, len(groups[u]), sum(groups[u]) / len(groups[u]), max(groups[u])) for u in order]


def _print(title: str, damper: Damper, records: list[Record], scores: dict[str, Score], seen: set[str]) -> None:
    rows = []
    for r in records:
        s = scores[r.name]
        energy = None if math.isnan(s.energy) else 100 * s.energy
        window = f"{s.window.start:.2f}–{s.window.end:.2f}"
        errors = [100 * s.l1, 100 * s.nrmse, s.r2, 100 * s.pointwise, 100 * s.peak_force, energy]
        rows.append([r.name, r.input_value, "yes" if r.name in seen else "no", *errors, window])
    notes = [
        f"mean L1 {100 * sum(s.l1 for s in scores.values()) / len(scores):.2f} % over {_count(len(rows), 'record')}"
    ]
    if any(row[8] is None for row in rows):
        notes.append("energy –: no whole cycle in the window, so it is not scored")
    print_table(title, NAMES, rows, ["", damper.input, "", "%", "%", "", "%", "%", "%", "s"], digits=3, notes=notes)
    groups = [[u, count, 100 * mean, 100 * worst] for u, count, mean, worst in _by_input(records, scores)]
    if len(groups) > 1:
        units = [damper.input, "", "%", "%"]
        click.echo()
        print_table("By input", ["input", "records", "mean L1", "worst L1"], groups, units, digits=3)
