"""A hybrid test on an actuator that does what it is asked for a fixed time later, with a damper's model as the specimen."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.hybrid import substructure_kernel
from dampyr.hybrid.substructure import Substructure, SubstructureRun
from dampyr.models import Damper
from dampyr.models.codegen.kernels import bind
from dampyr.models.laws import look_up, polynomial_table
from dampyr.structures.law_input import LawInput

Array = NDArray[np.float64]


def run_delayed(
    part: Substructure,
    specimen: Damper,
    delay: float,
    lead: float | None = None,
    law: Any = None,
) -> SubstructureRun:
    """The hybrid test of a damper's model on an actuator that is late by a fixed time.

    Parameters
    ----------
    part
        The computed part.
    specimen
        The damper whose force answers the actuator's displacement, at ``part.voltage``.
    delay
        s by which the actuator is late, 0 to 1.
    lead
        s by which set points are sent ahead of their time, 0 to 1; None: as long as the delay.
    law
        A control law that sets the input of the specimen in the place of ``part.voltage``, and of the model that predicts its
        force: it decides at the ends of the steps on the computed structure, the ground and the specimen's force. One that
        ``part`` has itself decides on what is predicted, as on the rig.

    Returns
    -------
    SubstructureRun
        The run, ended early where its error of energy passed the limit of ``part``.

    Raises
    ------
    InputError
        ``delay`` or ``lead`` is outside of its range, or the law does not fit the specimen.
    """
    h = part.h
    lead = delay if lead is None else lead
    for name, value in (("delay", delay), ("lead", lead)):
        if not 0.0 <= value <= 1.0:
            raise InputError(f"{name} = {value:g} s is not allowed; it must be from 0 to 1 s")
    ahead, late = round(lead / h), (delay - lead) / h + (lead / h - round(lead / h))
    run, follow = part.run(), bind(substructure_kernel.follow_path, (specimen.composition,))
    s, p = (
        np.array(specimen.composition.state0, float),
        np.ascontiguousarray(specimen.values(part.voltage, static=False)),
    )
    y, out = np.zeros(2), np.zeros(1)
    decided = (
        None
        if law is None
        else LawInput(law, specimen, part.building, part.row, GroundMotion(part.ground, h, "ground"))
    )
    parameters = None if part.law is None else polynomial_table(specimen, static=False)
    run.set_points(ahead)
    while not run.over:
        k = run.now + 1
        if decided is not None:
            q, v = np.split(run.z[run.now], 2)
            decided.decide_at(run.now * h, q, v, float(out[0]))
            voltage = decided.input_at(k * h)
            p = np.ascontiguousarray(specimen.values(voltage, static=False))
            run.set_input(voltage)
            run.commands[run.now :] = decided.command
        run.set_points(min(k + ahead, part.steps))
        if parameters is not None:
            look_up(*parameters, float(run.inputs[k - 1]), p)
        place = min(max(0.0, k - late), run.given)
        index = int(place)
        last = min(index + 1, run.given)
        y[1] = run.sent[index] + (place - index) * (run.sent[last] - run.sent[index])
        follow(y, h, 0, 1, s, p, out)
        run.measured(y[1], out[0])
        y[0] = y[1]
        if run.energy_error > part.energy_limit:
            break
    return run
