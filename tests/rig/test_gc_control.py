"""No full collection of garbage, which stops every thread, takes long while a rig is connected."""

import gc

import pytest
from tests.rig_time import SimulatedTime

from dampyr.errors import RigFault
from dampyr.rig import RigSettings
from dampyr.rig.gc_control import disable_gc, freeze_objects


@pytest.fixture(autouse=True)
def nothing_set_aside():
    """As a fresh process has it, before and after."""
    gc.unfreeze()
    yield
    gc.unfreeze()


@pytest.mark.prove
def test_what_exists_is_not_looked_at_again():
    objects = [[k] for k in range(150_000)]
    before = len(gc.get_objects())
    release = disable_gc()
    assert gc.get_freeze_count() > len(objects)
    assert len(gc.get_objects()) < before / 10
    release()
    assert gc.get_freeze_count() == 0


def test_new_garbage_is_still_collected():
    release = disable_gc()
    gc.collect()
    for _ in range(100):  # fewer than set a collection off
        circle = []
        circle.append(circle)
    del circle
    collected = gc.collect()
    release()
    assert collected >= 100


def test_what_was_garbage_before_is_not_kept():
    class Circle:
        seen = 0

        def __init__(self):
            self.me = self

        def __del__(self):
            Circle.seen += 1

    Circle()
    freeze_objects()
    assert Circle.seen == 1


def test_the_last_one_undoes_it_once():
    first, second = disable_gc(), disable_gc()
    first()
    first()
    assert gc.get_freeze_count() > 0
    second()
    assert gc.get_freeze_count() == 0


def test_what_others_set_aside_stays():
    gc.freeze()
    first, second = disable_gc(), disable_gc()
    second()
    first()
    assert gc.get_freeze_count() > 0


def test_a_rig_in_real_time_sets_aside_what_exists_when_it_is_connected_and_when_it_is_armed():
    def unplugged():
        raise RigFault("the wire is cut")

    with SimulatedTime().connect(RigSettings()) as rig:
        connected = gc.get_freeze_count()
        assert connected > 0
        objects = [[k] for k in range(100_000)]
        rig.uno.hello = unplugged
        with pytest.raises(RigFault, match="the wire is cut"), rig.armed():
            pass
        assert gc.get_freeze_count() > connected + 0.9 * len(objects)
    assert gc.get_freeze_count() == 0
