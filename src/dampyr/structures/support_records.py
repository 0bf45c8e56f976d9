"""Records at the supports of a structure, in a TOML file: a table for each support.

::

    [west]
    file = "quake.csv"                   # a ground motion beside this file, or motion = "el_centro"
    columns = { acceleration = "west" }  # of a table; component = "N-S" of a file of records that holds several
    units = "g"                          # where the file does not state it
    scale = 1.5

    [east]
    file = "quake.csv"
    columns = { acceleration = "east" }
    delay = "0.4 s"                      # by which the shaking comes later

A number without a unit is SI. All have one step; a support rests before its motion begins, and after it has ended.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from dampyr.config import Choices, fill, load_toml
from dampyr.errors import FileError, InputError
from dampyr.ground_motions import GroundMotion, el_centro, padded, read
from dampyr.structures.structure_file import own_file
from dampyr.structures.supports import SupportMotions
from dampyr.units import Quantity


@dataclass(frozen=True)
class SupportRecord:
    """What a support's table holds."""

    file: Annotated[str, "a ground motion's file beside this one"] = ""
    motion: Annotated[str, Choices(("", "el_centro")), "el_centro, where no file is given"] = ""
    component: Annotated[str, "of a file that holds several, what the file calls it"] = ""
    columns: Annotated[Mapping[str, str], "of a table its columns, such as { acceleration = 'west' }"] = field(
        default_factory=dict
    )
    units: Annotated[str, "unit of the acceleration, where the file does not state it"] = ""
    dt: Annotated[float | None, Quantity("s", low=0.0, open_low=True), "between samples, of a file of one column"] = (
        None
    )
    scale: Annotated[float, Quantity(""), "factor on the motion"] = 1.0
    delay: Annotated[float, Quantity("s", low=0.0), "by which it comes later, a whole number of samples"] = 0.0

    def record(self, folder: Path) -> GroundMotion:
        """The motion, scaled, with its rest before; files are in ``folder`` or below it."""
        if bool(self.file) == bool(self.motion):
            raise InputError('takes either file or motion = "el_centro"; give one of the two')
        if self.motion and (self.component or self.columns or self.units or self.dt is not None):
            raise InputError("has component, columns, units or dt, which are of a file; leave them out")
        motion = el_centro()
        if self.file:
            stated: dict[str, Any] = {name: getattr(self, name) for name in ("units", "dt", "component", "columns")}
            motion = read(
                own_file(folder, self.file, "file"), **{name: value for name, value in stated.items() if value}
            )
        count = round(self.delay / motion.dt)
        if abs(count * motion.dt - self.delay) > 1e-9 * motion.dt:
            raise InputError(
                f"delay = {self.delay:g} s is not a whole number of its motion's samples of {motion.dt:g} s; give "
                f"{count * motion.dt:g} s"
            )
        scaled = motion if self.scale == 1.0 else motion.scaled(self.scale)
        return padded(scaled, 0.0, before=count * motion.dt) if count else scaled


def read_supports(path: str | Path, name: str | None = None) -> SupportMotions:
    """The motions of the supports of a structure, in a TOML file with a table for each.

    A table has ``file``, a ground motion in the folder of this file or below it (with ``component``, ``columns``, ``units`` and
    ``dt`` as `dampyr.ground_motions.read` takes them), or ``motion = "el_centro"``; ``scale``, a factor; and ``delay`` s by
    which the motion comes later, a whole number of its samples. Shorter ones are followed by rest. Numbers may be texts with
    a unit.

    Parameters
    ----------
    path
        The file.
    name
        What the motions are called; by default after the file.

    Raises
    ------
    FileError
        It starts with the path: what is not known, missing or not allowed, of which support; motions of different steps.
    MissingData
        There is no such file.

    Examples
    --------
    >>> import dampyr as dp
    >>> from pathlib import Path
    >>> _ = Path("piers.toml").write_text('[west]\\nmotion = "el_centro"\\n[east]\\nmotion = "el_centro"\\ndelay = "0.4 s"')
    >>> motions = dp.structures.read_supports("piers.toml")
    >>> list(motions.motions), motions.n
    (['west', 'east'], 1580)
    """
    file = Path(path)
    document = load_toml(file)
    try:
        records = {support: _record(support, table, file.parent) for support, table in document.items()}
        if not records:
            raise InputError('there is no support; give each a table, such as [west] with file = "quake.csv"')
        steps = {motion.dt for motion in records.values()}
        if len(steps) > 1:
            raise InputError(
                f"the motions have steps of {', '.join(f'{step:g} s' for step in sorted(steps))}; resample them to one step"
            )
        longest = max(motion.n for motion in records.values())
        motions = {
            support: motion if motion.n == longest else padded(motion, (longest - motion.n) * motion.dt)
            for support, motion in records.items()
        }
        return SupportMotions(motions, name or file.stem)
    except FileError:
        raise
    except InputError as problem:
        raise FileError(file, str(problem)) from None


def _record(support: str, table: Any, folder: Path) -> GroundMotion:
    if not isinstance(table, Mapping):
        raise InputError(f'{support} = {table!r} is not a table; write [{support}] and below it file = "quake.csv"')
    made = fill(SupportRecord, table, support)
    try:
        return made.record(folder)
    except FileError:
        raise
    except InputError as problem:
        raise InputError(f"{support}: {problem}") from None
