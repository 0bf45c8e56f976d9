"""Marks by the slow passes before and after a test, over the same place with the coil at 0 V, and by the load cell's shunt.

What they show, the zero, the hysteresis and the step of a known resistor, changes with the load cell's chain and not with what
was tested between them (`dampyr.rig.session.ArmedRig.verify`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from dampyr.campaigns.campaign_thresholds import USUAL, CampaignThresholds
from dampyr.campaigns.marks import Mark
from dampyr.rig.settings import RigSettings
from dampyr.rig.shunt import expected_step, slowest_rise
from dampyr.rig.slow_passes import NAME as KEPT
from dampyr.rig.slow_passes import SlowPass, usual_pass
from dampyr.rig.uncertainty_budget import Evidence, shunt_error, slow_errors


def zero_moved(evidence: Evidence, span: float = 0.0, allowed: CampaignThresholds = USUAL) -> list[Mark]:
    """A zero of the force that moved between the slow passes before and after the test, or since the run's first one.

    ``span`` [N] is the force's, peak to peak: a damper that relaxes slowly is not quite the same after a test.
    """
    if evidence.zero_shift is None:
        return []
    before, after = evidence.zero_shift
    for change, rise, since in (
        (after - before, evidence.rise, "in the test"),
        (after, evidence.warming, "since the run began"),
    ):
        limit = allowed.pass_shift + allowed.pass_shift_share * span + allowed.shift_per_kelvin * abs(rise)
        if abs(change) > limit:
            return [
                Mark(
                    f"the force's zero moved by {change:+.3g} N {since}, by slow passes at 0 V over the same place, "
                    f"{limit:.3g} N at most; look at the load cell"
                )
            ]
    return []


def gain_moved(evidence: Evidence, rig: RigSettings, allowed: CampaignThresholds = USUAL) -> list[Mark]:
    """A height of the damper's hysteresis that is another on the slow pass after the test than on that before it, or than on
    the run's first one: friction does not change so, and the gain of the load cell's chain is its scale.
    """
    if evidence.heights is None:
        return []
    first, before, after = evidence.heights
    # Each height is half of the difference of two means, and two of them are compared: together they err as a single mean does.
    error = slow_errors(rig)
    for earlier, rise, since in (
        (before, evidence.rise, "in the test"),
        (first, evidence.warming, "since the run began"),
    ):
        share = allowed.pass_height_share + allowed.height_per_kelvin * abs(rise)
        limit = allowed.pass_height * error + share * abs(earlier)
        if abs(after - earlier) > limit < abs(earlier):  # of a damper without friction nothing is told
            return [
                Mark(
                    f"the damper's hysteresis is {after:.4g} N high after the test, by slow passes at 0 V over the same place, "
                    f"{after / earlier - 1.0:+.1%} (+-{error / abs(earlier):.1%}) {since}: the gain of the load cell's chain "
                    "has changed, or the coil has a voltage where 0 V are commanded, or the damper is another; look at the "
                    "cell's amplifier and at the supply, and calibrate the cell again"
                )
            ]
    return []


def pass_to_compare(
    kept: Sequence[SlowPass], first: SlowPass, rig: RigSettings, allowed: CampaignThresholds = USUAL
) -> SlowPass | None:
    """What the ``first`` pass of a run is compared with; None where no pass that is kept is like it, or where the damper's
    friction is too small to tell anything.
    """
    earlier = usual_pass(kept, first)
    if earlier is None or _most_change(earlier, first, rig, allowed, allowed.run_height_share) >= abs(earlier.height):
        return None
    return earlier


def agreeing_passes(
    passes: Sequence[SlowPass], rig: RigSettings, allowed: CampaignThresholds = USUAL
) -> list[SlowPass]:
    """The passes of a run up to the first one that tells another gain, or a slower cell, than the run's first."""
    first, agreeing = passes[0], []
    for one in passes:
        change = abs(one.height - first.height)
        if change > _most_change(first, one, rig, allowed, allowed.pass_height_share) or _is_quiet(
            first, one, rig, allowed
        ):
            break
        agreeing.append(one)
    return agreeing


def describe_comparison(
    compared: tuple[SlowPass, SlowPass] | None, rig: RigSettings, allowed: CampaignThresholds = USUAL
) -> str:
    """What is known of the gain of the load cell's chain from before the run."""
    read = "read by the shunt across its bridge before and after each test; " if rig.wires.shunt else ""
    if compared is None:
        return (
            f"{read}not compared with an earlier run: no slow pass with this specimen and this calibration of the load cell "
            "is kept that tells it"
        )
    earlier, first = compared
    limit = _most_change(earlier, first, rig, allowed, allowed.run_height_share)
    return (
        f"{read}compared with the runs until {earlier.time[:10]} with this specimen: by the height of the hysteresis on the "
        f"first slow pass {first.height / earlier.height - 1.0:+.1%} (+-{limit / abs(earlier.height):.1%})"
    )


