"""A hybrid test on an actuator that does what it is asked for a fixed time later, with a damper's model as the specimen."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.hybrid import substructure_kernel
from dampyr.hybrid.substructure import Substructure, SubstructureRun
from dampyr.models import Damper
from dampyr.models.codegen.kernels import bind

Array = NDArray[np.float64]


def run_delayed(
    about: Substructure,
    specimen: Damper,
    delay: float,
    lead: float | None = None,
    seen: Callable[[SubstructureRun], None] | None = None,
) -> SubstructureRun:
    """The hybrid test of ``specimen`` on an actuator with a ``delay`` [s], whose set points are sent ``lead`` s ahead of their
    time (None: as long as the delay); the run, ended early where its error of energy passed its limit.

    ``seen`` is called after every step.
    """
    h = about.h
    lead = delay if lead is None else lead
    for name, value in (("delay", delay), ("lead", lead)):
        if not 0.0 <= value <= 1.0:
            raise InputError(f"{name} = {value:g} s is not allowed; it must be from 0 to 1 s")
    ahead, late = round(lead / h), (delay - lead) / h + (lead / h - round(lead / h))
    run, follow = about.run(), bind(substructure_kernel.follow_path, (specimen.composition,))
    s, p = (
        np.array(specimen.composition.state0, float),
        np.ascontiguousarray(specimen.values(about.voltage, static=False)),
    )
    y, out = np.zeros(2), np.zeros(1)
    run.set_points(ahead)
    while not run.over:
        k = run.now + 1
        run.set_points(min(k + ahead, about.steps))
        place = min(max(0.0, k - late), run.given)
        whole = int(place)
        last = min(whole + 1, run.given)
        y[1] = run.sent[whole] + (place - whole) * (run.sent[last] - run.sent[whole])
        follow(y, h, 0, 1, s, p, out)
        run.measured(y[1], out[0])
        y[0] = y[1]
        if seen is not None:
            seen(run)
        if run.energy_error > about.energy_limit:
            break
    return run
