"""Recording of one test: its file is open before anything moves and states how the test ended, whatever happens."""

from __future__ import annotations

import dataclasses
import json
import math
import platform
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from datetime import datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.campaigns.campaign import Campaign
from dampyr.campaigns.campaign_thresholds import USUAL, CampaignThresholds
from dampyr.campaigns.force_prediction import mean_force_at, specimen
from dampyr.campaigns.journal import now
from dampyr.campaigns.kinds import kind
from dampyr.campaigns.marks import Mark, MeasuredTest, marks_of
from dampyr.campaigns.pass_marks import passes_differ
from dampyr.campaigns.planned_tests import UNCHECKED, PlannedTest
from dampyr.campaigns.run_control import Stopped, exit_status
from dampyr.errors import DampyrError, FileError, RigFault
from dampyr.models.numerics.differentiation import differentiate, window
from dampyr.records.checks.channel_uncertainty import ChannelUncertainty
from dampyr.records.conditioning.nominal_input import MEASURED, SOURCE
from dampyr.records.files.recording import RawChannel, Recording, RecordingHeader, check_disk_space
from dampyr.records.formats.h5 import PIECE
from dampyr.records.record import MIN_SAMPLES, Array, Label, as_group
from dampyr.rig.calibration import Calibration
from dampyr.rig.drive import Drive
from dampyr.rig.interlock import Samples
from dampyr.rig.session import ArmedRig, Rig
from dampyr.rig.settings import RigSettings
from dampyr.rig.uncertainty_budget import Evidence, LostCounts, budget
from dampyr.source_digest import full_version

Judge = Callable[[Recording], Mapping[str, str]]
UNREAD = "as commanded: nothing reads the coil's (wires.coil_voltage), so it is commanded, not measured"
SPARE = 2.0  # s of samples reserved beyond the plan: stopping takes less than 1 s


def take(
    table: ArmedRig,
    planned: PlannedTest,
    campaign: Campaign,
    path: Path,
    attempt: int,
    groups: Mapping[str, str],
    on_samples: Callable[[Samples], None],
    extra_provenance: Mapping[str, str] | None = None,
    judge: Judge | None = None,
    thresholds: CampaignThresholds = USUAL,
) -> tuple[str, ...]:
    """Play a test and record it, in a file whose room is reserved before anything moves. The file says how the test ended; what
    ended it early is raised again.

    ``on_samples`` is called with each block. ``extra_provenance`` is added to that of the record, and what ``judge`` gives of
    the samples of a test that came to its end. The marks of the test, by the ``thresholds``, are given back; one that spoils
    it is raised as a :class:`~dampyr.errors.RigFault`.
    """
    record_header = header(table.rig, table.loop.calibration, planned, campaign, attempt, groups, extra_provenance)
    recording = Recording(path, capacity(planned.drive, table.rig), record_header)
    try:
        table.go(float(planned.drive.displacement[0]))
    except BaseException:
        recording.discard()
        raise
    started = {"started": now(), "temperature_at_start_degC": f"{table.temperature:.2f}"}
    marks: list[Mark] = []
    largest = 0
    start_temperature, lost = table.temperature, LostCounts(table.rig.settings.encoder.count)
    table.rig.watchers.append(lost)
    try:
        with finished(
            recording,
            table,
            started,
            marks,
            lambda: collect_evidence(table, lost, start_temperature),
            judge,
            thresholds,
        ):
            for samples, selection in table.play(planned.drive):
                if selection.stop > selection.start:
                    if not recording.rows:
                        started |= steady_cycles(planned, float(samples.time[selection.start]))
                    recording.append(file_rows(samples, selection, recording.header, table.rig.settings))
                on_samples(samples)
                largest = max(largest, samples.status.current)
            if table.rig.settings.wires.bridge_current:  # of the readings that a status a block shows
                started["motor_current_largest_A"] = f"{table.rig.settings.motor_current(largest):.2f}"
            table.verify()
    finally:
        table.rig.watchers.remove(lost)
    return tuple(mark.text for mark in marks)


def steady_cycles(planned: PlannedTest, first: float) -> dict[str, str]:
    """Where the record, whose first sample is at ``first`` s, has the cycles that its step commands at full amplitude."""
    steady = getattr(planned.step, "steady_cycles", None)
    return steady.as_provenance(first - planned.drive.record_from * planned.drive.period) if steady else {}


