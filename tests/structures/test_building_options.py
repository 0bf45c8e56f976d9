"""What can be chosen for dampers in a building."""

import numpy as np
import pytest

from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.models import Damper
from dampyr.structures import RespondOptions, ensemble, respond, two_storey
from dampyr.structures.building_options import InstallationOptions
from dampyr.structures.sites import installed, places_and_dampers

MOTION = GroundMotion(el_centro().acceleration[:200], el_centro().dt, "two seconds")
DAHL = {"dahl.kx": 1000.0, "dahl.kw": 200.0, "dahl.rho": 1000.0}


@pytest.mark.prove  # its kernels take long to compile
def test_a_brace_is_an_option(cubics: Damper) -> None:
    options = RespondOptions(brace=2e5, after=1.0)
    braced = respond(two_storey(), MOTION, cubics, 1.0, options=options)
    np.testing.assert_array_equal(
        braced.displacement, respond(two_storey(), MOTION, cubics.on_brace(2e5), 1.0, after=1.0).displacement
    )


def test_a_brace_is_put_before_every_damper(cubics: Damper) -> None:
    """Also before those that stand side by side; a brace of 200 kN/m is a compliance of 5e-6 m/N."""
    placed = installed({1: cubics, 2: [cubics, cubics]}, InstallationOptions(brace=2e5))
    for _, damper in places_and_dampers(placed):
        assert damper.all_laws["compliance.s"](1.0) == 1 / 2e5
        assert damper.without("compliance").all_laws == cubics.all_laws
    assert installed({1: cubics}, InstallationOptions())[1] is cubics


def test_what_is_left_out_of_a_damper_is_an_option() -> None:
    late = Damper("dahl + delay", DAHL | {"delay.tau": 0.02})
    at_once = respond(two_storey(), MOTION, late, without=["delay"])
    np.testing.assert_array_equal(
        at_once.displacement, respond(two_storey(), MOTION, late.without("delay")).displacement
    )
    peaks = ensemble(two_storey(), MOTION, [None, late], without="delay").dataset
    plain = ensemble(two_storey(), MOTION, [None, late.without("delay")]).dataset
    np.testing.assert_array_equal(peaks.drift, plain.drift)
