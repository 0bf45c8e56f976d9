"""A hybrid test without a rig: a damper's model on an actuator that is late, which is computed too."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.hybrid.delayed_actuator import run_delayed
from dampyr.hybrid.hybrid_result import HybridResult, modelled_force
from dampyr.hybrid.substructure import LARGEST_LAG, substructure_of
from dampyr.input_kinds import input_arguments
from dampyr.models import Damper
from dampyr.origin import combined
from dampyr.structures import Building, respond
from dampyr.structures.control_laws import describe_law, is_control_law

STEP = 0.001  # s of the computed part where the actuator is computed too


def delayed_result(
    building: Building,
    motion: GroundMotion,
    damper: Damper,
    delay: float,
    value: Any = 0.0,
    place: Any = 1,
    lag_error: float = 0.0,
    adaptive: bool = True,
    h: float = STEP,
) -> HybridResult:
    """The hybrid test of a damper's model on an actuator that is late; the same model predicts the force.

    Parameters
    ----------
    building, motion
        The computed part, and the ground's acceleration.
    damper
        The specimen, and the model that predicts its force.
    delay
        s by which the actuator is late, 0 to 0.05.
    value
        The damper's input, V or A, or a control law that sets it.
    place
        Where the damper stands: a storey, or two floors.
    lag_error
        s by which the actuator is later than it is taken to be.
    adaptive
        Whether the lag is followed during the test.
    h
        s of a step of the computed part.

    Returns
    -------
    HybridResult
        The floors' displacements beside those of the response with the damper's model, and the error of energy.

    Raises
    ------
    InputError
        The delay is too long, or the error of energy passes its limit: such a test would be unstable.

    Examples
    --------
    >>> import dampyr as dp
    >>> from dampyr.hybrid.delayed_hybrid import delayed_result
    >>> damper, motion = dp.studies.load_damper("raminelli_2020"), dp.ground_motions.el_centro()
    >>> result = delayed_result(dp.structures.two_storey(), motion, damper, 0.005)
    >>> bool(abs(result.differences).max() < 0.001)
    True
    """
    lag = delay - lag_error
    for name, number in (("delay", delay), ("delay - lag_error", lag)):
        if not 0.0 <= number <= LARGEST_LAG:
            raise InputError(f"{name} = {number:g} s is not allowed; it must be from 0 to {LARGEST_LAG:g} s")
    inputs = input_arguments(damper.input, value)
    computed = respond(building, motion, {place: damper}, **inputs)
    law = value if is_control_law(value) else None
    first = value if law is None else law.low
    part = replace(substructure_of(building, place, computed, h, damper, first), lag=lag, adaptive=adaptive)
    run = run_delayed(part, damper, delay, 0.0, law)
    if not run.over:
        raise InputError(
            f"the hybrid test of {computed.title} would be unstable on an actuator {1e3 * delay:g} ms late that is taken for "
            f"{1e3 * lag:g} ms late: the error of energy passes {100 * part.energy_limit:g} % of the ground's energy after "
            f"{run.now * h:.2f} s; identify the delay better, or take a lower voltage or a heavier building"
        )
    return HybridResult(
        computed.title, 1.0, 1.0, float(run.inputs[:-1].mean()), np.asarray(np.arange(run.now + 1) * h, float),
        np.ascontiguousarray(run.z[:, : building.n_floors].T),
        run.target, run.achieved, run.force, modelled_force(part, run), 0.0,
        delay - run.lag.lag, run.lag.gain, run.energy_error, computed,
        origin=replace(combined([damper.origin]), kind="virtual"), law="" if law is None else describe_law(law, damper.input),
        inputs=None if law is None else run.commands, input_unit=damper.input if law is not None else "V",
    )  # fmt: skip
