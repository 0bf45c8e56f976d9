"""Demo: the whole chain on a simulated rig."""

from __future__ import annotations

from pathlib import Path

import click

from dampyr.cli._examples import examples
from dampyr.cli._output import as_json_option, print_json, print_table, state_origin
from dampyr.cli._progress import stages
from dampyr.cli._report import figures_option


@click.command(epilog=examples("dampyr demo --out demo"))
@click.option(
    "--out",
    default="dampyr-demo",
    show_default=True,
    type=click.Path(path_type=Path),
    help="The folder to write into.",
)
@figures_option
@as_json_option
def command(out: Path, as_json: bool) -> None:
    """Run the whole chain on a simulated rig and write a report.

    Tests at four voltages, records on disk, a joint identification, validation on held-out tests, and a building under
    El Centro 1940 with and without the damper. Needs nothing but this installation.
    """
    from dampyr.studies.demo import demo

    with stages() as progress:
        result = demo(out, progress)
    state_origin(result.origin)
    if as_json:
        print_json(result.summary() | {"report": out / "report.html"})
        return
    rows = [[name, 100 * s.l1, 100 * s.nrmse, 100 * s.peak_force] for name, s in result.scores.items()]
    print_table(
        "Held-out tests",
        ["record", "L1", "NRMSE", "peak force"],
        rows,
        ["", "%", "%", "%"],
        3,
    )
    rows = [
        [name, *(1e3 * r.peak_displacement), max(r.peak_acceleration), result.off_by(name)]
        for name, r in result.responses.items()
    ]
    print_table(
        "The building under El Centro 1940, peaks",
        ["case", "first floor", "roof", "acceleration", "off the specimen"],
        rows,
        ["", "mm", "mm", "m/s²", "%"],
        notes=[
            "off the specimen: of the first floor, from that with the simulated specimen: what leaving the tests' range costs",
            f"card    {result.card}",
            f"records {result.folder / 'records'}",
            f"report  {out / 'report.html'}",
        ],
        findings=result.of_building.findings,
    )
