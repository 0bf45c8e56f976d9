"""Options of an ensemble on the command line: its cases, its limits, its progress."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._control import (
    control_option,
    damper_of,
    inputs_for,
    place_of,
    structure_of,
    structure_option,
    temperature_option,
)
from dampyr.cli._motion import acceleration, after_option
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.ground_motions import GroundMotion
    from dampyr.models import Damper
    from dampyr.structures import Building, EnsembleOptions, Limit

MAX_SCALES = 10_000  # more is a mistyped step, such as 0.1:3:1e-9


@dataclass(frozen=True)
class EnsembleRequest:
    """The command line's options of the cases."""

    card: Path | None
    structure: str | None
    voltages: tuple[float, ...]
    currents: tuple[float, ...]
    controls: tuple[str, ...]
    storey: int | None
    between: tuple[str, str] | None
    brace: float | None
    without_damper: bool
    draws: int
    motions: tuple[Path, ...]
    motion_unit: str | None
    dt: float | None
    synthetic: int
    duration: float
    pga: str
    seed: int
    scales: tuple[str, ...]
    after: float
    temperature: float | None
    accuracy: str
    precision: str
    allow_extrapolation: bool

    def models(self) -> tuple[Building, list[GroundMotion], Damper]:
        """The building, the motions and the damper."""
        building = structure_of(self.structure)
        damper = damper_of(self.card, self.temperature, self.allow_extrapolation)
        inputs_for(damper, self.voltages, self.currents, self.controls)
        return building, self._motions(), damper

    def options(self, limits: tuple[Limit, ...] = (), intensity: str = "pga") -> EnsembleOptions:
        """The options of the job."""
        from dampyr.structures import EnsembleOptions

        return EnsembleOptions(
            inputs=self.voltages or self.currents,
            laws=self.controls,
            place=place_of(self.storey, self.between),
            brace=self.brace,
            bare=self.without_damper,
            draws=self.draws,
            seed=self.seed,
            scales=tuple(scales(self.scales)),
            after=self.after,
            limits=limits,
            intensity=intensity,
            accuracy=self.accuracy,
            precision=int(self.precision),
            allow_extrapolation=self.allow_extrapolation,
        )

    def _motions(self) -> list[GroundMotion]:
        from dampyr import ground_motions
        from dampyr.structures.ensembles.ensemble_run import synthetic_motions

        if not self.motions and (self.motion_unit is not None or self.dt is not None):
            raise InputError("--motion-unit and --dt belong to files that are given with --motion")
        motions = [ground_motions.read(path, units=self.motion_unit, dt=self.dt) for path in self.motions]
        if self.synthetic:
            motions += synthetic_motions(self.synthetic, self.seed, self.duration, acceleration(self.pga))
        return motions or [ground_motions.el_centro()]


