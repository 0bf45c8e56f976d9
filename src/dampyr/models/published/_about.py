"""A published set as its file describes it: where its numbers are printed, who read them, and what disagrees."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import pi
from pathlib import Path
from typing import Any

from dampyr.models.damper import Damper
from dampyr.models.published._conversion import LENGTHS, MODELS, PrintedSet
from dampyr.origin import DERIVED


@dataclass(frozen=True)
class SourceMotion:
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
    ``model``
        the model, a function of `dampyr.models.published._conversion`.
    ``length``
        the unit of length of the printed numbers: m, cm or mm.
    ``description``
        the equations, and what a reader should know first.
    ``letters``
        letter of the model -> letter or letters of the source, where they differ.
    ``printed``
        letter -> (number, unit) as printed; a unit that the source leaves out is inferred, and the notes say so.
    ``limits``
        the smallest and largest input, and ``limits_from`` where they come from.
    ``motion``
        a sine that the source runs.
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
    motion: SourceMotion
    model: str
    length: str
    description: str
    input: str = "V"
    notes: tuple[str, ...] = ()
    differs: Mapping[str, str] = field(default_factory=dict)
    letters: Mapping[str, str | list[str]] = field(default_factory=dict)

    @property
    def numbers(self) -> dict[str, float]:
        """letter -> the number as printed."""
        return {letter: number for letter, (number, _) in self.printed.items()}

    @property
    def eta(self) -> float | None:
        """The rate in 1/s of the first-order filter u' = -eta (u - V) between command and damper; None without one.

        The damper has it as the part ``lag``, tau = 1/eta.
        """
        return self.numbers.get("eta")

    @property
    def units(self) -> tuple[str, ...]:
        """The printed units, each once."""
        return tuple(dict.fromkeys(unit for _, unit in self.printed.values()))

    def damper(self) -> Damper:
        """The damper in SI, which says where it comes from."""
        laws = MODELS[self.model](PrintedSet(self.numbers, self.letters, LENGTHS[self.length]), self.limits)
        source = {"paper": self.paper, "where": self.where, "read": self.read, "device": self.device}
        source |= {"limits": self.limits_from}
        source["motion"] = (
            "no calibrated displacement or velocity is stated in what was read; it runs a sine of "
            f"{1e3 * self.motion.amplitude:g} mm at {self.motion.frequency:g} Hz"
        )
        if self.eta is not None:
            source["filter"] = (
                f"the source filters the command V first, u' = -{self.eta:g} (u - V): the part lag, tau = 1/eta"
            )
            laws["lag.tau"] = 1.0 / self.eta
        if self.differs:
            source["differs"] = "; ".join(f"{name}: {what}" for name, what in self.differs.items())
        parts = tuple(dict.fromkeys(name.partition(".")[0] for name in laws))
        return Damper(parts, laws, input=self.input, provenance=source, origin=DERIVED)


def read_sets(path: Path) -> dict[str, About]:
    """The sets of one file, by name: the file's own, or those of its tables ``sets``, which share all else."""
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    sets = table.pop("sets", {path.stem: {}})
    return {
        name: _read_set(table | of_set | {"printed": table["printed"] | of_set.get("printed", {})})
        for name, of_set in sets.items()
    }


def _read_set(table: dict[str, Any]) -> About:
    motion = dict(table["motion"])
    if "angular_frequency" in motion:
        motion["frequency"] = motion.pop("angular_frequency") / (2.0 * pi)
    read = {
        "motion": SourceMotion(motion["amplitude"], motion["frequency"], tuple(motion["inputs"])),
        "printed": {letter: (number, unit) for letter, (number, unit) in table["printed"].items()},
        "limits": tuple(table["limits"]),
        "notes": tuple(table["notes"]),
        "description": table["description"].strip(),
    }
    return About(**(table | read))
