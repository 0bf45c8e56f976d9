"""The first slow pass of a run against those of earlier runs with the same specimen."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import pytest
from tests.campaigns.test_pass_marks import RIG

from dampyr.campaigns import CampaignThresholds, campaign_of, perform, read_journal
from dampyr.campaigns.pass_marks import agreeing_passes, describe_comparison, differs_from_earlier_runs, pass_to_compare
from dampyr.errors import DampyrWarning, FileError
from dampyr.rig import Rig, RigSettings
from dampyr.rig.calibration import calibration_of
from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import InProcess
from dampyr.rig.instruments.ni_daqmx.simulated import InProcessBoard
from dampyr.rig.shunt import ShuntStep
from dampyr.rig.simulation.faults import FaultSpec
from dampyr.rig.simulation.simulator import Simulator
from dampyr.rig.slow_passes import NAME, SlowPass, load_passes
from dampyr.rig.uncertainty_budget import Evidence

EARLIER = SlowPass(135.0, 64.0, 6.5e-4, 20.0, specimen="D-17", time="2026-11-27T10:00:00+00:00")
SINE = {"kind": "sine", "amplitude": "5 mm", "frequency": "2 Hz", "cycles": 1, "rest_before": "0.1 s", "voltage": "1 V"}


def marks(**changes: float) -> list[str]:
    return [
        mark.text for mark in differs_from_earlier_runs(Evidence(compared=(EARLIER, replace(EARLIER, **changes))), RIG)
    ]


def test_a_height_is_compared_within_what_is_allowed() -> None:
    """2.1 times 0.80 N of the cell, 3 % of 64 N, and 1 % of it for each kelvin: 3.60 N, and 6.16 N at 4 K."""
    assert differs_from_earlier_runs(Evidence(), RIG) == []
    assert marks(height=67.59) == marks(height=60.41) == []
    (text,) = marks(height=60.39)
    assert "60.39 N high on the run's first slow pass, at 0 V, and was 64 N until 2026-11-27" in text
    assert "'D-17', -5.6% (+-5.6%): the gain of the load cell's chain has changed since, or the damper has" in text
    assert len(marks(height=67.61)) == 1
    assert marks(height=57.85, temperature=24.0) == []
    assert len(marks(height=57.83, temperature=16.0)) == 1
    wide = CampaignThresholds(run_height_share=0.1)
    assert not differs_from_earlier_runs(Evidence(compared=(EARLIER, replace(EARLIER, height=58.0))), RIG, wide)


def test_where_the_shunt_shows_what_it_should_it_is_the_damper() -> None:
    steps = 3 * (ShuntStep(562.5, 1e-3),)
    (mark,) = differs_from_earlier_runs(Evidence(compared=(EARLIER, replace(EARLIER, height=50.0)), shunts=steps), RIG)
    assert "the cell's shunt shows what it should, so the damper has changed" in mark.text
    assert "gain" not in mark.text


def test_a_cell_that_is_quieter_than_in_earlier_runs_has_grown_slow() -> None:
    assert marks(noise=4e-4) == []
    (text,) = marks(noise=3e-4)
    assert "noise from sample to sample is 46% of what it was until 2026-11-27" in text


def test_a_damper_without_friction_tells_nothing() -> None:
    loose = replace(EARLIER, height=1.7)
    assert pass_to_compare((EARLIER,), EARLIER, RIG) == EARLIER
    assert pass_to_compare((loose,), loose, RIG) is None
    assert describe_comparison(None, RIG).startswith("not compared with an earlier run")


def test_passes_that_agree_with_the_first_are_kept() -> None:
    passes = [replace(EARLIER, height=height) for height in (64.0, 63.0, 66.2, 60.0, 64.0)]
    assert agreeing_passes(passes, RIG) == passes[:3]
    assert agreeing_passes([EARLIER, replace(EARLIER, noise=1e-4)], RIG) == [EARLIER]


def run(
    simulator: Simulator, folder: Path, name: str, specimen: str = "D-17", scale: float = 613.0
) -> tuple[list[tuple[str, ...]], str]:
    """A run by a new host, beside whose settings ``folder`` lies: the marks of its records, and what they say of the gain."""
    rig = Rig(
        RigSettings(), Uno(InProcess(simulator.serial)), InProcessBoard(simulator), threaded=False, folder=folder,
        clocked_by_reads=True, clock=lambda: simulator.time,
        calibration=replace(calibration_of(RigSettings()), scale=scale),
    )  # fmt: skip
    header = {"name": name, "operator": "me", "specimen": specimen, "check_amplitude": "0 mm", "rest_between": "0.1 s"}
    made = perform(campaign_of(header | {"step": [SINE]}), rig, folder / name)
    (said,) = {record.provenance["cell_gain"] for record in made}
    return [record.marks for record in made], said


def test_a_gain_that_changed_between_two_runs_is_found(tmp_path: Path) -> None:
    simulator = Simulator(RigSettings())
    assert run(simulator, tmp_path, "first") == ([()], describe_comparison(None, RIG))
    simulator.faults = (FaultSpec("cell-gain", 0.0, amount=0.9),)
    with pytest.warns(DampyrWarning, match="the damper's hysteresis is 5.* the records of this run say so"):
        ((mark, *others),), said = run(simulator, tmp_path, "wrong")
    assert "the gain of the load cell's chain has changed since" in mark
    assert others == []
    assert said.startswith("compared with the runs until 20")
    assert "unlike earlier runs" in [event.what for event in read_journal(tmp_path / "wrong")[1]]


@pytest.mark.prove
def test_a_wrong_gain_is_told_in_every_run_until_something_is_done(tmp_path: Path) -> None:
    simulator = Simulator(RigSettings())
    run(simulator, tmp_path, "first")
    found, said = run(simulator, tmp_path, "healthy")
    assert found == [()]
    assert said.startswith("compared with the runs until 20")
    kept = (tmp_path / NAME).read_bytes()
    simulator.faults = (FaultSpec("cell-gain", 0.0, amount=0.9),)
    for name in ("wrong", "wrong still"):  # a run that differs is not what the next is compared with
        with pytest.warns(DampyrWarning, match="the damper's hysteresis is 5"):
            ((_,),), _ = run(simulator, tmp_path, name)
        assert (tmp_path / NAME).read_bytes() == kept
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert run(simulator, tmp_path, "another", "D-18") == ([()], describe_comparison(None, RIG))
        assert run(simulator, tmp_path, "calibrated", scale=613.0 / 0.9) == ([()], describe_comparison(None, RIG))
        found, said = run(simulator, tmp_path, "calibrated again", scale=613.0 / 0.9)
    assert found == [()]
    assert said.startswith("compared with the runs until 20")
    assert {one.specimen for one in load_passes(tmp_path)} == {"D-17", "D-18"}


def test_a_gain_that_changes_within_a_run_is_not_kept(tmp_path: Path) -> None:
    simulator = Simulator(RigSettings())
    run(simulator, tmp_path, "first")
    simulator.faults = (FaultSpec("cell-gain", simulator.time + 6.0, amount=0.9),)  # in the test
    ((mark,),), _ = run(simulator, tmp_path, "changes")
    assert "in the test" in mark
    assert all(abs(one.height - 64.0) < 2.5 for one in load_passes(tmp_path))
    with pytest.warns(DampyrWarning, match="the damper's hysteresis is 5"):
        run(simulator, tmp_path, "later")


def test_a_rig_without_a_file_remembers_its_own_runs(tmp_path: Path) -> None:
    from dampyr.rig import simulated

    with simulated() as rig:
        for name in ("one", "two"):
            made = perform(campaign_of({"name": name, "operator": "me", "step": [SINE]}), rig, tmp_path / name)
            (said,) = {record.provenance["cell_gain"] for record in made}
            assert said.startswith("not compared" if name == "one" else "compared")


def test_a_file_of_another_version_is_refused_before_anything_moves(tmp_path: Path) -> None:
    simulator = Simulator(RigSettings())
    (tmp_path / NAME).write_text("version = 7", "utf-8")
    with pytest.raises(FileError, match="has the version 7, and this dampyr reads 1"):
        run(simulator, tmp_path, "refused")
    assert simulator.time < 0.1
