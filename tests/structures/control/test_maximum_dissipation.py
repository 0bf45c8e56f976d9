"""Maximum energy dissipation: its decision, by its formula worked out by hand."""

import pytest

from dampyr.structures.control import maximum_dissipation

LOW, HIGH = 0.5, 3.0


@pytest.mark.parametrize(
    ("rate", "force", "expected"), [(1, 2, HIGH), (-1, -2, HIGH), (1, -2, LOW), (-1, 2, LOW), (0, 2, LOW), (1, 0, LOW)]
)
def test_maximum_dissipation(rate, force, expected):
    assert maximum_dissipation.decide(rate, force, LOW, HIGH) == expected
