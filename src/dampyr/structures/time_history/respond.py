r"""The response of a building with dampers to a ground motion, to loads on its floors, or to both.

The scheme (:mod:`dampyr.structures.time_history.time_stepping`) is one for every damper. Its step is chosen here: the final
one satisfies
:math:`\omega_s h \le 1/2`, with :math:`\omega_s^2 = k/m` of the dampers at rest, and is halved until no peak of displacement or
drift changes by more than the requested accuracy; under control laws until that is so twice, and of no decision that hangs on
the step.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from dampyr.argument_kinds import BUILDING, MOTION, Argument, check_kinds
from dampyr.errors import FindingWarning, InputError
from dampyr.findings import OF_DAMPER, handed_on
from dampyr.ground_motions import GroundMotion
from dampyr.input_kinds import NO_INPUT
from dampyr.options import takes
from dampyr.origin import combined
from dampyr.structures.building import Building, Condensed
from dampyr.structures.building_options import RespondOptions
from dampyr.structures.control_laws import describe_law
from dampyr.structures.ensembles.ensemble import ensemble
from dampyr.structures.ensembles.store import BARE, WITH_DAMPER
from dampyr.structures.floor_loads import FloorLoads
from dampyr.structures.sites import (
    Site,
    any_has_input,
    connections,
    describe_place,
    drawn_placements,
    drifts,
    input_of,
    installed,
    laws_of,
    make_sites,
    placement,
    warn_of_parts,
)
from dampyr.structures.supports import SupportedBuilding, SupportMotions
from dampyr.structures.time_history.kernel_run import runner
from dampyr.structures.time_history.linear_response import peak_displacement
from dampyr.structures.time_history.loading import Excitation, excitation
from dampyr.structures.time_history.modal_coordinates import ModalBuilding, refinements
from dampyr.structures.time_history.response import Energy, Integration, Output, Response, Truncation
from dampyr.structures.time_history.responses import INTERVAL, INTERVAL_OF, Responses
from dampyr.structures.time_history.step_size import (
    ACCURACIES,
    changes,
    given_steps_per_sample,
    halve_under_laws,
    halve_until_converged,
    largest_step,
    run_once,
    steps_per_sample,
    tolerance_of,
)

Array = NDArray[np.float64]
Progress = Callable[[str, float], None]

UNJUDGED = "no other: dashpots on what has no mass follow the springs, and what that changes is not known"
BEYOND = 1.01  # times a calibrated limit: what rounding and peaks between samples add does not leave it
FINAL_LIMIT = 0.5  # of omega h at the final step, which resolves the stuck damper's vibration with 12 steps a period


@overload
def respond(
    building: Building,
    motion: GroundMotion | SupportMotions | None,
    dampers: Any,
    voltage: list[Any] | tuple[Any, ...],
    current: None = None,
    options: RespondOptions | None = None,
    progress: Progress | None = None,
    loads: FloorLoads | None = None,
    **keywords: Any,
) -> Responses: ...


@overload
def respond(
    building: Building,
    motion: GroundMotion | SupportMotions | None = None,
    dampers: Any = None,
    voltage: None = None,
    *,
    current: list[Any] | tuple[Any, ...],
    options: RespondOptions | None = None,
    progress: Progress | None = None,
    loads: FloorLoads | None = None,
    **keywords: Any,
) -> Responses: ...


@overload
def respond(
    building: Building,
    motion: GroundMotion | SupportMotions | None = None,
    dampers: Any = None,
    voltage: Any = None,
    current: Any = None,
    options: RespondOptions | None = None,
    progress: Progress | None = None,
    loads: FloorLoads | None = None,
    **keywords: Any,
) -> Response: ...


@takes(RespondOptions)
def respond(
    building: Building,
    motion: GroundMotion | SupportMotions | None = None,
    dampers: Any = None,
    voltage: Any = None,
    current: Any = None,
    options: RespondOptions | None = None,
    progress: Progress | None = None,
    loads: FloorLoads | None = None,
    **keywords: Any,
) -> Response | Responses:
    """The response of ``building`` to ``motion`` and ``loads``, from rest: of one input, or beside one another of several.

    One input gives a `Response`. A list or a tuple of inputs, also of a single one, gives `Responses`: the building without
    dampers first, then a case for each input, with 90 % intervals of their peaks where ``draws`` is given. Without dampers an
    empty list gives the first of these alone.

    Parameters
    ----------
    building
        the building; one that was reduced (``keep`` in its file, a plane frame, `condense`) is taken with more coordinates
        than floors: the static answer to the force of each damper, and modes with the floors held (see
        `dampyr.structures.time_history.modal_coordinates`). Few degrees of freedom are whole then. Of more,
        ``response.truncation`` says how far peaks of displacement, drift, acceleration, base shear and force lie from those
        with half as many coordinates at the same step, the dampers present; without dampers, from those of all modes, where
        the building has them. It is another error than ``error_estimate``, which is of the step.
    motion
        the motion of the ground; the response ends with it, or ``after`` seconds later. Of a structure on several supports
        (`half_car`, `with_supports`) their `SupportMotions`. None where the loads act alone.
    dampers
        a damper, which stands in storey 1, or a mapping from place to a damper or a list of dampers in parallel. A place is a
        storey i, which joins the floors i-1 and i (0 is the ground), or any two floors (i, j) by label or count, such as
        (0, 2): the stroke is q_j - q_i, and (1, 2) is storey 2. None for the bare building. The static force of a damper is
        left out, springs stay.
    voltage, current
        the input of the dampers, V or A: a number, which is constant, or a control law
        (:func:`~dampyr.structures.control_laws.control_law`); one for all dampers, or a mapping from place to one. A list or a
        tuple of these are several inputs, each a case of its own; a damper without an input has one case, [None]. An array is
        neither, and is refused: what changes an input over time is a control law.
    options
        the further arguments as one object; those that are given by name take their places.
    progress
        called, where there are several inputs, with what is being done, and the fraction of all that is done.
    loads
        forces on the floors, `FloorLoads` or what `read_loads` gives, from the same zero of time as the motion. The response
        ends with the longer of the two, or ``after`` seconds later; its samples are the common step of both.

    The scheme is of fourth order, so that the error of the finer one of two steps is well below ``accuracy``, the change from
    one to the other. Under control laws two halvings must agree, and a run too in which every decision that hangs on the step
    is taken the other way. ``error_estimates`` has the changes of the other quantities, which may be larger.

    Warns (:class:`~dampyr.errors.DampyrWarning`) where the accuracy was not reached, where a damper, on the whole, fed the
    building, and where a damper has a part that is not for buildings.

    Raises
    ------
    InputError
        An argument is wrong, or the response grows without bound.

    Examples
    --------
    >>> import dampyr as dp
    >>> building, motion = dp.structures.two_storey(), dp.ground_motions.el_centro()
    >>> damper = dp.studies.raminelli_2020.damper()
    >>> response = dp.structures.respond(building, motion, dampers={1: damper}, voltage=1.98)
    >>> (1e3 * response.peak_displacement).round(2)
    array([ 7.45, 15.91])
    >>> list(dp.structures.respond(building, motion, dampers={1: damper}, voltage=[0.0, 1.98]).cases)
    ['no damper', '0 V', '1.98 V']
    """
    if isinstance(motion, FloorLoads):
        raise InputError("the motion is FloorLoads; give them by name, respond(building, None, ..., loads=loads)")
    check_kinds(
        "respond",
        Argument("building", building, (Building,), BUILDING),
        Argument("motion", motion, (GroundMotion, SupportMotions, *([] if loads is None else [type(None)])), MOTION),
    )
    chosen = RespondOptions.of("respond", options, keywords)
    pushed = excitation(building, motion, loads, chosen.after)
    kind, inputs = input_of(voltage, current)
    if isinstance(inputs, list | tuple):
        return _responses(
            building, pushed, placement(dampers), kind, inputs, chosen, progress or (lambda stage, done: None)
        )
    if chosen.draws is not None:
        raise InputError(
            f"draws = {chosen.draws} are for several inputs, and one is given; write it as a list, such as voltage=[1.98]"
        )
    return _respond(building, pushed, installed(placement(dampers), chosen), voltage, current, chosen)


def _responses(
    building: Building,
    pushed: Excitation,
    placed: Mapping[Any, Any],
    kind: str,
    inputs: list[Any] | tuple[Any, ...],
    options: RespondOptions,
    tell: Progress,
) -> Responses:
    """The case without dampers, then one for each input; an input that is given twice is one case."""
    if bool(placed) is not bool(inputs):
        raise InputError(
            f"no input and no control law is given; give one or more{'' if any_has_input(placed) else ': [None] is no input'}"
            if placed
            else f"{kind} = {inputs!r} is of dampers, and none are given; give dampers=, or leave the inputs out"
        )
    if options.draws is not None and not placed:
        raise InputError(
            f"draws = {options.draws} are of dampers, and none are given; give dampers=, or leave draws out"
        )
    if options.draws is not None and any(isinstance(value, Mapping) for value in inputs):
        raise InputError("draws take the same input for all dampers; give numbers or control laws, no mappings")
    if options.draws is not None and pushed.values.size:
        raise InputError(
            f"draws = {options.draws} are run as an ensemble, which knows the motion of one ground and no loads; leave draws "
            "out, and run damper.draws(...) one after another"
        )
    dampers = installed(placed, options)
    with (
        warnings.catch_warnings()
    ):  # errors are raised before anything is computed, doubts are warned of with their case
        warnings.simplefilter("ignore")
        for value in inputs:
            voltage, current = (value, None) if kind == "voltage" else (None, value)
            make_sites(building, dampers, voltage, current, options.allow_extrapolation)
    tell("without damper", 0.0)
    cases = {BARE: _respond(building, pushed, {}, None, None, options)}
    inputs_by_name = {}
    for k, value in enumerate(inputs, start=1):
        tell(f"case {k + 1} of {len(inputs) + 1}", k / (len(inputs) + 1))
        voltage, current = (value, None) if kind == "voltage" else (None, value)
        response = _respond(building, pushed, dampers, voltage, current, options)
        cases[case_name(response)], inputs_by_name[case_name(response)] = response, value
    intervals = {}
    if options.draws is not None:
        tell(f"{options.draws} drawn dampers", len(inputs) / (len(inputs) + 1))
        peaks = _peak_intervals(building, pushed.motion, placed, kind, list(inputs_by_name.values()), options)
        intervals = dict(zip(inputs_by_name, peaks, strict=True))
    units = (unit for response in cases.values() for unit in response.input_units)
    unit = next((unit for unit in units if unit != NO_INPUT), "")
    return Responses(building.name, pushed.title, unit, cases, intervals, options.draws or 0)


def case_name(response: Response) -> str:
    """The input of a case in words; where dampers have different ones, that of each that has one."""
    inputs = {
        site: law or f"{value:g} {unit}"
        for site, law, value, unit in zip(
            response.sites, response.laws, response.inputs, response.input_units, strict=True
        )
        if unit != NO_INPUT
    }
    if not inputs:
        return WITH_DAMPER
    if len(set(inputs.values())) == 1:
        return next(iter(inputs.values()))
    return "; ".join(f"{site}: {text}" for site, text in inputs.items())


def _peak_intervals(
    building: Building,
    motion: GroundMotion,
    placed: Mapping[Any, Any],
    kind: str,
    inputs: list[Any],
    options: RespondOptions,
) -> list[dict[str, Any]]:
    """The 90 % intervals of the peaks at each input, of drawn dampers: a dictionary of (2, ...) arrays for each."""
    assert options.draws is not None
    keyword: dict[str, Any] = {kind: inputs}
    peaks = ensemble(
        building,
        motion,
        [installed(drawn, options) for drawn in drawn_placements(placed, options.draws, options.seed)],
        **keyword,
        accuracy="strict" if tolerance_of(options.accuracy) <= ACCURACIES["strict"] else "fast",
        quantities=tuple(INTERVAL_OF),
        allow_extrapolation=options.allow_extrapolation,
        after=options.after,
    ).dataset
    intervals = []
    for k in range(len(inputs)):
        case = peaks.isel(building=0, input=k, motion=0, scale=0)
        intervals.append(
            {name: np.quantile(case[quantity].values, INTERVAL, axis=0) for quantity, name in INTERVAL_OF.items()}
        )
    return intervals


def _respond(
    building: Building,
    pushed: Excitation,
    dampers: Mapping[Any, Any],
    voltage: Any,
    current: Any,
    options: RespondOptions,
) -> Response:
    """The response of one input."""
    sites = make_sites(building, dampers, voltage, current, options.allow_extrapolation)
    if isinstance(building, SupportedBuilding):
        for site in sites:
            building.check_stroke(site.place)
    motion = pushed.motion
    whole, half = refinements(building, np.vstack([connections(building, sites), pushed.rows(building)]))
    run = runner(whole, motion, sites, pushed.loads(whole))
    if options.step is None:
        tolerance = tolerance_of(options.accuracy)
        first = 2 * largest_step(
            whole, sites, run.greatest_slopes() if sites else np.zeros((0, 2)), FINAL_LIMIT
        )  # so that the first halving meets it
        halve = halve_under_laws if laws_of(sites) else halve_until_converged
        best = halve(run, motion, tolerance, steps_per_sample(motion.dt, first, sites))
    else:
        best = run_once(run, given_steps_per_sample(motion, options.step, sites))
    truncation = None if whole is building else _truncation(whole, half, pushed, sites, best)
    response = _response(whole, pushed, sites, best, options.after, truncation)
    warn_of_parts(sites, stacklevel=4)
    for doubt in response.doubts:
        warnings.warn(doubt, FindingWarning, stacklevel=3)
    return response


def _truncation(
    whole: Building, half: Building | None, pushed: Excitation, sites: tuple[Site, ...], best: Integration
) -> Truncation:
    """What ``whole`` still leaves out: against all modes where they are the response, else by ``half`` at the same step."""
    assert isinstance(whole, Condensed)
    degrees, motion = len(whole.T), pushed.motion
    if half is None:
        return Truncation(whole.n, degrees) if whole.exact else Truncation(whole.n, degrees, UNJUDGED, *5 * (math.nan,))
    if not sites and not pushed.values.size and isinstance(whole, ModalBuilding):
        return whole.truncation_errors(motion)
    other = runner(half, motion, sites, pushed.loads(half))(round(motion.dt / best.step)).out
    changed = changes(other, best.out)
    judge = f"{half.n} coordinates, {'with' if sites else 'without'} the dampers"
    return Truncation(whole.n, degrees, judge, **{name: changed.get(name, 0.0) for name in other.peaks})


def _response(
    building: Building,
    pushed: Excitation,
    sites: tuple[Site, ...],
    run: Integration,
    after: float,
    truncation: Truncation | None,
) -> Response:
    out, n, floors, motion, loads = run.out, building.n, building.n_floors, pushed.motion, pushed.loads(building)
    rows, pull = connections(building, sites), building.influence @ building.M
    missing = building.ground_terms()[1]
    balanced = 0.0 if loads is None else loads.values @ loads.shear
    all_q = np.ascontiguousarray(out.state[:, :n].T)
    q, drift = all_q[:floors], (drifts(building) @ all_q)[:floors]
    general = any(not site.composition.path_only or site.delay > 0 for site in sites)
    energy = _energy(building, out)
    inaccurate = [f"the response is not to its accuracy: {run.reason}"] if run.reason else []
    outside = [sentence for d, site in enumerate(sites) for sentence in _limits_left(site, rows[d], out, motion.dt)]
    return Response(
        time=motion.time,
        ground_acceleration=motion.acceleration,
        displacement=q,
        velocity=np.ascontiguousarray(out.state[:, n : n + floors].T),
        acceleration=np.ascontiguousarray(out.acceleration[:, :floors].T),
        drift=drift,
        # what the structure hands to the ground: all of its inertia, the missing mass of a reduced one included, and the loads
        base_shear=-(out.acceleration @ pull + missing * motion.acceleration - balanced),
        force=np.ascontiguousarray(out.force.T),
        stroke=rows @ all_q,
        peak_displacement=out.displacement_peak,
        peak_drift=out.drift_peak,
        peak_acceleration=out.acceleration_peak,
        peak_base_shear=float(out.shear_peak[0]),
        peak_force=out.force_peak,
        energy=energy,
        storeys=tuple(site.storey for site in sites),
        sites=tuple(building.place_label(site.place) for site in sites),
        inputs=tuple(None if site.damper.input == NO_INPUT else site.input_value for site in sites),
        laws=tuple(describe_law(site.law, site.damper.input) if site.law else "" for site in sites),
        input=np.ascontiguousarray(out.input.T),
        mean_input=out.mean_input.copy(),
        input_units=tuple(site.damper.input for site in sites),
        floors=tuple(building.floors),
        scheme="linear" if not sites else "general" if general else "exact path",
        step=run.step,
        accuracy=run.tolerance,
        error_estimate=run.error,
        error_estimates=dict(run.changes),
        converged=not run.reason,
        reason=run.reason,
        title=f"{building.name}, {pushed.title}",
        loads=pushed.floor_loads,
        supports=building.supports if isinstance(building, SupportedBuilding) else (),
        support_acceleration=pushed.support_accelerations,
        after=float(after),
        truncation=truncation,
        wanted_forces=run.reasons,
        origin=combined(site.damper.origin for site in sites),
        of_dampers=handed_on((site.damper for site in sites), OF_DAMPER),
        doubts=(*inaccurate, *_feeding_dampers(energy, sites), *outside),
    )


def _limits_left(site: Site, row: Array, out: Output, dt: float) -> list[str]:
    """Sentences on the calibrated limits of displacement and velocity that the motion of a site leaves."""
    n = len(row)
    stroke, rate = out.state[:, :n] @ row, out.state[:, n:] @ row
    reach = out.drift_peak[site.storey - 1] if site.storey else peak_displacement(stroke, rate, dt)
    reached = {"displacement": (float(reach), "m"), "velocity": (float(np.max(np.abs(rate))), "m/s")}
    notes = []
    for name, (value, unit) in reached.items():
        limit = site.damper.ranges.get(name, (0.0, math.inf))[1]
        if value > BEYOND * limit:
            notes.append(
                f"the damper {describe_place(site.place)} reaches a {name} of {value:.4g} {unit}; "
                f"it was calibrated up to {limit:.4g} {unit}"
            )
    return notes


def _energy(building: Building, out: Output) -> Energy:
    # of the motion relative to the ground, whose input is -M iota ag times the relative velocity: the balance closes so
    q, v = out.state[:, : building.n], out.state[:, building.n :]
    kinetic = 0.5 * np.einsum("ti,ij,tj->t", v, building.M, v)
    strain = 0.5 * np.einsum("ti,ij,tj->t", q, building.K, q)
    work = out.work.T
    return Energy(work[0].copy(), kinetic, strain, work[1].copy(), work[2:].copy())


def _feeding_dampers(energy: Energy, sites: tuple[Site, ...]) -> list[str]:
    """Sentences on the dampers that gave the building energy over the whole motion."""
    scale = 1e-6 * float(np.max(np.abs(energy.input)))  # the balance of energies is not closer than that
    return [
        f"the damper {describe_place(site.place)} fed {-work[-1]:.3g} J into the building over the whole motion; "
        "check its delay and the sign of its force"
        for site, work in zip(sites, energy.dampers, strict=True)
        if work[-1] < -scale
    ]
