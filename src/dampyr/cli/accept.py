"""Accept: whether tested dampers lie within a band about a reference."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._examples import examples
from dampyr.cli._motion import ratio
from dampyr.cli._output import as_json_option, print_json, print_result, state_origin
from dampyr.cli._records import Reading, gather, reading_options, role_option
from dampyr.cli._report import report_options
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.identification import Tolerance
    from dampyr.models import Damper
    from dampyr.records import Record

FAILED, UNDECIDED = 1, 3  # exit codes; 2 is a wrong request, as with every command
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
        from dampyr.show.pages.acceptance_page import write_acceptance_page

        write_acceptance_page(result, report)
    state_origin(result.origin)
    if as_json:
        print_json(result.as_dict())
    else:
        print_result(result)
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
