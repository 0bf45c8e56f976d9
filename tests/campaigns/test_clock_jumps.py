"""Jumps of the day's clock (NTP, by hand) change nothing of a campaign, and a suspended host leaves the rig safe."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from datetime import datetime, timedelta
from itertools import cycle
from pathlib import Path

import numpy as np
import pytest
from tests.campaigns.quick_rig import QUICK, TWO_SINES, quick_rig

from dampyr.campaigns import RunControl, journal, perform, performing
from dampyr.campaigns.journal import Journal, read_journal
from dampyr.campaigns.run_control import Progress, Stopped
from dampyr.errors import RigFault
from dampyr.records import read_campaign
from dampyr.rig import damper_temperature

HOURS = (-31.0, 7.0, -3.0, 55.0)


def let_the_clock_jump(monkeypatch: pytest.MonkeyPatch, hours: tuple[float, ...]) -> None:
    """Each look at the day's clock finds it set to another hour."""
    jumps, real = cycle(hours), time.time

    class Jumping(datetime):
        @classmethod
        def now(cls, tz=None):
            return datetime.now(tz) + timedelta(hours=next(jumps))

    for module in (journal, performing, damper_temperature):
        monkeypatch.setattr(module, "datetime", Jumping)
    monkeypatch.setattr(time, "time", lambda: real() + 3600.0 * next(jumps))


def stopped_and_resumed(folder: Path) -> Path:
    """A campaign that is stopped in its second test and goes on with another host."""
    folder.mkdir()
    (folder / "two.toml").write_text(TWO_SINES)
    control = RunControl()

    def stop(progress: Progress) -> None:
        if progress.done == 1 and progress.phase == "testing":
            control.stop()

    with pytest.raises(Stopped):
        perform(folder / "two.toml", quick_rig(settings=QUICK), folder / "out", stop, control)
    perform(folder / "two.toml", quick_rig(settings=QUICK), folder / "out")
    return folder / "out"


def contents(folder: Path) -> Iterator[tuple[str, list[np.ndarray]]]:
    for record in read_campaign(folder):
        yield record.name, [record.time, record.displacement, record.force]


def test_a_campaign_runs_stops_and_resumes_alike_while_the_days_clock_jumps(tmp_path, monkeypatch) -> None:
    steady = stopped_and_resumed(tmp_path / "steady")
    let_the_clock_jump(monkeypatch, HOURS)
    jumping = stopped_and_resumed(tmp_path / "jumping")
    tests, events = read_journal(jumping)
    before, wanted = read_journal(steady)
    assert tests == before
    assert [entry.state for entry in tests] == ["complete", "complete"]
    assert [(event.what, event.test, event.attempt) for event in events] == [
        (event.what, event.test, event.attempt) for event in wanted
    ]
    assert [event.time for event in events] != sorted(event.time for event in events)  # it did jump
    for (name, rows), (other, others) in zip(contents(steady), contents(jumping), strict=True):
        assert name == other
        for row, same in zip(rows, others, strict=True):
            np.testing.assert_array_equal(row, same)


@pytest.mark.parametrize("hours", [50.0, -50.0])
def test_the_rig_that_a_lost_journal_had_does_not_depend_on_the_days_clock(tmp_path, monkeypatch, hours: float) -> None:
    """The second test was recorded with other settings, and by the clock before the first."""
    (tmp_path / "two.toml").write_text(TWO_SINES)
    control, out = RunControl(), tmp_path / "out"

    def stop(progress: Progress) -> None:
        if progress.done == 1:
            control.stop()

    clock = [0.0]

    class Set(datetime):
        @classmethod
        def now(cls, tz=None):
            return datetime.now(tz) + timedelta(hours=clock[0])

    monkeypatch.setattr(journal, "datetime", Set)
    with pytest.raises(Stopped):
        perform(tmp_path / "two.toml", quick_rig(settings=QUICK), out, stop, control)
    clock[0] = hours
    changed = replace(QUICK, load_cell=replace(QUICK.load_cell, noise=0.5))
    with pytest.warns(UserWarning, match="settings differ"):
        perform(tmp_path / "two.toml", quick_rig(settings=changed), out)
    with closing(Journal(out)) as entered:
        rig = entered.get_metadata("rig")
    (out / "journal.sqlite").unlink()
    with pytest.warns(UserWarning, match="is made anew"):
        perform(tmp_path / "two.toml", quick_rig(settings=QUICK), out)
    with closing(Journal(out)) as rebuilt:
        assert rebuilt.get_metadata("rig") == rig


def test_a_suspended_host_leaves_the_rig_safe_and_its_campaign_to_be_resumed(tmp_path) -> None:
    (tmp_path / "two.toml").write_text(TWO_SINES)
    rig = quick_rig(settings=QUICK)
    simulator, slept = rig.board.simulator, []

    def suspend(progress: Progress) -> None:
        if progress.done == 1 and progress.phase == "testing" and progress.fraction > 0.3 and not slept:
            slept.append(simulator.time)
            simulator.run_unattended(10.0)

    with pytest.raises(RigFault):
        perform(tmp_path / "two.toml", rig, tmp_path / "out", suspend)
    truth = simulator.truth
    after = truth.time > slept[0] + 0.5
    assert after.any()
    assert np.abs(truth.speed[after]).max() == 0.0
    assert not truth.enable[after].any()
    assert np.abs(truth.voltage[after]).max() == 0.0
    tests, _ = read_journal(tmp_path / "out")
    assert [entry.state for entry in tests] == ["complete", "failed"]
    records = perform(tmp_path / "two.toml", rig, tmp_path / "out")
    assert len(records) == 2
