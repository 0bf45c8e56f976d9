"""Inverse-model force tracking: each input is the one whose force, by the forward model, is nearest to the wanted one."""

from dataclasses import replace

import numpy as np
import pytest
from tests.structures.begin_of_el_centro import short
from tests.structures.control.sensed_signals import sensed

from dampyr.errors import DampyrWarning, InputError
from dampyr.ground_motions import kanai_tajimi
from dampyr.models import Damper
from dampyr.structures import Sensor, control_law, ensemble, respond, two_storey

HIGH, PERIOD = 3.0, 0.02


def test_the_wanted_force_is_that_of_clipped_optimal():
    assert np.array_equal(sensed("inverse_tracking", effort=0.1), sensed("clipped_optimal", effort=0.1))


def test_no_other_input_gives_a_force_nearer_to_the_wanted_one(cubics: Damper):
    """The forward model along the measured strokes, held inputs and all, under 61 inputs of the period to come."""
    law, motion = control_law("inverse_tracking", high=HIGH, period=PERIOD), short(8.0)
    response = respond(two_storey(), motion, {1: cubics}, voltage=law, step=0.0025)
    z = np.vstack([response.displacement, response.velocity])
    wanted = sensed("inverse_tracking")[:4] @ z
    x, v, t = z[0], z[2], motion.time
    commands = np.append(response.input[0, 1:], np.nan)  # what was decided at a sample acts at the next
    grid, met = np.linspace(0.0, HIGH, 61), 0
    for k in range(20, len(t) - 1, 37):
        past = t[: k + 2], np.append(x[: k + 1], x[k] + PERIOD * v[k]), np.append(v[: k + 1], v[k])
        inputs = np.append(0.0, commands[: k + 1])

        def given(u, past=past, inputs=inputs):
            return cubics.force(past[0], past[1], velocity=past[2], voltage=np.append(inputs[:-1], u))[-1]

        gaps = np.array([abs(given(u) - wanted[k]) for u in grid])
        found = abs(given(commands[k]) - wanted[k])
        assert found <= gaps.min() + 1e-6 * abs(wanted[k])
        met += found <= 1e-6 * abs(wanted[k])
    assert met >= 3


def test_how_often_the_force_was_met_is_said(cubics: Damper):
    law = control_law("inverse_tracking", high=HIGH, lag=0.01)
    response = respond(two_storey(), short(6.0), {1: cubics, 2: cubics}, voltage={1: law, 2: 1.0}, step=0.0025)
    shares, of_a_number = response.wanted_forces
    assert of_a_number == {}
    assert sum(shares.values()) == pytest.approx(1.0)
    assert {"met", "wrong_sign"} < set(shares)


def test_an_ensemble_has_the_peaks_of_a_response(cubics: Damper):
    """Each of two dampers of different laws, side by side and alone, with noise of a sensor and a coil that lags."""
    law = control_law("inverse_tracking", high=HIGH, lag=0.01, seed=3, sensors={"stroke": Sensor(noise=1e-5)})
    weaker = Damper(
        "dahl",
        {
            key: replace(value, coefficients=tuple(0.8 * c for c in value.coefficients))
            for key, value in cubics.laws.items()
        },
    )
    placed = [{1: cubics}, {1: weaker}]
    whole = ensemble(two_storey(), short(4.0), placed, law, [0.5, 1.0], accuracy="strict").dataset
    assert whole.attrs["one_by_one"] == 0
    for k, dampers in enumerate(placed):
        alone = ensemble(two_storey(), short(4.0), dampers, law, [1.0], accuracy="strict").dataset
        assert np.array_equal(alone.drift.values.ravel(), whole.drift.values[0, k, 0, 0, 1])
        one = respond(two_storey(), short(4.0), dampers, voltage=law, step=0.00125)
        here = whole.isel(building=0, damper=k, input=0, motion=0, scale=1)
        assert here.drift.values == pytest.approx(one.peak_drift, rel=2e-3)
        assert here.force.values == pytest.approx(one.peak_force, rel=2e-3)
        assert here.energy.values == pytest.approx(one.energy.dampers[:, -1], rel=2e-3)


@pytest.mark.prove
@pytest.mark.parametrize("more", [{}, {"lag": 0.01}])
def test_means_of_an_ensemble_are_those_of_responses(cubics: Damper, more: dict):
    """Of responses whose step is halved until no decision hangs on it: half a per cent of the mean."""
    law = control_law("inverse_tracking", high=HIGH, **more)
    motions = [kanai_tajimi(5.0, dt=0.02, seed=k, pga=3.0) for k in range(1, 13)]
    peaks = ensemble(two_storey(), motions, {1: cubics}, law, precision=64).dataset.isel(
        building=0, damper=0, input=0, scale=0
    )
    single = [respond(two_storey(), motion, {1: cubics}, voltage=law) for motion in motions]
    for quantity in ("drift", "force"):
        mean = np.mean([getattr(one, f"peak_{quantity}") for one in single], axis=0)
        assert peaks[quantity].mean("motion").values == pytest.approx(mean, rel=5e-3)
    half = ensemble(two_storey(), motions, {1: cubics}, law, precision=32).dataset.isel(
        building=0, damper=0, input=0, scale=0
    )
    assert half.drift.mean("motion").values == pytest.approx(peaks.drift.mean("motion").values, rel=5e-3)


def test_a_damper_without_an_inverse_is_refused(cubics: Damper):
    late = Damper("dahl + delay", {**cubics.laws, "delay.tau": 0.01})
    with pytest.raises(InputError, match="the force of this damper is delayed"):
        respond(two_storey(), short(1.0), {1: late}, voltage=control_law("inverse_tracking", high=HIGH))


def test_a_case_without_bound_leaves_its_neighbours_alone(cubics: Damper):
    law, motion = control_law("inverse_tracking", high=HIGH), kanai_tajimi(2.0, 0.02, seed=1, pga=3.0).scaled(1e200)
    with pytest.warns(DampyrWarning, match="1 cases grew without bound"):
        both = ensemble(two_storey(), motion, cubics, law, [1.0, 1e-200]).dataset
    alone = ensemble(two_storey(), motion, cubics, law, [1e-200]).dataset
    assert np.array_equal(both.drift[..., 1, :], alone.drift[..., 0, :])
