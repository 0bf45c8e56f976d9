"""Judgement of specimens by criteria: every level that their campaigns asked, from the folders alone.

The levels are the tests of a campaign that command cycles of full amplitude (`SteadyCycles`), as its journal has them, so that
a test that was never run is known too; the cycles are those that the records state.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, fields
from math import inf
from pathlib import Path
from typing import Annotated, Any

from dampyr.campaigns.journal import NAME, Journal, JournalEntry
from dampyr.campaigns.kinds import kind as kind_of
from dampyr.campaigns.recorded_campaign import RecordedCampaign
from dampyr.campaigns.recorded_tests import entries_with_files, file_of
from dampyr.campaigns.step import Frequency, Length, Volts, words
from dampyr.config import fill, load_toml, parse_toml
from dampyr.errors import FileError, InputError
from dampyr.findings import Finding, handed_on, worst_first
from dampyr.identification.acceptance_tests.acceptance import Verdict
from dampyr.identification.acceptance_tests.device_criteria import (
    QUANTITIES,
    SAME_AMPLITUDE,
    Criterion,
    CriterionVerdict,
    RequiredLevel,
    judge_level,
    read_criteria,
)
from dampyr.origin import Origin, combined
from dampyr.records import Record, read
from dampyr.records.cycle_analysis.device_figures import STEADY_CYCLES, SteadyCycles, device_figures
from dampyr.shown import Shown
from dampyr.units import Quantity

SAME = 1e-3  # relative: a level of the design is one that was asked
STATES = {"planned": "was not run", "running": "was interrupted", "gone": "has no file", "broken": "has a broken file"}


@dataclass(frozen=True)
class DesignLevel:
    """A ``[[level]]`` of a design: its amplitude, where levels differ in them its voltage and frequency, and the design's
    values."""

    amplitude: Annotated[float, Length, "amplitude of the level"]
    voltage: Annotated[float | None, Volts, "voltage at the coil; none: all of them"] = None
    frequency: Annotated[float | None, Frequency, "cycles per second; none: all of them"] = None
    largest_force: Annotated[float | None, Quantity("N", low=0.0), "largest force"] = None
    energy: Annotated[float | None, Quantity("J", low=0.0), "energy of a cycle"] = None
    effective_stiffness: Annotated[float | None, Quantity("N/m", low=0.0), "effective stiffness"] = None
    characteristic_strength: Annotated[float | None, Quantity("N", low=0.0), "characteristic strength"] = None
    damping_ratio: Annotated[float | None, Quantity("", low=0.0), "equivalent damping ratio"] = None

    def fits(self, step: Any) -> bool:
        """Whether it is the level of a step."""
        return all(
            wanted is None or abs(getattr(step, name, inf) - wanted) <= SAME * wanted
            for name in ("amplitude", "voltage", "frequency")
            for wanted in [getattr(self, name)]
        )

    @property
    def values(self) -> dict[str, float]:
        """The design's values that it states, SI."""
        return {name: getattr(self, name) for name in QUANTITIES if getattr(self, name) is not None}


@dataclass(frozen=True)
class LevelVerdict:
    """A level that was asked: the test of that name, ``words`` of what it does, ``asked`` cycles and how many were ``run``; the
    criteria on its cycles, and in sentences what could not be judged. ``record`` is None where no complete one is there."""

    test: str
    words: str
    amplitude: float
    asked: int
    run: int
    cycles: tuple[CriterionVerdict, ...]
    unjudged: tuple[str, ...]
    record: Record | None = field(default=None, repr=False, compare=False)

    @property
    def verdict(self) -> Verdict:
        """Failed where a criterion does not hold; passed where all were judged and hold."""
        if any(not cycle.holds for cycle in self.cycles):
            return "failed"
        return "not judged" if self.unjudged or not self.cycles else "passed"


@dataclass(frozen=True)
class SpecimenVerdict:
    """A specimen: the levels that its campaign asked, in their order, and the names of its tests that are no level."""

    specimen: str
    folder: Path
    levels: tuple[LevelVerdict, ...]
    beside: tuple[str, ...] = ()

    @property
    def verdict(self) -> Verdict:
        """Failed where a level failed; passed where every level did."""
        return worst_of(level.verdict for level in self.levels)

    @property
    def worst(self) -> tuple[LevelVerdict, CriterionVerdict] | None:
        """The cycle that takes most of the way to a limit, and its level; None where nothing was judged."""
        rows = [(level, cycle) for level in self.levels for cycle in level.cycles]
        return max(rows, key=lambda row: row[1].used, default=None)


