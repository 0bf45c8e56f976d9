"""Campaigns at the bench: where they are run into, a queue, skip and repeat, what the records say."""

import pytest
from tests.console.bench_runs import Phase, Until, records_of, start, states
from tests.short_campaign import FIRST, SECOND, SHORT

from dampyr.campaigns import RunControl
from dampyr.campaigns.journal import NAME as JOURNAL
from dampyr.console.bench_session import Bench
from dampyr.errors import DampyrError, InputError
from dampyr.records import read


def test_who_and_what_are_in_the_records(armed: Bench, phase: Phase) -> None:
    start(armed, operator="A. Operator", specimen="damper-7", note="after repair")
    phase(armed, "campaign")
    run = armed.state().run
    assert run is not None
    assert (run.operator, run.specimen) == ("A. Operator", "damper-7")
    phase(armed, "idle")
    record = read(records_of(armed) / f"{FIRST}.h5")
    assert record.specimen == "damper-7"
    assert record.provenance["operator"] == "A. Operator"


def test_a_complete_folder_is_refused_before_anything_moves(armed: Bench, phase: Phase) -> None:
    start(armed)
    phase(armed, "campaign")
    phase(armed, "idle")
    with pytest.raises(InputError, match="all 2 tests are recorded there"):
        start(armed)
    (armed.data / "campaigns" / "short.toml").write_text(SHORT.replace("4 mm", "3 mm"))
    with pytest.raises(InputError, match="holds the campaign 'short', which is another one"):
        start(armed)
    assert armed.state().phase == "idle"


@pytest.mark.prove
def test_a_queue_goes_on_only_after_what_was_complete(armed: Bench, until: Until, phase: Phase) -> None:
    start(armed, "one")
    for name in ("two", "three"):
        armed.enqueue("a", "short", name, operator="A. Operator")
    with pytest.raises(InputError, match="waits in the queue already"):
        armed.enqueue("a", "short", "two")
    assert [queued.folder for queued in armed.state().queue] == ["two", "three"]
    until(lambda: (run := armed.state().run) is not None and run.folder == "two" and run.cycles > 0.3, 60.0)
    assert set(states(records_of(armed, "one")).values()) == {"complete"}
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
    assert states(records_of(armed)) == {FIRST: "stopped", SECOND: "complete"}
    assert sorted(path.name for path in records_of(armed).glob("02*.h5")) == [f"{SECOND}.h5", f"{SECOND}.try2.h5"]
    start(armed)  # goes on with what was skipped
    phase(armed, "campaign")
    phase(armed, "idle")
    assert states(records_of(armed)) == {FIRST: "complete", SECOND: "complete"}


@pytest.mark.parametrize("press", ["stop", "abort"])
def test_a_button_that_is_pressed_as_a_campaign_ends_holds_the_queue(idle: Bench, press: str) -> None:
    idle.enqueue("a", "short", "next")
    runs = idle.runs
    ended = runs.control
    getattr(runs.control, press)()
    assert idle.rig is not None
    assert runs.begin_next(idle.rig) is None
    assert [queued.folder for queued in idle.state().queue] == ["next"]
    assert runs.control is not ended  # an abort sees what begins now
    assert runs.begin_next(idle.rig) is not None
    assert idle.state().queue == ()


def test_an_abort_meets_the_campaign_that_begins_in_this_moment(idle: Bench) -> None:
    runs, controls = idle.runs, [RunControl(), RunControl()]
    runs.control = controls[0]
    controls[0].abort_now = lambda why: setattr(runs, "control", controls[1])
    assert runs.abort("by the operator") is controls[1]
    assert [control.aborted for control in controls] == [True, True]


def test_an_interrupted_run_is_removed_and_no_other(armed: Bench, until: Until, phase: Phase) -> None:
    start(armed)
    until(lambda: (run := armed.state().run) is not None and run.cycles > 0.3)
    with pytest.raises(InputError, match="folder = 'run' is running; only an interrupted run can be removed"):
        armed.remove_run("a", "run", 0)
    armed.stop("a")
    phase(armed, "idle", 60.0)
    outside = armed.data / "kept.h5"
    outside.touch()
    (records_of(armed) / "link").symlink_to(outside)
    with pytest.raises(InputError, match="run has 0 complete tests by now, and not 1; look at it again"):
        armed.remove_run("a", "run", 1)
    armed.enqueue("a", "short", "run")
    with pytest.raises(InputError, match="waits in the queue"):
        armed.remove_run("a", "run", 0)
    armed.dequeue("a", armed.state().queue[0].number)
    with pytest.raises(InputError, match="no open stream"):
        armed.remove_run("b", "run", 0)
    armed.remove_run("a", "run", 0)
    assert list((armed.data / "runs").iterdir()) == []
    assert outside.is_file()
    assert armed.state().run is None
    assert armed.events.recent()[0].what == "removes the interrupted run run, 0 of its tests complete"
    start(armed)
    phase(armed, "campaign")
    phase(armed, "idle", 60.0)
    for folder, words in (
        ("run", "is complete; only"),
        ("../campaigns", "not a valid"),
        ("none", "there is no such file"),
    ):
        with pytest.raises(DampyrError, match=words):
            armed.remove_run("a", folder, 2)
    assert len(list(records_of(armed).glob("*.h5"))) == 2


def test_names_lead_to_places_in_the_data_folder(bench: Bench) -> None:
    folder = records_of(bench, "earlier")
    folder.mkdir(parents=True)
    (folder / JOURNAL).touch()
    order = bench.runs.order("short", "new", " A. Operator ", reference="earlier", tolerance=0.2)
    assert (order.path, order.folder) == (bench.data / "campaigns" / "short.toml", records_of(bench, "new"))
    assert order.queued.operator == "A. Operator"
    assert order.reference is not None
    assert (order.reference.folder, order.reference.tolerance) == (folder, 0.2)
    for names, words in (
        ({"campaign": "other", "folder": "new"}, "campaigns/other.toml: there is no such file"),
        ({"campaign": "../short", "folder": "new"}, "not a valid file name"),
        ({"campaign": "short", "folder": "a/b"}, "folder = 'a/b' is not allowed; give a name without /"),
        ({"campaign": "short", "folder": "new", "reference": "none"}, "there is no such file"),
        ({"campaign": "short", "folder": "earlier", "reference": "earlier"}, "is the folder of this run"),
    ):
        with pytest.raises(DampyrError, match=words):
            bench.runs.order(**names)
        with pytest.raises(DampyrError, match=words):  # before it is asked who holds control
            bench.start("nobody", **names)
