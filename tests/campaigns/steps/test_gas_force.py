"""Gas force: places met on both ways."""

import numpy as np
import pytest

from dampyr.campaigns.kinds import kind
from dampyr.errors import InputError
from dampyr.rig import RigSettings

RIG = RigSettings()


def test_the_places_of_the_gas_force_are_met_on_both_ways():
    drive = kind("gas_force")(0.01, places=5, hold=1.0).drive(RIG)
    x = np.round(drive.displacement[1:][np.diff(drive.displacement) == 0.0], 9)
    counts = {place: int(np.sum(x == place)) for place in (-0.01, -0.005, 0.005, 0.01)}
    assert counts[-0.005] == pytest.approx(200, abs=6)
    assert counts[0.005] == pytest.approx(200, abs=6)
    assert counts[0.01] == pytest.approx(100, abs=4)
    assert counts[-0.01] == pytest.approx(200, abs=6)  # first and last


def test_its_peaks_are_the_amplitude_and_what_the_longest_move_reaches():
    peaks = kind("gas_force")(0.01, places=5, speed=0.005).peaks(RIG)
    assert (peaks.position, peaks.speed) == (0.01, 0.005)
    for places, travel in ((5, 1e-5), (2, 2e-5)):  # to the first place, or from the one to the other
        peaks = kind("gas_force")(1e-5, places=places, speed=0.005).peaks(RIG)
        assert peaks.speed == pytest.approx(np.sqrt(travel * 0.005 / 0.1))


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"amplitude": 0.01, "places": 1}, "places = 1"),
        ({"amplitude": 0.01, "hold": 0.0}, "hold = 0 s"),
    ],
)
def test_what_makes_no_sense_is_refused(settings, words):
    with pytest.raises(InputError, match=words):
        kind("gas_force")(**settings)
