"""Run: a campaign on a rig, checked before anything moves."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._output import as_json_option, print_json, print_table
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.campaigns import Plan

REFUSED = 2


@click.command()
@click.argument("campaign", type=click.Path(path_type=Path))
@click.option("--rig", type=click.Path(path_type=Path), help="A rig.toml.  [default: the original rig, simulated]")
@click.option("--out", type=click.Path(path_type=Path), metavar="DIR", help="Where the records go.")
@click.option("--dry-run", is_flag=True, help="Print the plan and what the rig cannot do; move nothing.")
@click.option("--seed", type=click.IntRange(0), help="Of the random order, instead of the campaign's.")
@click.option("--report", type=click.Path(path_type=Path), metavar="HTML", help="Write a page of the plan.")
@as_json_option
def command(
    campaign: Path,
    rig: Path | None,
    out: Path | None,
    dry_run: bool,
    seed: int | None,
    report: Path | None,
    as_json: bool,
) -> int | None:
    """Run CAMPAIGN, a TOML file, on a rig.

    The whole campaign is checked first: what the rig cannot do is told with the largest value that it can, and nothing runs.
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
        _perform(found, out)
    return None


def _perform(found: Plan, out: Path | None) -> None:
    raise InputError("campaigns cannot be performed yet; give --dry-run to see the plan")


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
