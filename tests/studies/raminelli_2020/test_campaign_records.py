"""The campaign read and identified: slopes of a record whose damper is known, and files that are not there."""

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.identification.limit_cycle_methods.plastic_region import PlasticRegion
from dampyr.models import Damper
from dampyr.studies.raminelli_2020.campaign_records import PublishedCampaign, crossing_slopes

KX, KW, RHO = 900.0, 150.0, 1500.0


def test_the_slope_of_the_hysteretic_force_where_it_crosses_zero_is_rho() -> None:
    """dw/dx = rho (1 - w) after a turning point to the right, so rho at w = 0; the chord over a sample is near it."""
    record = sine(Damper("dahl", {"dahl.kx": KX, "dahl.kw": KW, "dahl.rho": RHO}), 0.0, offset=30.0, amplitude=0.004)
    known = PlasticRegion(KX, KW, RHO, KW * RHO, 30.0, 0.0, 0.5, 8)
    slopes = crossing_slopes(record, known)
    assert slopes.size >= 6
    assert np.median(slopes) == pytest.approx(RHO, rel=0.1)
    twice = crossing_slopes(record, PlasticRegion(KX, 2 * KW, RHO, KW * RHO, 30.0, 0.0, 0.5, 8))
    np.testing.assert_allclose(twice, slopes / 2.0, rtol=1e-12)


def test_rows_without_a_file_are_told_and_nothing_is_fitted_to_one_voltage(one_file: PublishedCampaign) -> None:
    [test] = one_file.tests
    assert one_file.test("4.2", test.row.row) is test
    assert one_file.table("4.2") == [test]
    assert one_file.table("4.3") == one_file.validation == []
    assert (one_file.joint, len(one_file.absent)) == (None, 40)
    assert test.least_squares is not None
