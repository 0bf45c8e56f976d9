"""One page holds control, and loses it when it is gone."""

import pytest

from dampyr.console.clients import MAX_CLIENTS, SILENCE, Clients, StreamTaken
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


def test_a_page_that_is_open_is_there_once_and_a_stream_that_was_given_up_ends_no_other(clock: Clock) -> None:
    clients = Clients(clock)
    first = clients.join("a")
    with pytest.raises(StreamTaken, match="another page is open under this one's id"):
        clients.join("a")
    clients.require("a")
    clock.now = SILENCE + 0.1
    assert clients.silent()  # a lost network: its page asks again, and the old stream ends when it ends
    second = clients.join("a")
    assert not clients.knows("a", first)
    assert not clients.disconnect("a", first)
    clients.require("a")
    assert clients.disconnect("a", second)


def test_who_does_what_is_named_by_operator_or_by_address(clock: Clock) -> None:
    clients = Clients(clock)
    clients.join("a", "192.0.2.7")
    assert (clients.who("a"), clients.titled("a")) == ("page 1 from 192.0.2.7", "page 1")
    clients.operate("a", " A. Operator ")
    clients.operate("a", "  ")  # nothing is no name
    assert (clients.who("a"), clients.titled("a")) == ("A. Operator, page 1", "A. Operator, page 1")
    assert clients.who("b") == ""


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
