"""Validate: how well a card predicts records."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._examples import examples
from dampyr.cli._motion import ratio
from dampyr.cli._output import as_json_option, print_json, print_table, state_origin
from dampyr.cli._records import Reading, gather, reading_options, role_option
from dampyr.cli._report import report_options

if TYPE_CHECKING:
    from dampyr.identification import Validated

NAMES = ["record", "input", "fitted on", "L1", "NRMSE", "R²", "pointwise", "peak force", "energy", "window"]
FITTED = {True: "yes", False: "no", None: "unknown"}


@click.command(
    epilog=examples(
        "dampyr validate damper.toml tests --role validation", "dampyr validate damper.toml tests --forces forces"
    )
)
@click.argument("card", type=click.Path(path_type=Path))
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path))
@role_option()
@click.option("--settling", default=2.0, show_default=True, help="s after the motion starts that are not scored.")
@click.option(
    "--band",
    default="90%",
    show_default=True,
    metavar="SHARE",
    help="How much of each record its predictive band is to hold; none for no bands.",
)
@click.option(
    "--session-prior",
    metavar="SHARE",
    help="How much the force differs from one measurement session to another, in the place of what the card states.",
)
@click.option(
    "--forces", type=click.Path(path_type=Path), metavar="DIR", help="Write measured and predicted forces as CSV."
)
@report_options()
@reading_options
@click.option("--allow-extrapolation", is_flag=True, help="Also inputs that the card was not calibrated on.")
@as_json_option
def command(
    card: Path,
    paths: tuple[Path, ...],
    role: str | None,
    settling: float,
    band: str,
    session_prior: str | None,
    forces: Path | None,
    report: Path | None,
    reading: Reading,
    allow_extrapolation: bool,
    as_json: bool,
) -> None:
    """Score a card on records that it predicts.

    CARD is a damper's card, or the name of a published damper. It runs freely along each record of PATHS (files or folders of
    them); only the offset is taken from the record. Records that the card was fitted on are marked. --forces writes NAME.csv
    for each record, with its time, displacement, measured force and predicted force; files that this command wrote before are
    replaced, others never.
    """
    from dampyr.identification import ValidateOptions, validate
    from dampyr.studies import load_damper

    share = None if band == "none" else ratio(band, "band")
    prior = None if session_prior is None else ratio(session_prior, "session-prior")
    options = ValidateOptions(settling, allow_extrapolation, share, prior)
    damper = load_damper(card)
    records = gather(paths, role, reading, reference_inputs=damper.range, warn=False)
    result = validate(damper, records, options, card=str(card))
    written = result.write_forces(forces) if forces else []
    if report:
        from dampyr.report import write_validate_page

        write_validate_page(result, report)
    state_origin(result.origin)
    if as_json:
        print_json(result.as_dict() | {"forces": written})
        return
    _print(result)
    if written:
        click.echo(f"forces: {_count(len(written), 'file')} in {forces}")
    if report:
        click.echo(f"page: {report}")


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _print(result: Validated) -> None:
    rows, fitted_on = [], result.fitted_on
    for r in result.records:
        s = result.scores[r.name]
        energy = None if math.isnan(s.energy) else 100 * s.energy
        window = f"{s.window.start:.2f}–{s.window.end:.2f}"
        errors = [100 * s.l1, 100 * s.nrmse, s.r2, 100 * s.pointwise, 100 * s.peak_force, energy]
        rows.append([r.name, r.input_value, FITTED[fitted_on[r.name]], *errors, window])
    mean = sum(s.l1 for s in result.scores.values()) / len(result.scores)
    notes = [f"mean L1 {100 * mean:.2f} % over {_count(len(rows), 'record')}"]
    if any(row[8] is None for row in rows):
        notes.append("energy –: no whole cycle in the window, so it is not scored")
    unit = result.damper.input
    title = f"{result.card}: {result.damper.composition}"
    print_table(
        title,
        NAMES,
        rows,
        ["", unit, "", "%", "%", "", "%", "%", "%", "s"],
        digits=3,
        notes=notes,
        findings=result.findings,
    )
    click.echo()
    _print_bands(result)
    groups = [[g["input"], g["records"], 100 * g["mean_l1"], 100 * g["worst_l1"]] for g in result.by_input]
    if len(groups) > 1:
        click.echo()
        print_table("By input", ["input", "records", "mean L1", "worst L1"], groups, [unit, "", "%", "%"], digits=3)


def _print_bands(result: Validated) -> None:
    """The level of each record, its L1 with that, and how much its band holds of the force, the peak and the energy."""
    from dampyr.identification.scoring.validate import bands_in_words

    rows = []
    for r in result.records:
        s, band = result.scores[r.name], result.bands.get(r.name)
        row: list[Any] = [r.name, s.level, 100 * s.l1, 100 * s.relevelled_l1]
        if band is not None:
            peak, energy = band.peak, band.energy
            row += [100 * band.holds, 100 * band.width, peak.measured, f"{peak.low:.4g} to {peak.high:.4g}"]
            row += [None, None] if energy is None else [energy.measured, f"{energy.low:.3g} to {energy.high:.3g}"]
        rows.append(row)
    names, units = ["record", "level", "L1", "relevelled"], ["", "", "%", "%"]
    notes = [
        "level: the factor that the first cycles put on the predicted force; relevelled: the L1 of the rest with it"
    ]
    if result.bands:
        share = f"{100 * next(iter(result.bands.values())).level:g} % band"
        names += [f"{share} holds", "width ±", "peak", "expected", "energy", "expected"]
        units += ["%", "%", "N", "N", "J", "J"]
        sessions = sorted({one.session for one in result.bands.values() if one.session is not None})
        of_fitted = f"; those of {', '.join(sessions)} have the level of that session" if sessions else ""
        notes.append(f"records count as of a new measurement session{of_fitted}; width: of the mean force")
        error = result.damper.prediction_error
        if error is not None:
            other = "" if error.session_estimated else "; --session-prior SHARE gives them at another"
            notes += [error.session_source, f"{bands_in_words(result.bands)}{other}"]
    elif result.no_band:
        notes.append(result.no_band)
    print_table("Level of each record, and predictive bands", names, rows, units, digits=3, notes=notes)
