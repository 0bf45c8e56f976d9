"""What the quality of a record shows."""

from __future__ import annotations

from dampyr.records.checks.quality import Quality
from dampyr.records.record import CHANNELS
from dampyr.show.descriptions import Description, describe


@describe.register
def describe_quality(quality: Quality) -> Description:
    """Samples, jitter and gaps, and what is wrong with single channels."""
    per_cycle = "no whole cycle" if quality.per_cycle is None else f"{quality.per_cycle:.4g} per cycle"
    rows = [
        ("samples", f"{quality.samples}, every {1e3 * quality.dt:.4g} ms, {per_cycle}"),
        ("jitter", f"{100 * quality.jitter:.2g} % of the interval"),
        ("gaps", f"{len(quality.gaps)}" + (f", the first at {quality.gaps[0][0]:.4g} s" if quality.gaps else "")),
    ]
    rows += [(f"{name} step", f"{value:.3g} {CHANNELS[name]}") for name, value in quality.quantum.items()]
    rows += [(f"{name} saturated", f"{count} samples") for name, count in quality.saturated.items()]
    rows += [
        (f"{name} spikes", f"{len(times)}, the first at {times[0]:.4g} s") for name, times in quality.spikes.items()
    ]
    if quality.leaps:
        rows.append(("displacement leaps", f"{len(quality.leaps)}, the first at {quality.leaps[0]:.4g} s"))
    if quality.run_away:
        rows.append(("middle of the stroke", f"runs away by {1e3 * quality.run_away:.3g} mm"))
    return Description("Quality", rows)
