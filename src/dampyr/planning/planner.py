"""The loop of a plan: propose, perform, fit, judge, and stop with a reason.

A folder holds one round of tests after the other, each a campaign of its own that goes on where it stopped, and beside it what
was expected of it::

    plan.json           what is planned for; another plan is refused in this folder
    round-01/           campaign.toml, expected.json, and the records and the journal of `dampyr.campaigns.perform`
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.campaigns.campaign import read
from dampyr.campaigns.force_prediction import specimen
from dampyr.campaigns.performing import Watcher, perform
from dampyr.campaigns.run_control import RunControl
from dampyr.errors import InputError
from dampyr.findings import Finding
from dampyr.identification import Fit
from dampyr.input_kinds import NO_INPUT
from dampyr.models import Damper
from dampyr.options import takes
from dampyr.origin import Named, Origin, check_one_kind
from dampyr.planning.expected_information import LEARNED_FROM, layout
from dampyr.planning.goal import is_named, peak_goal, peak_half_of_fit
from dampyr.planning.proposal import PlanOptions, Proposal, fitted, propose
from dampyr.records import Record, read_campaign
from dampyr.rig import Rig
from dampyr.shown import Shown
from dampyr.to_json import plain

Progress = Callable[[str, float], None]
PLAN, CAMPAIGN, EXPECTED = "plan.json", "campaign.toml", "expected.json"
SCHEMA = 1
BY_DEFAULT = 12  # tests at most, where there is neither number, duration nor target
ROUND = 4  # tests between two looks at the records
NO_GAIN = 0.02  # by which a round must be expected to improve what is aimed at


@dataclass(frozen=True, repr=False)
class Round(Shown):
    """One round: its tests, and the half widths of 95 % intervals over the values by coefficient, as expected before it and as
    the fit to all records gave them after it."""

    number: int
    folder: Path
    tests: tuple[str, ...]
    duration: float
    expected: Mapping[str, float]
    achieved: Mapping[str, float]
    peak_expected: float | None = None
    peak_achieved: float | None = None

    @property
    def ratios(self) -> dict[str, float]:
        """What was achieved over what was expected, by coefficient, where both are intervals."""
        return {
            label: half / promised
            for label, half in self.achieved.items()
            for promised in (self.expected.get(label),)
            if promised and np.isfinite(promised) and np.isfinite(half)
        }


@dataclass(frozen=True, eq=False, repr=False)
class Planned(Shown):
    """The outcome of a plan: its rounds, the fit to all records, and why it stopped; ``reached``: the targets are met."""

    folder: Path
    rounds: tuple[Round, ...]
    fit: Fit
    reached: bool
    reason: str
    goal: str

    @property
    def origin(self) -> Origin:
        """That of all records together."""
        return self.fit.origin

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Those of the fit to all records."""
        return self.fit.findings


@takes(PlanOptions)
def plan_and_perform(
    evidence: Damper | Fit | Record | Sequence[Record] | None,
    rig: Rig,
    folder: str | Path,
    options: PlanOptions | None = None,
    per_round: int = ROUND,
    progress: Progress = lambda stage, done: None,
    watcher: Watcher | None = None,
    control: RunControl | None = None,
    **given: Any,
) -> Planned:
    """Propose, perform and fit, round after round, until the answer is known well enough; goes on where it stopped.

    Parameters
    ----------
    evidence
        As in `propose`; the records take part in every fit. None: the card that the rig names.
    rig
        A connected rig, real or simulated; each round is a campaign that is checked as a whole before anything moves.
    folder
        Where the rounds go. A plan that was begun there goes on; another one is refused.
    options
        As in `propose`. ``tests`` and ``duration`` are those of all rounds together; without these and
        without a target there are twelve tests.
    per_round
        How many tests are performed before the records are looked at.
    progress
        Called with what is being done, and the fraction of it that is done.
    watcher, control
        Those of `dampyr.campaigns.perform`.

    Returns
    -------
    Planned
        also where the targets are not reached: ``reached`` and ``reason`` say so.

    Raises
    ------
    InputError
        nothing is known of the damper, another plan in this folder, or what `propose` and `dampyr.campaigns.perform` refuse.
    """
    options = PlanOptions.of("plan_and_perform", options, given)
    options.check_goal()
    if per_round < 1:
        raise InputError(f"per_round = {per_round} is not allowed; give at least 1 test")
    evidence = specimen(rig.settings, rig.folder) if evidence is None else evidence
    evidence, model = _start(evidence, options, progress)
    options = replace(options, model=model)
    if isinstance(evidence, Fit) and not options.mixed_origins:
        check_one_kind([*evidence.records, Named(f"the tests of the rig {rig.settings.name!r}", rig.origin)])
    folder = Path(folder)
    loop = _Loop(evidence, rig, folder, options, per_round, progress, watcher, control)
    loop.begin()
    return loop.run()


