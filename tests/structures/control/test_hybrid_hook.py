"""Hybrid of skyhook and groundhook: its decision, worked out by hand, and the two that it is made of."""

import pytest

from dampyr.structures.control import hybrid_hook, skyhook

LOW, HIGH = 0.5, 3.0


@pytest.mark.parametrize(
    ("velocity", "lower", "rate", "share", "expected"),
    [
        (1, 1, 2, 0.5, 0.5 + 2.5 * 0.5),
        (1, -1, 2, 0.5, 0.5 + 2.5 * 0.25),
        (-1, 1, 2, 0.25, 0.5 + 2.5 * 0.375),
        (-1, -1, 2, 0.5, LOW),
        (9, 9, 1, 0.5, HIGH),
        (1, 1, 0, 0.5, LOW),
    ],
)
def test_hybrid_hook(velocity, lower, rate, share, expected):
    assert hybrid_hook.decide(velocity, lower, rate, LOW, HIGH, share, 1.0) == pytest.approx(expected)


def test_all_its_share_is_a_skyhook():
    for velocity, rate in ((1.0, 3.0), (-1.0, 3.0), (-2.0, -1.0)):
        assert hybrid_hook.decide(velocity, 7.0, rate, LOW, HIGH, 1.0, 0.8) == skyhook.decide(
            velocity, rate, LOW, HIGH, 0.8
        )
