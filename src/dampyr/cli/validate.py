"""Validate: how well a card predicts records."""

from __future__ import annotations

from pathlib import Path

import click

from dampyr.cli._output import as_json_option, print_json, print_table
from dampyr.cli._records import Reading, gather, reading_options


@click.command()
@click.argument("card", type=click.Path(path_type=Path))
@click.argument("paths", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--role", type=click.Choice(["fit", "validation", "all"]), default="all", help="Of a campaign folder.")
@click.option("--settling", default=2.0, show_default=True, help="s after the motion starts that are not scored.")
@reading_options
@click.option("--allow-extrapolation", is_flag=True, help="Also inputs that the card was not calibrated on.")
@as_json_option
def command(
    card: Path,
    paths: tuple[Path, ...],
    role: str,
    settling: float,
    reading: Reading,
    allow_extrapolation: bool,
    as_json: bool,
) -> None:
    """Score a card on records that it predicts.

    The card runs freely along each record of PATHS (files or campaign folders); only the offset is taken from the record.
    Records that the card was fitted on are marked.
    """
    from dampyr.identification import score
    from dampyr.models import Damper

    damper = Damper.load(card)
    records = gather(paths, None if role == "all" else role, reading)
    seen = {name.strip() for name in damper.provenance.get("records", "").split(",")}
    scores = {r.name: score(damper, r, settling, allow_extrapolation=allow_extrapolation) for r in records}
    if as_json:
        told = {name: s.as_dict() | {"fitted_on": name in seen} for name, s in scores.items()}
        print_json({"card": card, "scores": told})
        return
    rows = [
        [r.name, r.input_value, "yes" if r.name in seen else "no", 100 * s.l1, 100 * s.nrmse, s.r2, 100 * s.pointwise,
         100 * s.peak_force, 100 * s.energy, f"{s.window.start:.2f}–{s.window.end:.2f}"]
        for r, s in zip(records, scores.values(), strict=True)
    ]  # fmt: skip
    names = [
        "record",
        "input",
        "fitted on",
        "L1",
        "NRMSE",
        "R²",
        "pointwise",
        "peak force",
        "energy",
        "window",
    ]
    mean = sum(s.l1 for s in scores.values()) / len(scores)
    print_table(
        f"{card}: {damper.composition}",
        names,
        rows,
        ["", damper.input, "", "%", "%", "", "%", "%", "%", "s"],
        digits=3,
        notes=[f"mean L1 {100 * mean:.2f} % over {len(rows)} records"],
    )
