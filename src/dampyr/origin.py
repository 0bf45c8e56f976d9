"""Origin of records, of dampers and of what is made of them: its kind, and by whom, of what, when and from which files.

The kind *measured* is only what the driver of a real instrument has read; *simulated* is of a rig, or a board, that is a model;
*virtual* is computed without any rig; *derived* comes from published numbers or somebody else's fit, not from records at
hand. What a file or an array does not say is *not stated*. Every page, table, figure and export of what is simulated or
virtual says so by `Origin.notice`.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields, replace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol, get_args

from dampyr.config import fill
from dampyr.errors import InputError
from dampyr.phrases import listing
from dampyr.source_digest import full_version
from dampyr.source_file import SHOWN_DIGITS, SourceFile

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OriginKind = Literal["measured", "simulated", "virtual", "derived", "not stated"]
ORIGIN_KINDS: tuple[OriginKind, ...] = get_args(OriginKind)

NOTICES: Mapping[str, str] = {
    "simulated": "SIMULATED: based on a simulated test rig, not on measurements",
    "virtual": "VIRTUAL: based on a test without a rig, not on measurements",
}
SIMULATED_SERIAL = "01A2B3C4"  # of the NI board whose other end is the simulated rig
MIXED_FITS = "mixed_origins=True (--mixed-origins)"  # how a fit of records of both kinds is asked for
FEW = 6  # names of operators, specimens or sessions that a page lists one by one
DAY = len("2026-03-01")  # of a date with a time of day


@dataclass(frozen=True, order=True)
class PublishedData:
    """A published data set that a file belongs to: its ``name`` (`dampyr.records.datasets`), DOI, licence and version."""

    name: str
    doi: str = ""
    licence: str = ""
    version: str = ""

    def __str__(self) -> str:
        stated = [text for text in (self.doi and f"doi:{self.doi}", self.version, self.licence) if text]
        return f"{self.name} ({', '.join(stated)})" if stated else self.name


@dataclass(frozen=True)
class Origin:
    """Where records, and what is made of them, come from.

    Parameters
    ----------
    kind
        "measured", "simulated", "virtual", "derived" or "not stated".
    sources
        The files, each with its SHA-256.
    operators, specimens, sessions
        Who tested, which dampers, and in which measurement sessions, as far as it is stated.
    dates
        Days of the tests, such as "2026-03-01".
    data_sets
        The published data sets that the files belong to.
    versions
        Of dampyr, with the digest of its sources, each that had part in it.
    """

    kind: OriginKind = "not stated"
    sources: tuple[SourceFile, ...] = ()
    operators: tuple[str, ...] = ()
    specimens: tuple[str, ...] = ()
    sessions: tuple[str, ...] = ()
    dates: tuple[str, ...] = ()
    data_sets: tuple[PublishedData, ...] = ()
    versions: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.kind not in ORIGIN_KINDS:
            raise InputError(f"origin = {self.kind!r} is not known; choose from {', '.join(ORIGIN_KINDS)}")

    def as_dict(self) -> dict[str, Any]:
        """Kind, files (name, sha256), operators, specimens, sessions, dates, data sets (name, doi, licence), versions."""
        return {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(self).items()}

    @classmethod
    def from_dict(cls, table: Mapping[str, Any]) -> Origin:
        """The inverse of `as_dict`; InputError for what is not an origin's."""
        lists = {name: value for name, value in table.items() if name != "kind"}
        return replace(fill(cls, lists, "origin"), kind=table.get("kind", NOT_STATED.kind))

    def as_json(self) -> str:
        """`as_dict` as text, for an attribute of a file."""
        return json.dumps(self.as_dict())

    @classmethod
    def from_json(cls, text: str) -> Origin:
        """The inverse of `as_json`; dampyr up to 0.3.0 wrote the kind alone."""
        return as_origin(text) if text in ORIGIN_KINDS else cls.from_dict(json.loads(text))

    @property
    def notice(self) -> str:
        """What the first line of a page, table or export says; empty unless it is simulated or virtual."""
        return NOTICES.get(self.kind, "")

    @property
    def series(self) -> str:
        """What a figure calls the curve of a record: "measured" unless it is simulated or virtual."""
        return self.kind if self.notice else "measured"

    def stamp(self, figure: Figure) -> Figure:
        """Write what `notice` begins with across a figure, once; the figure."""
        word, _, _ = self.notice.partition(":")
        if word and all(text.get_text() != word for text in figure.texts):
            figure.text(0.5, 0.5, word, size=40, color="#79828c", alpha=0.3, rotation=20, ha="center", va="center")
        return figure

    def facts(self) -> dict[str, str]:
        """What is stated, as a page and the head of an export list it: name -> value."""
        dates = [self.dates[0], self.dates[-1]] if len(self.dates) > 2 else self.dates
        stated = {
            "origin": [] if self.kind == "not stated" else [self.kind],
            "operator": self.operators,
            "specimen": self.specimens,
            "session": self.sessions,
            "tested": [" to ".join(dates)] if dates else [],
            "data set": [str(data_set) for data_set in self.data_sets],
            "earlier versions": [f"dampyr {version}" for version in self.versions if version != full_version()],
        }
        return {name: listing(values, FEW) for name, values in stated.items() if values}

    def in_words(self) -> str:
        """`facts` and the first of the files in one line, for the comment of an export; empty where nothing is stated."""
        files = [f"{file.name} (SHA-256 {file.sha256[:SHOWN_DIGITS]})" for file in self.sources]
        stated = self.facts() | ({"files": listing(files, FEW)} if files else {})
        return "; ".join(f"{name}: {value}" for name, value in stated.items())


