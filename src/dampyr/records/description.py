"""All that is known of a record without its samples, for a table or for machines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from dampyr.findings import Finding, Severity, findings_of
from dampyr.records.checks.label_checks import creates_energy, disagreements
from dampyr.records.checks.overview import Overview, overview
from dampyr.records.checks.quality import Quality, quality
from dampyr.records.conditioning.integrated_displacement import is_integrated
from dampyr.records.conditioning.lowpass import DisplacementNoise, displacement_noise
from dampyr.records.conditioning.smoothing_recognition import Recognised, recognise_smoothing
from dampyr.records.cycle_analysis.cycle_table import cycle_table
from dampyr.records.cycle_analysis.cycles import cut_cycles
from dampyr.records.cycle_analysis.measure import measure
from dampyr.records.record import GROUPS, Record
from dampyr.records.record_cache import cached_by_record

SAME_WINDOW = 0.02  # of the window: as well as the zeros of a short record tell it
FEW = 3  # notes of one kind that a record has one by one
LookedAt = tuple[Overview, Quality, DisplacementNoise, tuple[Recognised, ...]]


def describe(record: Record) -> dict[str, Any]:
    """All that is said and measured of a record, SI.

    Name, role, session, specimen, input, label, what was measured, how well it was sampled, and ``findings``: what a person
    should look at.

    ``measured`` is None where the motion does not repeat itself: then ``overview`` stands for it, and ``levels`` for
    a test with rising or falling strokes. ``input_range`` is the least and the largest input, None where it is not
    known. ``smoothing`` holds the moving averages that channels show and that are not declared, ``smoothed`` the one
    that is declared and not undone, ``noise`` what the displacement's noise does, ``marks`` the faults that the
    recorder saw, ``uncertainty`` the standard uncertainty of each channel and its parts.
    """
    seen, sampled, noise, smoothing = _looked_at(record)
    measured = measure(record) if seen.repeats else None
    return {
        "name": record.name,
        "role": record.role,
        **{name: getattr(record, name) for name in GROUPS},
        "origin": record.origin.as_dict(),
        "input": record.input,
        "input_value": record.input_value,
        "input_range": _range(record),
        "duration_s": record.duration,
        "label": record.label,
        "measured": measured,
        "levels": describe_levels(record),
        "overview": seen,
        "quality": sampled,
        "smoothing": smoothing,
        "smoothed": record.smoothed,
        "noise": noise,
        "marks": record.marks,
        "uncertainty": {
            name: {"standard": one.standard, "largest": one.largest, "parts": dict(one.parts)}
            for name, one in record.uncertainty.items()
        },
        "findings": [replace(finding, about=()).as_dict() for finding in record.findings],
        "history": record.history,
        "provenance": record.provenance,
    }


@cached_by_record
def _looked_at(record: Record) -> LookedAt:
    return overview(record), quality(record), displacement_noise(record), recognise_smoothing(record)


def describe_levels(record: Record) -> list[dict[str, Any]]:
    """The levels of a test with rising or falling strokes, SI: number, cycles, stroke, frequency and the mean energy
    of a cycle.

    Empty for any other motion.
    """
    made = cut_cycles(record)
    if not made.graded:
        return []
    energies: dict[int, list[float]] = {}
    for one in cycle_table(record):
        energies.setdefault(one.level, []).append(one.energy)
    return [
        {"number": each.number, "cycles": each.count, "stroke_m": each.stroke_m, "frequency_hz": 1.0 / each.period_s,
         "energy_per_cycle": float(np.mean(energies[each.number]))}
        for each in made.levels
    ]  # fmt: skip


def _in_levels(record: Record) -> str:
    made = cut_cycles(record)
    strokes = [1e3 * each.stroke_m for each in made.levels]
    span = f"{min(strokes):.3g} to {max(strokes):.3g} mm peak to peak"
    if made.stepped:
        return f"{len(made.levels)} levels, {len(made.cycles)} whole cycles of {made.run:g}, {span}"
    return f"strokes that rise or fall from cycle to cycle: {len(made.cycles)} whole cycles of {made.run:g}, {span}"


@findings_of.register(Record)
@cached_by_record
def _(record: Record) -> tuple[Finding, ...]:
    """All that a person should look at in a record: its ``findings``."""
    by_kind = findings_by_kind(record).values()
    return tuple(
        dict.fromkeys(Finding(severity, words, (record.name,)) for severity, some in by_kind for words in some)
    )


def findings_by_kind(record: Record) -> dict[str, tuple[Severity, list[str]]]:
    """The severity and the sentences of every kind of finding, whether the record has it or not; in the order of findings."""
    seen, sampled, noise, smoothing = _looked_at(record)
    against = [words.removeprefix(f"{record.name}: ") for words in disagreements(record)]
    energy = against[-1:] if creates_energy(record) else []
    irregular = [] if seen.repeats else [_in_levels(record) if cut_cycles(record).graded else _irregular(seen)]
    integrated = [f"displacement {record.provenance['displacement']}"] if is_integrated(record) else []
    doubts = {
        "mark": list(record.marks),
        "label": against[: len(against) - len(energy)],
        **sampled.by_kind,
        "undeclared smoothing": _undeclared(smoothing),
        "noise": list(noise.notes),
    }
    notes = {"integrated": integrated, "irregular": irregular, "declared smoothing": _declared(record)}
    return {
        "created energy": ("wrong", energy),
        **{kind: ("doubt", _condensed(some)) for kind, some in doubts.items()},
        **{kind: ("note", some) for kind, some in notes.items()},
    }


def _condensed(notes: Sequence[str]) -> list[str]:
    """The notes, those that are many of one kind, such as gaps, as the first of them and how many more there are."""
    kinds: dict[str, list[str]] = {}
    for note in notes:
        kinds.setdefault(Finding("doubt", note).kind, []).append(note)
    return [
        words
        for some in kinds.values()
        for words in (some if len(some) <= FEW else [f"{some[0]}, and {len(some) - 1} more like it"])
    ]


def _irregular(seen: Overview) -> str:
    if seen.dominant_hz is None:
        return "no whole cycle: nothing moves"
    return f"no repeating cycle: strongest at {seen.dominant_hz:.2g} Hz, {1e3 * seen.rms_speed:.3g} mm/s rms"


def _undeclared(recognised: tuple[Recognised, ...]) -> list[str]:
    """What is smoothed, as it shows, with the repair."""
    notes = []
    for here in _alike(recognised):
        one = max(here, key=lambda each: each.sigmas if each.sigmas == each.sigmas else 0.0)
        names = " and ".join(each.channel for each in here)
        part = f", {one.periods:.2g} of the period" if one.periods is not None else ""
        signs = (
            [] if one.sigmas != one.sigmas else [f"zeros {one.contrast:.2g} dB deep, {one.sigmas:.2g} standard errors"]
        )
        signs += [f"{each.channel} differences on its grid" for each in here if each.on_grid is not None]
        notes.append(
            f"{names} smoothed? a moving average over {one.window:.4g} s ({one.samples} samples{part}) shows in the spectrum, "
            f"{'; '.join(signs)}: declare it, --smoothed '{one.samples} samples'"
        )
    return notes


def _declared(record: Record) -> list[str]:
    """What is smoothed, as it is declared."""
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
    for one in sorted(recognised, key=lambda each: each.samples):
        if groups and one.samples - groups[-1][0].samples <= max(1.0, SAME_WINDOW * one.samples):
            groups[-1].append(one)
        else:
            groups.append([one])
    return [sorted(group, key=recognised.index) for group in groups]


def _range(record: Record) -> list[float] | None:
    value = record.voltage if record.voltage is not None else record.current
    if value is None:
        return None
    return [value, value] if isinstance(value, float) else [float(np.min(value)), float(np.max(value))]
