"""What a caller states of files of records, which the files do not state themselves; the same for all of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from dampyr.channel_columns import TextOptions
from dampyr.errors import InputError
from dampyr.input_kinds import INPUTS
from dampyr.options import Terminal
from dampyr.records.conditioning.cut_record import check_cut
from dampyr.records.conditioning.lowpass import as_lowpass
from dampyr.records.conditioning.moving_average import Declaration
from dampyr.records.conditioning.nominal_input import agrees
from dampyr.records.conditioning.repair_step import GAPS, as_repairs
from dampyr.records.record import CHANNELS, GROUPS, as_group
from dampyr.records.record_thresholds import RecordThresholds
from dampyr.units import Quantity


@dataclass(frozen=True)
class ReadOptions(TextOptions):
    """Options of `read` and `read_campaign`; ``cut``, which makes several records of one, is of `read_campaign` alone.

    ``thresholds`` say from when on what a record shows is a finding; they are an argument of the call alone.

    ``smoothed`` is kept as a `dampyr.records.Declaration`, ``lowpass`` in Hz or as a text such as ``"15 f"``.
    """

    CHANNELS: ClassVar[Mapping[str, str]] = CHANNELS

    voltage: Annotated[
        float | None,
        Quantity("V"),
        "Voltage at the coil, for all files; a measured column that agrees, to 5 % or 0.05 V, gives way to it",
    ] = None
    current: Annotated[
        float | None,
        Quantity("A"),
        "Current, in place of a voltage; a measured column that agrees, to 5 % or 0.05 A, gives way to it",
    ] = None
    no_input: Annotated[
        bool,
        "The damper has no voltage and no current, as one of friction, oil or rubber; a measured column that is 0, to 0.05 V "
        "or A, gives way to it",
    ] = False
    dt: Annotated[
        float | None,
        Quantity("s", low=0, open_low=True),
        Terminal(metavar="TIME"),
        "Sampling interval of files without a time, or with stamps that are coarser than it, such as 2ms",
    ] = None
    variable: Annotated[
        str | None,
        Terminal(metavar="NAME"),
        "Matrix of a MATLAB file, of which the columns are given by number, or structure of one; sheet of an Excel file; group "
        "of a TDMS file; dimension of a NetCDF file; block of an MTS file, by number",
    ] = None
    repair: Annotated[
        str | None,
        Terminal(metavar="KINDS"),
        "Samples to repair, with commas between: false-samples, gaps (rows with an empty cell are gaps, too), force-drift, "
        "position-drift; none undoes the repairs that an .h5 file holds",
    ] = None
    force_sign: Annotated[
        int | None,
        Terminal(metavar="SIGN"),
        "-1 turns the force, for files in which a positive force does not oppose a positive velocity",
    ] = None
    force_delay: Annotated[
        float | None,
        Quantity("s"),
        Terminal(metavar="TIME"),
        "How much later the force was sampled than the displacement, such as 10ms; the motion is moved to meet it",
    ] = None
    measurement_session: Annotated[
        str | None, Terminal(metavar="NAME"), "The records of one day on one mounting, for all files"
    ] = None
    specimen: Annotated[str | None, Terminal(metavar="NAME"), "Which damper it is, for all files"] = None
    smoothed: Annotated[
        str | float | Declaration | None,
        Terminal(metavar="WINDOW"),
        "Moving average that the channels went through, which is undone where it can be: '0.3 s', '15 samples' or "
        "'0.1 periods', and after a comma trailing, not undone, or channels such as force",
    ] = None
    lowpass: Annotated[
        str | float | None,
        Terminal(metavar="HZ"),
        "Frequency above which the displacement is noise, in Hz; '15 f' is 15 times that of the motion",
    ] = None
    cut: Annotated[
        str | float | None,
        Terminal(metavar="TIME|events"),
        "Cut every record into pieces of this duration, such as 5s, or at the rests between events",
    ] = None

    thresholds: RecordThresholds | None = None

    def __post_init__(self) -> None:
        for name in GROUPS:
            object.__setattr__(self, name, as_group(name, getattr(self, name)))
        if self.smoothed is not None:
            object.__setattr__(self, "smoothed", Declaration.of(self.smoothed))
        if self.lowpass is not None:
            object.__setattr__(self, "lowpass", as_lowpass(self.lowpass))
        super().__post_init__()

    def check(self) -> None:
        """Refuse unknown channels, an empty name, and a sign or a duration that is not one."""
        super().check()
        for name in INPUTS.values():
            if self.no_input and (value := getattr(self, name)) is not None:
                raise InputError(
                    f"{name} = {value:g} {CHANNELS[name]} and no_input are both given; leave one of them out: --no-input "
                    "or no_input=True is for a damper that has no input"
                )
        if self.variable is not None and not self.variable.strip():
            raise InputError(f"variable = {self.variable!r} is not a name; give that of a matrix in the file")
        if self.force_sign not in (None, -1, 1):
            raise InputError(
                f"force_sign = {self.force_sign} is not allowed; it must be -1, which turns the force, or 1"
            )
        if self.repair is not None:
            as_repairs(self.repair)
        if self.cut is not None:
            check_cut(self.cut)
        if self.thresholds is not None and not isinstance(self.thresholds, RecordThresholds):
            raise InputError(f"thresholds = {self.thresholds!r} are not allowed; give RecordThresholds(...)")

    @property
    def fills_gaps(self) -> bool:
        """Whether samples that are missing are put in, so that a row without one of its values may be left out."""
        return self.repair is not None and GAPS in as_repairs(self.repair)

    def input_channels(self, voltage: Any = None, current: Any = None, no_input: bool = False) -> dict[str, Any]:
        """The input of the record, from that of the call and that of the file (``voltage``, ``current``, ``no_input``).

        A number in the file must equal the one of the call; a measured channel must agree with it, and gives way to it. No
        input, by the call, agrees with a channel or a number that is 0 within what a measured one may be off by.
        """
        if self.no_input or no_input:
            for name, stored in (("voltage", voltage), ("current", current)):
                if stored is not None and not agrees(0.0, stored):
                    raise InputError(_not_without(name, stored))
                if (stated := getattr(self, name)) is not None:
                    raise InputError(
                        f"{name} = {stated:g} {CHANNELS[name]} was given, but the file says that the damper has no input; "
                        f"leave {name} out of the call"
                    )
            return {"voltage": None, "current": None, "no_input": True}
        channels: dict[str, Any] = {"no_input": False}
        for name, stated, stored in (("voltage", self.voltage, voltage), ("current", self.current, current)):
            if (
                stated is not None
                and stored is not None
                and not np.array_equal(stated, stored)
                and (np.ndim(stored) != 1 or not agrees(stated, stored))
            ):
                raise InputError(_contradiction(name, stated, stored))
            channels[name] = stated if stated is not None else stored
        return channels

    def replaced(self, voltage: Any = None, current: Any = None) -> tuple[str, ...]:
        """What the history says of a measured input that gave way to the one of the call."""
        if self.no_input:
            return ("no input as stated",) if voltage is not None or current is not None else ()
        pairs = (("voltage", self.voltage, voltage), ("current", self.current, current))
        return tuple(
            f"{name} {stated:g} {CHANNELS[name]} as stated; {np.mean(stored):.4g} {CHANNELS[name]} as measured"
            for name, stated, stored in pairs
            if stated is not None and stored is not None and not np.array_equal(stated, stored)
        )


def _not_without(name: str, stored: Any) -> str:
    return (
        f"no_input was given, but the file's {name} has {np.min(stored):.4g} to {np.max(stored):.4g} {CHANNELS[name]}; leave "
        f"no_input out, or, where that is no input of the damper, leave the column out: --column {name}=- or "
        f"columns={{{name!r}: None}}"
    )


def _contradiction(name: str, stated: float, stored: Any) -> str:
    unit = CHANNELS[name]
    if np.ndim(stored) == 0:
        in_file = f"{np.mean(stored):g} {unit}"
        return f"{name} = {stated:g} {unit} was given, but the file says {in_file}; leave {name} out of the call"
    return (
        f"{name} = {stated:g} {unit} was given, but the file's column has {np.min(stored):.4g} to "
        f"{np.max(stored):.4g} {unit} (mean {np.mean(stored):.4g}), which is further from it than 5 % or 0.05 {unit}; "
        f"leave {name} out of the call"
    )