def collect_evidence(table: ArmedRig, lost: LostCounts, start_temperature: float) -> Evidence:
    """What a test has shown of its own measurement; the damper was at ``start_temperature`` [degC] at its begin."""
    passes = table.passes
    zero, height = [one.mean for one in passes], [one.height for one in passes]
    shift = (zero[-2] - zero[0], zero[-1] - zero[0]) if len(zero) > 1 else None
    rise = table.temperature - start_temperature
    return dataclasses.replace(
        early_evidence(table),
        lost_counts=lost.number(table.loop.index),
        zero_shift=shift,
        first_mean=zero[0] if zero else 0.0,
        expected_mean=_expected_mean(table) if zero else None,
        heights=(height[0], height[-2], height[-1]) if len(height) > 1 else None,
        noise=passes[0].noise if passes else math.nan,
        compared=(table.earlier, passes[0]) if table.earlier is not None else None,
        shunts=(table.shunts[0], *table.shunts[-2:]) if len(table.shunts) > 1 else (),
        rise=rise,
    )


def _expected_mean(table: ArmedRig) -> float | None:
    """What the card of the damper promises of the force on the slow passes; None without a card."""
    damper = specimen(table.rig.settings, table.rig.folder)
    return None if damper is None else mean_force_at(damper, table.passes[-1].place)


def early_evidence(table: ArmedRig) -> Evidence:
    """What a test that was ended early has shown of its measurement: how warm the damper is, and how late its supply."""
    temperature, rig = table.temperature, table.rig
    return Evidence(
        temperature=temperature,
        warming=temperature - rig.settings.specimen.room,
        command_delay=rig.command_delay,
        parted=rig.warmth.parted,
        doubt=rig.warmth.doubt,
    )


@contextmanager
def finished(
    recording: Recording,
    table: ArmedRig,
    started: dict[str, str],
    marks: list[Mark],
    collect_evidence: Callable[[], Evidence],
    judge: Judge | None = None,
    thresholds: CampaignThresholds = USUAL,
) -> Iterator[None]:
    """Finish the file, after the table was brought to rest if something ended the test early; ``marks`` takes those of it.
    ``collect_evidence`` gives what a test that came to its end has shown of its measurement, ``judge`` what its record says
    besides.
    """
    held = table.rig.clock_held
    try:
        yield
    except BaseException as ended:
        table.soft_stop()
        problem = _with_cause(ended, recording, table, thresholds)
        outcome = started | {"ended": now(), **reason(problem)} | _clocks(table, held)
        with suppress(
            DampyrError
        ):  # a full disk, or too few samples for a record: what was acknowledged is in the file
            recording.close() if isinstance(problem, FileError) else recording.finish(
                outcome, complete=False, uncertainty=uncertainty(recording, table.rig.settings, early_evidence(table))
            )
        if problem is not ended:
            raise problem from None
        raise
    outcome = started | {"ended": now(), "temperature_at_end_degC": f"{table.temperature:.2f}"}
    outcome |= _clocks(table, held)
    evidence = collect_evidence()
    table.meanwhile(lambda: marks.extend(_finish(recording, table.rig.settings, outcome, evidence, judge, thresholds)))
    if any(mark.spoils for mark in marks):
        raise _spoiled(marks)


def _with_cause(
    ended: BaseException, recording: Recording, table: ArmedRig, thresholds: CampaignThresholds
) -> BaseException:
    """What ended a test early; where that is what a hybrid test computed from a force that was not the damper's, that."""
    if not (isinstance(ended, RigFault) and ended.ring == "check") or recording.rows < MIN_SAMPLES:
        return ended
    evidence, rig = early_evidence(table), table.rig.settings
    found = marks_of(lambda rows: measured_test(recording, rig, rows, evidence, thresholds), recording.rows)
    spoiling = [mark for mark in found if mark.spoils]
    return RigFault(f"{_spoiled(spoiling)}; so {ended}", "check") if spoiling else ended


def _clocks(table: ArmedRig, held: float) -> dict[str, str]:
    """What a record says of the clocks: the Uno's against the board's; and for how long that of a simulated rig was held back
    beyond the ``held`` s at the begin: in the rig's own time nothing was late.
    """
    ratio, seconds = table.loop.clock_ratio, table.rig.clock_held - held
    clocks = {"uno_clock_ratio": f"{ratio.value:.7f}", "uno_clock_ratio_uncertainty": f"{ratio.uncertainty:.1e}"}
    return clocks | ({"simulated_clock_held_back_s": f"{seconds:.3f}"} if seconds > 0.0 else {})