def case_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options that say which cases there are; they come as ``request``, an `EnsembleRequest`."""
    options = [
        click.argument("card", required=False, type=click.Path(path_type=Path)),
        structure_option,
        click.option("--voltage", "voltages", multiple=True, type=float, help="V at the coil; may be repeated."),
        click.option("--current", "currents", multiple=True, type=float, help="A, for a card over the current."),
        control_option,
        click.option("--storey", type=int, help="Where the damper stands.  [default: 1]"),
        click.option("--between", nargs=2, metavar="I J", help="Two floors that the damper joins instead."),
        click.option("--brace", type=float, metavar="N/M", help="Stiffness of a brace in series with the damper."),
        click.option("--without-damper", is_flag=True, help="Run the building without damper, too."),
        click.option("--draws", type=click.IntRange(1), default=None, help="Dampers drawn from the card's covariance."),
        click.option("--motion", "motions", multiple=True, type=click.Path(path_type=Path), help="May be repeated."),
        click.option("--motion-unit", metavar="UNIT", help="Of the acceleration in plain files, such as g."),
        click.option("--dt", type=float, help="s between samples, for plain files with one column."),
        click.option("--synthetic", type=click.IntRange(1), default=None, metavar="N", help="Make N motions by seed."),
        click.option("--duration", type=float, default=20.0, help="s, of synthetic motions.  [default: 20]"),
        click.option("--pga", default="0.3g", metavar="A", help="Of synthetic motions.  [default: 0.3g]"),
        click.option("--seed", type=int, default=1, help="Of motions, draws and bands.  [default: 1]"),
        click.option("--scale", "scales", multiple=True, metavar="LIST", help="Such as 0.5,1,2 or 0.1:3:0.1."),
        after_option,
        temperature_option,
        click.option("--accuracy", type=click.Choice(["fast", "strict"]), default="fast", help="[default: fast]"),
        click.option("--precision", type=click.Choice(["64", "32"]), default="64", help="Bits.  [default: 64]"),
        click.option("--allow-extrapolation", is_flag=True, help="Take inputs outside the calibrated range."),
    ]

    @wraps(command)
    def wrapped(**given: Any) -> Any:
        own = {field.name: given.pop(field.name) for field in fields(EnsembleRequest)}
        own["draws"], own["synthetic"] = own["draws"] or 0, own["synthetic"] or 0
        return command(request=EnsembleRequest(**own), **given)

    for option in reversed(options):
        wrapped = option(wrapped)
    return wrapped


def refuse_cases(context: click.Context, what: str) -> None:
    """Refuse options that choose cases where the cases were computed already."""
    names = {field.name for field in fields(EnsembleRequest)} - {"seed"}
    for parameter in context.command.params:
        source = context.get_parameter_source(str(parameter.name))
        if parameter.name in names and source is not click.core.ParameterSource.DEFAULT:
            name = parameter.opts[0] if isinstance(parameter, click.Option) else "CARD"
            raise InputError(f"{name} says what to compute, and {what} takes what was computed; leave it out")


def scales(given: tuple[str, ...]) -> list[float]:
    """``("0.5,1", "2:3:0.5")`` as 0.5, 1, 2, 2.5, 3; the end of a range belongs to it."""
    values = [value for text in given for part in text.split(",") for value in _span(part)]
    doubled = sorted({value for value in values if values.count(value) > 1}) if len(values) < MAX_SCALES else []
    if doubled:
        raise InputError(f"--scale: {doubled[0]:g} is given twice; give every scale once")
    return values or [1.0]


def _span(text: str) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(":")]
    except ValueError:
        numbers = []
    if len(numbers) == 1:
        return numbers
    if len(numbers) != 3 or numbers[2] <= 0 or numbers[1] < numbers[0]:
        raise InputError(
            f"--scale {text!r} is neither a number nor a range; write it as in 0.5,1,2 or 0.1:3:0.1 (from:to:step)"
        )
    first, last, step = numbers
    count = int((last - first) / step * (1 + 1e-12) + 1e-9) + 1
    if count > MAX_SCALES:
        raise InputError(f"--scale {text!r} has {count} scales; at most {MAX_SCALES} are allowed")
    return [float(f"{first + k * step:.12g}") for k in range(count)]


def limit(text: str, height: str | None) -> Limit:
    """``12mm`` a drift, ``1%`` a drift of the ``height``, ``0.3g`` an acceleration."""
    from dampyr import units
    from dampyr.structures import Limit

    if text.strip().endswith("%"):
        if height is None:
            raise InputError(
                f"--limit {text} is a ratio of the storey height; give it too, as in --height 3m, or a limit in mm"
            )
        return Limit("drift", _percent(text), units.parse(height, "m"))
    for quantity, unit in (("drift", "m"), ("acceleration", "m/s^2")):
        try:
            float(text)
        except ValueError:
            try:
                value = units.parse(text, unit)
            except InputError:
                continue
            return Limit(quantity, value)
    raise InputError(f"--limit {text!r} has no unit of a drift or an acceleration; write it as in 12mm, 1% or 0.5g")


def _percent(text: str) -> float:
    try:
        return float(text.strip().removesuffix("%")) / 100
    except ValueError:
        raise InputError(f"--limit {text!r} is not a ratio; write it as in 1%") from None


def shard(text: str) -> tuple[int, int]:
    """``3/32`` as (3, 32)."""
    part, _, parts = text.partition("/")
    if not (part.isdigit() and parts.isdigit() and 1 <= int(part) <= int(parts)):
        raise InputError(f"--shard {text!r} is not a part; write it as in 3/32, counted from 1 to the number of parts")
    return int(part), int(parts)


@contextmanager
def counting(before: int = 0) -> Iterator[Callable[[int, int], None]]:
    """A function ``(cases done, all)`` that shows rate and time left on stderr; ``before`` were there already."""
    if not sys.stderr.isatty():
        yield _lines(before)
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[rate]}"), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True)) as bars:
        task, rate = bars.add_task("cases", total=None, rate=""), Rate(before)
        yield lambda done, size: bars.update(task, completed=done, total=size, rate=f"{rate.of(done):.4g} cases/s")


class Rate:
    """Cases in each second, less those that were there ``before``."""

    def __init__(self, before: int, clock: Callable[[], float] = time.monotonic) -> None:
        self.clock, self.start, self.before = clock, clock(), before

    def of(self, done: int) -> float:
        """By now."""
        return (done - self.before) / max(self.clock() - self.start, 1e-9)


def _lines(before: int, every: float = 5.0, clock: Callable[[], float] = time.monotonic) -> Callable[[int, int], None]:
    rate, last = Rate(before, clock), [clock()]

    def show(done: int, size: int) -> None:
        if done < size and clock() - last[0] < every:
            return
        last[0] = clock()
        left = (size - done) / max(rate.of(done), 1e-9)
        print(f"{done} of {size} cases, {rate.of(done):.4g} cases/s, {left:.0f} s left", file=sys.stderr, flush=True)

    return show
