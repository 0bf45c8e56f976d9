"""Options of an ensemble on the command line: its cases, its progress."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.cli._control import (
    control_option,
    damper_of,
    inputs_by_kind,
    placed,
    storeys_option,
    structure_of,
    structure_option,
    temperature_option,
)
from dampyr.cli._motion import acceleration, component_option
from dampyr.cli._options import refuse_typed
from dampyr.cli._progress import is_followed, stages
from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.ground_motions import GroundMotion
    from dampyr.structures import EnsembleOptions

OF_THE_RESULT = {"limits", "height", "intensity", "seed"}  # options of what is made of the peaks
MAX_SCALES = 10_000  # more is a mistyped step, such as 0.1:3:1e-9


@dataclass(frozen=True)
class EnsembleCommand:
    """The command line's options of the cases, besides those of their class."""

    card: Path | None
    structure: str | None
    voltages: tuple[float, ...]
    currents: tuple[float, ...]
    controls: tuple[str, ...]
    storeys: tuple[int, ...]
    between: tuple[str, str] | None
    without_damper: bool
    motions: tuple[Path, ...]
    motion_unit: str | None
    dt: float | None
    component: str | None
    synthetic: int | None
    duration: float
    pga: str
    scales: tuple[str, ...]
    temperature: float | None

    def cases(self, options: EnsembleOptions, any_input: bool = False) -> dict[str, Any]:
        """The arguments of `dampyr.structures.ensemble` that say which cases there are; with ``any_input`` without one, too."""
        damper = damper_of(self.card, self.temperature, options.allow_extrapolation)
        return {
            "buildings": structure_of(self.structure),
            "motions": self._motions(options.seed),
            "dampers": [*([None] if self.without_damper else []), placed(damper, self.storeys, self.between)],
            "scales": scales(self.scales),
            "options": options,
            **self._inputs(damper, any_input),
        }

    def _inputs(self, damper: Any, any_input: bool) -> dict[str, Any]:
        if any_input and damper.has_input and not (self.voltages or self.currents or self.controls):
            return {"voltage" if damper.input == "V" else "current": []}
        return inputs_by_kind(damper, self.voltages, self.currents, self.controls)

    def _motions(self, seed: int) -> list[GroundMotion]:
        from dampyr import ground_motions

        if not self.motions and any(option is not None for option in (self.motion_unit, self.dt, self.component)):
            raise InputError("--motion-unit, --dt and --component belong to files that are given with --motion")
        motions = [ground_motions.read(path, self.motion_unit, self.dt, self.component) for path in self.motions]
        if self.synthetic:
            motions += ground_motions.synthetic_motions(self.synthetic, seed, self.duration, acceleration(self.pga))
        return motions or [ground_motions.el_centro()]


CASE_OPTIONS = (
    click.argument("card", required=False, type=click.Path(path_type=Path)),
    structure_option,
    click.option("--voltage", "voltages", multiple=True, type=float, help="Voltage at the coil in V; may be repeated."),
    click.option("--current", "currents", multiple=True, type=float, help="Current in A, for a card over the current."),
    control_option,
    storeys_option,
    click.option("--between", nargs=2, metavar="I J", help="Two floors that the damper joins instead."),
    click.option("--without-damper", is_flag=True, help="Run the building without damper, too."),
    click.option(
        "--motion", "motions", multiple=True, type=click.Path(path_type=Path), help="A ground motion file; repeatable."
    ),
    click.option("--motion-unit", metavar="UNIT", help="Unit of the acceleration in plain files, such as g."),
    click.option("--dt", type=float, help="Seconds between samples, for plain files with one column."),
    component_option,
    click.option("--synthetic", type=click.IntRange(1), default=None, metavar="N", help="Make N motions by seed."),
    click.option("--duration", type=float, default=20.0, help="Duration of synthetic motions in s.  [default: 20]"),
    click.option("--pga", default="0.3g", metavar="A", help="Peak acceleration of synthetic motions.  [default: 0.3g]"),
    click.option(
        "--scale", "scales", multiple=True, metavar="LIST", help="Factors on the motions: 0.5,1,2 or 0.1:3:0.1."
    ),
    temperature_option,
)


