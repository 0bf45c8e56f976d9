"""Records named on the command line: files, or folders of them."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.errors import DampyrWarning, InputError

if TYPE_CHECKING:
    from dampyr.records import Record


@dataclass(frozen=True)
class Reading:
    """Metadata that the command line gives for files without it, by the arguments of `records.read`; and how to cut them."""

    said: dict[str, Any]
    cut: str | None = None


def role_option(what: str = "Of a folder.") -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """``--role``, which comes as ``role``: None takes all."""
    chosen = click.Choice(["fit", "validation", "all"])
    return click.option("--role", type=chosen, default="all", callback=lambda *given: _role(given[-1]), help=what)


def _role(chosen: str) -> str | None:
    return None if chosen == "all" else chosen


OPTIONS = (
    click.option("--voltage", type=float, help="V at the coil, for all files; a measured column gives way to it."),
    click.option("--current", type=float, help="A, for all files; a measured column gives way to it."),
    click.option("--unit", "units", multiple=True, metavar="CHANNEL=UNIT", help="Such as displacement=mm."),
    click.option(
        "--column",
        "columns",
        multiple=True,
        metavar="CHANNEL=NAME",
        help="Such as force='Load cell', 'displacement=Displacement (mm)', its number from 0, or - for none.",
    ),
    click.option("--dt", metavar="TIME", help="Sampling interval of files without a time, such as 2ms; else in s."),
    click.option("--header", type=int, metavar="LINE", help="Line of the names in a text, from 1; 0: there is none."),
    click.option(
        "--variable", metavar="NAME", help="Matrix of a MATLAB file, sheet of an Excel file or group of a TDMS file."
    ),
    click.option("--force-sign", type=int, metavar="SIGN", help="-1 turns the force of all files."),
    click.option("--measurement-session", metavar="NAME", help="One day's records on one mounting, for all files."),
    click.option("--specimen", metavar="NAME", help="Which damper it is, for all files."),
    click.option(
        "--smoothed",
        metavar="WINDOW",
        help="The files' channels went through a moving average: '0.3 s', '15 samples' or '0.1 periods', ', trailing'.",
    ),
    click.option(
        "--lowpass", metavar="HZ", help="Displacement above it is noise; '15 f': 15 times the motion's frequency."
    ),
    click.option(
        "--cut", metavar="TIME|events", help="Cut every record, such as every 5s, or at the rests between events."
    ),
)


def reading_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options `OPTIONS`; they come as ``reading``, a `Reading`."""

    @wraps(command)
    def wrapped(*rest: Any, units: tuple[str, ...], columns: tuple[str, ...], cut: str | None, **options: Any) -> Any:
        from dampyr.records.files.record_files import Layout

        said = {name: options.pop(name) for name in ("voltage", "current", *Layout.__annotations__)}
        said |= {"units": pairs(units), "columns": pairs(columns)}
        return command(*rest, reading=Reading({k: v for k, v in said.items() if v is not None}, cut), **options)

    for option in reversed(OPTIONS):
        wrapped = option(wrapped)
    return wrapped


def gather(
    paths: tuple[Path, ...],
    role: str | None,
    reading: Reading,
    reference_inputs: Sequence[float] = (),
    warn: bool = True,
    short: list[str] | None = None,
) -> list[Record]:
    """The records in files and folders, measured inputs that are constant but for noise as constants.

    ``role`` chooses among those of a folder, None takes all; measured inputs close to ``reference_inputs`` count as these.
    A line on stderr lists what was joined, and with ``warn`` another one the records that create energy.
    ``short``, where it is given, takes the sentence of each file that has too few samples for a record, and none is an error.
    """
    from dampyr import records
    from dampyr.records.formats.h5 import FewSamples

    measured: list[Record] = []
    for path in paths:
        if path.is_dir():
            measured += records.read_campaign(path, role=role, **reading.said)  # type: ignore[arg-type]
        else:
            try:
                measured.append(records.read(path, **reading.said))
            except FewSamples as problem:
                if short is None:
                    raise
                short.append(str(problem))
    if not measured and not short:
        where, which = ", ".join(map(str, paths)), f" whose role is {role}" if role else ""
        raise InputError(f"no records{which} in {where}; name files, or a folder with records")
    if reading.cut is not None and measured:
        measured = [piece for record in measured for piece in records.cut(record, reading.cut)]
        name, count = Counter(record.name for record in measured).most_common(1)[0]
        if count > 1:
            raise InputError(
                f"{count} records or pieces are called {name!r}; rename a file, or read them without --cut"
            )
    nominal = records.nominal_inputs(measured, reference_inputs)
    tell_inputs(measured, nominal)
    if warn:
        warn_of_signs(nominal)
    return nominal


def tell_inputs(measured: Sequence[Record], nominal: Sequence[Record]) -> None:
    """Say on stderr, in one line, which measured inputs count as which."""
    joined: dict[float, list[float]] = {}
    units = set()
    for before, after in zip(measured, nominal, strict=True):
        if before is not after and before.input_value is not None and after.input_value is not None:
            joined.setdefault(after.input_value, []).append(before.input_value)
            units.add("voltage" if after.input == "V" else "current")
    unit = "V" if units == {"voltage"} else "A"
    summaries = [_joined(u, sorted(values), unit) for u, values in sorted(joined.items())]
    if any(summaries):
        click.echo(
            f"dampyr: {units.pop()} as measured, constant but for noise: {'; '.join(filter(None, summaries))}", err=True
        )


def _joined(nominal: float, values: list[float], unit: str) -> str:
    """What counts as ``nominal``; empty where that says nothing."""
    low, high, counts = f"{values[0]:.4g}", f"{values[-1]:.4g}", f"{nominal:.4g}"
    if low == high == counts:
        return ""
    seen = low if low == high else f"{low} to {high}"
    times = f" in {len(values)} records" if len(values) > 1 else ""
    return f"{seen} {unit}{times} counts as {counts} {unit}"


def warn_of_signs(record_list: Sequence[Record]) -> None:
    """Warn of records whose loops create energy, in one line."""
    from dampyr.records.checks.label_checks import creates_energy

    wrong = [record.name for record in record_list if creates_energy(record)]
    if wrong:
        names = ", ".join(wrong[:3]) + (f" and {len(wrong) - 3} more" if len(wrong) > 3 else "")
        warnings.warn(
            f"{len(wrong)} of {len(record_list)} records create energy where a damper dissipates ({names}); force "
            "sign inverted?",
            DampyrWarning,
            stacklevel=3,
        )


def pairs(given: tuple[str, ...]) -> dict[str, str] | None:
    """``NAME=VALUE`` options as a dictionary."""
    for pair in given:
        if "=" not in pair:
            raise InputError(f"{pair!r} has no '='; write it as in displacement=mm")
    return dict(pair.split("=", 1) for pair in given) or None
