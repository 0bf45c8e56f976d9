"""The displacement of a test that has a velocity and no displacement."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from dampyr.records.checks.overview import repeats
from dampyr.records.conditioning.drift import drift
from dampyr.records.record import Array, Record

INTEGRATED = "integrated from the velocity"


def integral(time: Array, velocity: Array) -> Array:
    """The displacement (n,) in m of a velocity (n,) in m/s by trapezoids, 0 at the first sample."""
    return np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time))])


def is_integrated(record: Record) -> bool:
    """Whether the record's displacement is the integral of its velocity."""
    return record.provenance.get("displacement", "").startswith(INTEGRATED)


def with_integrated_displacement(*, velocity: Any, provenance: Mapping[str, str], **fields: Any) -> Record:
    """The record of a test without a displacement: x = integral of v by trapezoids, 0 at the first sample.

    An error b of the velocity's zero grows to b t. Where the motion repeats itself (:func:`dampyr.records.overview`), the
    drift of the mean position (:func:`dampyr.records.conditioning.drift.drift`) is therefore taken from the displacement,
    and its slope from the velocity; a real drift goes with it, as a velocity alone cannot tell the two apart. Where it does
    not, nothing is taken away. What was done, with its numbers, stands in the history, in the provenance (``displacement``)
    and in the notes of :func:`dampyr.records.describe`. ``velocity`` is ``(n,)`` in m/s; ``fields`` are the others of
    :class:`Record`, which raises what is wrong with them.
    """
    zeros = np.zeros(np.shape(velocity))  # so that faults of the velocity are reported as such
    record = Record(displacement=zeros, velocity=velocity, provenance=provenance, **fields)
    v, t = record.velocity, record.time
    assert v is not None
    x = integral(t, v)
    moved = record.replace(note=f"displacement {INTEGRATED} by trapezoids, 0 at the first sample", displacement=x)
    if repeats(moved):  # then the mean position of a cycle is known, and what it does from cycle to cycle is drift
        slope = drift(moved)
        left = f"drift of {1e3 * slope:.3g} mm/s, {1e3 * slope * record.duration:.3g} mm in all, removed"
        moved = moved.replace(
            note=f"{left} from it and from the velocity", displacement=x - slope * (t - t[0]), velocity=v - slope
        )
    else:
        left = f"no repeating cycle to judge its drift by, nothing removed: it ends {1e3 * x[-1]:.3g} mm from its start"
        moved = moved.replace(note=left)
    return moved.replace(
        note="", history=moved.history, provenance=dict(provenance) | {"displacement": f"{INTEGRATED}; {left}"}
    )
