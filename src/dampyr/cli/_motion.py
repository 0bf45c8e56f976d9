"""A ground motion named on the command line: its file, and its scaling."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dampyr.errors import InputError

if TYPE_CHECKING:
    from dampyr.ground_motions import GroundMotion, MotionReadOptions


@dataclass(frozen=True)
class Ground:
    """The command line's options of a ground motion."""

    unit: str | None
    dt: float | None
    scale: float | None
    pga: str | None
    sa: str | None
    component: str | None = None

    def motion(
        self, path: Path | None, baseline: bool = False, options: MotionReadOptions | None = None
    ) -> GroundMotion:
        """The motion in the file, or El Centro 1940; less its ``baseline`` where asked for; as strong as asked for."""
        from dampyr import ground_motions
        from dampyr.options import command_words

        declared = [] if options is None else command_words(options)
        if path is None and (declared or any(option is not None for option in (self.unit, self.dt, self.component))):
            flag = f"{declared[0]} belongs" if declared else "--motion-unit, --dt and --component belong"
            raise InputError(f"{flag} to a file that is given with --motion; those of El Centro 1940 are fixed")
        motion = (
            ground_motions.el_centro()
            if path is None
            else ground_motions.read(path, units=self.unit, dt=self.dt, component=self.component, options=options)
        )
        return self._scaled(ground_motions.corrected(motion) if baseline else motion)

    def typed(self) -> list[str]:
        """The options that were given."""
        words = {"unit": "motion-unit"}
        names = ("unit", "dt", "scale", "pga", "sa", "component")
        return [f"--{words.get(name, name)}" for name in names if getattr(self, name) is not None]

    def _scaled(self, motion: GroundMotion) -> GroundMotion:
        flags = [f"--{name}" for name in ("scale", "pga", "sa") if getattr(self, name) is not None]
        if len(flags) > 1:
            raise InputError(f"{' and '.join(flags)} contradict each other; give one of them")
        if self.scale is not None:
            return motion if self.scale == 1.0 else motion.scaled(self.scale)
        if self.pga is not None:
            return motion.scaled_to_pga(acceleration(self.pga))
        return motion if self.sa is None else motion.scaled_to_sa(*spectral(self.sa))


component_option = click.option(
    "--component", metavar="NAME", help="Component of a file that holds several, as the file calls it, such as N-S."
)


def motion_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options ``--motion-unit --dt --component --scale --pga --sa``; they come as ``ground``, a `Ground`."""

    @click.option("--motion-unit", metavar="UNIT", help="Unit of the acceleration in a plain file, such as g.")
    @click.option("--dt", type=float, help="Seconds between samples, for a plain file with one column.")
    @component_option
    @click.option("--scale", type=float, metavar="FACTOR", help="Factor on the ground motion.")
    @click.option("--pga", metavar="A", help="Scale to this peak acceleration, such as 0.3g or '3 m/s^2'.")
    @click.option("--sa", metavar="A@T[@D]", help="Scale to this Sa at a period and damping, such as 0.5g@0.48s@5%.")
    @wraps(command)
    def wrapped(
        *rest: Any,
        motion_unit: str | None,
        dt: float | None,
        component: str | None,
        scale: float | None,
        pga: str | None,
        sa: str | None,
        **options: Any,
    ) -> Any:
        return command(*rest, ground=Ground(motion_unit, dt, scale, pga, sa, component), **options)

    return wrapped


def acceleration(text: str) -> float:
    """Such as ``0.3g`` or ``3 m/s^2`` in m/s2; a unit is required, since a bare 0.3 may mean either."""
    from dampyr import units

    try:
        float(text)
    except ValueError:
        return units.parse(text, "m/s^2")
    raise InputError(f"{text!r} has no unit; write it as in {text.strip()}g or '{text.strip()} m/s^2'")


def spectral(text: str) -> tuple[float, float, float]:
    """``0.5g@0.48s@5%`` as acceleration [m/s2], period [s] and damping; 5 % where it is left out."""
    from dampyr import units

    parts = text.split("@")
    if len(parts) not in (2, 3):
        raise InputError(f"{text!r} is not a spectral acceleration; write it as in 0.5g@0.48s or 0.5g@0.48s@5%")
    return acceleration(parts[0]), units.parse(parts[1], "s"), ratio(parts[2]) if len(parts) == 3 else 0.05


def ratio(text: str) -> float:
    """A damping ratio below 1, ``5%`` or ``0.05``."""
    number = text.strip()
    try:
        value = float(number.removesuffix("%")) / (100 if number.endswith("%") else 1)
    except ValueError:
        raise InputError(f"{text!r} is not a damping; write it as in 5% or 0.05") from None
    if not 0 <= value < 1:
        raise InputError(f"a damping of {text} is not allowed; it must be from 0 to less than 1, as in 5% or 0.05")
    return value
