"""Figures of devices against closed forms: power law, Dahl, a spring; numbers of cycles from the start."""

import json
from math import pi, tanh

import numpy as np
import pytest

import dampyr as dp
from dampyr.errors import InputError
from dampyr.records.cycle_analysis.device_figures import device_figures, power_law_energy, stability

D, F = 0.008, 1.0


def motion(cycles=5, n=4000):
    t = np.arange(cycles * n + 1) / n / F
    return t, D * np.sin(2 * pi * F * t), D * 2 * pi * F * np.cos(2 * pi * F * t)


def record(t, x, force):
    return dp.records.Record(t, x, force, voltage=0.0)


@pytest.mark.parametrize(("exponent", "factor"), [(0.0, 4.0), (0.15, 3.827), (0.3, 3.675), (0.5, 3.496), (1.0, pi)])
def test_the_energy_of_a_power_law_is_lambda_times_force_times_amplitude(exponent, factor):
    t, x, v = motion()
    figures = device_figures(record(t, x, 500.0 * np.sign(v) * np.abs(v) ** exponent))
    assert len(figures) == 5
    for cycle in figures[1:]:
        expected = power_law_energy(cycle.largest_force, D, exponent)
        assert cycle.energy == pytest.approx(expected, rel=5e-3)
        assert expected == pytest.approx(factor * cycle.largest_force * D, rel=2e-4)
        assert cycle.characteristic_strength == pytest.approx(cycle.largest_force, rel=5e-3)


def test_energy_stiffness_and_damping_of_a_steady_dahl_loop_are_those_of_its_closed_form():
    rho, kw = 600.0, 300.0
    t, x, _ = motion()
    w, values = 0.0, []
    for k in range(len(x)):
        if k:
            s = np.sign(x[k] - x[k - 1])
            w = s + (w - s) * np.exp(-rho * abs(x[k] - x[k - 1]))
        values.append(kw * w)
    last = device_figures(record(t, x, np.array(values)))[-1]
    energy = 4 * kw * (D - tanh(rho * D) / rho)  # w between -tanh(rho D) and tanh(rho D) along every leg
    assert last.energy == pytest.approx(energy, rel=5e-3)
    assert last.effective_stiffness == pytest.approx(kw * tanh(rho * D) / D, rel=5e-3)
    assert last.damping_ratio == pytest.approx(energy / (2 * pi * kw * tanh(rho * D) * D), rel=5e-3)


def test_a_spring_with_a_gas_force_has_its_stiffness_and_no_energy():
    t, x, _ = motion()
    for cycle in device_figures(record(t, x + 0.001, 20e3 * x + 112.0)):
        assert cycle.effective_stiffness == pytest.approx(20e3, rel=1e-3)
        assert abs(cycle.energy) < 1e-3


def test_the_third_cycle_is_the_third_from_the_start_of_the_motion():
    t, x, v = motion(6)
    fading = 1.0 - 0.04 * np.minimum(np.floor(t * F), 5)
    figures = device_figures(record(t, x, 1000.0 * fading * np.sign(v) * np.abs(v) ** 0.3))
    assert [cycle.in_level for cycle in figures] == [1, 2, 3, 4, 5, 6]
    away = stability([cycle.energy for cycle in figures])
    assert max(map(abs, away)) == pytest.approx(0.130, abs=1e-3)  # 0.12 / 0.92: NTC 2018 [11.9.7] allows 0.10


def test_two_cycles_have_no_third():
    with pytest.raises(InputError, match="2 cycles have no cycle 3"):
        stability([1.0, 1.0])


def with_run_in(count=3, begin=2.5):
    """A cycle that grows, ``count`` steady ones from 0.5 s after ``begin`` on, one that fades; viscous, from 2 s on."""
    t = 2.0 + np.arange(6 * 2000 + 1) / 2000
    after = t - begin
    grown = np.clip(np.minimum(after, count + 2 - after), 0.0, 1.0)
    x = D * 0.5 * (1 - np.cos(pi * grown)) * np.sin(2 * pi * after)
    steady = json.dumps({"begin": begin + 1.0, "period": 1.0, "count": count})
    record = dp.records.Record(t, x, 900.0 * np.gradient(x, t), voltage=0.0)
    return record, record.replace(note="as recorded", provenance={"steady_cycles": steady})


def test_a_record_that_states_its_steady_cycles_has_these_and_no_run_in_or_run_out():
    unstated, stated = with_run_in()
    assert min(cycle.amplitude for cycle in device_figures(stated)) == pytest.approx(D, rel=1e-6)
    assert [(c.number, c.in_level) for c in device_figures(stated)] == [(1, 1), (2, 2), (3, 3)]
    energy = pi * 900.0 * 2 * pi * D**2
    assert [c.energy for c in device_figures(stated)] == pytest.approx([energy] * 3, rel=1e-3)
    cut = dp.records.cut_cycles(stated)
    assert [c.number for c in device_figures(stated, cut)] == [c.number for c in device_figures(unstated)]


def test_of_a_record_that_ends_early_the_whole_cycles_are_left_with_their_numbers():
    _, stated = with_run_in()
    pieces = dp.records.cut(stated, 3.6)  # 2 to 5.6 s, and from there on
    assert [cycle.number for cycle in device_figures(pieces[0])] == [1, 2]
    with pytest.raises(InputError, match="no whole cycle"):
        device_figures(pieces[1])


@pytest.mark.parametrize("text", ["no JSON", "[]", '{"begin": 1.0}', '{"begin": 1.0, "period": 0.0, "count": 3}'])
def test_steady_cycles_that_cannot_be_read_are_refused(text):
    _, stated = with_run_in()
    with pytest.raises(InputError, match=r"steady_cycles = .* needs begin, period"):
        device_figures(stated.replace(note="spoiled", provenance={"steady_cycles": text}))
