"""A virtual hybrid test at 4096 Hz: dampyr's compiled loop, and the same loop with numpy's matrices and scipy's filters."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr.ground_motions import el_centro
from dampyr.hybrid import HybridSetup, KalmanCompensator, PhaseLeadCompensator, perform_virtual, run_many
from dampyr.hybrid.setup import IDEAL
from dampyr.hybrid.virtual_test import ground_history
from dampyr.studies.vrths_2020.benchmark import structure

Array = NDArray[np.float64]

PLANTS = 16
SHARE = 16  # of the motion that the loops in Python go through: their time is proportional to it
TITLE = "Virtual hybrid test of the benchmark of 2020, case 1, 4096 Hz, El Centro 1940: time of one run"


def run(data: Path | None) -> list[Line]:
    """One run of each; the batch's line is the time of a plant, on all processors."""
    motion = el_centro().scaled(0.4)
    quiet, noisy = HybridSetup(structure(1), sensors=IDEAL), HybridSetup(structure(1))
    sample, own = PhaseLeadCompensator(), KalmanCompensator.designed(noisy)
    part = motion.changed(motion.acceleration[: motion.n // SHARE], "its start")
    contenders: dict[str, Callable[[], Any]] = {
        "dampyr, sample controller, no noise": lambda: perform_virtual(quiet, sample, motion),
        "dampyr, Kalman, with noise": lambda: perform_virtual(noisy, own, motion),
        f"dampyr, {PLANTS} random plants with criteria, a plant": lambda: run_many(noisy, own, motion, PLANTS),
        "numpy and scipy, sample controller": lambda: by_numpy(quiet, part),
    }
    own_part = perform_virtual(quiet, sample, part).displacement
    gap = float(np.max(np.abs(by_numpy(quiet, part) - own_part)) / np.max(np.abs(own_part)))
    lines = race(contenders, {"numpy and scipy, sample controller": f"displacement within {gap:.0e}"}, rounds=3)
    names = list(contenders)
    factor = {names[2]: 1.0 / PLANTS, names[3]: motion.duration / part.duration}
    return [
        Line(each.name, each.median * f, each.fastest * f, each.rounds, each.error)
        for each in lines
        for f in [factor.get(each.name, 1.0)]
    ]


def by_numpy(setup: HybridSetup, motion: Any) -> Array:
    """The specimen's displacement (T,), as a script would compute it: matrices, and the controllers as filters with state."""
    from scipy.signal import bilinear, lfilter

    numerical, by_ground, by_force = setup.numerical_step
    plant, command = setup.plant_step
    ground = ground_history(motion, setup.dt)
    lead = bilinear([50.83163360273612, 8570.397339444286], [1.0, 8570.397339444286], setup.rate)
    pi = bilinear([2.0, 95.0], [1.0, 0.0], setup.rate)
    lead_state, pi_state = np.zeros(1), np.zeros(1)
    z, p, late, x = np.zeros(6), np.zeros(5), 0.0, np.zeros(len(ground))
    for k in range(len(ground)):
        x[k], force = p[3], p[2]
        wanted, lead_state = lfilter(*lead, z[:1], zi=lead_state)
        u, pi_state = lfilter(*pi, wanted - p[3], zi=pi_state)
        if k + 1 < len(ground):
            z = numerical @ z + by_ground @ ground[k : k + 2] + by_force * late
        p, late = plant @ p + command * u[0], force
    return x
