"""What every kind of step has: its fields, its drive, its peaks, and how it is called."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, ClassVar, Protocol, get_type_hints

from dampyr.config import split
from dampyr.errors import InputError
from dampyr.rig import Drive, RigSettings
from dampyr.units import Quantity, for_people

Length = Quantity("m", low=0.0, open_low=True)
Place = Quantity("m")
Speed = Quantity("m/s", low=0.0, open_low=True)
Frequency = Quantity("Hz", low=0.005, high=20.0)
Volts = Quantity("V", low=0.0)
Seconds = Quantity("s", low=0.0)
Time = Quantity("s", low=0.0, open_low=True)
Rest = Quantity("s", low=0.0, high=60.0)
Count = Quantity("", low=1.0)
Period = Quantity("s", low=0.001, high=0.05)

POINTS = 8  # set points that a cycle needs


@dataclass(frozen=True)
class Peaks:
    """The farthest position from the middle [m] and the greatest speed [m/s] of a step."""

    position: float
    speed: float


class Step(Protocol):
    """One file of ``steps/``: a frozen dataclass called as its file, whose fields a campaign fills.

    ``lowers`` : the fields that a refusal may propose to lower. ``named`` : the fields in a test's name and words.
    ``fixed`` : whether the test keeps its place where the order is random. ``learns`` : whether its drive can be learned: the
    table follows set points, and moves until their end. ``closed_loop`` : whether these follow from the measured force. One
    that names files has ``contents``, a hash of what is in each by its field. One that can be lowered to what the rig can
    do has ``fit_limits``, and ``fits``, the field that is lowered then. One with cycles of full amplitude by which a device may
    be judged has ``steady_cycles``, from the begin of the drive on, or None. A field that is added after a release has
    ``repr=False``: at its default it does not change what a campaign is.
    """

    lowers: ClassVar[tuple[str, ...]]
    named: ClassVar[tuple[str, ...]]
    fixed: ClassVar[bool]
    learns: ClassVar[bool]
    period: float

    def drive(self, rig: RigSettings) -> Drive:
        """The set points of table and coil."""

    def peaks(self, rig: RigSettings) -> Peaks:
        """Its peaks in closed form where there is one."""


def shown(step: Any, field: str, blank: str = " ") -> str:
    """A field in the unit that people read, ``12.4 mm``; with its name where it has no unit, ``seed 3``; "" for None."""
    value, quantity = getattr(step, field), split(get_type_hints(type(step), include_extras=True).get(field))[1]
    if value is None or isinstance(value, str):
        return value or ""
    if quantity is None or not quantity.unit:
        return f"{field}{blank}{value:.6g}"
    unit, factor = (quantity.unit, 1.0) if quantity.unit == "s" else for_people(quantity.unit)
    numbers = value if isinstance(value, tuple) else (value,)
    return f"{(', ' if blank else '+').join(f'{number * factor:.6g}' for number in numbers)}{blank}{unit}"


def words(kind: str, step: Any, leave_out: Sequence[str] = ()) -> str:
    """A step in words, such as ``sine 20 mm at 2 Hz, 0.8712 V``, without the fields of ``leave_out``."""
    first, *others = [text for text in (shown(step, name) for name in step.named if name not in leave_out) if text]
    return f"{kind.replace('_', ' ')} {first}" + (f" at {', '.join(others)}" if others else "")


@cache
def _quantities(kind: Any) -> dict[str, Quantity | None]:
    """What the fields of a kind of step mean; many steps are made where a campaign is planned."""
    return {name: split(hint)[1] for name, hint in get_type_hints(kind, include_extras=True).items()}


def quantity_of(step: Any, field: str) -> Quantity:
    """What a field means."""
    quantity = _quantities(step.__class__)[field]
    assert quantity is not None, f"{field} has no unit"
    return quantity


def check_ranges(step: Any) -> None:
    """Raise :class:`InputError` where a value leaves its range: for steps made in Python, not read from a file."""
    for field in fields(step):
        quantity, value = _quantities(step.__class__)[field.name], getattr(step, field.name)
        if quantity is not None and value is not None:
            for number in value if isinstance(value, tuple) else (value,):
                quantity.check(field.name, number)


def enough_points(period: float, frequency: float) -> None:
    """Raise :class:`InputError` where set points are too far apart to draw a cycle."""
    if POINTS * period * frequency > 1 + 1e-9:
        raise InputError(
            f"period = {period * 1e3:g} ms gives fewer than {POINTS} set points per cycle at {frequency:g} Hz; "
            f"give at most {1e3 / POINTS / frequency:.3g} ms, or a lower frequency"
        )
