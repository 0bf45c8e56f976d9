"""Bang-bang, and Lyapunov's law with it: full input where the damper takes power."""

import pytest
from tests.structures.control.sensed_signals import sensed

from dampyr.structures.control import bang_bang, lyapunov

LOW, HIGH = 0.5, 3.0


@pytest.mark.parametrize("law", [bang_bang, lyapunov])
@pytest.mark.parametrize(("signal", "force", "expected"), [(1, 2, HIGH), (-1, -2, HIGH), (1, -2, LOW), (0, 2, LOW)])
def test_laws_of_energy_look_at_the_power(law, signal, force, expected):
    assert law.decide(signal, force, LOW, HIGH) == expected


@pytest.mark.parametrize(
    ("place", "expected"), [(1, [0, 0, 1, 0, 1]), (2, [0, 0, -1, 1, 0]), ((0, 2), [0, 0, 0, 1, 1])]
)
def test_bang_bang_senses_the_rate_over_still_ground(place, expected):
    assert sensed("bang_bang", place).tolist() == expected