def differs_from_earlier_runs(evidence: Evidence, rig: RigSettings, allowed: CampaignThresholds = USUAL) -> list[Mark]:
    """A first slow pass of the run that is not what it was in the runs before it with the same specimen: another height of the
    damper's hysteresis, or a cell with less noise.
    """
    if evidence.compared is None:
        return []
    earlier, first = evidence.compared
    limit = _most_change(earlier, first, rig, allowed, allowed.run_height_share)
    other = f"name the damper that is mounted (specimen), or delete its passes in {KEPT} where it has changed"
    then = f"until {earlier.time[:10]} with the same specimen, {earlier.specimen!r}"
    if abs(first.height - earlier.height) > limit:
        gain = "the gain of the load cell's chain has changed since, or the damper has, or another one is mounted; "
        check = "check the cell with its shunt or a known weight, and calibrate it again; if it is right, "
        if evidence.shunts:
            gain, check = (
                "the cell's shunt shows what it should, so the damper has changed, or another one is mounted; ",
                "",
            )
        return [
            Mark(
                f"the damper's hysteresis is {first.height:.4g} N high on the run's first slow pass, at 0 V, and was "
                f"{earlier.height:.4g} N {then}, {first.height / earlier.height - 1.0:+.1%} "
                f"(+-{limit / abs(earlier.height):.1%}): {gain}{check}{other}"
            )
        ]
    if _is_quiet(earlier, first, rig, allowed):
        return [
            Mark(
                f"the load cell's noise from sample to sample is {first.noise / earlier.noise:.0%} of what it was {then}: its "
                "amplifier has grown slow, so that the force is late and its turns are rounded, or what disturbed it is gone; "
                f"look at it and at its filter, and measure its bandwidth again, or delete the passes in {KEPT}"
            )
        ]
    return []


def _most_change(
    earlier: SlowPass, later: SlowPass, rig: RigSettings, allowed: CampaignThresholds, share: float
) -> float:
    """N by which the heights of two passes may differ; the fluid of a damper thins as it warms."""
    warmer = abs(later.temperature - earlier.temperature)
    return allowed.pass_height * slow_errors(rig) + (share + allowed.height_per_kelvin * warmer) * abs(earlier.height)


def _is_quiet(earlier: SlowPass, later: SlowPass, rig: RigSettings, allowed: CampaignThresholds) -> bool:
    """Whether the cell's noise is less by so much that its amplifier has grown slow; below a step of the converter what is
    read is the converter's own noise, which no amplifier lessens.
    """
    return earlier.noise > rig.step / math.sqrt(3.0) and later.noise < allowed.quiet_share * earlier.noise


def shunt_differs(evidence: Evidence, rig: RigSettings, allowed: CampaignThresholds = USUAL) -> list[Mark]:
    """A step of the shunt across the load cell's bridge that is not what it was, or not what it should be, or slow."""
    if not evidence.shunts:
        return []
    first, before, after = evidence.shunts
    expected = expected_step(rig)
    look = "look at the load cell's amplifier and its supply, and calibrate the cell again"
    for step, earlier, since in ((after, before, "in the test"), (after, first, "since the run began")):
        limit = allowed.pass_height * math.sqrt(2.0) * slow_errors(rig) + allowed.shunt_share * abs(earlier.force)
        change = step.force - earlier.force
        if abs(change) > limit < abs(earlier.force):
            return [
                Mark(
                    f"the step of the shunt across the load cell's bridge is {step.force:.4g} N after the test, "
                    f"{change / earlier.force:+.1%} (+-{limit / abs(earlier.force):.1%}) {since}: the gain of the cell's chain "
                    f"has changed; {look}",
                    spoils=abs(change) > allowed.spoiling_share * abs(earlier.force),
                )
            ]
    error = shunt_error(rig)
    if abs(after.force - expected) > allowed.shunt_expected * error:
        return [
            Mark(
                f"the shunt across the load cell's bridge gives {after.force:.4g} N, and {expected:.4g} N "
                f"(+-{allowed.shunt_expected * error:.2g} N) are expected of {rig.load_cell.shunt:g} ohm: the gain of the "
                f"cell's chain is not the calibrated one; {look}"
            )
        ]
    slowest = slowest_rise(rig)
    if max(before.rise, after.rise) > slowest:
        return [
            Mark(
                f"the step of the shunt across the load cell's bridge takes {1e3 * max(before.rise, after.rise):.3g} ms, "
                f"{1e3 * slowest:.3g} ms at most by load_cell.bandwidth: the cell's amplifier has grown slow, so that the "
                "force is late and its turns are rounded; look at it and at its filter"
            )
        ]
    return []


def passes_differ(
    evidence: Evidence, rig: RigSettings, span: float = 0.0, allowed: CampaignThresholds = USUAL
) -> list[Mark]:
    """What the slow passes before and after a test show: a gain that changed, a zero that moved by more than that explains."""
    gain = (
        shunt_differs(evidence, rig, allowed)
        or gain_moved(evidence, rig, allowed)
        or differs_from_earlier_runs(evidence, rig, allowed)
    )
    if gain and evidence.zero_shift is not None and evidence.heights is not None and evidence.heights[0]:
        first, before, after = evidence.heights
        by_gain = [evidence.first_mean * (height / first - 1.0) for height in (before, after)]
        moved = tuple(shift - scaled for shift, scaled in zip(evidence.zero_shift, by_gain, strict=True))
        evidence = replace(evidence, zero_shift=(moved[0], moved[1]))
    return gain + (zero_moved(evidence, span, allowed) or zero_unexpected(evidence, allowed))


def zero_unexpected(evidence: Evidence, allowed: CampaignThresholds = USUAL) -> list[Mark]:
    """A force on the run's first slow pass that is not what the damper's card promises: it was there before, and stays."""
    expected = evidence.expected_mean
    if expected is None or evidence.zero_shift is None:
        return []
    limit = allowed.pass_expected + allowed.pass_expected_share * abs(expected)
    if abs(evidence.first_mean - expected) <= limit:
        return []
    return [
        Mark(
            f"the force is {evidence.first_mean:.4g} N on the run's first slow pass at 0 V, its mean of both ways, and by the "
            f"damper's card it is {expected:.4g} N, {limit:.3g} N more or less: look at the load cell's zero and for a shunt "
            "that is on, or whether it is this damper"
        )
    ]
