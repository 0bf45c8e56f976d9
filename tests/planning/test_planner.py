"""The loop on the simulated rig: it goes on where it stopped, and stops with a reason."""

from pathlib import Path

import pytest
from tests.planning.laboratory import BANDWIDTH, DAHL, laboratory

from dampyr.errors import InputError
from dampyr.planning import plan_and_perform
from dampyr.planning.planner import CAMPAIGN, EXPECTED, PLAN, Planned
from dampyr.rig import simulated
from dampyr.show.planning.planner import widths_figure

QUICK = {"bandwidth": BANDWIDTH, "seconds": 4.0, "voltages": (0.0, 1.98), "kinds": ("sine", "voltage_steps")}


def perform(folder: Path, **given: object) -> Planned:
    settings = laboratory(folder.parent / "rig", DAHL)
    with simulated(settings, seed=5) as rig:
        return plan_and_perform(DAHL, rig, folder, **{**QUICK, **given})  # type: ignore[arg-type]


@pytest.mark.prove
def test_a_plan_goes_on_where_it_stopped_and_says_why_it_ends(tmp_path: Path) -> None:
    folder = tmp_path / "plan"
    first = perform(folder, tests=4, per_round=2)
    assert first.reason == "all 4 tests are performed"
    assert not first.reached
    assert [len(one.tests) for one in first.rounds] == [2, 2]
    assert {each.name for each in (folder / "round-01").iterdir()} >= {CAMPAIGN, EXPECTED, "journal.sqlite"}
    written = {path: path.stat().st_mtime_ns for path in folder.rglob("*.h5")}
    again = perform(folder, tests=4, per_round=2)
    assert again.fit.parameters == first.fit.parameters
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*.h5")} == written
    # a test that is missing is made again, with the same promise
    lost = next((folder / "round-02").glob("*.h5"))
    (folder / "round-02" / "journal.sqlite").unlink()
    lost.unlink()
    with pytest.warns(UserWarning, match="made anew from the files"):
        repaired = perform(folder, tests=4, per_round=2)
    assert lost.is_file()
    assert repaired.rounds[1].expected == first.rounds[1].expected
    assert widths_figure(repaired).axes[0].get_ylabel() == "achieved half width [%]"
    with pytest.raises(InputError, match="holds another plan, which differs in tests; choose another folder"):
        perform(folder, tests=5, per_round=2)


@pytest.mark.prove
def test_a_target_ends_the_plan(tmp_path: Path) -> None:
    planned = perform(tmp_path / "plan", targets={"dahl.kw": 0.10}, per_round=4)
    assert planned.reached
    assert planned.reason == "the targets are reached"
    halves = planned.rounds[-1].achieved
    assert all(half <= 0.10 for label, half in halves.items() if label.startswith("dahl.kw"))


@pytest.mark.prove
def test_rounds_of_three_are_not_ended_by_a_spread_that_is_only_assumed(tmp_path: Path) -> None:
    """After three records the assumed spread promises less than they already know; it is no reason to stop."""
    planned = perform(tmp_path / "plan", targets={"dahl.rho": 5e-4}, tests=6, per_round=3)
    assert [len(one.tests) for one in planned.rounds] == [3, 3]
    assert planned.reason == "all 6 tests are performed"


def test_a_folder_that_holds_something_else_is_refused_before_anything_moves(tmp_path: Path) -> None:
    folder = tmp_path / "plan"
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="is not empty and holds no plan"):
        perform(folder)
    (folder / PLAN).write_text("{")
    with pytest.raises(InputError, match="cannot be read"):
        perform(folder)
    with pytest.raises(InputError, match="per_round = 0 is not allowed"):
        perform(folder, per_round=0)
    assert {each.name for each in folder.iterdir()} == {"notes.txt", PLAN}
