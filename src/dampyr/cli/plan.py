"""Plan: the next tests, by what they are expected to tell; performed where asked for."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._control import structure_of
from dampyr.cli._examples import examples
from dampyr.cli._motion import Ground, motion_options
from dampyr.cli._options import OptionsCommand
from dampyr.cli._output import as_json_option, in_process_option, print_json, print_result, state_origin
from dampyr.cli._progress import stages
from dampyr.cli._records import READING, gather
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.planning import Peak, PlanOptions
    from dampyr.records import ReadOptions


@click.command(
    cls=OptionsCommand,
    options=READING,
    leave_out=("voltage", "dt"),
    first=26,
    epilog=examples(
        "dampyr plan --card damper.toml --rig rig.toml --tests 6 --out next.toml",
        "dampyr plan tests --model dahl --rig rig.toml --target dahl.rho=5% --out narrow.toml",
        "dampyr plan --card damper.toml --tests 3 --seconds 4 --perform --out lab/planned",
        "dampyr plan --card damper.toml --goal peak --voltage 1.98 --peak-target 2% --perform --out lab/peak",
    ),
)
@click.argument("records", nargs=-1, type=click.Path(path_type=Path))
@click.option("--card", type=click.Path(path_type=Path), help="What is known of the damper, in place of records.")
@click.option("--model", metavar="NAME", help="What is fitted, such as dahl; records need it.")
@click.option("--law", "laws", multiple=True, metavar="NAME=LAW", help="As of identify, such as dahl.rho=constant.")
@click.option("--bandwidth", type=float, metavar="HZ", help="Of the velocity, derived from the displacement.")
@click.option("--rig", type=click.Path(path_type=Path), help="A rig.toml.  [default: the original rig, simulated]")
@click.option("--tests", type=int, metavar="N", help="How many at most.  [default: 6; with --perform 12]")
@click.option("--duration", metavar="TIME", help="How long the tests may take together, such as '10 min'.")
@click.option(
    "--target",
    "targets",
    multiple=True,
    metavar="NAME=SHARE",
    help="Half width of a 95 % interval, such as dahl.rho=5%; may be repeated.",
)
@click.option(
    "--goal",
    default="parameters",
    metavar="GOAL",
    help="parameters, or the peak of a structure.  [default: parameters]",
)
@click.option(
    "--structure",
    metavar="FILE",
    help="Of the goal peak: a structure's file or published name.  [default: raminelli_2020]",
)
@click.option(
    "--motion", type=click.Path(path_type=Path), help="Of the goal peak: a ground motion's file.  [default: El Centro]"
)
@motion_options
@click.option("--voltage", type=float, help="Of the goal peak: V at the coil, constant in the earthquake.")
@click.option(
    "--peak", "peak_of", default="drift", metavar="WHICH", help="drift, displacement or acceleration.  [default: drift]"
)
@click.option("--peak-target", metavar="SHARE", help="Half width of the peak's 95 % interval, such as 2%.")
@click.option("--at", "voltages", multiple=True, type=float, metavar="V", help="A voltage to test at; may be repeated.")
@click.option("--seconds", type=float, default=20.0, metavar="S", help="Of steady motion in each test.  [default: 20]")
@click.option("--kind", "kinds", multiple=True, metavar="KIND", help="Kinds of step to choose from; may be repeated.")
@click.option(
    "--out", type=click.Path(path_type=Path), metavar="PATH", help="A campaign file; with --perform a folder."
)
@click.option("--perform", is_flag=True, help="Run the tests round by round, and stop when it is known well enough.")
@click.option("--mixed-origins", is_flag=True, help="Fit simulated or virtual records together with others.")
@click.option("--per-round", type=int, default=4, metavar="N", help="Tests before the next look at them.  [default: 4]")
@in_process_option
@click.option(
    "--figure",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Draw it as .png or .svg: the tests, or how it went.",
)
@as_json_option
def command(
    records: tuple[Path, ...],
    card: Path | None,
    model: str | None,
    laws: tuple[str, ...],
    bandwidth: float | None,
    rig: Path | None,
    tests: int | None,
    duration: str | None,
    targets: tuple[str, ...],
    goal: str,
    structure: str | None,
    motion: Path | None,
    ground: Ground,
    voltage: float | None,
    peak_of: str,
    peak_target: str | None,
    voltages: tuple[float, ...],
    seconds: float,
    kinds: tuple[str, ...],
    out: Path | None,
    perform: bool,
    mixed_origins: bool,
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
    from dampyr.models import published
    from dampyr.units import parse

    if records and card:
        raise InputError(
            "records and --card are both given; a card stands in place of records, so leave one of them out"
        )
    evidence: Any = published.card_or_published(str(card), Path()) if card else None
    options = planning.PlanOptions(
        model=model,
        laws=_pairs(laws),
        bandwidth=bandwidth,
        tests=tests,
        duration=None if duration is None else parse(duration, "s"),
        targets={name: share(text, f"the target of {name}") for name, text in (_pairs(targets) or {}).items()},
        goal=goal,
        peak=_peak(goal, structure, motion, ground, voltage, peak_of),
        peak_target=None if peak_target is None else share(peak_target, "the peak's target"),
        voltages=voltages or None,
        kinds=kinds or planning.PlanOptions.kinds,
        seconds=seconds,
        mixed_origins=mixed_origins,
    )
    if records:
        evidence = gather(records, "fit", reading)
    if perform and out is None:
        raise InputError("--out is missing; give a folder for the rounds of tests")
    if perform:
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
    state_origin(proposal.origin)
    if as_json:
        print_json(proposal.as_dict())
    else:
        print_result(proposal)
        click.echo(f"\n{_next(out)}")


def share(text: str, what: str) -> float:
    """A share of 1, written as ``5%``, ``5 %`` or ``0.05``."""
    bare = text.strip()
    try:
        return float(bare.removesuffix("%")) / (100.0 if bare.endswith("%") else 1.0)
    except ValueError:
        raise InputError(f"{what} is {text!r}; write it as in 5% or 0.05") from None


def _peak(
    goal: str, structure: str | None, motion: Path | None, ground: Ground, voltage: float | None, peak_of: str
) -> Peak | None:
    """The peak that is planned for, where one is."""
    from dampyr.planning import Peak

    if goal != "peak":
        if structure is not None or motion is not None or voltage is not None:
            raise InputError(
                "--structure, --motion and --voltage are of --goal peak; give it too, or --at for a test's voltage"
            )
        return None
    if voltage is None:
        raise InputError("--goal peak needs the damper's --voltage in the earthquake, such as --voltage 1.98")
    return Peak(structure_of(structure), ground.motion(motion), voltage, peak_of)


def _perform(
    evidence: Any,
    rig: Path | None,
    out: Path | None,
    options: PlanOptions,
    per_round: int,
    figure: Path | None,
    as_json: bool,
) -> None:
    """Run the rounds, and say how it went."""
    from dampyr import planning
    from dampyr.cli._running import stopped_by_signals
    from dampyr.rig.connecting import open_rig

    assert out is not None
    with stages() as show, stopped_by_signals(), open_rig(rig) as opened:

        def watch(now: Any) -> None:
            show(f"testing, {now.name}" if now.total > 1 else "testing", now.fraction)

        planned = planning.plan_and_perform(
            evidence, opened, out, options, per_round=per_round, progress=show, watcher=watch
        )
    if planned.fit.damper is not None:
        planned.fit.damper.save(out / "damper.toml")
    if figure is not None:
        from dampyr.show.planning.planner import widths_figure

        _draw(planned.origin.stamp(widths_figure(planned)), figure)
    state_origin(planned.origin)
    if as_json:
        print_json(planned.as_dict())
    else:
        print_result(planned)
        if planned.fit.damper is not None:
            click.echo(f"\nThe damper's card: {out / 'damper.toml'}")


def _draw(drawn: Any, path: Path) -> None:
    if path.suffix not in (".png", ".svg", ".pdf"):
        raise InputError(f"--figure {path}: the ending {path.suffix!r} is not drawn; give .png, .svg or .pdf")
    try:
        drawn.savefig(path, dpi=150)
    except OSError as problem:
        raise InputError(f"{path} cannot be written ({problem.strerror}); choose another --figure") from None


def _next(out: Path | None) -> str:
    return (
        f"Next: dampyr run {out} --rig RIG --out DIR"
        if out
        else "Next: give --out FILE, and dampyr run FILE performs it."
    )


def _pairs(given: tuple[str, ...]) -> dict[str, str] | None:
    """``NAME=VALUE`` options as a dictionary."""
    for pair in given:
        if "=" not in pair:
            raise InputError(f"{pair!r} has no '='; write it as in dahl.rho=5%")
    return dict(pair.split("=", 1) for pair in given) or None