NOT_STATED = Origin()
SIMULATED = Origin("simulated")
VIRTUAL = Origin("virtual")
DERIVED = Origin("derived")


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


def as_origin(value: Any) -> Origin:
    """An `Origin` of which only the kind is stated, or one as it is; InputError for anything else."""
    return value if isinstance(value, Origin) else Origin(value)


def of_board(identity: str) -> Origin:
    """What the identity of a board tells, also in records of before their origin was written."""
    return SIMULATED if "simulated" in identity.lower() or SIMULATED_SERIAL in identity else NOT_STATED


def combined(origins: Iterable[Origin]) -> Origin:
    """The origin of what this dampyr makes of several.

    Its kind is simulated or virtual where that of one of them is, else theirs where all agree, else not stated; files, people,
    specimens, sessions, dates, data sets and versions are those of all.
    """
    parts = list(origins)
    kinds = {part.kind for part in parts}
    unreal: list[OriginKind] = [kind for kind in ("simulated", "virtual") if kind in kinds]
    kind = unreal[0] if unreal else kinds.pop() if len(kinds) == 1 else "not stated"
    lists = {
        field.name: tuple(sorted({value for part in parts for value in getattr(part, field.name)}))
        for field in fields(Origin)
        if field.name not in ("kind", "versions")
    }
    versions = dict.fromkeys([*(version for part in parts for version in part.versions), full_version()])
    return Origin(kind, **lists, versions=tuple(versions))


def check_one_kind(records: Iterable[Source]) -> None:
    """Refuse records of which some are simulated or virtual, and others are not or do not say."""
    unreal, others = list[Source](), list[Source]()
    for record in records:
        (unreal if record.origin.notice else others).append(record)
    if unreal and others:
        raise InputError(
            f"{_some(unreal)} and {_some(others)} are not fitted together, for the fit would be of neither; "
            f"fit them apart, or ask for it by name: {MIXED_FITS}"
        )


def _some(records: list[Source]) -> str:
    words = " or ".join(dict.fromkeys(record.origin.kind for record in records))
    return f"{listing([record.name for record in records], 2)} ({words})"
