"""Rigs that several tests begin with."""

from collections.abc import Iterator

import pytest
from tests.rig.drives import made
from tests.rig.served_loop import Served

from dampyr.rig import Rig
from dampyr.rig.simulation.simulator import Simulator


@pytest.fixture
def ready() -> tuple[Rig, Simulator]:
    """A rig whose table stands in its middle."""
    rig, simulator = made()
    with rig.armed() as table:
        table.home()
        table.go(0.0)
    return rig, simulator


@pytest.fixture
def served() -> Iterator[Served]:
    """A rig that is read by a server in a thread, while time passes."""
    made = Served()
    with made.time.passing():
        yield made
        made.rig.close()
        made.thread.join(10.0)
        assert not made.thread.is_alive()
    made.inner.close()
