"""Pieces of path against their formulas and against integration by scipy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from dampyr.campaigns.paths import GLIDE, RAMP, around, driven, hold, move, moves, sampled, stepwise, swing, top_speed


def test_the_steady_cycles_of_a_swing_are_a_sine():
    piece = swing(0.0124, 1.5, cycles=5, taper=2, centre=0.003)
    assert piece.duration == pytest.approx(9 / 1.5)
    t = np.linspace(2 / 1.5, 7 / 1.5, 400)
    np.testing.assert_allclose(piece.at(t), 0.003 + 0.0124 * np.sin(2 * np.pi * 1.5 * t), atol=1e-15)


@given(frequency=st.floats(0.05, 10.0), taper=st.integers(1, 4))
def test_a_taper_is_never_faster_than_the_sine(frequency, taper):
    piece = swing(1.0, frequency, cycles=1, taper=taper)
    t = np.linspace(0.0, piece.duration, 20001)
    v = np.diff(piece.at(t)) / np.diff(t)
    assert np.abs(v).max() <= 2 * np.pi * frequency * (1 + 1e-9)
    assert np.abs(v[[0, -1]]).max() < 1e-3 * frequency


def test_a_swing_ends_as_it_began_turned_round():
    piece = swing(1.0, 0.7, cycles=3, taper=1)
    t = np.linspace(0.0, piece.duration, 999)
    np.testing.assert_allclose(piece.at(t), -piece.at(piece.duration - t), atol=1e-12)


@pytest.mark.parametrize(("start", "stop", "speed"), [(0.0, 0.02, 0.01), (0.01, -0.01, 0.03), (0.0, 2e-4, 0.01)])
def test_a_move_is_the_integral_of_a_trapezoid(start, stop, speed):
    piece, top = move(start, stop, speed), top_speed(stop - start, speed)
    ramp = top * RAMP / speed

    def speed_at(t):
        return top * min(t / ramp, (piece.duration - t) / ramp, 1.0)

    for t in np.linspace(0.0, piece.duration, 9):
        way = quad(speed_at, 0.0, t, points=(ramp, piece.duration - ramp), epsabs=1e-12)[0]
        assert piece.at(np.array([t]))[0] == pytest.approx(start + np.sign(stop - start) * way, abs=1e-10)
    assert piece.at(np.array([piece.duration]))[0] == pytest.approx(stop, abs=1e-15)


def test_a_short_move_does_not_reach_its_speed():
    assert top_speed(1e-4, 0.01) == pytest.approx(np.sqrt(1e-4 * 0.01 / RAMP))
    assert top_speed(0.01, 0.01) == 0.01
    assert top_speed(0.0, 0.01) == 0.0


def test_moves_pause_at_each_place():
    pieces = list(moves([0.0, 0.01, 0.0], 0.01, pause=0.5))
    assert [piece.duration for piece in pieces] == pytest.approx([1.1, 0.5, 1.1, 0.5])


def test_a_centre_is_reached_by_a_glide_and_left_by_one():
    x = sampled(around([hold(0.01, 1.0)], 0.01, rest_before=0.3), 0.01)
    assert x[0] == x[-1] == 0.0
    assert np.sum(x == 0.01) >= 100
    assert np.abs(np.diff(x)).max() / 0.01 == pytest.approx(GLIDE)


def test_set_points_reach_the_end_where_the_period_does_not_divide_it():
    drive = driven([move(0.0, 0.0123, 0.01), hold(0.0123, 0.0004)], 0.01, 1.0)
    assert drive.displacement[-1] == pytest.approx(0.0123, abs=1e-15)
    assert drive.duration == pytest.approx(1.34)


def test_levels_stand_where_they_are_said():
    drive = stepwise([hold(0.0, 4.0)], 0.01, begin=1.0, levels=[2.0, 0.5], hold_for=0.75)
    t = np.arange(drive.n) * 0.01
    assert np.all(drive.voltage[t < 0.995] == 0.0)
    assert np.all(drive.voltage[(t > 0.995) & (t < 1.745)] == 2.0)
    assert np.all(drive.voltage[(t > 1.745) & (t < 2.495)] == 0.5)
    assert np.all(drive.voltage[t > 2.495] == 0.0)
