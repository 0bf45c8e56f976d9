"""The plan of a campaign on a rig: every test with what it will ask for, all refusals together, nothing moved."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.campaigns.campaign import Campaign, Test, read
from dampyr.campaigns.check import Violation, largest, repairs, violations_of
from dampyr.campaigns.force_prediction import UNKNOWN, course, specimen
from dampyr.campaigns.learning import TRIES
from dampyr.campaigns.step import shown, words
from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.rig import Drive, RigSettings, load_settings
from dampyr.shown import Shown

WAYS = (
    3.0  # s of the slow ways to a test and, after it, past the index; 3.1 s on the average of examples/every_kind.toml
)
UNCHECKED = "unchecked, as check_amplitude = 0: whether the load cell's sign is right and the encoder's scale is"


@dataclass(frozen=True, eq=False, repr=False)
class PlannedTest(Shown):
    """A test as it would run.

    ``duration`` s, ``peak_speed`` m/s, ``peak_position`` m from the middle, ``peak_voltage`` V, ``peak_force`` N as expected
    and ``energy`` J that this force takes up (both None where the voltage is refused). ``step`` may differ from ``test.step``
    where the plan says so in ``notes``; ``fitted`` is the note where it was lowered to what the rig can do, else "".
    ``refusal`` is the sentence of what is in the way, "" where the rig can do it.
    """

    test: Test
    step: Any
    drive: Drive
    duration: float
    peak_speed: float
    peak_position: float
    peak_force: float | None
    peak_voltage: float
    energy: float | None
    notes: tuple[str, ...] = ()
    refusal: str = ""
    fitted: str = ""

    @property
    def name(self) -> str:
        """Unique in its campaign."""
        return self.test.name

    @property
    def kind(self) -> str:
        """The kind of step."""
        return self.test.kind

    @property
    def words(self) -> str:
        """What it does, as it would run."""
        return words(self.kind, self.step)


@dataclass(frozen=True, eq=False, repr=False)
class Plan(Shown):
    """The tests in their order, the stroke before them, and what the expected force rests on."""

    campaign: Campaign
    rig: RigSettings
    damper: Damper | None
    tests: tuple[PlannedTest, ...]
    preliminary: Drive | None
    notes: tuple[str, ...]
    refusals: tuple[str, ...]

    @property
    def duration(self) -> float:
        """s, with the rests and slow ways between the tests and the stroke before them, homing left out; for drives that are
        learned with all their tries, fewer of which may do.
        """
        rests = self.campaign.header.rest_between * max(len(self.tests) - 1, 0)
        before = 0.0 if self.preliminary is None else self.preliminary.duration
        return sum(map(self.rig_time, self.tests)) + rests + before

    def rig_time(self, test: PlannedTest) -> float:
        """s that a test takes at most: its own, and where its drive is learned that of every try and the rest after it."""
        return test.duration + WAYS + (TRIES * self.try_time(test) if test.test.learn else 0.0)

    def try_time(self, test: PlannedTest) -> float:
        """s that a try of a drive that is learned takes, with the rest after it."""
        return test.duration + WAYS + self.campaign.header.rest_between

    def require(self) -> None:
        """Raise :class:`~dampyr.errors.InputError` with all refusals, where there are any."""
        if self.refusals:
            raise InputError("; ".join(self.refusals))


def plan(
    campaign: Campaign | str | Path,
    rig: RigSettings | str | Path | None = None,
    damper: Damper | None = None,
    seed: int | None = None,
) -> Plan:
    """What a campaign would ask of a rig, and all that the rig cannot do.

    Parameters
    ----------
    campaign
        A campaign, or the path of its TOML file.
    rig
        The rig's settings, or the path of its ``rig.toml``; None: the original rig's parts.
    damper
        Gives the expected force. Without one it is the damper that the rig names where ``campaign`` or ``rig`` is a file (its
        card is looked for beside ``rig.toml``), else a conservative envelope gives the force, and the plan's notes say so.
    seed
        Of a campaign file in random order, in the place of the one that it states.

    Returns
    -------
    Plan
        Every test with its duration, peaks and expected force; ``refusals`` holds a sentence for each that the rig cannot do.

    Examples
    --------
    >>> import dampyr as dp
    >>> step = {"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz", "voltage": ["0 V", "1.98 V"], "cycles": 2}
    >>> campaign = dp.campaigns.campaign_of({"name": "two", "operator": "me", "step": [step]})
    >>> plan = dp.campaigns.plan(campaign, dp.rig.RigSettings())
    >>> [test.name for test in plan.tests], plan.refusals
    (['01-sine-8mm-1Hz-0V', '02-sine-8mm-1Hz-1.98V'], ())
    """
    folder = None if rig is None or isinstance(rig, RigSettings) else Path(rig).parent
    settings = rig if isinstance(rig, RigSettings) else RigSettings() if rig is None else load_settings(rig)
    if damper is None and not (isinstance(campaign, Campaign) and folder is None):
        damper = specimen(settings, folder)
    if not isinstance(campaign, Campaign):
        campaign = read(campaign, seed)
    by_number = {test.number: test for test in campaign.tests}  # repeats are planned once
    planned = {number: _plan_test(by_number[number], settings, damper) for number in sorted(by_number)}
    tests = tuple(replace(planned[test.number], test=test) for test in campaign.tests)
    stroke = campaign.preliminary
    refusals = [test.refusal for test in planned.values() if test.refusal]
    if stroke is not None and (violations := violations_of(stroke, settings, damper)):
        refusals.insert(0, f"the stroke before the first test: {violations[0].words}; lower check_amplitude")
    notes = (UNKNOWN,) if damper is None else ()
    if stroke is None:
        notes = (*notes, f"before the first test: {UNCHECKED}")
    preliminary = stroke.drive(settings) if stroke else None
    return Plan(campaign, settings, damper, tests, preliminary, notes, tuple(refusals))


def _plan_test(test: Test, rig: RigSettings, damper: Damper | None) -> PlannedTest:
    step, violations, fitted = _fit_to_rig(test.step, violations_of(test.step, rig, damper), rig, damper)
    notes = (fitted,) if fitted else ()
    if test.learn:
        notes = (*notes, f"its drive is learned first, in at most {TRIES} tries")
    drive, peaks, force, energy = step.drive(rig), step.peaks(rig), None, None
    if not any(violation.limit == "voltage" for violation in violations):
        trajectory = course(drive, rig, damper)
        force, energy = float(np.abs(trajectory.force).max()), trajectory.energy
        notes = (*notes, *trajectory.notes, *_note_warming(energy, rig))
    if hasattr(step, "remarks"):
        notes = (*notes, *step.remarks(rig))
    refusal = _describe_refusal(test, step, violations, rig, damper)
    if not refusal and hasattr(step, "rehearsal") and (words := step.rehearsal(rig)):
        refusal = f"{test.where}: {words}"
    return PlannedTest(
        test, step, drive, drive.duration, peaks.speed, peaks.position, force, drive.voltage_range[1],
        energy, notes, refusal, fitted,
    )  # fmt: skip


def _note_warming(energy: float, rig: RigSettings) -> tuple[str, ...]:
    """A note where a test alone may warm the damper from the room's temperature to the limit."""
    rise, ambient = energy / rig.specimen.heat_capacity, rig.specimen.room
    if ambient + rise < rig.limits.temperature:
        return ()
    return (
        f"puts {1e-3 * energy:.3g} kJ into the damper, up to {rise:.0f} K; the limit is {rig.limits.temperature:g} degC",
    )


