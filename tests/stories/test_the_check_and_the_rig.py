"""What the check before motion says is what the simulated rig then does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import dampyr as dp
from dampyr.campaigns.check import largest
from dampyr.campaigns.force_prediction import specimen
from dampyr.campaigns.kinds import kind
from dampyr.rig import Drive, RigSettings

RIG = RigSettings()


def played(drive: Drive) -> np.ndarray:
    """Where the simulated table was, sample by sample [m]."""
    with dp.rig.simulated() as rig, rig.armed() as table:
        table.home()
        table.go(0.0)
        return np.concatenate([samples.displacement[selected] for samples, selected in table.play(drive)])


def peak_speed(x: np.ndarray, over: int = 20) -> float:
    """The greatest speed over ``over`` samples [m/s]."""
    return float(np.abs(x[over:] - x[:-over]).max() * RIG.board.rate / over)


@pytest.mark.parametrize(("frequency", "voltage"), [(1.2, 1.98), pytest.param(0.5, 0.0, marks=pytest.mark.prove)])
def test_the_largest_sine_is_followed_and_a_larger_one_is_not(frequency: float, voltage: float) -> None:
    step = kind("sine")(0.03, frequency, voltage, cycles=3)
    largest_step = replace(step, amplitude=largest(step, "amplitude", RIG, specimen(RIG)))
    assert peak_speed(played(largest_step.drive(RIG))) > 0.98 * largest_step.peaks(RIG).speed
    more = replace(largest_step, amplitude=1.2 * largest_step.amplitude)
    assert peak_speed(played(more.drive(RIG))) < 0.92 * more.peaks(RIG).speed


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        pytest.param("earthquake", {"voltage": 0.8712}, marks=pytest.mark.prove),
        ("sweep", {"amplitude": 0.02, "start": 0.3, "stop": 1.5, "duration": 10.0}),
    ],
)
def test_what_is_lowered_to_the_largest_is_followed(name: str, settings: dict[str, float]) -> None:
    step = kind(name)(**settings)
    field = step.lowers[0]
    largest_step = replace(step, **{field: largest(step, field, RIG, specimen(RIG))})
    drive, x = largest_step.drive(RIG), played(largest_step.drive(RIG))
    commanded = np.interp(np.arange(x.size) / RIG.board.rate, np.arange(drive.n) * drive.period, drive.displacement)
    assert np.abs(x).max() == pytest.approx(largest_step.peaks(RIG).position, rel=0.03)
    assert np.std(x - commanded) < 0.03 * np.abs(commanded).max()
