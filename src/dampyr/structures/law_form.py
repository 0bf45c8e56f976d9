r"""What a control law is: settings, measures, a linear filter and a formula.

At its samples, a period apart, a law measures y (`dampyr.structures.sensors`), and with the memory x of its filter

.. math:: s_k = C x_k + D y_k, \qquad u_k = \mathrm{decide}(s_k, \dots), \qquad x_{k+1} = F x_k + G y_k

A file of a law has a class of its settings (`ControlLaw`), and beside it

``MEASURES``
    the names of what it measures, in order.
``design(law, building, row)``
    the filter and its signals, worked out once, in plain Python: a `LawDesign`. Without it there is no memory, and the measures
    of one number are the signals.
``STATES`` and ``update(...)``
    further memory, name -> value at the start, and its next values in that order, before the decision.
``decide(...)``
    the input from then on, in V or A as the damper takes it.

``ASKS = "force"``
    where ``decide`` gives the force that the law wants [N], and the input is what the damper's own model, run backwards, finds
    for it (`dampyr.structures.wanted_force`). Such a law measures ``stroke`` and ``rate``, which the model follows.

``update`` and ``decide`` are formulas: one expression each, of the signals, measures of one number, states and settings that
they name. They are written into the kernels of responses and ensembles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.structures.sensor_noise import MAX_SEED
from dampyr.structures.sensors import Sensor
from dampyr.units import Quantity

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ControlLaw:
    """The inputs ``low`` and ``high`` [V or A], the ``period`` between decisions and the ``lag`` of the coil [s]; the
    ``sensors`` by the names of what they measure, ideal where none is given, and the ``seed`` of their noise."""

    low: Annotated[float, Quantity("V or A")]
    high: Annotated[float, Quantity("V or A")]
    period: Annotated[float, Quantity("s", low=0, open_low=True)] = 0.005
    lag: Annotated[float, Quantity("s", low=0)] = 0.0
    sensors: Mapping[str, Sensor] | tuple[tuple[str, Sensor], ...] = field(default=(), kw_only=True)
    seed: int = field(default=1, kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "sensors", _sensors(self.sensors))
        whole = isinstance(self.seed, int | float | np.integer) and not isinstance(self.seed, bool)
        if not whole or not 0 <= self.seed <= MAX_SEED or self.seed != int(self.seed):
            raise InputError(f"seed = {self.seed!r} is not allowed; it must be a whole number from 0 to {MAX_SEED}")
        object.__setattr__(self, "seed", int(self.seed))

    def sensor_of(self, measure: str) -> Sensor:
        """The sensor of a measure."""
        return dict(self.sensors).get(measure, Sensor())


SHARED = ("low", "high", "period", "lag", "sensors", "seed")
"""The settings of every law."""


def _sensors(given: Any) -> tuple[tuple[str, Sensor], ...]:
    """Sensors that are not ideal, sorted by what they measure."""
    pairs = dict(given)
    wrong = next((value for value in pairs.values() if not isinstance(value, Sensor)), None)
    if wrong is not None:
        raise InputError(
            f"sensors holds a {type(wrong).__name__}; write a Sensor for each measure, such as Sensor(noise=0.05)"
        )
    return tuple(sorted((name, sensor) for name, sensor in pairs.items() if not sensor.is_ideal))


@dataclass(frozen=True, eq=False, repr=False)
class LawDesign:
    """What a law works out of a building: ``signals``, name -> row over the memory and the measures (X + Y,), and the filter
    ``F`` (X, X) and ``G`` (X, Y), which has no memory unless they are given."""

    signals: Mapping[str, Array]
    F: Array = field(default_factory=lambda: np.zeros((0, 0)))
    G: Array | None = None

    def __repr__(self) -> str:
        return f"LawDesign(signals {', '.join(self.signals)}; memory of {len(self.F)} numbers)"
