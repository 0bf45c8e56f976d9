"""History of specimens, from the folders of their tests alone: tests, cards and verdicts of each serial number, and its trends.

A specimen is one where its name and the rig of its records are: equal names at different rigs are different specimens, and so
are those of records that state no rig in different folders.
"""

from __future__ import annotations

import json
import tomllib
import warnings
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.errors import DampyrError, DampyrWarning, InputError, MissingData
from dampyr.findings import Finding, Findings, handed_on
from dampyr.models import Damper
from dampyr.origin import Origin, combined
from dampyr.records.checks.overview import overview
from dampyr.records.cycle_analysis.cycle_table import cycle_table
from dampyr.records.files.campaign_folder import read_campaign
from dampyr.records.record import Record
from dampyr.shown import Shown
from dampyr.source_file import SourceFile

NOT_STATED = "not stated"


@dataclass(frozen=True)
class TrendPoint:
    """A test in a trend: when it began, its record, the mean force at peak velocity [N], half of the difference of both ways,
    and the mean energy of a cycle [J]."""

    started: str
    record: str
    force: float
    energy: float


@dataclass(frozen=True)
class SpecimenTrend:
    """Equal tests of a specimen over time: what they are, and a point each, the earliest first."""

    test: str
    points: tuple[TrendPoint, ...]

    @property
    def force_change(self) -> float:
        """The last force over the first, less 1."""
        return self.points[-1].force / self.points[0].force - 1.0

    @property
    def energy_change(self) -> float:
        """The last energy over the first, less 1."""
        return self.points[-1].energy / self.points[0].energy - 1.0


@dataclass(frozen=True)
class SpecimenHistory:
    """What the folders hold of a specimen: ``laboratory`` is the rig that its records state, or else their folder."""

    specimen: str
    laboratory: str
    complete: int
    incomplete: int
    dates: tuple[str, ...]
    sessions: tuple[str, ...]
    operators: tuple[str, ...]
    cards: tuple[str, ...]
    verdicts: tuple[str, ...]
    trends: tuple[SpecimenTrend, ...]


@dataclass(frozen=True, repr=False)
class SpecimenHistories(Shown):
    """The history of every specimen in some folders, and the origin and the findings of their records."""

    folders: tuple[str, ...]
    histories: tuple[SpecimenHistory, ...]
    origin: Origin
    findings: tuple[Finding, ...] | Findings

    def __len__(self) -> int:
        return len(self.histories)

    def __iter__(self) -> Iterator[SpecimenHistory]:
        return iter(self.histories)


def specimens(*folders: str | Path) -> SpecimenHistories:
    """The history of each specimen whose records lie in ``folders`` or in folders in them.

    Cards (TOML) and verdicts of ``dampyr accept --json`` beside the records count for the specimens that their origin names.

    Raises
    ------
    MissingData
        There is no such folder, or there are no records in it.
    """
    if not folders:
        raise InputError("specimens() needs a folder with records; give one or several")
    found: list[tuple[Path, Record]] = []
    stated: list[tuple[str, str, Origin]] = []  # "card" or "verdict", what it says, of what
    for root in map(Path, folders):
        if not root.is_dir():
            raise MissingData(f"{root}: there is no such folder; check the path")
        places = [root, *sorted(path for path in root.rglob("*") if path.is_dir() and not path.name.startswith("."))]
        for place in dict.fromkeys(places):
            found += [(place, record) for record in _records(place)]
            stated += [*_cards(place), *_verdicts(place)]
    if not found:
        raise MissingData(f"{', '.join(map(str, folders))}: no records there; give folders with records")
    groups: dict[tuple[str, str], list[Record]] = defaultdict(list)
    for place, record in found:
        groups[record.specimen or NOT_STATED, _rig_of(record) or str(place)].append(record)
    histories = tuple(_history(*key, records, stated) for key, records in sorted(groups.items()))
    records = [record for _, record in found]
    return SpecimenHistories(
        tuple(map(str, folders)),
        histories,
        combined(record.origin for record in records),
        Findings(lambda: handed_on(records)),
    )


def _records(folder: Path) -> list[Record]:
    """All records of a folder, incomplete ones too; none where it holds none, a warning where they cannot be read."""
    try:
        return read_campaign(folder, role=None, incomplete=True)
    except MissingData:
        return []
    except DampyrError as problem:
        warnings.warn(f"{folder}: left out: {problem}", DampyrWarning, stacklevel=3)
        return []


