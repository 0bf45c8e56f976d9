"""Work at the bench besides one campaign: a rig that is not armed, a queue, skip and repeat, what the records say."""

import pytest
from tests.console.bench_runs import Phase, Until, start, states
from tests.short_campaign import FIRST, SECOND, SHORT

from dampyr.console.bench_session import Bench, RunAbout
from dampyr.errors import InputError
from dampyr.records import read


def test_a_disarmed_rig_is_read_before_arming_and_after_an_abort(idle: Bench, until: Until, phase: Phase) -> None:
    until(lambda: idle.state().live is not None)
    live, age = idle.state().live, idle.state().live_age
    assert live is not None
    assert live.voltage == 0.0
    assert abs(live.force) > 10.0  # the simulated damper pushes
    assert age is not None
    assert age < 0.5
    bins = idle.strips.count if idle.strips else 0
    until(lambda: idle.strips is not None and idle.strips.count > bins + 20)
    idle.arm("a")
    phase(idle, "armed")
    idle.abort()
    phase(idle, "idle", 5.0)
    until(lambda: (now := idle.state()).live is not None and now.live.voltage == 0.0 and (now.live_age or 0.0) < 0.5)


def test_homed_positions_are_read_while_disarmed(armed: Bench, until: Until, phase: Phase) -> None:
    armed.go("a", 0.005)
    phase(armed, "moving")
    phase(armed, "armed")
    armed.disarm("a")
    phase(armed, "idle")
    until(
        lambda: (
            (live := armed.state().live) is not None and abs(live.position - 0.005) < 3e-4 and not armed.state().armed
        )
    )


def test_who_and_what_are_in_the_records(armed: Bench, phase: Phase) -> None:
    start(armed, about=RunAbout("A. Operator", "damper-7", "after repair"))
    phase(armed, "campaign")
    run = armed.state().run
    assert run is not None
    assert (run.operator, run.specimen) == ("A. Operator", "damper-7")
    phase(armed, "idle")
    record = read(armed.data / "run" / f"{FIRST}.h5")
    assert record.specimen == "damper-7"
    assert record.provenance["operator"] == "A. Operator"


def test_a_complete_folder_is_refused_before_anything_moves(armed: Bench, phase: Phase) -> None:
    start(armed)
    phase(armed, "campaign")
    phase(armed, "idle")
    with pytest.raises(InputError, match="all 2 tests are recorded there"):
        start(armed)
    (armed.data / "short.toml").write_text(SHORT.replace("4 mm", "3 mm"))
    with pytest.raises(InputError, match="holds the campaign 'short', which is another one"):
        start(armed)
    assert armed.state().phase == "idle"


@pytest.mark.prove
def test_a_queue_goes_on_only_after_what_was_complete(armed: Bench, until: Until, phase: Phase) -> None:
    start(armed, "one")
    for name in ("two", "three"):
        armed.enqueue("a", "short", armed.data / "short.toml", armed.data / name, RunAbout("A. Operator"))
    with pytest.raises(InputError, match="waits in the queue already"):
        armed.enqueue("a", "short", armed.data / "short.toml", armed.data / "two", RunAbout())
    assert [queued.folder for queued in armed.state().queue] == ["two", "three"]
    until(lambda: (run := armed.state().run) is not None and run.folder == "two" and run.cycles > 0.3, 60.0)
    assert set(states(armed.data / "one").values()) == {"complete"}
    armed.abort()
    phase(armed, "idle", 5.0)
    assert [queued.folder for queued in armed.state().queue] == ["three"]  # it waits: what came before was aborted
    armed.dequeue("a", armed.state().queue[0].number)
    assert armed.state().queue == ()


def test_a_test_is_skipped_and_one_repeated(armed: Bench, until: Until, phase: Phase) -> None:
    start(armed)
    until(lambda: (run := armed.state().run) is not None and run.cycles > 0.3)
    armed.skip("a", FIRST)
    until(lambda: (run := armed.state().run) is not None and run.test == SECOND and run.cycles > 0.3, 60.0)
    armed.repeat("a", SECOND)
    phase(armed, "idle", 60.0)
    run = armed.state().run
    assert run is not None
    assert run.outcome == "stopped"
    assert f"skipped by the operator: {FIRST}" in run.reason
    assert states(armed.data / "run") == {FIRST: "stopped", SECOND: "complete"}
    assert sorted(path.name for path in (armed.data / "run").glob("02*.h5")) == [f"{SECOND}.h5", f"{SECOND}.try2.h5"]
    start(armed)  # goes on with what was skipped
    phase(armed, "campaign")
    phase(armed, "idle")
    assert states(armed.data / "run") == {FIRST: "complete", SECOND: "complete"}