def _finish(
    recording: Recording,
    rig: RigSettings,
    outcome: dict[str, str],
    evidence: Evidence,
    judge: Judge | None,
    thresholds: CampaignThresholds,
) -> list[Mark]:
    """Finish the file of a test that came to its end, complete unless a mark spoils it; its marks."""
    outcome = outcome | dict(judge(recording) if judge is not None else {})
    marks = marks_of(lambda rows: measured_test(recording, rig, rows, evidence, thresholds), recording.rows)
    span = float(np.ptp(recording.read("calibrated/force", thinned(recording)))) if recording.rows else 0.0
    marks += passes_differ(evidence, rig, span, thresholds)
    if evidence.doubt:
        marks.append(Mark(evidence.doubt))
    changes: dict[str, Any] = {"marks": tuple(mark.text for mark in marks)}
    changes["uncertainty"] = uncertainty(recording, rig, evidence)
    if "voltage" in recording.header.constants and "raw/coil_voltage" in recording.datasets:
        changes["constants"] = {"voltage": mean_voltage(recording, rig)}
        outcome = outcome | {SOURCE: MEASURED}  # tests at one voltage then count as such, whatever was read
    if any(mark.spoils for mark in marks):
        recording.finish(outcome | reason(_spoiled(marks)), complete=False, **changes)
    else:
        outcome = outcome | {"exit_status": "complete", "reason": ""}
        recording.finish(
            outcome, history(rig), refine=lambda values: refined(values, rig), margin=margin(rig), **changes
        )
    return marks