def _cards(folder: Path) -> Iterator[tuple[str, str, Origin]]:
    """The cards of dampers that lie in a folder."""
    for path in sorted(folder.glob("*.toml")):
        try:
            if "damper" in tomllib.loads(path.read_text("utf-8")):
                yield "card", path.name, Damper.load(path).origin
        except (tomllib.TOMLDecodeError, UnicodeDecodeError, OSError, DampyrError) as problem:
            warnings.warn(f"{path}: left out: {problem}", DampyrWarning, stacklevel=4)


def _verdicts(folder: Path) -> Iterator[tuple[str, str, Origin]]:
    """The verdicts of acceptance tests that lie in a folder as JSON."""
    for path in sorted(folder.glob("*.json")):
        try:
            answer = json.loads(path.read_text("utf-8"))
            if isinstance(answer, Mapping) and {"verdict", "origin"} <= answer.keys():
                yield "verdict", f"{answer['verdict']} ({path.name})", Origin.from_dict(answer["origin"])
        except (ValueError, OSError, DampyrError) as problem:
            warnings.warn(f"{path}: left out: {problem}", DampyrWarning, stacklevel=4)


def _rig_of(record: Record) -> str:
    """The name of the rig that a record states, or of its published data set; empty without either."""
    try:
        rig = json.loads(record.provenance.get("rig", "{}"))
    except ValueError:
        rig = {}
    name = str(rig.get("name", "")) if isinstance(rig, Mapping) else ""
    return name or ", ".join(data_set.name for data_set in record.origin.data_sets)


def _history(
    specimen: str, laboratory: str, records: list[Record], stated: Iterable[tuple[str, str, Origin]]
) -> SpecimenHistory:
    complete = [record for record in records if record.provenance.get("complete") != "no"]
    sources = {source for record in records for source in record.origin.sources}
    about: dict[str, list[str]] = {"card": [], "verdict": []}
    for kind, words, origin in stated:
        if _is_about(origin, specimen, sources):
            about[kind].append(words)
    return SpecimenHistory(
        specimen,
        laboratory,
        len(complete),
        len(records) - len(complete),
        _texts(_started(record)[:10] for record in records),
        _texts(record.measurement_session for record in records),
        _texts(record.provenance.get("operator") for record in records),
        tuple(about["card"]),
        tuple(about["verdict"]),
        _trends(complete),
    )


def _is_about(origin: Origin, specimen: str, sources: set[SourceFile]) -> bool:
    """Whether a card or a verdict is of these records: by their files, or by the specimen's name where it names no files."""
    if origin.sources:
        return bool({file.sha256 for file in origin.sources} & {file.sha256 for file in sources})
    return specimen in origin.specimens


def _texts(values: Iterable[Any]) -> tuple[str, ...]:
    return tuple(sorted({str(value) for value in values if value}))


def _started(record: Record) -> str:
    return str(record.provenance.get("started") or (record.origin.dates[0] if record.origin.dates else ""))


def _trends(records: Iterable[Record]) -> tuple[SpecimenTrend, ...]:
    """Equal tests that were made twice or more, at known times: of one stroke, frequency and input as measured or labelled."""
    equal: dict[str, list[TrendPoint]] = defaultdict(list)
    for record in records:
        label, started, value = record.label, _started(record), record.input_value
        if label is None or label.frequency_hz is None or not started or not overview(record).repeats:
            continue
        cycles = [cycle for cycle in cycle_table(record) if cycle.level]
        if not cycles:
            continue
        test = f"{1e3 * label.peak_to_peak_m:.4g} mm at {label.frequency_hz:.4g} Hz"
        test += "" if value is None else f", {value:.3g} {record.input}"
        force = float(np.mean([0.5 * (cycle.force_out - cycle.force_in) for cycle in cycles]))
        energy = float(np.mean([cycle.energy for cycle in cycles]))
        equal[test].append(TrendPoint(started, record.name, force, energy))
    return tuple(
        SpecimenTrend(test, tuple(sorted(points, key=lambda point: point.started)))
        for test, points in sorted(equal.items())
        if len(points) > 1
    )
