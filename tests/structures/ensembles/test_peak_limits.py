"""Limits of peaks as people write them."""

import pytest

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.models import Damper
from dampyr.structures import ensemble, two_storey

MOTION = GroundMotion(el_centro().acceleration[:200], el_centro().dt, "two seconds")


def test_limits_of_an_ensemble_are_texts_with_units(cubics: Damper) -> None:
    given = (two_storey(), [MOTION, MOTION.scaled(-0.5)], [None, cubics], [1.0], [0.5, 1.0, 2.0])
    result = ensemble(*given, limits=("5 mm", "1%", "0.5g", "force=1kN"), height=3.0, intensity="scale")
    assert [(c.quantity, c.limit_unit, c.intensity) for c in result.curves] == [
        ("drift", "m", "scale"), ("drift", "", "scale"), ("acceleration", "m/s^2", "scale"), ("force", "N", "scale"),
    ]  # fmt: skip
    assert result.curves[3].limit == 1000.0
    again = ensemble(*given).evaluated("5 mm", intensity="scale")
    assert [c.theta for c in again.curves[0].curves] == [c.theta for c in result.curves[0].curves]
    assert result.to_xarray() is result.dataset
    for wrong, words in (
        ({"limits": "5"}, "'5' has no unit of a drift or an acceleration"),
        ({"limits": "1%"}, "give height too"),
        ({"limits": "5mm", "height": 3.0}, "height belongs to a limit in per cent"),
        ({"limits": "colour=5mm"}, "'colour' is not known"),
        ({"limits": "force=5mm"}, "has no unit of a force; write it as in force=1N"),
        ({"limits": "force=5%"}, "which only a drift has"),
        ({"limits": "-5mm"}, "must be greater than 0"),
        ({"limits": "5mm", "quantities": "force"}, "a limit of drift, which is not among the quantities"),
        ({"quantities": ()}, "quantities is empty"),
    ):
        with pytest.raises(InputError, match=words):
            ensemble(*given, **wrong)
