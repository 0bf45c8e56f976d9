"""Calibrate: the load cell's zero and scale, by a known load or a shunt."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import click

from dampyr.cli._output import as_json_option, print_json, print_table
from dampyr.errors import InputError


@click.command()
@click.option("--rig", type=click.Path(path_type=Path), required=True, help="The rig.toml; the result lies beside it.")
@click.option("--load", metavar="FORCE", help='A known load, such as "20 kg" or "196.1 N".')
@click.option("--shunt", metavar="OHM", help='A resistor across one arm of the bridge, such as "100 kohm".')
@click.option("--seconds", default=2.0, show_default=True, type=click.FloatRange(0.1, 60.0), help="Of each reading.")
@click.option("--yes", is_flag=True, help="Do not wait for Enter before each reading.")
@as_json_option
def command(rig: Path, load: str | None, shunt: str | None, seconds: float, yes: bool, as_json: bool) -> None:
    """Find the load cell's zero and scale.

    The scale is found by a known load or a shunt; without --load and --shunt only the zero is found. Nothing moves, the coil
    stays at 0 V. The result is calibration.toml beside the rig.toml, and every campaign with that rig uses it.
    """
    from dampyr.rig.connect import open_rig
    from dampyr.rig.load_cell_calibration import Calibrating

    if load and shunt:
        raise InputError("both --load and --shunt are given; give one of the two")
    with open_rig(rig) as opened:
        steps = Calibrating(opened, seconds)
        _wait("Take all load off the cell.", yes)
        steps.zero()
        if load:
            _wait(f"Load the cell with {load}.", yes)
            steps.loaded(load)
        if shunt:
            _wait(f"Switch the shunt of {shunt} in.", yes)
            steps.shunted(shunt)
        path = steps.save(
            rig.parent, {"date": datetime.now(UTC).isoformat(timespec="seconds"), "load": load or shunt or ""}
        )
    if as_json:
        print_json({"file": str(path), "calibration": steps.calibration, "doubt": steps.doubt})
        return
    rows = [
        ["zero", steps.calibration.zero, "V"],
        ["scale", steps.calibration.scale, "N/V"],
        ["noise", steps.noise, "N rms"],
    ]
    notes = [steps.calibration.how, *([steps.doubt] if steps.doubt else []), f"written: {path}"]
    print_table("Load cell", ["what", "value", "unit"], rows, notes=notes)


def _wait(words: str, yes: bool) -> None:
    if not yes:
        click.prompt(f"{words} Then press Enter", default="", show_default=False, prompt_suffix=" ", err=True)
