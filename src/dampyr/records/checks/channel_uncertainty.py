"""Standard uncertainty of a channel, with the parts that it is made of."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from dampyr.errors import InputError


@dataclass(frozen=True)
class ChannelUncertainty:
    r"""The standard uncertainty (one sigma) of a channel of a record, in the channel's unit.

    .. math:: u = \sqrt{\textstyle\sum_k u_k^2}

    with the ``parts`` u_k by name, taken as independent (JCGM 100:2008, 5.1.2). Raises :class:`~dampyr.errors.InputError` for
    a part that is negative or not finite.
    """

    parts: Mapping[str, float]

    def __post_init__(self) -> None:
        for name, value in self.parts.items():
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError(f"uncertainty {name} = {value} is not allowed; it must be finite and 0 or more")
        object.__setattr__(self, "parts", MappingProxyType({name: float(value) for name, value in self.parts.items()}))

    def __reduce__(self) -> tuple[type[ChannelUncertainty], tuple[dict[str, float]]]:
        return ChannelUncertainty, (dict(self.parts),)

    @property
    def standard(self) -> float:
        """One sigma."""
        return math.sqrt(sum(value**2 for value in self.parts.values()))

    @property
    def largest(self) -> str:
        """The name of the largest part."""
        return max(self.parts, key=lambda name: self.parts[name], default="")

    def to_json(self) -> str:
        """The parts as text."""
        return json.dumps(dict(self.parts))
