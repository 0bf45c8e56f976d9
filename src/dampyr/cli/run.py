"""Run: a campaign on a rig, checked before anything moves."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._examples import examples
from dampyr.cli._output import (
    as_json_option,
    drop_unwritten,
    in_process_option,
    print_json,
    print_result,
    print_table,
    state_origin,
)
from dampyr.cli._report import report_options
from dampyr.errors import DampyrError, InputError, RigFault

if TYPE_CHECKING:
    from dampyr.campaigns import Plan
    from dampyr.campaigns.journal import JournalEntry
    from dampyr.rig.session import Rig

# exit codes: a wrong argument's, nothing has moved; a safety layer acted; something else ended it; 128 + SIGINT
REFUSED, TRIPPED, FAILED, INTERRUPTED = 2, 3, 4, 130
SAFETY = ("firmware", "interlock", "check")  # layers that stop a rig by themselves
FEW = 50  # rows of a table that are all printed; of more, only those that are not complete


@click.command(
    epilog=examples(
        "dampyr run campaign.toml --dry-run",
        "dampyr run campaign.toml --out lab/quick",
    )
)
@click.argument("campaign", type=click.Path(path_type=Path))
@click.option("--rig", type=click.Path(path_type=Path), help="A rig.toml.  [default: the original rig, simulated]")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Where the records go; a campaign goes on where it stopped.",
)
@click.option(
    "--again", multiple=True, metavar="TEST", help="Record a test of that name again, although it is complete."
)
@click.option("--dry-run", is_flag=True, help="Print the plan and what the rig cannot do; move nothing.")
@click.option("--seed", type=click.IntRange(0), help="Seed of the random order, in place of the campaign's.")
@report_options("Write a page of the plan.")
@in_process_option
@click.option("--real-time", is_flag=True, help="Simulate the rig at the pace of a real one.")
@click.option(
    "--fault",
    "faults",
    multiple=True,
    metavar="FAULT",
    help='Give a simulated rig a fault: "stalled-motor@60s for 2s".',
)
@click.option(
    "--chip",
    nargs=2,
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    metavar="PROGRAM ELF",
    help="Simulate the rig with the firmware's binary in simavr.",
)
@as_json_option
def command(
    campaign: Path,
    rig: Path | None,
    out: Path | None,
    again: tuple[str, ...],
    dry_run: bool,
    seed: int | None,
    report: Path | None,
    real_time: bool,
    faults: tuple[str, ...],
    chip: tuple[Path, Path] | None,
    as_json: bool,
) -> int | None:
    """Run CAMPAIGN, a TOML file, on a rig.

    The whole campaign is checked first: what the rig cannot do is refused with the largest value that it can, and nothing runs.
    While it runs: p pauses after the test under way and goes on, s or Ctrl-C stops in order, a aborts at once.
    Exit codes: 0 complete, 2 refused and nothing has moved, 3 a safety layer stopped the rig, 4 it failed otherwise,
    130 interrupted (143 by SIGTERM, 129 by SIGHUP).
    """
    from dampyr import campaigns

    plan = campaigns.plan(campaign, rig, seed=seed)
    if report:
        from dampyr.show.pages.result_page import write_page

        write_page(plan, report)
    if dry_run:
        print_json(plan.as_dict()) if as_json else print_result(plan)
    for refusal in plan.refusals:
        click.echo(f"dampyr: {refusal}", err=True)
    if plan.refusals:
        return REFUSED
    if not dry_run:
        if out is None:
            raise InputError(
                "--out is missing; give the folder where the records go, or --dry-run to see the plan only"
            )
        how = {"faults": faults, "real_time": real_time, "chip": chip}
        return _perform(plan, rig, out, again, as_json, how)
    return None


def _perform(
    plan: Plan, rig: Path | None, out: Path, again: tuple[str, ...], as_json: bool, how: dict[str, Any]
) -> int:
    """Run it, and say how it ended; the exit code."""
    from dampyr.campaigns import RunControl, perform
    from dampyr.campaigns.planned_tests import UNCHECKED
    from dampyr.cli._frame import say, with_notes
    from dampyr.cli._running import keys, shown, stopped_by_signals
    from dampyr.rig.connecting import open_rig

    control = RunControl()
    opened: Rig | None = None
    try:
        if plan.preliminary is None:
            say(f"warning: {UNCHECKED}")
        with stopped_by_signals(), open_rig(rig, **how) as opened, shown(plan) as show, keys(control):
            perform(plan, opened, out, show, control, again)
    except BaseException as problem:
        with suppress(DampyrError, OSError):  # what ended the campaign is told, and not that it cannot be listed
            _tell_outcome(plan, out, as_json)
        if isinstance(problem, DampyrError | OSError):
            say(with_notes(problem))
            return exit_code(problem, opened is not None and opened.was_armed)
        if isinstance(problem, SystemExit):
            say(f"ended by signal {int(problem.code or 0) - 128}; the rig is at rest")
        raise
    if opened.clock_held > 0.0:
        say(
            f"the simulated rig's clock was held back for {opened.clock_held:.2f} s in all, as this machine was too busy; "
            "in the rig's own time, by which the records go, nothing was late"
        )
    try:
        _tell_outcome(plan, out, as_json)
    except BrokenPipeError:  # whoever read has seen enough, and the campaign is complete
        drop_unwritten()
    return 0


def _tell_outcome(plan: Plan, out: Path, as_json: bool) -> None:
    from dampyr.campaigns import read_journal
    from dampyr.campaigns.journal import journal_origin
    from dampyr.campaigns.recorded_tests import entries_with_files

    if (out / "journal.sqlite").is_file():
        journal, events = read_journal(out)
        tests, origin = entries_with_files(journal, out), journal_origin(out)
        state_origin(origin)
        if as_json:
            print_json(
                {
                    "folder": str(out),
                    "origin": origin.as_dict(),
                    "tests": tests,
                    "events": events,
                    "fitted": _fitted(plan),
                }
            )
        elif tests:
            _summary(plan, out, tests)


def exit_code(problem: Exception, was_armed: bool) -> int:
    """How a run ended, for scripts; ``was_armed``: the rig has been armed, so that something may have moved."""
    from dampyr.campaigns import Stopped

    if isinstance(problem, Stopped) or (isinstance(problem, RigFault) and problem.ring == "operator"):
        return INTERRUPTED
    if not was_armed:
        return REFUSED
    return TRIPPED if isinstance(problem, RigFault) and problem.ring in SAFETY else FAILED


def _summary(plan: Plan, out: Path, tests: list[JournalEntry]) -> None:
    """What is there now."""
    words = {test.name: test.words for test in plan.tests}
    learned = {test.name for test in plan.tests if test.test.learn}
    rows = [[test.name, words.get(test.name, ""), test.state, test.attempt, test.reason] for test in tests]
    complete = sum(test.state == "complete" for test in tests)
    left = len(tests) - complete
    lost = [f"--again {test.name}" for test in tests if test.state in ("gone", "broken")]
    hint = f"dampyr identify {out}" if not left else " ".join(["run the same command again to go on", *lost])
    if lost and len(lost) == left:
        hint = f"run the same command with {' '.join(lost)}"
    print_table(
        f"{plan.campaign.header.name}: {complete} of {len(tests)} tests complete in {out}",
        ["test", "what", "state", "try", "reason"],
        [row for row in rows if row[2] != "complete" or row[0] in learned or len(rows) <= FEW]
        or [["all", "", "complete", None, ""]],
        notes=[*(f"{name}: {what}" for name, what in _fitted(plan).items()), f"next: {hint}"],
    )


def _fitted(plan: Plan) -> dict[str, str]:
    """The tests that were lowered to what the rig can do, and to what."""
    return {test.name: test.fitted for test in plan.tests if test.fitted}
