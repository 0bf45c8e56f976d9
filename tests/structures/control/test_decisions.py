"""Each law's decision, by its equation written out here."""

import pytest

from dampyr.structures.control import bang_bang, clipped_optimal, lyapunov, on_off, skyhook

LOW, HIGH = 0.5, 3.0


@pytest.mark.parametrize(
    ("signal", "rate", "expected"), [(1, 1, HIGH), (-1, -1, HIGH), (1, -1, LOW), (-1, 1, LOW), (0, 1, LOW), (1, 0, LOW)]
)
def test_on_off(signal, rate, expected):
    assert on_off.decide(signal, rate, LOW, HIGH) == expected


@pytest.mark.parametrize(
    ("signal", "rate", "ratio", "expected"),
    [(1, 2, 1, 1.75), (-1, -2, 1, 1.75), (1, 2, 0.5, 1.125), (3, 1, 1, HIGH), (1, -1, 1, LOW), (1, 0, 1, LOW)],
)
def test_skyhook_goes_with_the_ratio_of_the_velocities(signal, rate, ratio, expected):
    assert skyhook.decide(signal, rate, LOW, HIGH, ratio) == expected


@pytest.mark.parametrize(
    ("wanted", "force", "expected"),
    [(9, 5, HIGH), (-9, -5, HIGH), (5, 9, LOW), (-5, -9, LOW), (-5, 9, LOW), (5, -9, LOW), (5, 0, LOW)],
)
def test_clipped_optimal_wants_more_of_the_same_force(wanted, force, expected):
    assert clipped_optimal.decide(wanted, force, LOW, HIGH) == expected


@pytest.mark.parametrize("law", [bang_bang, lyapunov])
@pytest.mark.parametrize(("signal", "force", "expected"), [(1, 2, HIGH), (-1, -2, HIGH), (1, -2, LOW), (0, 2, LOW)])
def test_laws_of_energy_look_at_the_power(law, signal, force, expected):
    assert law.decide(signal, force, LOW, HIGH) == expected
