"""Earthquake: the record filtered and integrated."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from dampyr.campaigns.kinds import kind
from dampyr.errors import InputError, MissingData
from dampyr.ground_motions import el_centro
from dampyr.ground_motions.intensity_measures import pgd, pgv
from dampyr.rig import RigSettings

RIG = RigSettings()


def test_an_earthquake_is_the_record_filtered_and_integrated():
    step = kind("earthquake")(scale=0.1, rest_before=1.0)
    drive = step.drive(RIG)
    x = drive.displacement[100:]
    v = cumulative_trapezoid(np.gradient(np.gradient(x, 0.01), 0.01), dx=0.01)
    peaks = step.peaks(RIG)
    assert np.abs(v).max() == pytest.approx(peaks.speed, rel=0.02)
    assert np.abs(x).max() == pytest.approx(peaks.position, rel=1e-3)
    a = np.gradient(np.gradient(x, 0.01), 0.01)[: 2 * el_centro().n : 2][:1500] / 0.1
    assert np.corrcoef(a, el_centro().acceleration[:1500])[0, 1] > 0.98
    assert peaks.position < 0.1 * pgd(el_centro())
    assert peaks.speed == pytest.approx(0.1 * pgv(el_centro()), rel=0.15)


def test_a_motion_that_is_not_there_and_a_scale_of_0_are_refused(tmp_path):
    with pytest.raises(MissingData, match="there is no such file; check motion in the campaign"):
        kind("earthquake")("none.csv").located_in(tmp_path).drive(RIG)
    with pytest.raises(InputError, match="scale = 0"):
        kind("earthquake")(scale=0.0)
