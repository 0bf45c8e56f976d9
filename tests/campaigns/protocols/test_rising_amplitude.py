"""Ladders as coded: their fractions and cycles, and that they end at the largest amplitude."""

import pytest

from dampyr import campaigns
from dampyr.campaigns.protocols.rising_amplitude import LADDERS


@pytest.mark.parametrize(
    ("ladder", "fractions", "cycles"),
    [
        (
            "ASCE 41 as coded",
            [1 / 24, 1 / 12, 1 / 8, 1 / 6, 1 / 4, 1 / 3, 1 / 2, 2 / 3, 1.0],
            [3, 3, 3, 3, 3, 3, 2, 2, 2],
        ),
        ("modified ATC-24 as coded", [0.1, 0.2, 0.3, 0.5, 0.7, 1.0], [3, 3, 3, 2, 2, 1]),
        ("FEMA 461 as coded", [1.4 ** (k - 9) for k in range(10)], [2] * 10),
    ],
)
def test_a_ladder_has_its_levels_and_ends_at_the_largest(ladder, fractions, cycles):
    table = {"kind": "rising_amplitude", "ladder": ladder, "largest_amplitude": "12 mm", "frequency": "0.5 Hz"}
    tests = campaigns.campaign_of({"protocol": table}).tests
    assert [test.step.amplitude / 0.012 for test in tests] == pytest.approx(fractions, rel=1e-9)
    assert [test.step.cycles for test in tests] == cycles
    assert tests[-1].step.amplitude == pytest.approx(0.012, rel=1e-12)


def test_the_first_level_of_fema_461_is_0_048_of_the_largest():
    levels = LADDERS["FEMA 461 as coded"]
    assert levels[0][0] / levels[-1][0] == pytest.approx(0.048, abs=5e-4)


def test_no_ladder_claims_a_document_that_was_not_read():
    assert all(name.endswith("as coded") for name in LADDERS)
