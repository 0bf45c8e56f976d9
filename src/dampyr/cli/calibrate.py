"""Calibrate: the load cell by a known load or a shunt, its amplifier by a step, the coil by steps of the voltage."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._examples import examples
from dampyr.cli._output import as_json_option, print_json, print_table
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.rig.calibration import Calibration


VALUES = [
    ("load cell's zero", "zero", "V"),
    ("load cell's scale", "scale", "N/V"),
    ("load cell's noise", "noise", "N rms"),
    ("amplifier's bandwidth", "bandwidth", "Hz"),
    ("supply's gain", "gain", "V/V"),
    ("coil's resistance at 20 degC", "resistance", "ohm"),
    ("coil's inductance", "inductance", "H"),
]


@click.command(epilog=examples("dampyr calibrate --rig rig.toml", "dampyr calibrate --rig rig.toml --coil --yes"))
@click.option("--rig", type=click.Path(path_type=Path), required=True, help="The rig.toml; the result lies beside it.")
@click.option("--load", metavar="FORCE", help='A known load, such as "20 kg" or "196.1 N".')
@click.option("--shunt", metavar="OHM", help='A resistor across one arm of the bridge, such as "100 kohm".')
@click.option(
    "--amplifier", is_flag=True, help="Measure its bandwidth, from a shunt that is switched in while the cell is read."
)
@click.option(
    "--coil",
    is_flag=True,
    help="Measure its resistance and inductance, and the supply's gain; needs wires.coil_current.",
)
@click.option(
    "--seconds", default=2.0, show_default=True, type=click.FloatRange(0.1, 60.0), help="Duration of a reading, s."
)
@click.option("--yes", is_flag=True, help="Do not wait for Enter before each reading.")
@as_json_option
def command(
    rig: Path,
    load: str | None,
    shunt: str | None,
    amplifier: bool,
    coil: bool,
    seconds: float,
    yes: bool,
    as_json: bool,
) -> None:
    """Calibrate load cell, amplifier and coil.

    The scale is found by a known load or a shunt; without --load and --shunt only the zero is found. Nothing moves, and without
    --coil the coil stays at 0 V; with it the rig is armed and the coil gets up to half of limits.voltage for three seconds.
    Each value comes with its standard uncertainty. The result is calibration.toml beside the rig.toml, and every campaign with
    that rig uses it.
    """
    from dampyr.rig.connecting import open_rig
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
        if amplifier:
            _wait("Be ready to switch a shunt in, a second after Enter, and leave it in for four seconds.", yes)
            steps.amplifier()
        if coil:
            _wait("Let the damper have the room's temperature; nothing moves, the coil gets a voltage.", yes)
            steps.coil()
        if steps.doubt and not yes and not click.confirm(f"{steps.doubt}. Save it all the same?", err=True):
            raise InputError("nothing is saved; calibrate again")
        path = steps.save(
            rig.parent, {"date": datetime.now(UTC).isoformat(timespec="seconds"), "load": load or shunt or ""}
        )
    if as_json:
        print_json({"file": str(path), "calibration": steps.calibration, "doubt": steps.doubt})
        return
    notes = [steps.calibration.how, *([steps.doubt] if steps.doubt else []), f"written: {path}"]
    print_table("Calibration", ["what", "value", "standard uncertainty", "unit"], _rows(steps.calibration), notes=notes)


def _rows(calibration: Calibration) -> list[list[Any]]:
    """What is calibrated, a row each."""
    values = [(name, getattr(calibration, field), field, unit) for name, field, unit in VALUES]
    return [
        [name, value, "" if field == "noise" else getattr(calibration, f"{field}_uncertainty"), unit]
        for name, value, field, unit in values
        if value is not None
    ]


def _wait(words: str, yes: bool) -> None:
    if not yes:
        click.prompt(f"{words} Then press Enter", default="", show_default=False, prompt_suffix=" ", err=True)
