"""Run: a campaign on a rig, checked before anything moves."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._output import as_json_option, print_json, print_table
from dampyr.cli._report import report_options
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.campaigns import Plan
    from dampyr.campaigns.journal import Entry

REFUSED, FEW = 2, 50


@click.command()
@click.argument("campaign", type=click.Path(path_type=Path))
@click.option("--rig", type=click.Path(path_type=Path), help="A rig.toml.  [default: the original rig, simulated]")
@click.option(
    "--out", type=click.Path(path_type=Path), metavar="DIR", help="Where the records go; goes on where it stopped."
)
@click.option("--dry-run", is_flag=True, help="Print the plan and what the rig cannot do; move nothing.")
@click.option("--seed", type=click.IntRange(0), help="Of the random order, instead of the campaign's.")
@report_options("Write a page of the plan.")
@click.option("--in-process", is_flag=True, help="Simulate the rig without its wires (without the extra rig).")
@click.option("--real-time", is_flag=True, help="Simulate the rig at the pace of a real one.")
@click.option(
    "--fault", "faults", multiple=True, metavar="FAULT", help='Of a simulated rig: "stalled-motor@60s for 2s".'
)
@as_json_option
def command(
    campaign: Path,
    rig: Path | None,
    out: Path | None,
    dry_run: bool,
    seed: int | None,
    report: Path | None,
    in_process: bool,
    real_time: bool,
    faults: tuple[str, ...],
    as_json: bool,
) -> int | None:
    """Run CAMPAIGN, a TOML file, on a rig.

    The whole campaign is checked first: what the rig cannot do is told with the largest value that it can, and nothing runs.
    While it runs: p pauses after the test under way and goes on, s or Ctrl-C stops in order, a aborts at once.
    """
    from dampyr import campaigns

    found = campaigns.planned(campaign, rig, seed)
    if report:
        from dampyr.report.plan_page import write_plan_page

        write_plan_page(found, report)
    if dry_run:
        _tell(found, as_json)
    for refusal in found.refusals:
        click.echo(f"dampyr: {refusal}", err=True)
    if found.refusals:
        return REFUSED
    if not dry_run:
        if out is None:
            raise InputError(
                "--out is missing; give the folder where the records go, or --dry-run to see the plan only"
            )
        _perform(found, rig, out, as_json, {"faults": faults, "in_process": in_process, "real_time": real_time})
    return None


def _perform(found: Plan, rig: Path | None, out: Path, as_json: bool, how: dict[str, Any]) -> None:
    from dampyr.campaigns import Control, perform, read_journal
    from dampyr.cli._running import keys, shown, stopped_by_signals
    from dampyr.rig import open_rig

    control = Control()
    try:
        with open_rig(rig, **how) as opened, stopped_by_signals(), shown(found) as show, keys(control):
            perform(found, opened, out, show, control)
    finally:
        if (out / "journal.sqlite").is_file():
            tests, events = read_journal(out)
            if as_json:
                print_json({"folder": str(out), "tests": tests, "events": events})
            elif tests:
                _summary(found, out, tests)


def _summary(found: Plan, out: Path, tests: list[Entry]) -> None:
    """What is there now."""
    words = {test.name: test.words for test in found.tests}
    rows = [[test.name, words.get(test.name, ""), test.state, test.attempt, test.reason] for test in tests]
    complete = sum(test.state == "complete" for test in tests)
    left = len(tests) - complete
    hint = f"dampyr identify {out}" if not left else "run the same command again to go on"
    print_table(
        f"{found.campaign.header.name}: {complete} of {len(tests)} tests complete in {out}",
        ["test", "what", "state", "try", "reason"],
        [row for row in rows if row[2] != "complete" or len(rows) <= FEW] or [["all", "", "complete", None, ""]],
        notes=[f"next: {hint}"],
    )


def _tell(found: Plan, as_json: bool) -> None:
    if as_json:
        print_json(_told(found))
        return
    from dampyr.report.plan_page import COLUMNS, UNITS, plan_notes, plan_rows

    print_table(_title(found), COLUMNS, plan_rows(found), UNITS, notes=plan_notes(found))


def _title(found: Plan) -> str:
    minutes = f"{found.duration / 60:.1f} min" if found.duration >= 60 else f"{found.duration:.0f} s"
    return f"{found.campaign.header.name}: {len(found.tests)} tests on {found.rig.name}, {minutes}"


def _told(found: Plan) -> dict[str, Any]:
    return {
        "campaign": found.campaign.header,
        "rig": found.rig.name,
        "duration_s": found.duration,
        "tests": [
            {
                "name": each.name, "kind": each.kind, "step": each.step, "duration_s": each.duration,
                "peak_speed_m_s": each.peak_speed, "peak_position_m": each.peak_position,
                "peak_force_N": each.peak_force, "peak_voltage_V": each.peak_voltage,
                "energy_J": each.energy,
                "notes": each.notes, "refusal": each.refusal,
            }
            for each in found.tests
        ],
        "notes": found.notes,
        "refusals": found.refusals,
    }  # fmt: skip
