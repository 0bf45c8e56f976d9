"""Plan: the next tests, by what they are expected to tell; performed where asked for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._control import structure_of
from dampyr.cli._examples import examples
from dampyr.cli._motion import Ground, motion_options
from dampyr.cli._options import OptionsCommand
from dampyr.cli._output import as_json_option, in_process_option, print_answer
from dampyr.cli._progress import stages
from dampyr.cli._records import READING, gather
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.planning import Peak, PlanOptions
    from dampyr.records import ReadOptions


@click.command(
    cls=OptionsCommand,
    options={"options": "dampyr.planning:PlanOptions"} | READING,
    leave_out=("voltage", "dt"),
    first=1,
    epilog=examples(
        "dampyr plan --card damper.toml --rig rig.toml --tests 6 --out next.toml",
        "dampyr plan tests --model dahl --rig rig.toml --target dahl.rho=5% --out narrow.toml",
        "dampyr plan --card damper.toml --tests 3 --seconds 4 --perform --out lab/planned",
        "dampyr plan --card damper.toml --goal peak --voltage 1.98 --peak-target 2% --perform --out lab/peak",
    ),
)
@click.argument("records", nargs=-1, type=click.Path(path_type=Path))
@click.option("--card", type=click.Path(path_type=Path), help="The damper's card, in place of records.")
@click.option("--rig", type=click.Path(path_type=Path), help="A rig.toml.  [default: the original rig, simulated]")
@click.option(
    "--structure",
    metavar="FILE",
    help="For the goal peak: a structure's file or published name.  [default: raminelli_2020]",
)
@click.option(
    "--motion", type=click.Path(path_type=Path), help="For the goal peak: a ground motion's file.  [default: El Centro]"
)
@motion_options
@click.option("--voltage", type=float, help="For the goal peak: voltage at the coil in V, constant in the earthquake.")
@click.option(
    "--peak", "peak_of", default="drift", metavar="WHICH", help="drift, displacement or acceleration.  [default: drift]"
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="PATH",
    help="The campaign file to write; with --perform the folder.",
)
@click.option("--perform", is_flag=True, help="Run the tests round by round, and stop when the targets are reached.")
@click.option("--per-round", type=int, default=4, metavar="N", help="Number of tests in a round.  [default: 4]")
@in_process_option
@click.option(
    "--figure",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Draw the proposed tests, or what was achieved, as .png or .svg.",
)
@as_json_option
def command(
    records: tuple[Path, ...],
    card: Path | None,
    options: PlanOptions,
    rig: Path | None,
    structure: str | None,
    motion: Path | None,
    ground: Ground,
    voltage: float | None,
    peak_of: str,
    out: Path | None,
    perform: bool,
    per_round: int,
    figure: Path | None,
    reading: ReadOptions,
    as_json: bool,
) -> None:
    """Propose the next tests on a rig.

    They are those that narrow the intervals most, from RECORDS or from a card.

    What is proposed lies inside the rig's limits, checked with the damper's force, and is a campaign file that `dampyr run`
    performs. With --perform the tests are run in rounds until the targets are reached, or the tests or the time are used up;
    the same command goes on where it stopped.
    """
    from dampyr import planning
    from dampyr.input_kinds import NO_INPUT
    from dampyr.models import published

    if records and card:
        raise InputError(
            "records and --card are both given; a card stands in place of records, so leave one of them out"
        )
    evidence: Any = published.card_or_published(str(card), Path()) if card else None
    if records:
        evidence = gather(records, "fit", reading)
    has_input = (
        all(record.input != NO_INPUT for record in evidence) if records else evidence is None or evidence.has_input
    )
    options = replace(options, peak=_peak(options.goal, structure, motion, ground, voltage, peak_of, has_input))
    if perform:
        if out is None:
            raise InputError("--out is missing; give a folder for the rounds of tests")
        _perform(evidence, rig, out, options, per_round, figure, as_json)
        return
    if out is not None and out.exists():
        raise InputError(f"{out} is there already; give another --out, or remove it")
    with stages() as show:
        proposal = planning.propose(evidence, rig, options, show)
    if out is not None:
        proposal.save(out)
    if figure is not None:
        from dampyr.show.planning.proposal import envelope_figure

        _draw(proposal.origin.stamp(envelope_figure(proposal)), figure)
    print_answer(proposal, as_json)
    if not as_json:
        following = (
            f"dampyr run {out} --rig RIG --out DIR" if out else "give --out FILE, and dampyr run FILE performs it."
        )
        click.echo(f"\nNext: {following}")


def _peak(
    goal: str,
    structure: str | None,
    motion: Path | None,
    ground: Ground,
    voltage: float | None,
    peak_of: str,
    has_input: bool,
) -> Peak | None:
    """The peak that is planned for, where one is."""
    from dampyr.planning import Peak

    if goal != "peak":
        if structure is not None or motion is not None or voltage is not None:
            raise InputError(
                "--structure, --motion and --voltage are of --goal peak; give it too, or --at for a test's voltage"
            )
        return None
    if voltage is None and has_input:
        raise InputError("--goal peak needs the damper's --voltage in the earthquake, such as --voltage 1.98")
    return Peak(structure_of(structure), ground.motion(motion), voltage, peak_of)


def _perform(
    evidence: Any,
    rig: Path | None,
    out: Path,
    options: PlanOptions,
    per_round: int,
    figure: Path | None,
    as_json: bool,
) -> None:
    """Run the rounds, and say how it went."""
    from dampyr import planning
    from dampyr.cli._running import stopped_by_signals
    from dampyr.rig.connecting import open_rig

    with stages() as show, stopped_by_signals(), open_rig(rig) as opened:

        def watch(state: Any) -> None:
            show(f"testing, {state.name}" if state.total > 1 else "testing", state.fraction)

        planned = planning.plan_and_perform(
            evidence, opened, out, options, per_round=per_round, progress=show, watcher=watch
        )
    if planned.fit.damper is not None:
        planned.fit.damper.save(out / "damper.toml")
    if figure is not None:
        from dampyr.show.planning.planner import widths_figure

        _draw(planned.origin.stamp(widths_figure(planned)), figure)
    print_answer(planned, as_json)
    if planned.fit.damper is not None and not as_json:
        click.echo(f"\nThe damper's card: {out / 'damper.toml'}")


def _draw(picture: Any, path: Path) -> None:
    if path.suffix not in (".png", ".svg", ".pdf"):
        raise InputError(f"--figure {path}: the ending {path.suffix!r} is not drawn; give .png, .svg or .pdf")
    try:
        picture.savefig(path, dpi=150)
    except OSError as problem:
        raise InputError(f"{path} cannot be written ({problem.strerror}); choose another --figure") from None
