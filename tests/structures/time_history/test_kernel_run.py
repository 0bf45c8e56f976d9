"""The compiled kernel: what it takes and tells, and where it ends."""

import numpy as np
import pytest
from tests.structures.begin_of_el_centro import short

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.models.codegen.kernels import bind
from dampyr.structures import control_law, respond, shear_building, two_storey
from dampyr.structures.sites import make_sites
from dampyr.structures.time_history.kernel_run import distinct, runner
from dampyr.structures.time_history.time_stepping import integrate
from dampyr.studies import raminelli_2020


def test_growth_without_bound_is_an_error():
    feeding = Damper("dahl + delay", {"dahl.kx": 9e6, "dahl.kw": 1e-9, "dahl.rho": 1000.0, "delay.tau": 0.02})
    with pytest.raises(InputError, match="grows without bound"):
        respond(two_storey(), short(20.0), {1: feeding}, voltage=0.0, step=0.01)


HIGH = 3.212


@pytest.fixture(scope="module")
def damper() -> Damper:
    return raminelli_2020.damper()


def test_the_kernel_takes_what_is_imposed_and_tells_what_hangs_on_the_step(damper):
    """Decisions that differ from those at twice the step, and those whose law crosses within the change of what it senses."""
    motion, law = short(4.0), control_law("on_off", high=HIGH)
    run = runner(two_storey(), motion, make_sites(two_storey(), {1: damper}, law, None, False))
    coarse = run(4).decisions
    fine = run(8, before=coarse.sensed)
    others = fine.decisions.others()
    assert others.shape == (1, fine.decisions.count) == (1, round(4.0 / 0.005))
    differ = coarse.sensed[:, :, -1] != fine.decisions.sensed[:, :, -1]
    assert np.all(np.isfinite(others[differ]))
    signal, rate = (fine.decisions.sensed[0, :, k] for k in (0, 1))
    change = [np.abs(fine.decisions.sensed[0, :, k] - coarse.sensed[0, :, k]) for k in (0, 1)]
    crosses = ((np.abs(signal) < change[0]) & (rate != 0.0)) | ((np.abs(rate) < change[1]) & (signal != 0.0))
    np.testing.assert_array_equal(np.isfinite(others[0]), crosses | differ[0])
    taken = run(8, imposed=others).decisions.sensed[:, :, -1]
    np.testing.assert_array_equal(taken[np.isfinite(others)], others[np.isfinite(others)])
    np.testing.assert_array_equal(run(8).out.state, fine.out.state)


def kernels_of(buildings_and_dampers) -> int:
    """How many kernels short runs of these need: one for each signature, and for each binding that none before it had."""
    bound, kernels = bind.cache_info().misses, set()
    for building, dampers in buildings_and_dampers:
        sites = make_sites(building, dampers, 1.98, None, False)
        runner(building, short(0.1), sites)(1)
        kernels.add(bind(integrate, distinct(sites), ""))
    # other tests of the process may have run the same kernel with loads, which is a signature of its own
    without_loads = [
        signature for kernel in kernels for signature in kernel.signatures if "StepLoads" not in str(signature)
    ]
    return max(bind.cache_info().misses - bound, len(without_loads))


def test_any_number_of_equal_dampers_runs_in_one_kernel(damper):
    tower = shear_building([2e4] * 20, [4e7] * 20, damping_ratio=0.03)
    placed = [(two_storey(), {1: [damper] * count}) for count in (1, 2, 3, 5)]
    placed += [(two_storey(), {2: damper}), (tower, dict.fromkeys(range(1, 21), damper))]
    assert kernels_of(placed) == 1


def test_the_places_of_different_dampers_make_no_further_kernel_and_each_keeps_its_formula(damper, tangent):
    one_way, other_way = {1: damper, 2: [tangent, damper]}, {1: [tangent, damper], 2: damper}
    assert kernels_of([(two_storey(), one_way), (two_storey(), other_way)]) == 1
    response = respond(two_storey(), short(2.0), one_way, voltage=1.98, step=0.005)
    c, ft, v0, s = tangent.values(1.98)
    stroke, rate = response.drift[1], np.diff(response.velocity, axis=0)[0]
    np.testing.assert_allclose(response.force[1], c * rate + ft * np.tanh((rate + s * stroke) / v0), atol=1e-6)
    kx, kw, _ = damper.values(1.98)
    for k, velocity in ((0, response.velocity[0]), (2, rate)):
        assert np.abs((response.force[k] - kx * velocity) / kw).max() <= 1 + 1e-9
