"""What a score shows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, fields
from typing import Any

import numpy as np

from dampyr.identification.scoring.score import Score
from dampyr.input_kinds import ALL_RECORDS, NO_INPUT
from dampyr.phrases import percent
from dampyr.records import Record
from dampyr.show.descriptions import Description, describe


@describe.register
def describe_score(score: Score) -> Description:
    """The errors of the force, of its peak and of the energy, the level, and which samples were scored."""
    rows = [
        ("NRMSE", f"{percent(score.nrmse)}, R² {score.r2:.4g}"),
        ("pointwise", percent(score.pointwise)),
        ("peak force", f"{100 * score.peak_force:+.3g} % against the measured one"),
        ("energy", f"{100 * score.energy:+.3g} % against the measured one, per cycle"),
        ("level", f"{score.level:.4g} by the first cycles; with it L1 {percent(score.relevelled_l1)}"),
        ("offset", f"{score.offset:.4g} N"),
        ("window", f"{score.window.start:.4g} … {score.window.end:.4g} s"),
    ]
    if score.band is not None:
        rows.append((f"{percent(score.band.level)} band", score.band.words))
    return Description(f"Score, L1 {percent(score.l1)}", rows, data=lambda: _numbers(score))


def _numbers(score: Score) -> dict[str, Any]:
    """Plain numbers, for JSON; ``band`` is there where there is one."""
    values = {field.name: getattr(score, field.name) for field in fields(score) if field.name != "band"}
    band = {} if score.band is None else {"band": score.band.as_dict()}
    return values | {"window": asdict(score.window)} | band


def group_by_input(records: Iterable[Record], values: Mapping[str, float]) -> dict[str, list[float]]:
    """The records' values under the words for their input, in its order; records without a value are left out."""
    groups: dict[str, list[float]] = {}
    for record in sorted(records, key=lambda r: -math.inf if r.input_value is None else r.input_value):
        if record.name in values:
            groups.setdefault(input_words(record), []).append(values[record.name])
    return groups


def input_words(record: Record) -> str:
    """Such as ``1.98 V``; the mean where the input varies, and ``all records`` where there is none."""
    if record.input == NO_INPUT:
        return ALL_RECORDS
    if record.input_value is None or record.input_channel is None:
        return "input not known"
    varies = np.ptp(record.input_channel) > 1e-9
    return f"{record.input_value:.5g} {record.input}" + (" (mean)" if varies else "")