@dataclass(frozen=True, repr=False)
class JudgedSpecimens(Shown):
    """Result of `judge`: the specimens, in the order of their folders, by the criteria of that ``name``.

    ``findings`` are what is wrong or in doubt in their records.
    """

    name: str
    criteria: tuple[Criterion, ...]
    specimens: tuple[SpecimenVerdict, ...]
    origin: Origin
    findings: tuple[Finding, ...] = ()

    @property
    def verdict(self) -> Verdict:
        """Failed where a specimen failed; passed where every one did."""
        return worst_of(specimen.verdict for specimen in self.specimens)


def worst_of(verdicts: Iterable[Verdict]) -> Verdict:
    """The verdict of all: failed where one is, else not judged where one is, else passed."""
    known = set(verdicts)
    order: tuple[Verdict, ...] = ("failed", "not judged", "passed")
    return next(verdict for verdict in order if verdict in known)


Folders = str | Path | RecordedCampaign | Sequence[str | Path | RecordedCampaign]


def judge(
    folders: Folders, criteria: str | Path | Sequence[Criterion], design: str | Path | Sequence[DesignLevel] = ()
) -> JudgedSpecimens:
    """Judge specimens by criteria on every cycle of every level that their campaigns asked.

    A specimen passes when every level was run to its end with its cycles and every criterion holds on them, fails when one does
    not hold, and is else not judged, with the reasons. A record in which something is wrong is not judged.

    Parameters
    ----------
    folders
        one folder of a campaign that dampyr ran, or several; a folder is a specimen.
    criteria
        a shipped name such as "ntc_2018_viscous", the path of a file like the template, or the criteria themselves.
    design
        the design's values, for criteria that refer to them: the path of a TOML file of ``[[level]]`` tables, or the levels.

    Returns
    -------
    JudgedSpecimens
        a verdict for each specimen, each level and each cycle.

    Raises
    ------
    InputError
        a folder without a journal or without a level, a level of the design that no campaign asked, or two that fit one.
    FileError
        the file of the criteria or of the design is wrong.

    Examples
    --------
    >>> import dampyr as dp
    >>> step = {"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz", "voltage": "1.98 V", "cycles": 3}
    >>> campaign = dp.campaigns.campaign_of({"name": "one", "operator": "me", "step": [step]})
    >>> with dp.rig.simulated() as rig:
    ...     folder = dp.campaigns.perform(campaign, rig, "specimen 1").folder
    >>> dp.campaigns.judge(folder, "ntc_2018_viscous").verdict  # no value of the design for its largest force
    'not judged'
    """
    rows = tuple(read_criteria(criteria) if isinstance(criteria, str | Path) else criteria)
    levels = read_design(design) if isinstance(design, str | Path) else tuple(design)
    several = [folders] if isinstance(folders, str | Path | RecordedCampaign) else list(folders)
    paths = [folder.folder if isinstance(folder, RecordedCampaign) else Path(folder) for folder in several]
    if not rows or not paths:
        raise InputError("there is nothing to judge, or nothing to judge by; give a folder and a criterion at least")
    campaigns = [_read_levels(path) for path in paths]
    for level in levels:
        if not any(level.fits(step) for tests in campaigns for _, _, step in tests.levels):
            raise InputError(
                f"no campaign asks the design's level of {1e3 * level.amplitude:.6g} mm; give amplitude, voltage "
                "and frequency of a test, or leave it out"
            )
    specimens = tuple(_judge_folder(tests, rows, levels) for tests in campaigns)
    records = [[level.record for level in specimen.levels if level.record] for specimen in specimens]
    sources = [specimen.specimen if len(specimens) > 1 else "" for specimen in specimens]
    findings = worst_first(*(handed_on(group, source) for group, source in zip(records, sources, strict=True)))
    origins = [record.origin for group in records for record in group] or [tests.origin for tests in campaigns]
    name = str(criteria) if isinstance(criteria, str | Path) else "criteria from Python"
    return JudgedSpecimens(name, rows, specimens, combined(origins), findings)


def read_design(path: str | Path) -> tuple[DesignLevel, ...]:
    """The design's levels in a TOML file of ``[[level]]`` tables; FileError where it is something else."""
    table = load_toml(path)
    rows = table.get("level")
    if set(table) != {"level"} or not isinstance(rows, list) or not rows:
        raise FileError(
            Path(path), 'needs tables [[level]] and nothing else, such as amplitude = "4 mm", energy = "30 J"'
        )
    try:
        return tuple(fill(DesignLevel, row, f"level {k + 1}") for k, row in enumerate(rows))
    except InputError as problem:
        raise FileError(Path(path), str(problem)) from None


