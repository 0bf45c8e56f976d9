"""Accept: whether tested dampers lie within a band about a reference."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._examples import examples
from dampyr.cli._motion import ratio
from dampyr.cli._output import as_json_option, print_json, print_table, state_origin
from dampyr.cli._records import Reading, gather, reading_options, role_option
from dampyr.cli._report import report_options
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.identification import Acceptance, Accepted, Tolerance
    from dampyr.models import Damper
    from dampyr.records import Record

FAILED, UNDECIDED = 1, 3  # exit codes; 2 is a wrong request, as with every command
MAX_REASONS = 6  # lines below the table; --json and --report have all
COLUMNS = ["record", "input", "verdict", "run", "cut", "judged", "largest", "outside", "worst", "cycle", "speed",
           "measured", "expected", "off by", "false fail", "false pass"]  # fmt: skip
UNITS = ["", "", "", "cycles", "cycles", "cycles", "mm", "points", "", "", "mm/s", "N or J", "N or J", "%", "", ""]
LEVELS = ["record", "level", "cycles", "judged", "stroke", "frequency", *("extension", "compression", "energy"), ""]
LEVEL_UNITS = ["", "", "", "", "mm", "Hz", "%", "%", "%", ""]
QUANTITIES = ("extension", "compression", "energy")


@click.command(
    epilog=examples(
        "dampyr accept damper.toml tests --tolerance 20%",
        "dampyr accept damper.toml tests --tolerance 10% --report accept.html",
    )
)
@click.argument("reference", metavar="REFERENCE")
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--tolerance", default="15%", show_default=True, help="Of what the reference gives, such as 10% or 0.1.")
@click.option("--slack", "slacks", multiple=True, metavar="Q", help="And this much more: 20N of force, 0.5J of energy.")
@click.option("--judge", multiple=True, type=click.Choice(QUANTITIES), help="Only this; may be repeated.")
@click.option("--offset", metavar="F", help="Taken from every measured force; without it, its mean over whole cycles.")
@click.option(
    "--relevel",
    type=click.IntRange(0),
    default=0,
    metavar="N",
    help="Judge again with the level of the first N cycles taken out.",
)
@role_option("Of a folder in PATHS.")
@report_options()
@reading_options
@click.option("--allow-extrapolation", is_flag=True, help="Judge beyond what a card was calibrated on, too.")
@as_json_option
def command(
    reference: str,
    paths: tuple[Path, ...],
    tolerance: str,
    slacks: tuple[str, ...],
    judge: tuple[Any, ...],
    offset: str | None,
    relevel: int,
    role: str | None,
    report: Path | None,
    reading: Reading,
    allow_extrapolation: bool,
    as_json: bool,
) -> int:
    """Judge records by a reference damper with a band of tolerance.

    REFERENCE is a card, the name of a published damper, or records of a reference damper (a file, or a folder of
    them). Every whole cycle of every level of every record in PATHS is judged: the force at peak velocity in
    extension and in compression, and the energy; and the mean of each over a level. Exits with 0 when every record
    passed, with 1 when a point or a mean lies outside, with 3 when none does but a record could not be judged.
    --relevel judges again with one factor on the force, that of each record's first cycles, taken out: it tells a
    record of another level from a damper of another shape. The exit code is that of the records as they are.
    """
    from dampyr import units
    from dampyr.identification import AcceptOptions, accept_records
    from dampyr.identification.acceptance_tests.accept_records import inputs_of

    zero = None if offset is None else units.parse(offset, "N")
    options = AcceptOptions(_tolerance(tolerance, slacks), judge or QUANTITIES, zero, allow_extrapolation, relevel)
    against = _reference(reference, reading)
    records = gather(paths, role, reading, reference_inputs=inputs_of(against), warn=False)
    result = accept_records(records, against, options, reference)
    if report:
        from dampyr.report import write_acceptance_page

        write_acceptance_page(result, report)
    state_origin(result.origin)
    if as_json:
        print_json(result.as_dict())
    else:
        _print(result)
        if report:
            click.echo(f"page: {report}")
    return {"passed": 0, "failed": FAILED, "not judged": UNDECIDED}[result.verdict]


def _tolerance(share: str, slacks: tuple[str, ...]) -> Tolerance:
    from dampyr import units
    from dampyr.identification import Tolerance

    given: dict[str, float] = {}
    for text in slacks:
        for name, unit in (("force", "N"), ("energy", "J")):
            try:
                float(text)  # a bare number could be either
            except ValueError:
                try:
                    given[name] = units.parse(text, unit)
                    break
                except InputError:
                    continue
        else:
            raise InputError(f"--slack {text!r} has no unit of a force or an energy; write it as in 20N or 0.5J")
    return Tolerance(ratio(share, "tolerance"), **given)


def _reference(text: str, reading: Reading) -> Damper | list[Record]:
    from dampyr import studies

    path = Path(text)
    if path.exists() and path.suffix.lower() != ".toml":
        return gather((path,), None, reading, warn=False)
    names = studies.available_dampers()
    if path.suffix.lower() != ".toml" and text not in names:
        raise InputError(
            f"{text}: no such file, and no published damper; give a card, records, or one of {', '.join(names)}"
        )
    return studies.load_damper(text)


def _print(result: Accepted) -> None:
    from dampyr.identification.acceptance_tests.acceptance import BEYOND, in_short

    results = result.results
    title = f"{len(results)} {'record' if len(results) == 1 else 'records'}: {in_short(results)}"
    off = BEYOND * results[0].tolerance.relative
    notes = [
        f"by {result.reference}, {results[0].tolerance}",
        "run, cut, judged: cycles from the start of the motion, whole ones, those judged; largest: the largest stroke judged",
        "false fail: the chance, at the record's scatter, that a damper like the reference fails; false pass: that one passes "
        "which is off by "
        + (f"{100 * off:.3g} % in one quantity at one level" if off else "a third more than is allowed"),
    ]
    rows = [_row(one) for one in results]
    print_table(title, COLUMNS, rows, UNITS, notes=[*notes, *_reasons(results)], findings=result.findings)
    _print_levels(results)
    if result.relevelled:
        again = result.relevelled
        title = f"Relevelled by the first cycles: {in_short(again)}"
        rows = [[one.record, one.input_value, one.level, *_row(one)[2:]] for one in again]
        units = [*UNITS[:2], "", *UNITS[2:]]
        notes = ["level: measured over expected in the first cycles, which is taken out of the later ones"]
        print_table(title, [*COLUMNS[:2], "level", *COLUMNS[2:]], rows, units, notes=[*notes, *_reasons(again)])


def _print_levels(results: Sequence[Acceptance]) -> None:
    """The means of every level, of records with more than one."""
    rows = [
        [one.record, each.number, each.cycles, each.judged, 1e3 * each.stroke_m, each.frequency_hz,
         *(_percent(each.deviation.get(q)) for q in QUANTITIES), "outside" if each in one.levels_outside else ""]
        for one in results if len(one.levels) > 1 for each in one.levels
    ]  # fmt: skip
    if rows:
        click.echo()
        print_table("Means of each level, off by", LEVELS, rows, LEVEL_UNITS)


def _percent(share: float | None) -> float | None:
    return None if share is None else 100 * share


def _row(one: Acceptance) -> list[Any]:
    from dampyr.identification.acceptance_tests.acceptance import percent

    worst = one.worst
    largest = 1e3 * one.judged_stroke_m if one.judged else None
    judged = f"{one.judged_cycles} of {one.cut}"
    head = [one.record, one.input_value, one.verdict, one.run, one.cut, judged, largest, len(one.outside)]
    chances = [each if each is None else percent(each) for each in (one.wrong_rejection, one.wrong_acceptance)]
    if worst is None:
        return [*head, *[None] * 6, *chances]
    off = _percent(worst.deviation)
    return [*head, worst.quantity, worst.cycle, 1e3 * worst.speed, worst.measured, worst.expected, off, *chances]


def _reasons(results: Sequence[Acceptance]) -> list[str]:
    """Why points were not judged, a line for each reason."""
    records_by_reason: dict[str, list[str]] = {}
    for one in results:
        for reason in one.unjudged:
            records_by_reason.setdefault(reason, []).append(one.record)
    lines = [f"not judged: {reason} – {_names(names)}" for reason, names in records_by_reason.items()]
    more = len(lines) - MAX_REASONS
    return (
        lines if more <= 0 else [*lines[:MAX_REASONS], f"and for {more} more reasons, which --json and --report tell"]
    )


def _names(names: list[str]) -> str:
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
