"""Accept: whether tested dampers lie within a band about a reference."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from dampyr.cli._examples import examples
from dampyr.cli._options import OptionsCommand
from dampyr.cli._output import EXIT_CODES, answer, as_json_option
from dampyr.cli._records import READING, gather, role_option
from dampyr.cli._report import report_options
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.identification import AcceptOptions
    from dampyr.models import Damper
    from dampyr.records import ReadOptions, Record


@click.command(
    cls=OptionsCommand,
    options={"options": "dampyr.identification:AcceptOptions"} | READING,
    epilog=examples(
        "dampyr accept damper.toml tests --tolerance 20%",
        "dampyr accept damper.toml tests --tolerance 10% --report accept.html",
    ),
)
@click.argument("reference", metavar="REFERENCE")
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path))
@role_option("Which records of a folder in PATHS are taken.")
@report_options()
@as_json_option
def command(
    reference: str,
    paths: tuple[Path, ...],
    options: AcceptOptions,
    role: str | None,
    report: Path | None,
    reading: ReadOptions,
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
    from dampyr.identification import accept
    from dampyr.identification.acceptance_tests.accept import inputs_of

    damper_or_records = _reference(reference, reading)
    records = gather(paths, role, reading, reference_inputs=inputs_of(damper_or_records), warn=False)
    result = accept(records, damper_or_records, options, reference)
    answer(result, report, as_json)
    return EXIT_CODES[result.verdict]


def _reference(text: str, reading: ReadOptions) -> Damper | list[Record]:
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