read_option = click.option(
    "--read", type=click.Path(path_type=Path), metavar="FILE", help="Take a finished file instead of computing."
)
workers_option = click.option(
    "--workers", type=click.IntRange(1), metavar="N", help="Number of threads.  [default: one for each core]"
)


cluster_option = click.option(
    "--cluster", metavar="ADDRESS", help="Compute on a dask cluster whose scheduler is there, such as tcp://host:8786."
)


@contextmanager
def workers_of(workers: int | None, cluster: str | None) -> Iterator[Any]:
    """Threads of this process, or the client of a cluster."""
    if cluster is None:
        with ThreadPoolExecutor(workers) as pool:
            yield pool
        return
    if workers is not None:
        raise InputError("--workers counts threads here, and --cluster computes elsewhere; give one of the two")
    from dampyr.structures.ensembles.ensemble_workers import connected

    with connected(cluster) as client:
        yield client


def case_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options that say which cases there are; they come as ``request``, an `EnsembleCommand`."""

    @wraps(command)
    def wrapped(**options: Any) -> Any:
        of_cases = {field.name: options.pop(field.name) for field in fields(EnsembleCommand)}
        return command(request=EnsembleCommand(**of_cases), **options)

    for option in reversed(CASE_OPTIONS):
        wrapped = option(wrapped)
    return wrapped


def refuse_cases(what: str) -> None:
    """Refuse options that choose cases where the cases were computed already."""
    from dampyr.options import options_of
    from dampyr.structures import EnsembleOptions

    names = {field.name for field in fields(EnsembleCommand)} | {option.name for option in options_of(EnsembleOptions)}
    refuse_typed(names - OF_THE_RESULT, f"says what to compute, and {what} takes what was computed; leave it out")


def scales(texts: tuple[str, ...]) -> list[float]:
    """``("0.5,1", "2:3:0.5")`` as 0.5, 1, 2, 2.5, 3; the end of a range belongs to it."""
    values = [value for text in texts for part in text.split(",") for value in read_range(part, "--scale", MAX_SCALES)]
    doubled = sorted({value for value in values if values.count(value) > 1}) if len(values) < MAX_SCALES else []
    if doubled:
        raise InputError(f"--scale: {doubled[0]:g} is given twice; give every scale once")
    return values or [1.0]


def read_range(text: str, option: str, most: int) -> list[float]:
    """``2`` as 2 and ``0.5:1.5:0.5`` as 0.5, 1, 1.5; the end of a range belongs to it. ``option`` is named where it is neither,
    or has more than ``most`` numbers."""
    try:
        numbers = [float(part) for part in text.split(":")]
    except ValueError:
        numbers = []
    if len(numbers) == 1:
        return numbers
    if len(numbers) != 3 or not numbers[2] > 0.0 or numbers[1] < numbers[0]:
        raise InputError(
            f"{option} {text!r} is neither a number nor a range; write it as in 0.5,1,2 or 0.1:3:0.1 (from:to:step)"
        )
    first, last, step = numbers
    count = int((last - first) / step * (1 + 1e-12) + 1e-9) + 1
    if count > most:
        raise InputError(f"{option} {text!r} has {count} numbers; at most {most} are allowed")
    return [float(f"{first + k * step:.12g}") for k in range(count)]


def shard(text: str) -> tuple[int, int]:
    """``3/32`` as (3, 32)."""
    part, _, parts = text.partition("/")
    if not (part.isdigit() and parts.isdigit() and 1 <= int(part) <= int(parts)):
        raise InputError(f"--shard {text!r} is not a part; write it as in 3/32, counted from 1 to the number of parts")
    return int(part), int(parts)


@contextmanager
def counting(before: int = 0) -> Iterator[Callable[[int, int], None]]:
    """A function ``(cases done, all)`` that shows rate and time left on stderr; ``before`` were there already."""
    if is_followed():
        with stages() as show:
            yield lambda done, size: show(f"{done} of {size} cases", done / size)
        return
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
