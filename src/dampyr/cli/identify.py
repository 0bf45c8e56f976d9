"""Identify: from records to a damper's card."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._output import as_json_option, print_json, print_table
from dampyr.cli._progress import stages
from dampyr.cli._records import Reading, gather, pairs, reading_options
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.identification import Fit, Validation
    from dampyr.records import Record


@click.command()
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--model", default="dahl", show_default=True, help="Parts, such as 'dahl + spring + delay'.")
@click.option("--law", "laws", multiple=True, metavar="[NAME=]KIND", help="constant, interpolation, polynomial:DEGREE.")
@click.option("--fix", "fixed", multiple=True, metavar="NAME=VALUE", help="Hold a parameter, in SI units.")
@click.option("--bandwidth", type=float, metavar="HZ", help="Derive the velocity with this bandwidth.")
@click.option(
    "--predict",
    "splits",
    multiple=True,
    metavar="SPLIT",
    help="Cross-validate by record, input, frequency or amplitude.",
)
@click.option("--each", is_flag=True, help="Fit every record by itself instead of all together.")
@click.option("--save", type=click.Path(path_type=Path), metavar="CARD", help="Write the damper's card, a .toml file.")
@click.option("--report", type=click.Path(path_type=Path), metavar="HTML", help="Write a page with figures.")
@reading_options
@as_json_option
def command(
    paths: tuple[Path, ...],
    model: str,
    laws: tuple[str, ...],
    fixed: tuple[str, ...],
    bandwidth: float | None,
    splits: tuple[str, ...],
    each: bool,
    save: Path | None,
    report: Path | None,
    reading: Reading,
    as_json: bool,
) -> None:
    """Identify a damper from records by least squares.

    PATHS are record files or campaign folders (of which the records for fitting are taken). All records are fitted
    together, each parameter following the voltage, unless --each is given. --predict says how well the model predicts
    records that it was not fitted on: five random parts of the records, one input left out at a time, or five parts in
    the order of frequency or stroke.
    """
    from dampyr.identification import cross_validate, fit

    records = gather(paths, "fit", reading)
    if each and (save or report or splits):
        raise InputError(
            "--each makes one fit per record and no card; leave out --save, --report and --predict, or --each"
        )
    options: dict[str, Any] = {"laws": _laws(laws), "fixed": _numbers(fixed), "bandwidth": bandwidth}
    groups = [[record] for record in records] if each else [records]
    fits = []
    with stages() as progress:
        for k, group in enumerate(groups):

            def show(step: int, _: float, k: int = k) -> None:
                progress("identifying", (k + step / (step + 20.0)) / len(groups))

            progress("identifying", k / len(groups))
            fits.append(fit(model, group, **options, progress=show))
        progress("identifying", 1.0)
        checks = []
        for split in splits:

            def share(done: float, split: str = split) -> None:
                progress(f"predicting by {split}", done)

            checks.append(cross_validate(model, records, split, progress=share, **options))
    if as_json:
        told = [_told(f) | ({"predictions": checks} if checks else {}) for f in fits]
        print_json(told if each else told[0])
    elif each:
        _print_each(fits)
    else:
        _print(fits[0])
        for check in checks:
            _print_prediction(check, records)
    if save:
        _save(fits[0], save)
    if report:
        from dampyr.report.fit_page import write_fit_page

        write_fit_page(fits[0], report)


def _laws(given: tuple[str, ...]) -> str | dict[str, str] | None:
    plain = [law for law in given if "=" not in law]
    if len(plain) == 1 and len(given) == 1:
        return plain[0]
    return pairs(given)


def _numbers(given: tuple[str, ...]) -> dict[str, float]:
    found = {}
    for name, text in (pairs(given) or {}).items():
        try:
            found[name] = float(text)
        except ValueError:
            raise InputError(f"--fix {name}={text}: {text!r} is not a number in SI units") from None
    return found


def _save(fit: Fit, path: Path) -> None:
    if fit.damper is None:
        raise InputError(f"no card was written: {fit.reason}")
    fit.damper.save(path)


def _told(fit: Fit) -> dict[str, Any]:
    return {
        "model": str(fit.problem.composition),
        "records": [record.name for record in fit.records],
        "converged": fit.converged,
        "reason": fit.reason,
        "notes": fit.notes,
        "clusters": fit.clusters,
        "parameters": fit.parameters,
        "stderr": fit.stderr,
        "naive_stderr": fit.naive_stderr,
        "units": fit.units,
        "correlation": fit.correlation,
        "nuisances": fit.nuisances,
        "scores": fit.scores,
    }


def _print(fit: Fit) -> None:
    from dampyr.units import for_people

    rows = []
    for name, value in fit.parameters.items():
        unit, factor = for_people(fit.units[name])
        rows.append([name, value * factor, fit.stderr[name] * factor, fit.naive_stderr[name] * factor, unit])
    notes = [f"The search {fit.reason}.", *(f"{note}." for note in fit.notes)]
    names = ["parameter", "value", "standard error", "naive error", "unit"]
    print_table(f"{fit.problem.composition}, {len(fit.records)} records", names, rows, digits=5, notes=notes)
    title = "How well it describes what it was fitted to (no prediction)"
    _print_groups(title, list(fit.records), {name: s.l1 for name, s in fit.scores.items()})


def _print_prediction(check: Validation, records: list[Record]) -> None:
    """The scores of records that the model was not fitted on, by input."""
    title = f"How well it predicts records that it was not fitted on, {len(check.folds)} parts by {check.split}"
    notes = [f"a part of {len(f.fitted_on)} records gave no damper: {f.reason}" for f in check.folds if not f.scores]
    notes += [f"a fit on {len(f.fitted_on)} records {f.reason}" for f in check.folds if f.scores and not f.converged]
    _print_groups(title, records, {name: s.l1 for name, s in check.scores.items()}, notes)


def _print_groups(title: str, records: list[Record], l1: dict[str, float], notes: Sequence[str] = ()) -> None:
    """Mean and worst L1 over the records of each input that have a score."""
    groups: dict[float | None, list[float]] = {}
    for record in records:
        if record.name in l1:
            groups.setdefault(record.input_value, []).append(l1[record.name])
    rows = [[u, len(values), 100 * sum(values) / len(values), 100 * max(values)] for u, values in groups.items()]
    names, units = ["input", "records", "mean L1", "worst L1"], [records[0].input or "", "", "%", "%"]
    print_table(title, names, rows, units, digits=3, notes=notes)


def _print_each(fits: list[Fit]) -> None:
    from dampyr.units import for_people

    names = list(fits[0].parameters)
    shown = [for_people(fits[0].units[name]) for name in names]
    rows = []
    for fit in fits:
        record = fit.records[0]
        values = [value * factor for value, (_, factor) in zip(fit.parameters.values(), shown, strict=True)]
        state = "yes" if fit.converged else fit.reason
        rows.append([record.name, record.input_value, *values, 100 * fit.scores[record.name].l1, state])
    print_table(
        f"{fits[0].problem.composition}, each of {len(fits)} records by itself",
        ["record", "input", *names, "L1", "converged"],
        rows,
        ["", fits[0].records[0].input or "", *(unit for unit, _ in shown), "%", ""],
    )
