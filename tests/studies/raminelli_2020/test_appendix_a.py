"""Table A.2 of Raminelli (2020): the printed speed of the actuator against the fastest record."""

from types import SimpleNamespace

import pytest

from dampyr.studies.raminelli_2020 import PUBLISHED
from dampyr.studies.raminelli_2020.appendix_a import rig


def campaign(*speeds: float) -> SimpleNamespace:
    """Records with these peak speeds, as multiples of the printed one."""
    printed = 1e-3 * float(PUBLISHED.actuator_speed)
    return SimpleNamespace(
        tests=[
            SimpleNamespace(record=SimpleNamespace(name=f"run {k}"), measured=SimpleNamespace(peak_speed=s * printed))
            for k, s in enumerate(speeds)
        ]
    )


@pytest.mark.parametrize(("speeds", "verdict"), [((0.4, 1.05, 0.9), "agrees"), ((0.4, 1.2, 0.9), "differs")])
def test_a_record_may_be_a_tenth_faster_than_printed(speeds: tuple[float, ...], verdict: str) -> None:
    [value] = rig(PUBLISHED, campaign(*speeds)).compared
    assert value.ours == pytest.approx(speeds[1] * PUBLISHED.actuator_speed)
    assert value.verdict == verdict
    assert value.reason.startswith(f"run 1 moves at {speeds[1]:g} times")


def test_without_records_it_cannot_be_checked() -> None:
    for none in (None, campaign()):
        [value] = rig(PUBLISHED, none).compared
        assert (value.ours, value.verdict) == (None, "cannot be checked")
        assert "dampyr datasets fetch labcontrol" in value.reason
