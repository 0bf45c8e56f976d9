"""Origin of records, of dampers and of what is made of them: measured, simulated, virtual, derived or not stated.

*measured* is only what the driver of a real instrument has read; *simulated* is of a rig, or a board, that is a model;
*virtual* is computed without any rig; *derived* comes from published numbers or somebody else's fit, not from records at
hand. What a file or an array does not say is *not stated*. Every page, table, figure and export of what is simulated or
virtual says so by `notice`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol, get_args

from dampyr.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Origin = Literal["measured", "simulated", "virtual", "derived", "not stated"]
MEASURED: Origin = "measured"
SIMULATED: Origin = "simulated"
VIRTUAL: Origin = "virtual"
DERIVED: Origin = "derived"
NOT_STATED: Origin = "not stated"
ORIGINS: tuple[Origin, ...] = get_args(Origin)

NOTICES: Mapping[str, str] = {
    SIMULATED: "SIMULATED: based on a simulated test rig, not on measurements",
    VIRTUAL: "VIRTUAL: based on a test without a rig, not on measurements",
}
SIMULATED_SERIAL = "01A2B3C4"  # of the NI board whose other end is the simulated rig
MIXED_FITS = "mixed_origins=True (--mixed-origins)"  # how a fit of records of both kinds is asked for


class Source(Protocol):
    """What has a name and an origin, such as a record."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def origin(self) -> Origin:
        """Its origin."""


class Named(NamedTuple):
    """A `Source` that is not there yet."""

    name: str
    origin: Origin


def as_origin(text: Any) -> Origin:
    """One of `ORIGINS`, or an :class:`~dampyr.errors.InputError`."""
    if text not in ORIGINS:
        raise InputError(f"origin = {text!r} is not known; choose from {', '.join(ORIGINS)}")
    origin: Origin = text
    return origin


def of_board(identity: str) -> Origin:
    """What the identity of a board tells, also in records of before their origin was written."""
    return SIMULATED if SIMULATED in identity.lower() or SIMULATED_SERIAL in identity else NOT_STATED


def combined(origins: Iterable[Origin]) -> Origin:
    """The origin of what is made of several: simulated or virtual where one of them is, else theirs where all agree."""
    given = set(origins)
    for unreal in (SIMULATED, VIRTUAL):
        if unreal in given:
            return unreal
    return given.pop() if len(given) == 1 else NOT_STATED


def notice(origin: Origin) -> str:
    """What the first line of a page or a table says of an origin; empty unless it is simulated or virtual."""
    return NOTICES.get(origin, "")


def series(origin: Origin) -> str:
    """What a figure calls the curve of a record: "measured" unless it is simulated or virtual."""
    return origin if notice(origin) else MEASURED


def check_one_kind(records: Iterable[Source]) -> None:
    """Refuse records of which some are simulated or virtual, and others are not or do not say."""
    unreal, others = list[Source](), list[Source]()
    for record in records:
        (unreal if notice(record.origin) else others).append(record)
    if unreal and others:
        raise InputError(
            f"{_some(unreal)} and {_some(others)} are not fitted together, for the fit would be of neither; "
            f"fit them apart, or ask for it by name: {MIXED_FITS}"
        )


def stamp(figure: Figure, origin: Origin) -> Figure:
    """Write what `notice` begins with across a figure, once; the figure."""
    word, _, _ = notice(origin).partition(":")
    if word and all(text.get_text() != word for text in figure.texts):
        figure.text(0.5, 0.5, word, size=40, color="#79828c", alpha=0.3, rotation=20, ha="center", va="center")
    return figure


def _some(records: list[Source]) -> str:
    more = f" and {len(records) - 2} more" if len(records) > 2 else ""
    words = " or ".join(dict.fromkeys(record.origin for record in records))
    return f"{', '.join(record.name for record in records[:2])}{more} ({words})"
