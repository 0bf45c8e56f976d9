"""A damper that is unlike in extension and compression."""

from pathlib import Path

import numpy as np
import pytest

from dampyr import records
from dampyr.identification import fit
from dampyr.models import Damper

CASE = Path(__file__).resolve().parents[4] / "shared" / "findings" / "cases" / "asymmetric"


def test_each_direction_has_its_own_numbers() -> None:
    values = {"ce": 2000.0, "cc": 800.0, "fe": 100.0, "fc": 50.0, "v0": 1e-3}
    damper = Damper("asymmetric", {f"asymmetric.{key}": value for key, value in values.items()})
    force = damper.force(np.arange(3.0), np.zeros(3), voltage=0.0, velocity=np.array([-0.1, 0.0, 0.1]))
    assert force == pytest.approx([-80.0 - 50.0, 0.0, 200.0 + 100.0])


@pytest.mark.skipif(not CASE.exists(), reason="the folder shared with its cases is not beside the repository")
def test_two_slopes_are_found_from_five_sines() -> None:
    """2.0 N s/mm out and 0.8 N s/mm in."""
    result = fit([records.read(path, voltage=0.0) for path in sorted(CASE.glob("*.csv"))], "asymmetric")
    assert result.parameters["asymmetric.ce"] == pytest.approx(2000.0, rel=1e-3)
    assert result.parameters["asymmetric.cc"] == pytest.approx(800.0, rel=1e-3)
    assert max(score.l1 for score in result.scores.values()) < 1e-3