def uncertainty(recording: Recording, rig: RigSettings, evidence: Evidence) -> dict[str, ChannelUncertainty]:
    """The standard uncertainty of each channel of a test; none with too few samples for a record."""
    rows = recording.rows
    if rows < MIN_SAMPLES or rows < 5.0 * rig.board.rate / rig.board.velocity_bandwidth:
        return {}
    voltage, count = recording.header.constants.get("voltage"), max(1, rows // PIECE)

    def piece(k: int) -> tuple[Array, Array, Array, Array | float]:
        part = slice(rows * k // count, rows * (k + 1) // count)
        time, x, force = (recording.read(f"calibrated/{name}", part) for name in ("time", "displacement", "force"))
        return time, x, force, recording.read("calibrated/voltage", part) if voltage is None else voltage

    parts = budget(rig, evidence, rows / rig.board.rate, map(piece, range(count)))
    return {name: ChannelUncertainty(terms) for name, terms in parts.items()}


def mean_voltage(recording: Recording, rig: RigSettings) -> float:
    """The mean of the coil's voltage [V] as read back in a test at one voltage, less what its warmth has added."""
    nominal = recording.header.constants["voltage"]
    read_back, command = (recording.read(f"raw/{name}", thinned(recording)) for name in ("coil_voltage", "command"))
    # The command rises with the coil's warmth, so that its current stays; over the nominal voltage it is by how much.
    rise = np.mean(command) * rig.supply.gain / nominal if nominal else 1.0
    return float(np.mean(read_back)) * rig.supply.voltage_scale / float(rise or 1.0)


def thinned(recording: Recording) -> slice:
    """So many of its samples, evenly spaced, that a test of any length takes the same memory."""
    return slice(0, None, max(1, -(-recording.rows // PIECE)))


def _spoiled(marks: list[Mark]) -> RigFault:
    return RigFault(f"the test is spoiled: {'; '.join(mark.text for mark in marks if mark.spoils)}", "check")


def measured_test(
    recording: Recording, rig: RigSettings, rows: slice, evidence: Evidence, thresholds: CampaignThresholds
) -> MeasuredTest:
    """What was measured, as `dampyr.campaigns.marks` looks at it, beside what the test has shown of its measurement."""
    coil = {
        name: recording.read(f"raw/{name}", rows) * scale
        for name, scale in (
            ("coil_voltage", rig.supply.voltage_scale),
            ("coil_current", rig.supply.current_scale),
            ("command", rig.supply.gain),
        )
        if f"raw/{name}" in recording.datasets
    }
    voltage = recording.header.constants.get("voltage")
    return MeasuredTest(
        recording.read("calibrated/time", rows),
        recording.read("calibrated/displacement", rows),
        recording.read("calibrated/force", rows),
        recording.read("raw/force", rows),
        recording.read("calibrated/voltage", rows) if voltage is None else voltage,
        rig,
        evidence.temperature,
        noise=evidence.noise,
        **coil,
        closed_loop=getattr(kind(recording.header.provenance["kind"]), "closed_loop", False),
        thresholds=thresholds,
    )


def margin(rig: RigSettings) -> int:
    """How many samples `refined` looks at before and after each."""
    dt = 1.0 / rig.board.rate
    return (
        math.ceil(rig.force_delay / dt)
        + (2 if rig.load_cell.mass else 1) * window(dt, rig.board.velocity_bandwidth)[1]
        + 2
    )


def refined(values: dict[str, Array], rig: RigSettings) -> dict[str, Array]:
    """The displacement on the force's clock, and its derivative; the force without the inertia of `load_cell.mass`, which
    a force that is positive against a positive velocity carries along: :math:`F - m a`."""
    time = values["time"]
    x = np.interp(time - rig.force_delay, time, values["displacement"])
    velocity = differentiate(time, x, rig.board.velocity_bandwidth)
    changed = {"displacement": x, "velocity": velocity}
    if mass := rig.load_cell.mass:
        changed["force"] = values["force"] - mass * differentiate(time, velocity, rig.board.velocity_bandwidth)
    return values | changed


def history(rig: RigSettings) -> tuple[str, ...]:
    """What `refined` did, in words."""
    cell, board = rig.load_cell, rig.board
    return (
        f"displacement read {rig.force_delay * 1e3:.3g} ms earlier: so much the load cell's filter of {cell.bandwidth:g} Hz "
        "delays the force",
        f"velocity derived from it, 3 dB down at {board.velocity_bandwidth:g} Hz",
        *(
            (
                f"{cell.mass:g} kg hang at the load cell: mass times acceleration is taken off the force, the acceleration "
                f"derived from the velocity at the same {board.velocity_bandwidth:g} Hz; the raw force is as read",
            )
            if cell.mass
            else ()
        ),
        *(
            ("the voltage is that of a coil at 20 degC: the command rose with its warmth",)
            if rig.supply.compensated
            else ()
        ),
    )


def reason(problem: BaseException) -> dict[str, str]:
    """Exit status and reason of what ended a test early."""
    status = exit_status(problem)
    if isinstance(problem, Stopped):
        return {"exit_status": status, "reason": "by the operator"}
    if isinstance(problem, RigFault):
        return {"exit_status": status, "reason": str(problem), "ring": problem.ring}
    if status == "stopped":
        return {"exit_status": status, "reason": "interrupted"}
    return {"exit_status": status, "reason": f"{type(problem).__name__}: {problem}"}


def capacity(drive: Drive, rig: Rig) -> int:
    """The number of samples to reserve in the file."""
    last = drive.n - 1 if drive.record_to is None else drive.record_to
    return round(((last - drive.record_from) * drive.period + SPARE) * rig.settings.board.rate) + 1


def check_disk(folder: Path, rig: Rig, tests: list[PlannedTest], campaign: Campaign, groups: Mapping[str, str]) -> None:
    """Raise :class:`~dampyr.errors.FileError` where the disk has no space for one of the tests."""
    assert rig.calibration is not None
    largest = max(tests, key=lambda test: capacity(test.drive, rig))
    record_header = header(rig, rig.calibration, largest, campaign, 1, groups)
    check_disk_space(folder, largest.name, record_header, capacity(largest.drive, rig))


def groups_of(rig: RigSettings, campaign: Campaign, started: datetime) -> dict[str, str]:
    """The session and the specimen of the tests of a run that began at ``started``.

    They are as the campaign states them. Else the specimen is what the rig's file calls it, or its card or data sheet without
    a name; and the session is the day, in local time, and the specimen: the tests of one run, even past midnight, and those of
    further runs on that day. Who mounts the damper anew within a day has to state the session.
    """
    named = rig.specimen
    specimen = campaign.header.specimen or named.name or Path(named.card).stem or named.data_sheet
    day = started.astimezone().date().isoformat()
    session = campaign.header.measurement_session or f"{day} {specimen}"
    texts = (("measurement_session", session), ("specimen", specimen))
    groups = {name: as_group(name, text) for name, text in texts if text}
    return {name: text for name, text in groups.items() if text}


def header(
    rig: Rig,
    calibration: Calibration,
    planned: PlannedTest,
    campaign: Campaign,
    attempt: int,
    groups: Mapping[str, str],
    extra_provenance: Mapping[str, str] | None = None,
) -> RecordingHeader:
    """The header of the file, complete before the test begins."""
    drive = planned.drive
    voltage = drive.voltage[drive.record_from : drive.record_to]
    constant = not drive.law and bool(np.ptp(voltage) == 0.0)
    channels = ["time", "displacement", "force", *(() if constant else ("voltage",))]
    raw = {
        "force": RawChannel(
            "V",
            calibration.scale,
            -calibration.scale * calibration.zero,
            "N",
            mass=rig.settings.load_cell.mass,
            bandwidth=rig.settings.board.velocity_bandwidth if rig.settings.load_cell.mass else None,
        ),
        "position": RawChannel(
            "count",
            calibration.count,
            calibration.count * (0.5 - calibration.middle),
            "m",
            "i8",
            rig.settings.force_delay,
        ),
    }
    inputs, supply = rig.settings.inputs, rig.settings.supply
    if "temperature" in inputs:
        channels.append("temperature")
        raw["temperature"] = RawChannel("V", calibration.slope, calibration.base, "degC")
    if "coil_voltage" in inputs:
        raw["coil_voltage"] = RawChannel("V", supply.voltage_scale, 0.0, "V")
    if "coil_current" in inputs:
        raw["coil_current"] = RawChannel("V", supply.current_scale, 0.0, "A")
    if raw.keys() & {"coil_voltage", "coil_current"}:
        raw["command"] = RawChannel("V", supply.gain, 0.0, "V")
    if drive.law:
        raw["asked_voltage"] = RawChannel("V", 1.0, 0.0, "V")
    return RecordingHeader(
        planned.name,
        planned.name,
        attempt,
        tuple(channels),
        raw,
        {"voltage": float(voltage[0])} if constant else {},
        role=getattr(planned.step, "role", "fit"),
        label=label(planned.step),
        provenance=provenance(rig, calibration, planned, campaign) | dict(extra_provenance or {}),
        derived=("velocity",),
        origin=rig.origin,
        **groups,
    )


def label(step: Any) -> Label | None:
    """Peak to peak and frequency of a sine."""
    if not (hasattr(step, "amplitude") and isinstance(getattr(step, "frequency", None), float)):
        return None
    return Label(2.0 * step.amplitude, step.frequency)


def provenance(rig: Rig, calibration: Calibration, planned: PlannedTest, campaign: Campaign) -> dict[str, str]:
    """Configuration, versions, calibration and the operator's note."""
    return {
        "campaign": campaign.header.name,
        "campaign_digest": campaign.digest,
        "operator": campaign.header.operator,
        "note": campaign.header.note,
        "kind": planned.kind,
        "step": as_json(planned.step),
        **({"fitted": planned.fitted} if planned.fitted else {}),
        **({"law": planned.drive.law} if planned.drive.law else {}),
        "rig": as_json(rig.settings),
        "calibration": json.dumps(
            {key: value for key, value in dataclasses.asdict(calibration).items() if value is not None}
        ),
        **rig.settings.certificates.provenance(),
        "board": rig.identity,
        "data_sheet": rig.settings.specimen.data_sheet,
        "voltage": voltage_source(rig.settings),
        "motor_current": motor_current_source(rig.settings),
        "preliminary_check": "passed" if campaign.header.check_amplitude else UNCHECKED,
        "dampyr": full_version(),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "h5py": version("h5py"),
    }


def voltage_source(rig: RigSettings) -> str:
    """How the voltage in a record is known."""
    terminal = rig.inputs.get("coil_voltage")
    return f"read back on {terminal}" if terminal else UNREAD


def motor_current_source(rig: RigSettings) -> str:
    """How the motor's current is known."""
    if not rig.wires.bridge_current:
        return "not read: the bridge's current outputs are not wired (wires.bridge_current)"
    return f"read by the Uno, which stops above {rig.actuator.max_current:g} A"


def as_json(settings: Any) -> str:
    """A dataclass as text, SI."""
    return json.dumps(dataclasses.asdict(settings), default=str)


def file_rows(samples: Samples, selection: slice, record_header: RecordingHeader, rig: RigSettings) -> dict[str, Any]:
    """The rows of a block for the file."""
    columns: dict[str, Any] = {
        "calibrated/time": samples.time,
        "calibrated/displacement": samples.displacement,
        "calibrated/force": samples.force,
        "calibrated/voltage": samples.voltage,
        "calibrated/temperature": samples.temperature,
        **{f"raw/{name}": volts for name, volts in zip(rig.inputs, samples.volts, strict=True)},
        "raw/position": samples.counts,
        "raw/command": samples.command / rig.supply.gain,
        "raw/asked_voltage": samples.asked,
    }
    names = [
        *(f"calibrated/{name}" for name in record_header.channels),
        *(f"raw/{name}" for name in record_header.raw),
    ]
    return {name: columns[name][selection] for name in names}
