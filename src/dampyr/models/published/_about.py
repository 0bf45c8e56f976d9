"""What is known of a published set: where its numbers stand, who read them where, and what disagrees."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from dampyr.models.damper import Damper
from dampyr.models.laws import Law


@dataclass(frozen=True)
class Motion:
    """A sine that the source runs: ``amplitude`` m, ``frequency`` Hz, and the ``inputs`` (V or A) it is run at."""

    amplitude: float
    frequency: float
    inputs: tuple[float, ...]


@dataclass(frozen=True)
class About:
    """One published set.

    ``claims``
        the source that the numbers are said to come from, in short: sets with the same claim name each other in ``differs``.
    ``paper``
        the publication that the numbers are attributed to, in the words of who attributes them.
    ``where``
        page or table in it; where it was not read, so it says.
    ``read``
        what was read: the source of every number here.
    ``device``
        the specimen, as far as the source names it.
    ``printed``
        letter -> (number, unit) as printed; a unit that the source leaves out is inferred, and the notes say so.
    ``limits``
        the smallest and largest input, and ``limits_from`` where they come from.
    ``motion``
        a sine that the source runs.
    ``eta``
        the rate in 1/s of the first-order filter u' = -eta (u - V) between command and damper; None without one. The damper
        has it as the part ``lag``, tau = 1/eta.
    ``notes``
        what a user must know.
    ``differs``
        name of another set -> what differs, for sets that claim the same source or share its numbers.
    """

    claims: str
    paper: str
    where: str
    read: str
    device: str
    printed: Mapping[str, tuple[float, str]]
    limits: tuple[float, float]
    limits_from: str
    motion: Motion
    input: str = "V"
    eta: float | None = None
    notes: tuple[str, ...] = ()
    differs: Mapping[str, str] = field(default_factory=dict)

    @property
    def numbers(self) -> dict[str, float]:
        """letter -> the number as printed."""
        return {letter: number for letter, (number, _) in self.printed.items()}

    @property
    def units(self) -> tuple[str, ...]:
        """The printed units, each once."""
        return tuple(dict.fromkeys(unit for _, unit in self.printed.values()))

    def damper(self, parts: str, laws: Mapping[str, Law | float]) -> Damper:
        """A damper of these laws, and of the lag of its input, that says where it comes from."""
        said = {"paper": self.paper, "where": self.where, "read": self.read, "device": self.device}
        said |= {"limits": self.limits_from}
        if self.eta is not None:
            said["filter"] = (
                f"the source filters the command V first, u' = -{self.eta:g} (u - V): the part lag, tau = 1/eta"
            )
            parts, laws = f"{parts} + lag", {**laws, "lag.tau": 1.0 / self.eta}
        if self.differs:
            said["differs"] = "; ".join(f"{name}: {what}" for name, what in self.differs.items())
        return Damper(parts, laws, input=self.input, provenance=said)
