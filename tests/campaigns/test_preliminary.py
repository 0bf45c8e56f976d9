"""The slow stroke before the first test: what it measures, and what ends the campaign."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from dampyr.campaigns.campaign_thresholds import CampaignThresholds
from dampyr.campaigns.preliminary import preliminary_check
from dampyr.errors import RigFault
from dampyr.rig import Drive

PHASE = 2 * np.pi * np.arange(401) / 400
STROKE = 0.002 * np.sin(PHASE)
DRIVE = Drive(0.01, STROKE, np.zeros(401))


def played(displacement: np.ndarray, force: np.ndarray) -> Any:
    """A table that plays in blocks of 100 samples."""
    blocks = [slice(k, k + 100) for k in range(0, 401, 100)]
    samples = SimpleNamespace(displacement=displacement, force=force)
    return cast(Any, SimpleNamespace(play=lambda drive: ((samples, block) for block in blocks)))


def test_the_energy_of_a_dashpot_over_a_stroke_is_pi_f_a() -> None:
    """A force F cos against a displacement A sin: pi F A, and 2 F from peak to peak."""
    words = preliminary_check(played(STROKE, 50.0 * np.cos(PHASE)), DRIVE)
    assert words == f"stroke 4.00 mm, force 100 N peak to peak, {np.pi * 50.0 * 0.002:.3g} J"


def test_a_stroke_of_another_length_is_a_fault_beyond_its_threshold() -> None:
    short = played(0.4 * STROKE, 50.0 * np.cos(PHASE))
    with pytest.raises(RigFault, match=r"was 1.60 mm where 4.00 mm were asked for; look at the encoder and the screw"):
        preliminary_check(short, DRIVE)
    assert preliminary_check(short, DRIVE, CampaignThresholds(stroke_error=0.7)).startswith("stroke 1.60 mm")


@pytest.mark.parametrize("force", [-50.0, 0.0])
def test_a_force_that_takes_no_energy_is_a_fault(force: float) -> None:
    with pytest.raises(RigFault, match="is the force's sign inverted, or the load cell not connected"):
        preliminary_check(played(STROKE, force * np.cos(PHASE)), DRIVE)
