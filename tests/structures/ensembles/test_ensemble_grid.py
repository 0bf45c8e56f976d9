"""The cases of an ensemble and their shards."""

from __future__ import annotations

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.ground_motions import el_centro
from dampyr.models import Damper
from dampyr.structures import control_law, ensemble, two_storey
from dampyr.structures.ensembles.ensemble_grid import cases
from dampyr.structures.sensors import Sensor

pytestmark = pytest.mark.filterwarnings("ignore:.*was calibrated:dampyr.errors.DampyrWarning")


@pytest.mark.parametrize(
    ("lines", "scales", "shards"), [(1, 100_000, 1), (21, 2400, 21), (100, 10, 1), (1000, 10, 4), (10_000, 100, 123)]
)
def test_shards_are_many_enough_to_share_out_and_worth_their_beginning(lines: int, scales: int, shards: int) -> None:
    what = cases(two_storey(), el_centro(), [None] * lines, None, np.linspace(0.1, 2.0, scales))
    assert what.shards() == shards
    shard_lines = [what.lines_of(k, shards) for k in range(shards)]
    assert all(shard_lines)
    assert sum(map(len, shard_lines)) == lines


def test_shards_of_cases_that_run_one_by_one_are_small(cubics: Damper) -> None:
    """A case under a law whose sensor is late by more samples than an engine keeps takes as long as thousands of others."""
    late = control_law("on_off", high=2.0, sensors={"rate": Sensor(delay=9)})
    for law, shards in ((control_law("on_off", high=2.0), 1), (late, 10)):
        assert cases(two_storey(), el_centro(), [cubics] * 20, [law, 0.0], [1.0, 2.0]).shards() == shards


def test_lists_of_the_wrong_thing_are_refused() -> None:
    with pytest.raises(InputError, match="motions holds a int; give one GroundMotion"):
        ensemble(two_storey(), [3])