def _start(evidence: Any, options: PlanOptions, progress: Progress) -> tuple[Damper | Fit, str]:
    """What is known, as a damper or a fit, and the model of the fits to come."""
    if evidence is None:
        raise InputError("nothing is known of the damper, not even a card; give a card or records")
    if not isinstance(evidence, Damper | Fit):
        evidence = fitted(evidence, options, progress)
    composition = evidence.composition if isinstance(evidence, Damper) else evidence.problem.composition
    parts = [name for name in composition.names if name != "lag"]
    return evidence, options.model or " + ".join(parts)


@dataclass
class _Loop:
    """One plan under way."""

    evidence: Damper | Fit
    rig: Rig
    folder: Path
    options: PlanOptions
    per_round: int
    progress: Progress
    watcher: Watcher | None
    control: RunControl | None
    first: Proposal | None = None  # made before there is a folder, so that a refusal leaves nothing behind

    @property
    def identity(self) -> dict[str, Any]:
        """What makes this plan another one than the next."""
        arguments = {
            f.name: getattr(self.options, f.name)
            for f in fields(self.options)
            if f.name not in ("peak", "mixed_origins")
        }
        peak = self.options.peak
        arguments["peak"] = None if peak is None else [peak.words, float(np.sum(np.square(peak.motion.acceleration)))]
        names = [record.name for record in self.evidence.records] if isinstance(self.evidence, Fit) else []
        arguments |= {"schema": SCHEMA, "per_round": self.per_round, "records": names}
        plain_text: dict[str, Any] = json.loads(json.dumps(plain(arguments)))
        return plain_text

    def begin(self) -> None:
        """Begin the folder, or go on with it; :class:`InputError` where it holds another plan or something else."""
        path = self.folder / PLAN
        if path.is_file():
            try:
                saved = json.loads(path.read_text("utf-8"))
            except ValueError:
                raise InputError(f"{path} cannot be read; choose another folder") from None
            wanted = self.identity
            differ = [name for name in wanted if saved.get(name) != wanted[name]]
            if differ:
                raise InputError(
                    f"{self.folder} holds another plan, which differs in {', '.join(differ)}; choose another folder, or repeat "
                    "its arguments to go on with it"
                )
            return
        if self.folder.is_dir() and any(self.folder.iterdir()):
            raise InputError(f"{self.folder} is not empty and holds no plan; choose another folder")
        self.first = self._propose(self.evidence, [])  # refuses what cannot be planned before there is a folder
        self.folder.mkdir(parents=True, exist_ok=True)
        write_whole(path, json.dumps(self.identity, indent=2) + "\n")

    @property
    def max_tests(self) -> int | None:
        """Tests of all rounds together, None where only time or a target ends them."""
        o = self.options
        if o.tests is not None:
            return o.tests
        return None if o.aimed or o.duration is not None else BY_DEFAULT

    def _propose(self, evidence: Damper | Fit, rounds: list[Round]) -> Proposal:
        """The next round, with the tests and the s of them that are left."""
        number, duration = self.per_round, self.options.duration
        if self.max_tests is not None:
            number = min(number, self.max_tests - sum(len(performed.tests) for performed in rounds))
        if duration is not None:
            duration -= sum(performed.duration for performed in rounds)
        options = replace(self.options, tests=number, duration=duration)
        return propose(evidence, self.rig.settings, options, self.progress)

    def run(self) -> Planned:
        """All rounds."""
        rounds: list[Round] = []
        evidence: Damper | Fit = self.evidence
        while True:
            number = len(rounds) + 1
            folder = self.folder / f"round-{number:02d}"
            if not (folder / CAMPAIGN).is_file():
                reason, reached = self._decide(evidence, rounds)
                proposal = None if reason else self._propose_unless_out_of_time(evidence, rounds)
                if proposal is None:
                    reason = reason or "what is left of the duration is too short for another test"
                elif rounds and self._gains_little(proposal):
                    reason = f"another round is expected to improve the intervals by less than {100 * NO_GAIN:g} %"
                if reason or proposal is None:
                    if not isinstance(evidence, Fit):
                        raise InputError(f"nothing was performed: {reason}")
                    return Planned(self.folder, tuple(rounds), evidence, reached, reason, self.options.aim)
                self._write_round(folder, proposal)
            perform(folder / CAMPAIGN, self.rig, folder, self.watcher, self.control)
            evidence = self._fit_all(number)
            rounds.append(self._record_round(number, folder, evidence))

    def _propose_unless_out_of_time(self, evidence: Damper | Fit, rounds: list[Round]) -> Proposal | None:
        """The next round; None where no candidate fits into what is left of the duration."""
        if not rounds and self.first is not None:
            return self.first
        try:
            return self._propose(evidence, rounds)
        except InputError as problem:
            if self.options.duration is not None and str(problem).startswith("duration ="):
                return None
            raise

    def _write_round(self, folder: Path, proposal: Proposal) -> None:
        """The promise first: a round with a campaign has it."""
        folder.mkdir(exist_ok=True)
        promise = {
            "half_width": dict(proposal.after),
            "peak_half_width": proposal.peak_after,
            "duration_s": proposal.duration,
        }
        write_whole(folder / EXPECTED, json.dumps(plain(promise), indent=2) + "\n")
        write_whole(folder / CAMPAIGN, proposal.text)

    @property
    def _has_input(self) -> bool:
        """Whether the damper has an input; where it has none the coil of the rig stays off, and no record has a voltage."""
        known = self.evidence
        return known.has_input if isinstance(known, Damper) else known.residuals.unit != NO_INPUT

    def _fit_all(self, last: int) -> Fit:
        """The fit to the records that were known and those of all rounds so far."""
        records = list(self.evidence.records) if isinstance(self.evidence, Fit) else []
        for number in range(1, last + 1):
            for record in read_campaign(self.folder / f"round-{number:02d}", role="fit", no_input=not self._has_input):
                name = f"round {number}, {record.name}"
                records.append(record.replace(note=f"named {name} among the rounds of a plan", name=name))
        return fitted(records, self.options, self.progress)

    def _record_round(self, number: int, folder: Path, evidence: Fit) -> Round:
        promise = json.loads((folder / EXPECTED).read_text("utf-8"))
        spans = evidence.intervals()
        achieved = {}
        for label, value in evidence.parameters.items():
            half = 0.5 * (spans[label][1] - spans[label][0])
            if value and not np.isnan(half):
                achieved[label] = float(half / abs(value))
        promised = {label: np.inf if half is None else float(half) for label, half in promise["half_width"].items()}
        tests = tuple(test.name for test in read(folder / CAMPAIGN).tests)
        peak = self._measure_peak(evidence)
        return Round(
            number, folder, tests, float(promise["duration_s"]), promised, achieved, promise["peak_half_width"], peak
        )

    def _measure_peak(self, evidence: Fit) -> float | None:
        """The half width of the peak's 95 % interval over the peak, by the covariance of the fit."""
        if self.options.peak is None or evidence.damper is None:
            return None
        plan = layout(
            evidence.damper, [p.levels for p in evidence.problem.pieces], self.options.laws, self.options.fixed
        )
        goal, _ = peak_goal(plan, self.options.peak)
        return peak_half_of_fit(evidence, plan, goal)[0]

    def _decide(self, evidence: Damper | Fit, rounds: list[Round]) -> tuple[str, bool]:
        """Why no further round is performed, empty where one is; and whether the targets are met."""
        if isinstance(evidence, Fit) and evidence.damper is None:
            return f"the fit gives no damper to plan from: {evidence.reason}", False
        if self._is_reached(evidence, rounds):
            return "the targets are reached", True
        done = sum(len(performed.tests) for performed in rounds)
        if self.max_tests is not None and done >= self.max_tests:
            return f"all {self.max_tests} tests are performed", False
        used = sum(performed.duration for performed in rounds)
        if self.options.duration is not None and used >= self.options.duration:
            return f"the {self.options.duration:g} s of tests are used", False
        return "", False

    def _is_reached(self, evidence: Damper | Fit, rounds: list[Round]) -> bool:
        if not isinstance(evidence, Fit) or not self.options.aimed:
            return False
        if self.options.peak_target is not None:
            half = rounds[-1].peak_achieved if rounds else self._measure_peak(evidence)
            return half is not None and half <= self.options.peak_target
        spans = evidence.intervals()
        for name, target in self.options.targets.items():
            for label, value in evidence.parameters.items():
                if not is_named(label, name):
                    continue
                half = 0.5 * (spans[label][1] - spans[label][0])
                if not half <= target * abs(value):
                    return False
        return True

    def _gains_little(self, proposal: Proposal) -> bool:
        """Whether what is aimed at is expected to become narrower by next to nothing; never where the spread of records is only
        assumed, for that is not what the intervals of the fit know."""
        if proposal.spread.records < LEARNED_FROM:
            return False
        if proposal.peak_after is not None and proposal.peak_before is not None:
            return proposal.peak_after > (1.0 - NO_GAIN) * proposal.peak_before
        aims = self.options.targets
        aimed_at = [
            (proposal.before[label], half)
            for label, half in proposal.after.items()
            if label in proposal.before
            and np.isfinite(half)
            and (not aims or any(is_named(label, name) for name in aims))
        ]
        if not aimed_at or any(not np.isfinite(before) for before, _ in aimed_at):
            return False
        return float(np.mean([np.log(after / before) for before, after in aimed_at])) > np.log(1.0 - NO_GAIN)