Violations = tuple[Violation, ...]


def _fit_to_rig(
    step: Any, violations: Violations, rig: RigSettings, damper: Damper | None
) -> tuple[Any, Violations, str]:
    """The step lowered to what the rig can do, where it asks for that and needs it, and what was done in words."""
    field = getattr(step, "fits", "scale")
    value = largest(step, field, rig, damper) if violations and getattr(step, "fit_limits", False) else None
    if value is None:
        return step, violations, ""
    lower = replace(step, **{field: value})
    before, after = (_field_text(version, field) for version in (step, lower))
    why = " and it ".join(violation.words for violation in violations)
    head = "scaled" if field == "scale" else f"{field} lowered"
    return lower, (), f"{head} to {after} instead of {before}: at {before} it {why}"


def _field_text(step: Any, field: str) -> str:
    """A field with its unit and without its name."""
    return shown(step, field).removeprefix(f"{field} ")


def _describe_refusal(
    test: Test, step: Any, violations: tuple[Violation, ...], rig: RigSettings, damper: Damper | None
) -> str:
    sentences = []
    for violation in violations:
        ways = repairs(step, rig, damper, violation.limit if len(violations) > 1 else None)
        sentences.append(violation.words + (f"; lower {' or '.join(ways)}" if ways else ""))
    return f"{test.where}: {'; it also '.join(sentences)}" if sentences else ""
