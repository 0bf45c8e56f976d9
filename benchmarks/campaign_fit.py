"""One Dahl fit per record of the published campaign, against scipy's least squares over the same kernel."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr.identification import fit
from dampyr.identification.fit_data import Piece, piece
from dampyr.models import compose
from dampyr.models.path_integration import along
from dampyr.records import Record, read_campaign

JOINT = "dampyr, one joint fit of all records with dahl + hyperbolic_tangent + spring + delay"
COMPOSITION = "dahl + hyperbolic_tangent + spring + delay"
FIXED = {"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.s": 0.0}
PEER = "scipy least_squares, finite differences, no errors"
TITLE = "Dahl fit of each record of the published campaign (kx, kw, rho, the force's offset and the initial state)"


def run(data: Path | None) -> list[Line] | str:
    """`fit` with its choice of a start and its standard errors; least squares from one start, which gives no errors."""
    folder = data / "labcontrol-mr-damper" if data else None
    if folder is None or not folder.is_dir():
        return "the campaign's files are not on this machine; `dampyr datasets fetch labcontrol` gets them"
    records = read_campaign(folder)
    ours = np.array([identified(record) for record in records])
    peers = np.array([searched(piece(record, None)) for record in records])
    apart = np.max(np.abs(peers / ours - 1.0), axis=1)
    agree = f"{np.sum(apart < 1e-3)} of {len(records)} agree to 0.1 % in kx, kw and rho (median {np.median(apart):.0e})"
    contenders = {
        f"dampyr fit, {len(records)} records, with errors": lambda: [identified(record) for record in records],
        PEER: lambda: [searched(piece(record, None)) for record in records],
    }
    lines = race(contenders, {PEER: agree}, rounds=5)
    each = lines[0]
    return [
        *lines,
        *race({JOINT: lambda: fit(COMPOSITION, records, bandwidth=8.0, fixed=FIXED)}, {}, rounds=3),
        Line("dampyr fit, per record", each.median / len(records), each.fastest / len(records), each.rounds),
    ]


def identified(record: Record) -> list[float]:
    """kx, kw and rho by dampyr."""
    return list(fit("dahl", record).parameters.values())


def searched(one: Piece) -> list[float]:
    """kx, kw and rho by least squares over offset, w(0) and these three, scaled, with derivatives by finite differences."""
    from scipy.optimize import least_squares

    composition = compose("dahl")
    middle, reach = float(np.mean(one.force)), 0.5 * float(np.ptp(one.force))
    scale = np.array([1000.0, reach, 10.0 / float(np.ptp(one.x)), reach, 1.0])

    def residual(z: Any) -> Any:
        kx, kw, rho, f0, w0 = z * scale
        model = along(composition, one.t, one.x, one.v, np.array([kx, kw, rho]), np.array([w0]))
        return (middle + f0 + model - one.force) / reach

    low, high = [0.0, 1e-9, 1e-9, -np.inf, -1.0], [np.inf, np.inf, np.inf, np.inf, 1.0]
    solution = least_squares(
        residual, [1.0, 0.8, 1.0, 0.0, 0.0], bounds=(low, high), xtol=1e-10, ftol=1e-10, gtol=1e-10
    )
    return [float(value) for value in (solution.x * scale)[:3]]
