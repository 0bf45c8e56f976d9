"""What can be chosen for dampers in a building."""

import numpy as np

from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.models import Damper
from dampyr.structures import RespondOptions, ensemble, respond, two_storey

MOTION = GroundMotion(el_centro().acceleration[:200], el_centro().dt, "two seconds")
DAHL = {"dahl.kx": 1000.0, "dahl.kw": 200.0, "dahl.rho": 1000.0}


def test_what_is_changed_of_a_damper_is_an_option(cubics: Damper) -> None:
    options = RespondOptions(brace=2e5, after=1.0)
    braced = respond(two_storey(), MOTION, cubics, 1.0, options=options)
    np.testing.assert_array_equal(
        braced.displacement, respond(two_storey(), MOTION, cubics.on_brace(2e5), 1.0, after=1.0).displacement
    )
    late = Damper("dahl + delay", DAHL | {"delay.tau": 0.02})
    at_once = respond(two_storey(), MOTION, late, without=["delay"])
    np.testing.assert_array_equal(
        at_once.displacement, respond(two_storey(), MOTION, late.without("delay")).displacement
    )
    peaks = ensemble(two_storey(), MOTION, [None, late], without="delay", quantities="drift").dataset
    plain = ensemble(two_storey(), MOTION, [None, late.without("delay")], quantities="drift").dataset
    np.testing.assert_array_equal(peaks.drift, plain.drift)