@dataclass(frozen=True)
class _CampaignLevels:
    """What a folder's journal says of its campaign: the tests that are levels, with kind and step, the others, and what to call
    the specimen where no record says it."""

    folder: Path
    entries: dict[str, JournalEntry]
    levels: list[tuple[str, str, Any]]
    beside: tuple[str, ...]
    origin: Origin
    specimen: str


def _read_levels(folder: Path) -> _CampaignLevels:
    if not (folder / NAME).is_file():
        raise InputError(f"{folder} has no {NAME}; give the folder of a campaign that dampyr ran")
    with closing(Journal(folder)) as journal:
        entries = {entry.name: entry for entry in entries_with_files(journal.tests(), folder)}
        contents, origin = journal.get_metadata("contents"), journal.origin
        stated = parse_toml(journal.get_metadata("source")).get("specimen", "")
        rig = json.loads(journal.get_metadata("rig") or "{}")
    levels, beside = [], []
    for name, kind, table in json.loads(contents or "[]"):
        step = _step(kind, table)
        if step is None:
            beside.append(name)
        else:
            levels.append((name, kind, step))
    if not levels:
        raise InputError(
            f"{folder}: no test of its campaign has cycles to judge, or its journal does not say; run a sine, or a "
            "quasi_static of at least 2 cycles"
        )
    specimen = stated or rig.get("specimen", {}).get("name", "") or folder.name
    return _CampaignLevels(folder, entries, levels, tuple(beside), origin, specimen)


def _step(kind: str, table: Mapping[str, Any]) -> Any:
    """The step of a test with steady cycles; None of any other."""
    cls = kind_of(kind)
    if not hasattr(cls, "steady_cycles"):
        return None
    step = cls(**{field.name: table[field.name] for field in fields(cls) if field.name in table})
    return step if step.steady_cycles else None


def _judge_folder(
    tests: _CampaignLevels, criteria: Sequence[Criterion], design: Sequence[DesignLevel]
) -> SpecimenVerdict:
    levels = tuple(_judge_test(tests, name, kind, step, criteria, design) for name, kind, step in tests.levels)
    names = {level.record.specimen for level in levels if level.record and level.record.specimen}
    if len(names) > 1:
        raise InputError(
            f"{tests.folder} has records of several specimens, {', '.join(sorted(names))}; run each into its own"
        )
    return SpecimenVerdict(names.pop() if names else tests.specimen, tests.folder, levels, tests.beside)


def _judge_test(
    tests: _CampaignLevels,
    name: str,
    kind: str,
    step: Any,
    criteria: Sequence[Criterion],
    design: Sequence[DesignLevel],
) -> LevelVerdict:
    asked: SteadyCycles = step.steady_cycles
    about = name, words(kind, step), step.amplitude, asked.count
    entry = tests.entries.get(name)
    if entry is None or entry.state != "complete":
        state = STATES.get(entry.state, entry.state) if entry else STATES["planned"]
        return LevelVerdict(
            *about, 0, (), (f"the test {state}" + (f": {entry.reason}" if entry and entry.reason else ""),)
        )
    record = read(file_of(tests.folder, name, entry.attempt))
    wrong = [finding.words for finding in record.findings if finding.severity == "wrong"]
    if wrong:
        return LevelVerdict(*about, 0, (), (f"its record cannot be used: {'; '.join(wrong)}",), record)
    if STEADY_CYCLES not in record.provenance:
        reason = "its record does not state its steady cycles, as records of before version 0.4 do not; record it again"
        return LevelVerdict(*about, 0, (), (reason,), record)
    try:
        cycles = device_figures(record)
    except InputError as problem:
        return LevelVerdict(*about, 0, (), (str(problem),), record)
    farthest = max(cycles, key=lambda cycle: abs(cycle.amplitude - step.amplitude))
    if abs(farthest.amplitude - step.amplitude) > SAME_AMPLITUDE * step.amplitude:
        reason = f"{1e3 * farthest.amplitude:.3g} mm were reached of {1e3 * step.amplitude:.3g} mm in cycle {farthest.number}"
        return LevelVerdict(*about, len(cycles), (), (reason,), record)
    fitting = [level for level in design if level.fits(step)]
    if len(fitting) > 1:
        raise InputError(f"{len(fitting)} levels of the design fit {about[1]}; give them voltage or frequency")
    values = fitting[0].values if fitting else {}
    rows, reasons = judge_level(cycles, criteria, RequiredLevel(step.amplitude, asked.count, values))
    if len(cycles) < asked.count:
        reasons.insert(0, f"{asked.count} cycles are asked, its record has {len(cycles)}; run the test again")
    return LevelVerdict(*about, len(cycles), tuple(rows), tuple(reasons), record)
