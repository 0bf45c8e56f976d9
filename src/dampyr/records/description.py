"""All that is known of a record without its samples, for a table or for machines."""

from __future__ import annotations

from typing import Any

import numpy as np

from dampyr.records.integrated_displacement import is_integrated
from dampyr.records.label_checks import disagreements
from dampyr.records.lowpass import displacement_noise
from dampyr.records.measure import measure
from dampyr.records.overview import Overview, overview
from dampyr.records.quality import quality
from dampyr.records.record import COMMENTS, Record
from dampyr.records.smoothing_recognition import Recognised, recognise_smoothing

SAME_WINDOW = 0.02  # of the window: as well as the zeros of a short record tell it


def describe(record: Record) -> dict[str, Any]:
    """All that is said and measured of a record, SI.

    Name, role, session, specimen, input, label, what was measured, how well it was sampled, and in ``notes`` what a person
    should look at.

    ``measured`` is None where the motion does not repeat itself: then ``overview`` stands for it. ``input_range`` is the least
    and the largest input, None where it is not known. ``smoothing`` holds the moving averages that channels show and that are
    not declared, ``smoothed`` the one that is declared and not undone, ``noise`` what the displacement's noise does,
    ``marks`` the faults that the recorder saw, ``uncertainty`` the standard uncertainty of each channel and its parts.
    """
    seen = overview(record)
    measured = measure(record) if seen.repeats else None
    notes = disagreements(record)
    if measured is None:
        notes = [_irregular(seen), *notes]
    if is_integrated(record):
        notes = [f"displacement {record.provenance['displacement']}", *notes]
    sampled, noise, smoothing = quality(record), displacement_noise(record), recognise_smoothing(record)
    return {
        "name": record.name,
        "role": record.role,
        **{name: getattr(record, name) for name in COMMENTS},
        "input": record.input,
        "input_value": record.input_value,
        "input_range": _range(record),
        "duration_s": record.duration,
        "label": record.label,
        "measured": measured,
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
        "notes": [
            *record.marks,
            *(note.removeprefix(f"{record.name}: ") for note in notes),
            *sampled.notes,
            *_smoothing_notes(record, smoothing),
            *noise.notes,
        ],
        "history": record.history,
        "provenance": record.provenance,
    }


def _irregular(seen: Overview) -> str:
    if seen.dominant_hz is None:
        return "no whole cycle: nothing moves"
    return f"no repeating cycle: strongest at {seen.dominant_hz:.2g} Hz, {1e3 * seen.rms_speed:.3g} mm/s rms"


def _smoothing_notes(record: Record, recognised: tuple[Recognised, ...]) -> list[str]:
    """What is smoothed, as it shows and as it is declared, with the repair."""
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
    if record.smoothed is not None:
        left = record.smoothed.channels
        notes.append(f"{' and '.join(left)} smoothed over {record.smoothed.window:.4g} s, as declared, and not undone")
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
