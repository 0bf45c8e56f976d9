"""What is known of a record without its samples, for a table or for machines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from dampyr.findings import Finding, Severity, findings_of
from dampyr.records.checks.certificates import expired_certificates
from dampyr.records.checks.label_checks import creates_energy, disagreements
from dampyr.records.checks.overview import Overview, overview
from dampyr.records.checks.quality import Quality, quality
from dampyr.records.conditioning.integrated_displacement import is_integrated
from dampyr.records.conditioning.lowpass import DisplacementNoise, displacement_noise
from dampyr.records.conditioning.repair import repair_sentences
from dampyr.records.conditioning.smoothing_recognition import Recognised, recognise_smoothing
from dampyr.records.cycle_analysis.cycle_table import cycle_table
from dampyr.records.cycle_analysis.cycles import cut_cycles
from dampyr.records.cycle_analysis.measure import measure
from dampyr.records.record import GROUPS, Record
from dampyr.records.record_cache import cached_by_record

SAME_WINDOW = 0.02  # of the window: as well as the zeros of a short record tell it
FEW = 3  # notes of one kind that a record has one by one


def describe(record: Record) -> dict[str, Any]:
    """What is stated and measured of a record, SI.

    Name, role, session, specimen, input, label, what was measured, how well it was sampled, and ``findings``: what a person
    should look at.

    ``measured`` is None where the motion does not repeat itself: then ``overview`` stands for it, and ``levels`` for
    a test with rising or falling strokes. ``input_range`` is the least and the largest input, None where it is not
    known. ``smoothing`` holds the moving averages that channels show and that are not declared, ``smoothed`` the one
    that is declared and not undone, ``noise`` what the displacement's noise does, ``marks`` the faults that the
    recorder saw, ``uncertainty`` the standard uncertainty of each channel and its parts.
    """
    motion, sampling, noise, smoothing = _checks(record)
    measured = measure(record) if motion.repeats else None
    values = record.input_channel
    return {
        "name": record.name,
        "role": record.role,
        **{name: getattr(record, name) for name in GROUPS},
        "origin": record.origin.as_dict(),
        "input": record.input,
        "input_value": record.input_value,
        "input_range": None if values is None else [float(np.min(values)), float(np.max(values))],
        "duration_s": record.duration,
        "label": record.label,
        "measured": measured,
        "levels": describe_levels(record),
        "overview": motion,
        "quality": sampling,
        "smoothing": smoothing,
        "smoothed": record.smoothed,
        "noise": noise,
        "marks": record.marks,
        "uncertainty": {
            name: {"standard": channel.standard, "largest": channel.largest, "parts": dict(channel.parts)}
            for name, channel in record.uncertainty.items()
        },
        "findings": [replace(finding, about=()).as_dict() for finding in record.findings],
        "history": record.history,
        "provenance": record.provenance,
    }


@cached_by_record
def _checks(record: Record) -> tuple[Overview, Quality, DisplacementNoise, tuple[Recognised, ...]]:
    return overview(record), quality(record), displacement_noise(record), recognise_smoothing(record)


def describe_levels(record: Record) -> list[dict[str, Any]]:
    """The levels of a test with rising or falling strokes, SI: number, cycles, stroke, frequency and the mean energy
    of a cycle.

    Empty for any other motion.
    """
    cut = cut_cycles(record)
    if not cut.graded:
        return []
    energies: dict[int, list[float]] = {}
    for cycle in cycle_table(record):
        energies.setdefault(cycle.level, []).append(cycle.energy)
    return [
        {"number": level.number, "cycles": level.count, "stroke_m": level.stroke_m, "frequency_hz": 1.0 / level.period_s,
         "energy_per_cycle": float(np.mean(energies[level.number]))}
        for level in cut.levels
    ]  # fmt: skip


def _levels_sentence(record: Record) -> str:
    cut = cut_cycles(record)
    strokes = [1e3 * level.stroke_m for level in cut.levels]
    span = f"{min(strokes):.3g} to {max(strokes):.3g} mm peak to peak"
    if cut.stepped:
        return f"{len(cut.levels)} levels, {len(cut.cycles)} whole cycles of {cut.run:g}, {span}"
    return f"strokes that rise or fall from cycle to cycle: {len(cut.cycles)} whole cycles of {cut.run:g}, {span}"


@findings_of.register(Record)
@cached_by_record
def _(record: Record) -> tuple[Finding, ...]:
    """All that a person should look at in a record: its ``findings``."""
    by_kind = findings_by_kind(record).values()
    return tuple(
        dict.fromkeys(
            Finding(severity, sentence, (record.name,)) for severity, sentences in by_kind for sentence in sentences
        )
    )


def findings_by_kind(record: Record) -> dict[str, tuple[Severity, list[str]]]:
    """The severity and the sentences of every kind of finding, whether the record has it or not; in the order of findings."""
    motion, sampling, noise, smoothing = _checks(record)
    contradictions = [sentence.removeprefix(f"{record.name}: ") for sentence in disagreements(record)]
    energy = contradictions[-1:] if creates_energy(record) else []  # which `disagreements` names last
    irregular = []
    if not motion.repeats:
        irregular = [_levels_sentence(record) if cut_cycles(record).graded else _irregular_sentence(motion)]
    integrated = [f"displacement {record.provenance['displacement']}"] if is_integrated(record) else []
    repaired, repairs = repair_sentences(record)
    doubts = {
        "mark": list(record.marks),
        "many repaired": repaired,
        "certificate": expired_certificates(record.provenance),
        "label": contradictions[: len(contradictions) - len(energy)],
        **sampling.judged(record.thresholds),
        "undeclared smoothing": _undeclared(smoothing),
        "noise": list(noise.judged(record.thresholds)),
    }
    notes = {
        "repaired": repairs,
        "integrated": integrated,
        "irregular": irregular,
        "declared smoothing": _declared(record),
    }
    return {
        "created energy": ("wrong", energy),
        **{kind: ("doubt", _condensed(sentences)) for kind, sentences in doubts.items()},
        **{kind: ("note", sentences) for kind, sentences in notes.items()},
    }


def _condensed(notes: Sequence[str]) -> list[str]:
    """The notes, those that are many of one kind, such as gaps, as the first of them and how many more there are."""
    kinds: dict[str, list[str]] = {}
    for note in notes:
        kinds.setdefault(Finding("doubt", note).kind, []).append(note)
    return [
        note
        for alike in kinds.values()
        for note in (alike if len(alike) <= FEW else [f"{alike[0]}, and {len(alike) - 1} more like it"])
    ]


def _irregular_sentence(motion: Overview) -> str:
    if motion.dominant_hz is None:
        return "no whole cycle: nothing moves"
    return f"no repeating cycle: strongest at {motion.dominant_hz:.2g} Hz, {1e3 * motion.rms_speed:.3g} mm/s rms"


def _undeclared(recognised: tuple[Recognised, ...]) -> list[str]:
    """Notes on channels that show a moving average which nobody declared, with the repair."""
    notes = []
    for group in _alike(recognised):
        # a window that shows on the converter's grid alone has no standard errors (NaN)
        clearest = max(group, key=lambda channel: 0.0 if math.isnan(channel.sigmas) else channel.sigmas)
        names = " and ".join(channel.channel for channel in group)
        part = f", {clearest.periods:.2g} of the period" if clearest.periods is not None else ""
        signs = [f"{channel.channel} differences on its grid" for channel in group if channel.on_grid is not None]
        if not math.isnan(clearest.sigmas):
            signs.insert(0, f"zeros {clearest.contrast:.2g} dB deep, {clearest.sigmas:.2g} standard errors")
        notes.append(
            f"{names} smoothed? a moving average over {clearest.window:.4g} s ({clearest.samples} samples{part}) shows in the "
            f"spectrum, {'; '.join(signs)}: declare it, --smoothed '{clearest.samples} samples'"
        )
    return notes


def _declared(record: Record) -> list[str]:
    """Notes on channels that are declared smoothed."""
    if record.smoothed is None:
        return []
    left = record.smoothed.channels
    notes = [f"{' and '.join(left)} smoothed over {record.smoothed.window:.4g} s, as declared, and not undone"]
    if "displacement" in left:
        notes.append("the model runs on a smoothed displacement, which is less sharp than what the damper felt")
    return notes


def _alike(recognised: tuple[Recognised, ...]) -> list[list[Recognised]]:
    """Channels together whose windows agree to two hundredths, or to a sample."""
    groups: list[list[Recognised]] = []
    for channel in sorted(recognised, key=lambda channel: channel.samples):
        if groups and channel.samples - groups[-1][0].samples <= max(1.0, SAME_WINDOW * channel.samples):
            groups[-1].append(channel)
        else:
            groups.append([channel])
    return [sorted(group, key=recognised.index) for group in groups]
