"""What a plan is after: a peak of a structure and its gradient, or parameters with their targets."""

import re
import tomllib
from dataclasses import replace
from pathlib import Path
import numpy as np
import pytest
from tests.identification.synthetic import sine
from tests.planning.laboratory import DAHL
from dampyr import campaigns, ground_motions, structures
from dampyr.errors import FileError, InputError, RangeError
from dampyr.planning import Peak, propose
from dampyr.planning.proposal import Proposal
from dampyr.records import Record
from dampyr.rig import RigSettings
from dampyr.show.planning.proposal import envelope_figure
from dampyr.to_json import plain

QUICK = {"seconds": 4.0, "voltages": (0.0, 1.98), "kinds": ("sine", "voltage_steps")}
RIG = RigSettings()


@pytest.mark.prove
def test_a_peak_is_planned_for_by_its_gradient() -> None:
    peak = Peak(structures.two_storey(), ground_motions.el_centro().scaled(0.3), 1.98)
    planned = propose(DAHL, RIG, goal="peak", peak=peak, tests=3, **QUICK)
    assert planned.goal == "the largest drift at 1.98 V"
    assert planned.peak == pytest.approx(peak.value(DAHL), rel=0.05)
    assert planned.peak_after is not None
    assert 0.0 < planned.peak_after < 1.0
    with pytest.raises(RangeError, match="outside"):
        propose(DAHL, RIG, goal="peak", peak=replace(peak, voltage=3.5), tests=3, **QUICK)
    # two records at 1.98 V do not say how records differ there, so the peak has no interval yet
    few = [
        sine(DAHL, u, f"{u:g}V-{k}", 0.06 / (2 * np.pi * f), float(f), seconds=4.0)
        for u, n in ((0.0, 4), (1.98, 2))
        for k, f in enumerate(np.geomspace(0.5, 2.0, n))
    ]
    options = QUICK | {"kinds": ("sine",), "laws": "interpolation", "model": "dahl"}
    after_few = propose(few, RIG, goal="peak", peak=peak, tests=3, **options)
    assert after_few.peak_before == np.inf
    assert after_few.peak_after is not None
    assert np.isfinite(after_few.peak_after)
    assert "none ->" in repr(after_few)
