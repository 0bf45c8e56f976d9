"""The compiled kernel: what it takes and tells, and where it ends."""

import numpy as np
import pytest
from tests.structures.begin_of_el_centro import short

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.structures import control_law, respond, two_storey
from dampyr.structures.sites import make_sites
from dampyr.structures.time_history.kernel_run import runner
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
    differ = coarse.sensed[:, :, 4] != fine.decisions.sensed[:, :, 4]
    assert np.all(np.isfinite(others[differ]))
    signal, rate = (fine.decisions.sensed[0, :, k] for k in (0, 2))
    change = [np.abs(fine.decisions.sensed[0, :, k] - coarse.sensed[0, :, k]) for k in (0, 2)]
    crosses = ((np.abs(signal) < change[0]) & (rate != 0.0)) | ((np.abs(rate) < change[1]) & (signal != 0.0))
    np.testing.assert_array_equal(np.isfinite(others[0]), crosses | differ[0])
    taken = run(8, imposed=others).decisions.sensed[:, :, 4]
    np.testing.assert_array_equal(taken[np.isfinite(others)], others[np.isfinite(others)])
    np.testing.assert_array_equal(run(8).out.state, fine.out.state)
