"""The kernel for a graphics card, in numba's simulator; and on a card where there is one."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from tests.structures.steel_dampers import of

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.models import Damper
from dampyr.structures import ensemble, two_storey
from dampyr.structures.batch.gpu import ON_THE_CARD, missing

CARDS = {
    "dahl": {"dahl.kx": 1400.0, "dahl.kw": 227.0, "dahl.rho": 18800.0},
    "hyperbolic_tangent + delay": {
        "hyperbolic_tangent.c": 1500.0, "hyperbolic_tangent.ft": 200.0, "hyperbolic_tangent.v0": 0.0032,
        "hyperbolic_tangent.s": 0.13, "delay.tau": 0.007,
    },
}  # fmt: skip
SCRIPT = """
import json, sys
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.models import Damper
from dampyr.structures import ensemble, two_storey
given = json.load(sys.stdin)
motions = [GroundMotion(el_centro().acceleration[:n], 0.02) for n in (60, 40)]
quantities = ("drift", "force", "energy")
found = ensemble(two_storey(), motions, Damper(*given), [0.0], [1.0, 3.0], device="gpu", quantities=quantities).dataset
print(json.dumps({q: found[q].values.tolist() for q in quantities}))
"""


@pytest.mark.prove
@pytest.mark.parametrize("name", CARDS)
def test_the_simulated_card_gives_what_the_processor_gives(name: str) -> None:
    environment = os.environ | {"NUMBA_ENABLE_CUDASIM": "1", "PYTHONWARNINGS": "ignore"}
    given = json.dumps([name, CARDS[name]])
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], input=given, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    motions = [GroundMotion(el_centro().acceleration[:n], 0.02) for n in (60, 40)]
    here = ensemble(two_storey(), motions, Damper(name, CARDS[name]), [0.0], [1.0, 3.0]).dataset
    for quantity, values in json.loads(done.stdout).items():
        np.testing.assert_allclose(
            values, here[quantity], rtol=5e-4
        )  # peaks between steps: a quick reciprocal here, a division there


KINDS = (
    "dahl", "bouc_wen", "sigmoid", "hyperbolic_tangent + spring", "dahl + delay", "hyperbolic_tangent + delay",
    "bouc_wen + delay", "dahl + compliance", "hyperbolic_tangent + compliance", "dahl + free_play",
    "hysteretic_biviscous + spring + compliance", "dahl + compliance + delay", "dahl + inertia",
)  # fmt: skip


@pytest.mark.by_hand
@pytest.mark.parametrize("name", KINDS)
def test_a_card_gives_what_the_processor_gives(name: str) -> None:
    """What the simulator cannot show: whether it compiles for a card, and what that computes."""
    if reason := missing():
        pytest.skip(reason)
    motions = [GroundMotion(el_centro().acceleration[:n], 0.02) for n in (300, 200)]
    quantities = ("drift", "displacement", "acceleration", "force", "energy")
    case = (two_storey(), motions, of(name), [0.0], [1.0, 3.0])
    card = ensemble(*case, device="gpu", quantities=quantities).dataset
    processor = ensemble(*case, quantities=quantities).dataset
    for quantity in quantities:
        largest = float(np.max(processor[quantity]))
        np.testing.assert_allclose(card[quantity], processor[quantity], rtol=0, atol=2e-5 * largest)


def test_a_place_of_the_ring_is_a_whole_number_also_where_floor_gives_a_float() -> None:
    names: dict[str, Any] = {"floor_of": lambda t: float(math.floor(t)), "eighth": 0.125}
    exec(ON_THE_CARD, names)
    for t, place in ((2.7, 2), (-0.5, -1)):
        assert (names["floor"](t), type(names["floor"](t))) == (place, int)
    assert names["eighth_over"](0.5) == 0.25


def test_without_a_card_it_says_so() -> None:
    if not missing():
        pytest.skip("there is a graphics card here")
    with pytest.raises(InputError, match=r"device = 'gpu': .*(device='cpu'|install)"):
        ensemble(two_storey(), el_centro(), device="gpu")


def test_a_device_that_there_is_not() -> None:
    with pytest.raises(InputError, match="choose from cpu, gpu"):
        ensemble(two_storey(), el_centro(), device="tpu")
