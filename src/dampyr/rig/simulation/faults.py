"""Faults of the simulated rig and their times: ``stuck-encoder@12.5s for 3s``, ``lost-bytes=0.1@2s for 5s``."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from dampyr.config import unknown
from dampyr.errors import InputError
from dampyr.units import parse


@dataclass(frozen=True)
class Kind:
    """One kind of fault: its description, and the meaning of its number."""

    words: str
    amount: float | None = None
    unit: str = ""
    high: float = math.inf
    signed: bool = True  # whether the number may be negative


KINDS: dict[str, Kind] = {
    "lost-bytes": Kind("each byte of the serial wire, both ways, is lost with this probability", 0.1, "", 1.0, False),
    "unplugged-serial": Kind("nothing passes the serial wire"),
    "restarted-uno": Kind("the Uno restarts (power, watchdog)"),
    "uno-clock": Kind("the Uno's clock is slower by so much more; faster where it is negative", 3e3, "ppm", 9e5),
    "stuck-encoder": Kind("neither the Uno nor the board sees the encoder's pulses"),
    "stuck-encoder-uno": Kind("the Uno sees none of the encoder's pulses"),
    "stuck-encoder-board": Kind("the board sees none of the encoder's pulses"),
    "glitching-encoder": Kind("both lines of the encoder change at once, as the Uno sees them"),
    "swapped-encoder": Kind("the encoder's lines A and B are swapped: it counts the other way"),
    "slipped-encoder": Kind("the encoder's scale slips by this distance, at once", 1e-3, "m", 0.01),
    "inverted-cell": Kind("the load cell's two wires are swapped: the force has the other sign"),
    "emergency-stop": Kind("the emergency stop is pressed, where one is wired"),
    "broken-cell": Kind("the load cell's wire is broken: its input floats to this voltage", 10.0, "V", 10.0),
    "drifting-cell": Kind("the load cell's zero drifts at this rate", 50.0, "N/s"),
    "shunted-cell": Kind(
        "a shunt across the load cell's bridge is switched in: before its filter the force is more by this", 200.0, "N", 5e3
    ),
    "cell-clip": Kind("the load cell's amplifier saturates: its signal ends at this force, either way", 250.0, "N", 1e5, False),
    "cell-gain": Kind("the gain of the load cell's chain changes: it shows this share of the force", 0.9, "", 10.0, False),
    "cell-slow": Kind(
        "the load cell's amplifier grows slow: its bandwidth, and its noise's, falls to this", 20.0, "Hz", 1e5, False
    ),
    "dead-supply": Kind("the supply gives no voltage, whatever it is commanded"),
    "supply-stuck": Kind("the supply's voltage stands where it is, whatever it is commanded; its enable line cuts it still"),
    "supply-gain": Kind("the supply gives this share of what it is commanded", 0.8, "", 10.0, False),
    "open-coil": Kind("the coil's wire is broken: no current flows"),
    "stalled-motor": Kind("the motor does not turn"),
    "hot-specimen": Kind("the specimen, with its coil, is suddenly warmer by this difference", 60.0, "K"),
    "thermocouple-stuck": Kind("the thermocouple's reading stands where it is, whatever the specimen's temperature"),
    "board-timeout": Kind("the board's samples do not arrive: DAQmx error -200284"),
    "board-overrun": Kind("the board's buffer overflows: DAQmx error -200279"),
    "late-samples": Kind("each read of the board is delayed by this time on the wall clock", 0.5, "s", 60.0, False),
}  # fmt: skip
EXAMPLE = "write such as 'stuck-encoder@12.5s for 3s' or 'lost-bytes=0.1@2s'"
_FORM = re.compile(r"\s*(?P<kind>[\w-]+)\s*(=\s*(?P<amount>[^@]+?))?\s*@\s*(?P<at>.+?)(\s+for\s+(?P<time>.+?))?\s*")


@dataclass(frozen=True)
class FaultSpec:
    """A fault of the simulated rig: its kind, when it begins [s, simulated], how long it lasts [s], and its number."""

    kind: str
    at: float
    duration: float = math.inf
    amount: float | None = None

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(unknown(f"fault {self.kind!r}", self.kind, sorted(KINDS)))
        fault_kind = KINDS[self.kind]
        if not 0.0 <= self.at < math.inf:
            raise InputError(f"fault {self.kind}: begins at {self.at:g} s; give a time of 0 s or later")
        if not self.duration > 0.0:
            raise InputError(
                f"fault {self.kind}: lasts {self.duration:g} s; give more than 0 s, or leave it out for a permanent fault"
            )
        if self.amount is None:
            object.__setattr__(self, "amount", fault_kind.amount)
        elif fault_kind.amount is None:
            raise InputError(f"fault {self.kind} takes no number, but {self.amount:g} was given; leave it out")
        elif not abs(self.amount) <= fault_kind.high:
            raise InputError(
                f"fault {self.kind} = {self.amount:g} {fault_kind.unit} is not allowed; give at most {fault_kind.high:g}"
            )
        if self.size < 0.0 and not fault_kind.signed:
            raise InputError(f"fault {self.kind} = {self.size:g} must be 0 or more")

    @property
    def until(self) -> float:
        """Its end, s."""
        return self.at + self.duration

    @property
    def size(self) -> float:
        """Its number; 0 for a kind that has none."""
        return 0.0 if self.amount is None else self.amount

    @classmethod
    def parse(cls, text: str) -> FaultSpec:
        """A fault as typed, ``kind[=number]@time [for time]``; InputError says what is wrong with it."""
        match = _FORM.fullmatch(text)
        if match is None:
            raise InputError(f"fault {text!r} cannot be read; {EXAMPLE}")
        kind = match["kind"]
        if kind not in KINDS:
            raise InputError(unknown(f"fault {kind!r}", kind, sorted(KINDS)))
        try:
            at = parse(match["at"], "s")
            duration = parse(match["time"], "s") if match["time"] else math.inf
            amount = parse(match["amount"], KINDS[kind].unit) if match["amount"] else None
        except InputError as problem:
            raise InputError(f"fault {text!r}: {problem}; {EXAMPLE}") from None
        return cls(kind, at, duration, amount)

    def __str__(self) -> str:
        number = "" if self.amount is None else f"={self.amount:g}"
        return f"{self.kind}{number}@{self.at:g}s" + ("" if math.isinf(self.duration) else f" for {self.duration:g}s")
