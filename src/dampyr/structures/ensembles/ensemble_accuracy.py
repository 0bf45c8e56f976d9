"""Accuracy of an ensemble: the bounds of its two accuracies, and what was measured against them, in words."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

# Of a peak displacement or drift above 0.1 mm and 1 % of the largest of its case. The largest errors of 466 random dampers,
# buildings and motions were 0.75 % and 0.06 %. tests/structures/ensembles/test_ensemble_bounds.py runs 2,000 in `make endure`.
BOUNDS = {"fast": 0.02, "strict": 1e-3}
FLOOR = "peaks above 0.1 mm and 1 % of the largest of their case"


def truncation_in_words(attributes: Mapping[str, Any]) -> str:
    """What reduced structures of an ensemble leave out, from the ``attrs`` of its dataset, as a sentence; "" for whole ones."""
    names = {
        "truncation_error": "displacements and drifts",
        "truncation_error_acceleration": "accelerations",
        "truncation_error_force": "damper forces",
    }
    changes = {peaks: attributes[name] for name, peaks in names.items() if name in attributes}
    if not changes:
        return ""
    if math.inf in changes.values():
        return "reduced structure: dashpots on what has no mass follow the springs, and what that changes is not known"
    listed = ", ".join(f"{peaks} {100 * value:.2g} %" for peaks, value in changes.items())
    judge = "half as many coordinates, with the dampers"
    return f"reduced structure: beside {judge}, peaks of the judged cases differ by at most: {listed}"


def under_laws(attributes: Mapping[str, Any]) -> str:
    """What half the step changes in cases under control laws, from the ``attrs`` of a dataset, as a sentence; "" without laws.

    No doubt and no error: where a decision falls the other way a case is another one, at any step, while the means hardly move.
    """
    judged = attributes.get("judged_under_laws", 0)
    if not judged:
        return ""
    names = ("drift", "acceleration", "force")
    means = ", ".join(_change(attributes, name) for name in names)
    return (
        f"under control laws, {attributes['changed_under_laws']} of {judged} cases at random change a peak of displacement or "
        f"drift by more than {100 * BOUNDS[attributes['accuracy']]:.2g} % at half the step, as a decision falls the other way; "
        f"mean peaks change by: {means}; take means and shares of many cases from this, and run a single case by itself"
    )


def _change(attributes: Mapping[str, Any], name: str) -> str:
    change, error = (100 * attributes[f"{part}_of_mean_{name}"] for part in ("change", "error"))
    return f"{name} {change:+.2g} % ± {error:.2g} %"


def outside_sentence(beyond: int, cases: int, times: float, limits: Sequence[float]) -> str:
    """How many of the ``cases`` with calibrated dampers leave the displacement [m] that these were calibrated on, one of
    ``limits``, and by how much; "" for none.

    A note and no error: strong motion takes most dampers beyond the strokes of their tests. Velocities are not among the peaks.
    """
    if not beyond:
        return ""
    span = " to ".join(dict.fromkeys(f"{1e3 * limit:.3g}" for limit in (min(limits), max(limits))))
    return (
        f"in {beyond} of {cases} cases ({100 * beyond / cases:.0f} %) a damper's stroke leaves the {span} mm that it was "
        f"calibrated on, by up to {times:.1f} times: the force there is extrapolated"
    )


def doubts(attributes: Mapping[str, Any]) -> list[str]:
    """What is wrong with the accuracy or the cases of an ensemble, from the ``attrs`` of its dataset; sentences, or none."""
    sentences = []
    bound, error = BOUNDS[attributes["accuracy"]], attributes["error_estimate"]
    if error > bound:
        moving = attributes.get("error_estimate_moving")
        among = "" if moving is None else f", and by {100 * moving:.2g} % among {FLOOR}"
        remedy = (
            "take accuracy 'strict'"
            if attributes["accuracy"] == "fast"
            else "run such cases one by one, with `respond`"
        )
        sentences.append(
            f"peaks changed by up to {100 * error:.2g} % on halving the step{among}: more than the {100 * bound:.2g} % of "
            f"accuracy '{attributes['accuracy']}'; {remedy}, or leave out what hardly moves"
        )
    if unconverged := attributes.get("unconverged", 0):
        sentences.append(
            f"{unconverged} cases under control laws are not to their accuracy: decisions that hang on the step change their "
            f"peaks of displacement or drift, by up to {100 * error:.2g} %; give the coil a lag or the law a longer period, "
            "or run such a case with `respond`, which says why"
        )
    if attributes["unbounded"]:
        sentences.append(
            f"{attributes['unbounded']} cases grew without bound: they have no peak, and count as exceeding every limit; check "
            "delays, signs and inputs"
        )
    return sentences
