"""Run: a campaign on a rig, checked before anything moves."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import replace
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
    from dampyr.campaigns import Campaign, Plan
    from dampyr.campaigns.journal import JournalEntry
    from dampyr.rig.session import Rig

# exit codes: a wrong argument's, nothing has moved; a safety layer acted; something else ended it; 128 + SIGINT
REFUSED, TRIPPED, FAILED, INTERRUPTED = 2, 3, 4, 130
SAFETY = ("firmware", "interlock", "check")  # layers that stop a rig by themselves
FOLDER_SIGNS = re.compile(r"[^\w.-]+")  # what a folder's name has not
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
@click.option(
    "--specimens",
    metavar="NAMES",
    help="Run it on several dampers in turn, such as SN1,SN2, each in a folder of its name in --out.",
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
    specimens: str | None,
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
    Exit codes: 0 complete, 2 refused and nothing has moved, 3 a safety layer stopped the rig, 4 it failed otherwise or its
    protocol has ended it, 130 interrupted (143 by SIGTERM, 129 by SIGHUP).
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
        if specimens is not None:
            return _perform_queue(plan, specimen_names(specimens), rig, out, again, as_json, how)
        return _perform(plan, rig, out, again, as_json, how)
    return None


def specimen_names(text: str) -> dict[str, str]:
    """The specimens of a list with commas, each with the name of its folder."""
    from dampyr.records.record import as_group

    names = {str(as_group("specimens", part)): FOLDER_SIGNS.sub("_", part.strip()) for part in text.split(",")}
    for name, folder in names.items():
        if list(names.values()).count(folder) > 1 or not folder.strip("."):
            raise InputError(f"specimens = {name!r} gives no folder of its own ({folder}); name it otherwise")
    if len(names) != text.count(",") + 1:
        raise InputError(f"specimens = {text!r} names one of them twice; name each once")
    return names


def _perform_queue(
    plan: Plan,
    names: dict[str, str],
    rig: Path | None,
    out: Path,
    again: tuple[str, ...],
    as_json: bool,
    how: dict[str, Any],
) -> int:
    """Run it on each specimen that is not complete; in between the rig is disarmed, and the operator mounts the next."""
    from dampyr.campaigns.run_folders import folder_state
    from dampyr.cli._frame import say

    for k, (name, folder) in enumerate(names.items(), 1):
        header = replace(plan.campaign.header, specimen=name)
        of_specimen = replace(plan, campaign=replace(plan.campaign, header=header))
        if not again and folder_state(of_specimen, out / folder)[0] == "complete":
            say(f"{name}: complete in {out / folder}")
            continue
        question = (
            f"Specimen {k} of {len(names)}: the rig is disarmed and the coil at 0 V. Mount {name}, then press Enter"
        )
        try:
            click.prompt(question, default="", show_default=False, prompt_suffix=" ", err=True)
        except click.Abort:
            say(f"{name} was not mounted; run the same command again to go on with it")
            return INTERRUPTED
        if code := _perform(of_specimen, rig, out / folder, again, as_json, how):
            return code
    return 0


def _perform(
    plan: Plan, rig: Path | None, out: Path, again: tuple[str, ...], as_json: bool, how: dict[str, Any]
) -> int:
    """Run it, and say how it ended; the exit code."""
    from dampyr.campaigns import RunControl, perform
    from dampyr.campaigns.planned_tests import UNCHECKED
    from dampyr.campaigns.run_control import EndedByProtocol
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
            _tell_outcome(plan, out, as_json, ended=isinstance(problem, EndedByProtocol))
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


def _tell_outcome(plan: Plan, out: Path, as_json: bool, ended: bool = False) -> None:
    """The journal, and what to do next; ``ended`` says that the protocol has come to its end."""
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
            _summary(plan, out, tests, ended)


def exit_code(problem: Exception, was_armed: bool) -> int:
    """How a run ended, for scripts; ``was_armed``: the rig has been armed, so that something may have moved."""
    from dampyr.campaigns import Stopped
    from dampyr.campaigns.run_control import EndedByProtocol

    if isinstance(problem, EndedByProtocol):
        return FAILED
    if isinstance(problem, Stopped) or (isinstance(problem, RigFault) and problem.ring == "operator"):
        return INTERRUPTED
    if not was_armed:
        return REFUSED
    return TRIPPED if isinstance(problem, RigFault) and problem.ring in SAFETY else FAILED


def _summary(plan: Plan, out: Path, tests: list[JournalEntry], ended: bool) -> None:
    """What is there now."""
    words = {test.name: test.words for test in plan.tests}
    learned = {test.name for test in plan.tests if test.test.learn}
    rows = [[test.name, words.get(test.name, ""), test.state, test.attempt, test.reason] for test in tests]
    complete = sum(test.state == "complete" for test in tests)
    left = len(tests) - complete
    lost = [f"--again {test.name}" for test in tests if test.state in ("gone", "broken")]
    hint = next_command(plan.campaign, out) if not left else " ".join(["run the same command again to go on", *lost])
    if lost and len(lost) == left:
        hint = f"run the same command with {' '.join(lost)}"
    if ended:
        hint = f"dampyr protocol {out}"
    print_table(
        f"{plan.campaign.header.name}: {complete} of {len(tests)} tests complete in {out}",
        ["test", "what", "state", "try", "reason"],
        [row for row in rows if row[2] != "complete" or row[0] in learned or len(rows) <= FEW]
        or [["all", "", "complete", None, ""]],
        notes=[*_unread(out, tests), *(f"{name}: {what}" for name, what in _fitted(plan).items()), f"next: {hint}"],
    )


def next_command(campaign: Campaign, out: Path) -> str:
    """What a campaign was run for: a damper, or the figures or the judgement of a protocol."""
    if campaign.protocol is None:
        return f"dampyr identify {out}"
    return f"dampyr protocol {out}" if hasattr(campaign.protocol, "figures") else f"dampyr judge {out} --criteria NAME"


def _unread(out: Path, tests: list[JournalEntry]) -> list[str]:
    """What the records say of the coil's voltage where nothing reads it: a dead supply is not seen then."""
    from dampyr.campaigns.record_test import UNREAD
    from dampyr.campaigns.recorded_tests import file_of
    from dampyr.records.formats import h5

    files = [file_of(out, test.name, test.attempt) for test in tests if test.state == "complete"]
    unread = sum(h5.provenance(path).get("voltage") == UNREAD for path in files if path.is_file())
    if not unread:
        return []
    which = "all" if unread == len(files) else f"{unread} of {len(files)}"
    return [
        f"the coil's voltage in {which} records is commanded, not measured: a dead supply is not seen; wire it, and name its "
        "input in wires.coil_voltage"
    ]


def _fitted(plan: Plan) -> dict[str, str]:
    """The tests that were lowered to what the rig can do, and to what."""
    return {test.name: test.fitted for test in plan.tests if test.fitted}
