"""Hybrid: a building in the computer and its damper on the rig."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._examples import examples
from dampyr.cli._options import refuse_typed
from dampyr.cli._output import (
    as_json_option,
    findings_below,
    in_process_option,
    print_answer,
    print_json,
    print_table,
)
from dampyr.cli._report import report_options
from dampyr.cli.run import REFUSED, exit_code
from dampyr.errors import DampyrError, InputError

if TYPE_CHECKING:
    from dampyr.campaigns import Plan
    from dampyr.hybrid.hybrid_result import HybridResult


@click.command(
    epilog=examples(
        "dampyr hybrid --scale 0.5 --dry-run",
        "dampyr hybrid --delay 0.01 --voltage 1.98 --report hybrid.html",
        "dampyr hybrid --control clipped_optimal:period=4ms,high=1.5 --dry-run",
    )
)
@click.option(
    "--structure", default="heavy_two_storey", show_default=True, help="A structure's TOML file, or two_storey."
)
@click.option("--motion", default="el_centro", show_default=True, help="A ground motion file, or el_centro.")
@click.option(
    "--scale", type=float, default=1.0, show_default=True, help="Factor on the ground motion, before it is lowered."
)
@click.option(
    "--storey",
    type=int,
    default=1,
    show_default=True,
    help="The storey in which the damper stands; i joins floors i-1 and i.",
)
@click.option("--voltage", type=float, default=0.0, show_default=True, help="Voltage at the coil in V.")
@click.option("--clock", type=float, default=1.0, show_default=True, help="How much slower the building's time passes.")
@click.option(
    "--duration", type=float, default=0.0, metavar="S", help="Duration of the test in s; 0: the whole motion."
)
@click.option("--model", default="", metavar="CARD", help="The card that predicts the force.  [default: the rig's]")
@click.option("--rig", type=click.Path(path_type=Path), help="A rig.toml.  [default: the original rig, simulated]")
@click.option(
    "--out", type=click.Path(path_type=Path), metavar="DIR", help="The folder for the record and its journal."
)
@click.option(
    "--delay", type=float, metavar="S", help="Use no rig: an actuator with this delay moves the card's model."
)
@click.option("--control", metavar="LAW", help="A law that sets the input, such as on_off:period=4ms,high=2.")
@click.option("--lag-error", type=float, default=0.0, metavar="S", help="With --delay: the error of the assumed delay.")
@click.option(
    "--record",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Tell the result of a test that was recorded; nothing is run.",
)
@click.option("--dry-run", is_flag=True, help="Print what would be done and what is in the way; move nothing.")
@report_options()
@in_process_option
@click.option("--real-time", is_flag=True, help="Simulate the rig at the pace of a real one.")
@as_json_option
def command(
    structure: str,
    motion: str,
    scale: float,
    storey: int,
    voltage: float,
    clock: float,
    duration: float,
    model: str,
    rig: Path | None,
    out: Path | None,
    delay: float | None,
    control: str | None,
    lag_error: float,
    record: Path | None,
    dry_run: bool,
    report: Path | None,
    real_time: bool,
    as_json: bool,
) -> int | None:
    """Test a damper in a building that is computed.

    The building is in an earthquake: each step's displacement goes to the table, the measured force comes back. The record is
    scaled to what the rig can do, or the building's time passes slower (--clock). What would be unstable is refused before
    anything moves. The result stands beside the same building with the damper's model in its place. Exit codes: as dampyr run.
    """
    from dampyr import campaigns

    table = {
        "kind": "hybrid", "structure": structure, "motion": motion, "scale": scale, "storey": storey, "voltage": voltage,
        "clock": clock, "duration": duration, "model": model, "control": control or "",
    }  # fmt: skip
    if record is not None:
        refuse_typed(OF_A_TEST, "is of a test that is run, and --record tells of one that was; leave it out")
        with findings_below():
            result = campaigns.hybrid_result(record)
        _tell(result, report, as_json)
        return None
    if delay is not None:
        refuse_typed(
            OF_A_RIG, "is of a rig, and --delay computes the actuator too, in the building's own time; leave it out"
        )
        with findings_below():
            result = _on_delayed_actuator(structure, motion, model, table, delay, lag_error, control)
        _tell(result, report, as_json)
        return None
    if lag_error:
        raise InputError("--lag-error is of --delay; leave it out")
    if out is None and not dry_run:
        raise InputError("--out is missing; give the folder where the record goes, or --dry-run to see the plan only")
    plan = campaigns.planned_hybrid(table, rig)
    test = plan.tests[0]
    if dry_run or plan.refusals:
        _tell_plan(plan, as_json)
    if plan.refusals:
        for refusal in plan.refusals:
            click.echo(f"dampyr: {refusal}", err=True)
        return REFUSED
    if dry_run or out is None:
        return None
    code = _perform(plan, rig, out, {"real_time": real_time})
    if code:
        return code
    with findings_below():
        result = campaigns.hybrid_result(out / f"{test.name}.h5")
    _tell(result, report, as_json)
    return None


OF_A_RIG = ("rig", "out", "clock", "dry_run", "real_time")
OF_A_TEST = (
    *OF_A_RIG,
    "structure",
    "motion",
    "scale",
    "storey",
    "voltage",
    "duration",
    "model",
    "delay",
    "control",
    "lag_error",
)


def _on_delayed_actuator(
    structure: str, motion: str, model: str, table: dict[str, Any], delay: float, lag_error: float, control: str | None
) -> HybridResult:
    """The test with an actuator that is computed too; without a card with the damper of Raminelli (2020)."""
    from dampyr import studies
    from dampyr.campaigns.steps.hybrid import Hybrid, building_of, motion_of
    from dampyr.hybrid.delayed_hybrid import delayed_result
    from dampyr.structures.control_laws import law_of

    damper = studies.load_damper(model or studies.THESIS)
    value: Any = table["voltage"]
    if control is not None:
        if value:
            raise InputError("--voltage and --control both set the input; give one of the two")
        value = law_of(control, damper)
    named = {"structure": structure, "motion": motion, "scale": table["scale"], "duration": table["duration"]}
    ground = motion_of(Hybrid(**named))
    return replace(
        delayed_result(building_of(structure), ground, damper, delay, value, table["storey"], lag_error),
        scale=table["scale"],
    )


def _perform(plan: Plan, rig: Path | None, out: Path, how: dict[str, Any]) -> int:
    from dampyr.campaigns import RunControl, perform
    from dampyr.cli._frame import say, with_notes
    from dampyr.cli._running import keys, shown, stopped_by_signals
    from dampyr.rig.connecting import open_rig

    for note in plan.tests[0].notes:
        say(note)
    control, opened = RunControl(), None
    try:
        with stopped_by_signals(), open_rig(rig, **how) as opened, shown(plan) as show, keys(control):
            perform(plan, opened, out, show, control)
    except (DampyrError, OSError) as problem:
        say(with_notes(problem))
        return exit_code(problem, opened is not None and opened.was_armed)
    return 0


def _tell_plan(plan: Plan, as_json: bool) -> None:
    test = plan.tests[0]
    figures = {
        "test": test.words, "scale": test.step.scale, "duration_s": test.duration, "peak_position_m": test.peak_position,
        "peak_speed_m_per_s": test.peak_speed, "peak_force_N": test.peak_force, "notes": list(test.notes),
        "refusal": test.refusal,
    }  # fmt: skip
    if as_json:
        print_json(figures)
        return
    print_table(
        f"Hybrid test of {test.step.title}, as planned",
        ["scale", "duration", "position", "speed", "force"],
        [[test.step.scale, test.duration, 1e3 * test.peak_position, 1e3 * test.peak_speed, test.peak_force]],
        ["", "s", "mm", "mm/s", "N"],
        digits=4,
        notes=list(test.notes),
    )


def _tell(result: HybridResult, report: Path | None, as_json: bool) -> None:
    if report:
        from dampyr.show.pages.result_page import write_page

        write_page(result, report)
    print_answer(result, as_json)
