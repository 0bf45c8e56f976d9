"""Labels against measurements: a label that disagrees with its own record is reported, never used."""

from __future__ import annotations

import numpy as np

from dampyr.records.checks.overview import work
from dampyr.records.cycle_analysis.cycles import cycle_bounds
from dampyr.records.cycle_analysis.measure import cycle_energies, measure
from dampyr.records.record import Record


def disagreements(record: Record, frequency: float | None = None, peak_to_peak: float | None = None) -> list[str]:
    """What does not agree in a record, one sentence each; an empty list when all agrees.

    The labelled frequency and peak-to-peak displacement are compared with the measured ones (tolerances relative to the
    measured, by default those of the record's thresholds, 5 % each), and the loops must dissipate energy, else the sign of the
    force is inverted; without a whole cycle the work over all of the record tells. A record without a whole cycle can confirm
    no label, and says so where it has one.
    """
    spans = cycle_bounds(record)
    sentences = []
    if record.label and spans:
        limits = record.thresholds
        sentences += _against_label(
            record,
            limits.label_frequency if frequency is None else frequency,
            limits.label_peak_to_peak if peak_to_peak is None else peak_to_peak,
        )
    elif record.label:
        sentences.append(f"{record.name}: no whole cycle, so its label cannot be checked")
    return sentences + _against_dissipation(record, spans)


def creates_energy(record: Record) -> bool:
    """Whether the loops of a record create energy, where a damper dissipates it: its force has the wrong sign."""
    return bool(_against_dissipation(record, cycle_bounds(record)))


def _against_dissipation(record: Record, spans: list[tuple[int, int]]) -> list[str]:
    energy = float(np.median(cycle_energies(record, spans))) if spans else work(record)
    if energy >= 0:
        return []
    span = "per cycle" if spans else "in all"
    return [
        f"{record.name}: its loops create energy ({-energy:.3g} J {span} where a damper dissipates); force sign inverted?"
    ]


def _against_label(record: Record, frequency: float, peak_to_peak: float) -> list[str]:
    label, measured = record.label, measure(record)
    assert label is not None
    sentences = []
    deviation = label.frequency_hz / measured.frequency_hz - 1.0
    if abs(deviation) > frequency:
        sentences.append(
            f"{record.name}: labelled {label.frequency_hz:.4g} Hz, measures {measured.frequency_hz:.4g} Hz "
            f"({100 * deviation:+.1f} %)"
        )
    deviation = label.peak_to_peak_m / measured.peak_to_peak_m - 1.0
    if abs(deviation) > peak_to_peak:
        sentences.append(
            f"{record.name}: labelled {1e3 * label.peak_to_peak_m:.4g} mm peak to peak, "
            f"measures {1e3 * measured.peak_to_peak_m:.4g} mm per cycle ({100 * deviation:+.1f} %)"
        )
    return sentences
