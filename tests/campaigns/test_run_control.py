"""The buttons of a campaign that runs: what is asked for, and how it ends it."""

import pytest

from dampyr.campaigns.run_control import RunControl, Skipped, Stopped, exit_status
from dampyr.errors import RigFault


def test_nothing_is_raised_where_nothing_was_pressed() -> None:
    control = RunControl()
    control.check()
    assert (control.paused, control.stopped, control.aborted) == (False, False, False)


def test_pause_waits_until_it_is_gone_on_with() -> None:
    control = RunControl()
    control.pause()
    assert control.paused
    control.check()  # it acts between two tests, and ends none
    control.resume()
    assert not control.paused


def test_stop_and_abort_end_it_and_abort_goes_before() -> None:
    heard: list[str] = []
    control = RunControl(abort_now=heard.append)
    control.stop()
    with pytest.raises(Stopped, match="run it again to go on"):
        control.check()
    control.abort("by a door")
    assert heard == ["by a door"]
    with pytest.raises(RigFault, match="aborted: by a door") as fault:
        control.check()
    assert fault.value.ring == "operator"


def test_a_test_that_is_skipped_ends_only_while_it_is_under_way() -> None:
    control = RunControl(under_way="first")
    control.skip("second")
    control.check()
    control.under_way = "second"
    with pytest.raises(Skipped):
        control.check()
    assert (control.skips("second"), control.skips("second"), control.skips("first")) == (True, False, False)
    control.check()


def test_repeats_are_taken_once() -> None:
    control = RunControl()
    control.repeat("a")
    control.repeat("b")
    assert (control.repeats(), control.repeats()) == (["a", "b"], [])


@pytest.mark.parametrize(
    ("problem", "status"),
    [
        (Stopped("x"), "stopped"),
        (Skipped("x"), "stopped"),
        (KeyboardInterrupt(), "stopped"),
        (RigFault("x", "operator"), "aborted"),
        (RigFault("x", "firmware"), "failed"),
        (OSError(), "failed"),
    ],
)
def test_how_it_ended_is_told_by_what_ended_it(problem: BaseException, status: str) -> None:
    assert exit_status(problem) == status
