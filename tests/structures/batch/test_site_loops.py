"""More sites than are written out, in loops: as written out, as a response, and as dashpots in the matrix of the building."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.signal import lsim
from tests.structures.steel_dampers import of

from dampyr.errors import DampyrWarning
from dampyr.ground_motions import GroundMotion, el_centro, kanai_tajimi
from dampyr.models import Damper
from dampyr.structures import Building, control_law, ensemble, respond, two_storey
from dampyr.structures.batch import assemble
from dampyr.structures.ensembles import ensemble_batches
from dampyr.structures.sensors import Sensor

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*was calibrated:dampyr.errors.DampyrWarning"),
    pytest.mark.filterwarnings("ignore:peaks changed by up to:dampyr.errors.DampyrWarning"),
    pytest.mark.filterwarnings("ignore:the response is not to its accuracy:dampyr.errors.DampyrWarning"),
]
QUANTITIES = ("displacement", "drift", "acceleration", "force", "stroke", "energy")
HIGH = 3.212


def storeys(n: int) -> Building:
    """A shear building of so many equal storeys."""
    K = 2e6 * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    K[-1, -1] -= 2e6
    return Building(2e3 * np.eye(n), 1e-3 * K + 1e3 * np.eye(n), K)


@pytest.fixture
def in_loops(monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """Call it, and any number of sites runs in loops."""

    def change() -> None:
        monkeypatch.setattr(assemble, "SITES_WRITTEN_OUT", 0)
        monkeypatch.setattr(ensemble_batches, "_ENGINES", type(ensemble_batches._ENGINES)())

    return change


def _sensors(names: tuple[str, ...]) -> dict[str, Sensor]:
    return {name: Sensor(0.02, 0.01, 0.0, 5.0, delay=1) for name in names}


@pytest.mark.parametrize(
    ("placement", "law"),
    [
        pytest.param({1: of("dahl"), 2: [of("dahl + delay"), of("dahl")]}, None, id="delay"),
        pytest.param({2: [of("dahl + compliance"), of("hyperbolic_tangent")]}, None, id="series", marks=pytest.mark.prove),
        pytest.param(
            "published", control_law("clipped_optimal_lqg", high=HIGH, lag=0.01, seed=5, sensors=_sensors(("accelerations",))),
            id="filter", marks=pytest.mark.prove,
        ),
        pytest.param(
            "published", control_law("inverse_tracking", high=HIGH, lag=0.01), id="inverse", marks=pytest.mark.prove,
        ),
        pytest.param(
            "published", control_law("fuzzy", high=HIGH, seed=5, sensors=_sensors(("velocity", "rate"))), id="jumps",
            marks=pytest.mark.prove,
        ),
    ],
)  # fmt: skip
def test_loops_give_what_is_written_out(placement: Any, law: Any, cubics: Damper, in_loops: Callable[[], None]) -> None:
    """To what the order of sums changes: a billionth, and a little more behind a filter."""
    placed = {1: cubics, 2: cubics} if placement == "published" else placement
    motions = [GroundMotion(el_centro().acceleration[:150], 0.02), kanai_tajimi(2.0, dt=0.02, seed=1, pga=3.0)]

    def run() -> Any:
        return ensemble(two_storey(), motions, placed, law or 0.0, [0.5, 1.0], quantities=QUANTITIES).dataset

    written = run()
    in_loops()
    looped = run()
    for quantity in QUANTITIES:
        np.testing.assert_allclose(looped[quantity], written[quantity], rtol=1e-7)


@pytest.mark.prove
def test_sites_of_several_kinds_are_those_of_a_response() -> None:
    """Two kinds in turns, two dampers in a storey, a place between two floors; nothing runs one by one."""
    placement = {
        1: [of("dahl"), of("hyperbolic_tangent")],
        2: of("dahl"),
        3: of("hyperbolic_tangent"),
        (0, 2): of("dahl"),
    }
    motion = GroundMotion(el_centro().acceleration[:400], 0.02)
    dataset = ensemble(storeys(3), motion, placement, [0.0], accuracy="strict", quantities=QUANTITIES).dataset
    assert dataset.attrs["one_by_one"] == 0
    one = respond(storeys(3), motion, placement, voltage=0.0, accuracy=5e-5)
    np.testing.assert_allclose(dataset.drift[0, 0, 0, 0, 0], one.peak_drift, rtol=1e-3)
    np.testing.assert_allclose(dataset.force[0, 0, 0, 0, 0], one.peak_force, rtol=2e-3)
    np.testing.assert_allclose(dataset.energy[0, 0, 0, 0, 0], one.energy.dampers[:, -1], rtol=3e-3)


def test_dashpots_are_those_of_the_matrix() -> None:
    """Against scipy: a damper that is a dashpot adds to C."""
    n, c = 5, [3e3, 5e3, 2e3, 4e3, 1e3]
    building = storeys(n)
    dashpots = {
        k + 1: Damper("dahl", {"dahl.kx": value, "dahl.kw": 1e-9, "dahl.rho": 1.0}) for k, value in enumerate(c)
    }
    motion = kanai_tajimi(6.0, dt=0.02, seed=1, pga=3.0)
    dataset = ensemble(building, motion, dashpots, [0.0], [1.0, 2.0], quantities=("displacement",)).dataset
    rows = np.eye(n) - np.eye(n, k=-1)
    C = building.C + rows.T @ np.diag(c) @ rows
    A = np.block(
        [[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(building.M, building.K), -np.linalg.solve(building.M, C)]]
    )
    B = np.concatenate([np.zeros(n), -np.ones(n)])[:, None]
    t = np.linspace(0.0, motion.duration, 20 * (motion.n - 1) + 1)
    _, x, _ = lsim((A, B, np.eye(2 * n)[:n], np.zeros((n, 1))), np.interp(t, motion.time, motion.acceleration), t)
    for s, scale in enumerate((1.0, 2.0)):
        np.testing.assert_allclose(dataset.displacement[0, 0, 0, 0, s], scale * np.abs(x).max(axis=0), rtol=2e-4)


@pytest.mark.prove
@pytest.mark.parametrize("name", ["bang_bang", "clipped_optimal_lqg"])
def test_laws_at_many_sites_are_those_of_a_response(name: str, cubics: Damper) -> None:
    """At the same step with the same noise of each sensor; a filter for each place; a number beside the law."""
    sensors = _sensors(("accelerations",)) if name == "clipped_optimal_lqg" else {}
    law = control_law(name, high=HIGH, lag=0.01, seed=5, sensors=sensors)
    motion, placement = kanai_tajimi(3.0, dt=0.02, seed=1, pga=3.0), dict.fromkeys((1, 2, 3, 4), cubics)
    dataset = ensemble(storeys(4), motion, placement, [law, 1.0], [0.5, 1.0], accuracy="strict").dataset
    assert dataset.attrs["one_by_one"] == 0
    for s, scale in enumerate((0.5, 1.0)):
        one = respond(storeys(4), motion.scaled(scale), placement, voltage=law, step=0.00125)
        here = dataset.isel(building=0, damper=0, input=0, motion=0, scale=s)
        np.testing.assert_allclose(here.drift, one.peak_drift, rtol=2e-3)
        np.testing.assert_allclose(here.acceleration, one.peak_acceleration, rtol=5e-3)
        np.testing.assert_allclose(here.force, one.peak_force, rtol=2e-3)
        np.testing.assert_allclose(here.energy, one.energy.dampers[:, -1], rtol=2e-3)


@pytest.mark.prove
def test_eight_sites_in_either_precision() -> None:
    """However the cases are shared out, to the last bit; in single precision to a thousandth."""
    placement, motion = dict.fromkeys(range(1, 9), of("dahl")), kanai_tajimi(2.0, dt=0.02, seed=1, pga=3.0)
    scales = np.linspace(0.2, 2.0, 70)
    double = ensemble(storeys(8), motion, placement, [0.0], scales, quantities=("drift",)).dataset
    single = ensemble(storeys(8), motion, placement, [0.0], scales, quantities=("drift",), precision=32).dataset
    np.testing.assert_allclose(single.drift, double.drift, rtol=2e-3)
    alone = ensemble(storeys(8), motion, placement, [0.0], scales[-2:], quantities=("drift",)).dataset
    np.testing.assert_array_equal(alone.drift, double.drift[..., -2:, :])


@pytest.mark.prove
def test_a_case_that_grows_without_bound_is_counted() -> None:
    feeding = Damper("spring + dahl", {"spring.k0": -3e6, "dahl.kx": 1.0, "dahl.kw": 1.0, "dahl.rho": 10.0})
    with pytest.warns(DampyrWarning, match="1 cases grew without bound"):
        ensemble(storeys(4), el_centro().scaled(1e6), dict.fromkeys((1, 2, 3, 4), feeding), [0.0], [1e300])
