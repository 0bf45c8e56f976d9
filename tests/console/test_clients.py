"""One page holds control, and loses it when it is gone."""

import pytest

from dampyr.console.clients import MAX_CLIENTS, SILENCE, Clients
from dampyr.errors import InputError


class Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


def test_the_first_gets_control_and_the_second_has_to_take_it(clock: Clock) -> None:
    clients = Clients(clock)
    clients.join("a")
    clients.join("b")
    clients.require("a")
    with pytest.raises(InputError, match="page 1 holds control; take control first"):
        clients.require("b")
    clients.take("b")
    clients.require("b")
    with pytest.raises(InputError, match="page 2 holds control"):
        clients.require("a")


def test_a_client_without_a_stream_cannot_hold_control(clock: Clock) -> None:
    clients = Clients(clock)
    for ask in (clients.take, clients.require):
        with pytest.raises(InputError, match="no open stream"):
            ask("script")


def test_who_leaves_loses_control_and_nobody_gets_it_unasked(clock: Clock) -> None:
    clients = Clients(clock)
    clients.join("a")
    clients.join("b")
    assert clients.disconnect("a")
    assert clients.holder is None
    with pytest.raises(InputError, match="nobody holds control"):
        clients.require("b")
    assert not clients.disconnect("a")


def test_the_same_page_twice_is_one_client_until_both_are_closed(clock: Clock) -> None:
    clients = Clients(clock)
    clients.join("a")
    clients.join("a")
    assert not clients.disconnect("a")
    clients.require("a")
    assert clients.disconnect("a")


def test_silence_is_as_good_as_gone(clock: Clock) -> None:
    clients = Clients(clock)
    clients.join("a")
    clients.join("b")
    clock.now = SILENCE
    clients.hear("b")
    assert not clients.silent()
    clock.now += 0.1
    assert clients.silent()
    assert clients.holder is None
    assert clients.count == 1


def test_how_long_nobody_looks(clock: Clock) -> None:
    clients = Clients(clock)
    clients.join("a")
    clock.now = 2.0
    assert clients.alone == 0.0
    clients.disconnect("a")
    clock.now = 5.0
    assert clients.alone == 3.0


def test_a_crowd_is_turned_away(clock: Clock) -> None:
    clients = Clients(clock)
    for k in range(MAX_CLIENTS):
        clients.join(str(k))
    with pytest.raises(InputError, match="close one"):
        clients.join("one more")
