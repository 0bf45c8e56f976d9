"""The cases of an ensemble in blocks: every kind of damper, as alone, however the work is cut."""

from __future__ import annotations

import numpy as np
import pytest
from tests.structures.steel_dampers import of

from dampyr.errors import DampyrWarning
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.models import Damper
from dampyr.models.codegen.composition import compose
from dampyr.structures import ensemble, respond, two_storey
from dampyr.structures.ensembles.ensemble import run
from dampyr.structures.ensembles.ensemble_batches import run_shard
from dampyr.structures.ensembles.ensemble_grid import cases

pytestmark = pytest.mark.filterwarnings("ignore:.*was calibrated:dampyr.errors.DampyrWarning")


def test_bit_identical_however_it_is_cut(cubics: Damper, motions: list[GroundMotion]) -> None:
    what = cases(two_storey(), motions, [cubics, None], [0.0, 1.0], np.linspace(0.2, 2.0, 7))
    whole = run_shard(0, 1, what).values
    for shards in (2, 5):
        parts = [run_shard(k, shards, what).values for k in range(shards)]
        for quantity, values in whole.items():
            np.testing.assert_array_equal(np.concatenate([p[quantity] for p in parts]), values)


@pytest.mark.parametrize(
    ("name", "one_by_one"),
    [
        pytest.param("hyperbolic_tangent + spring", 0, marks=pytest.mark.prove),
        pytest.param("bouc_wen", 0, marks=pytest.mark.prove),
        pytest.param("sigmoid", 0, marks=pytest.mark.by_hand),
        pytest.param("dahl + delay", 0, marks=pytest.mark.by_hand),
        pytest.param("dahl + compliance", 0, marks=pytest.mark.by_hand),
        pytest.param("hyperbolic_tangent + compliance", 0, marks=pytest.mark.by_hand),
        pytest.param("dahl + free_play", 0, marks=pytest.mark.by_hand),
        pytest.param("hysteretic_biviscous + spring + compliance", 0, marks=pytest.mark.prove),
        pytest.param("dahl + compliance + delay", 0, marks=pytest.mark.by_hand),
        pytest.param("dahl + inertia", 1, marks=pytest.mark.prove),
    ],
)
def test_every_kind_of_damper(name: str, one_by_one: int) -> None:
    motion = GroundMotion(el_centro().acceleration[:400], 0.02)
    dataset = ensemble(
        two_storey(), motion, of(name), [0.0], quantities=("drift", "force", "energy"), accuracy="strict"
    ).dataset
    assert dataset.attrs["one_by_one"] == one_by_one
    one = respond(two_storey(), motion, {1: of(name)}, voltage=0.0, accuracy=5e-5)
    np.testing.assert_allclose(dataset.drift[0, 0, 0, 0, 0], one.peak_drift, rtol=1.5e-3)
    np.testing.assert_allclose(dataset.force[0, 0, 0, 0, 0], one.peak_force, rtol=2e-3)
    np.testing.assert_allclose(dataset.energy[0, 0, 0, 0, 0], one.energy.dampers[:, -1], rtol=3e-3)


def test_a_delay_of_nothing_is_no_delay() -> None:
    given = dict(zip(compose("dahl + delay").parameters, (1400.0, 227.0, 18800.0, 0.0)))
    dataset = ensemble(two_storey(), el_centro(), [Damper("dahl + delay", given), of("dahl")], [0.0]).dataset
    assert dataset.attrs["one_by_one"] == 0
    np.testing.assert_array_equal(dataset.drift[:, 0], dataset.drift[:, 1])


@pytest.mark.prove  # its kernels take long to compile
def test_several_dampers_of_different_kinds() -> None:
    placement = {1: [of("dahl"), of("hyperbolic_tangent")], 2: of("dahl + delay")}
    motion = GroundMotion(el_centro().acceleration[:400], 0.02)
    dataset = ensemble(two_storey(), motion, placement, [0.0], accuracy="strict").dataset
    one = respond(two_storey(), motion, placement, voltage=0.0, accuracy=5e-5)
    np.testing.assert_allclose(dataset.drift[0, 0, 0, 0, 0], one.peak_drift, rtol=1e-3)
    np.testing.assert_allclose(dataset.force[0, 0, 0, 0, 0], one.peak_force, rtol=2e-3)


@pytest.mark.prove
def test_unbounded_cases_are_counted(motions: list[GroundMotion]) -> None:
    feeding = Damper("spring + dahl", {"spring.k0": -3e5, "dahl.kx": 1.0, "dahl.kw": 1.0, "dahl.rho": 10.0})
    with pytest.warns(DampyrWarning, match="1 cases grew without bound"):
        dataset = ensemble(two_storey(), motions[0].scaled(1e6), feeding, [0.0], [1e300]).dataset
    assert np.isnan(dataset.drift).all()


def test_one_engine_serves_dampers_of_the_same_parts(cubics: Damper) -> None:
    """A block of different dampers gives each what it would get alone."""
    others = [
        cubics,
        *(
            Damper("dahl", dict(zip(("dahl.kx", "dahl.kw", "dahl.rho"), v)))
            for v in ((800.0, 60.0, 3e4), (3e3, 400.0, 1e4))
        ),
    ]
    together = ensemble(two_storey(), el_centro(), others, [0.0]).dataset
    for k, damper in enumerate(others):
        np.testing.assert_array_equal(
            together.drift[:, k], ensemble(two_storey(), el_centro(), damper, [0.0]).dataset.drift[:, 0]
        )


def test_the_spread_of_a_motion_is_run_through_once(cubics: Damper) -> None:
    """The unit that a scheduler runs gives the same as the whole."""
    what = cases(two_storey(), el_centro(), cubics, [0.0], [1.0, 2.0])
    assert what.size == 2
    np.testing.assert_array_equal(run(what).drift.values.reshape(1, 2, 2), run_shard(0, 1, what).values["drift"])
