"""Bring-up: each step passes on a whole rig, a wrong part is found at its own step, and the file goes on where it ended."""

from __future__ import annotations

import getpass
import json
from dataclasses import replace
from pathlib import Path

import pytest
from tests.rig.table import settings

from dampyr.errors import FileError
from dampyr.rig import RigSettings, simulated
from dampyr.rig.bring_up import STEPS, BringUpOutcome, BringUpStep, bring_up, without_private
from dampyr.rig.simulation.stand_in import OperatorStandIn

WIRED = settings(True, True, coil_voltage="ai2", coil_current="ai3")
NAMES = [step.name for step in STEPS]


def brought_up(
    path: Path, *faults: str, rig: RigSettings = WIRED, parts: RigSettings | None = None, answer=lambda _: "go"
) -> list[BringUpOutcome]:
    with simulated(rig, faults=faults, parts=parts) as opened:
        return bring_up(opened, path, OperatorStandIn(opened.board.simulator, answer))


def test_a_whole_rig_passes_every_step(tmp_path) -> None:
    outcomes = brought_up(tmp_path / "b.json")
    assert [(outcome.step, outcome.verdict, outcome.cause) for outcome in outcomes] == [
        (name, "passed", "") for name in NAMES
    ]


def test_a_rig_without_readings_and_switches_passes_with_a_voltmeter(tmp_path) -> None:
    outcomes = {outcome.step: outcome for outcome in brought_up(tmp_path / "b.json", rig=RigSettings())}
    assert outcomes.pop("switches").verdict == "not wired"
    assert {outcome.verdict for outcome in outcomes.values()} == {"passed"}


@pytest.mark.parametrize(
    ("fault", "step", "words"),
    [
        ("unplugged-serial@0s", "uno", "the Uno does not answer HELLO"),
        ("board-timeout@0s", "bridge-unpowered", "the simulated board gives an error"),
        ("stuck-encoder@0s", "encoder", "no counts come"),
        ("stuck-encoder-uno@0s", "encoder", "D2 and D3 of the Uno"),
        ("stuck-encoder-board@0s", "encoder", "the counter ctr0"),
        ("swapped-encoder@0s", "encoder", "swap its lines A and B"),
        ("inverted-cell@0s", "load-cell", "its sign is inverted"),
        ("broken-cell@0s", "load-cell", "an open input floats"),
        ("broken-cell=0@0s", "load-cell", "nothing is felt"),
        ("emergency-stop@0s", "switches", "a switch is open"),
        ("dead-supply@0s", "coil", "the supply gives nothing"),
        ("open-coil@0s", "coil", "no current flows"),
        ("supply-gain=0.5@0s", "coil", "supply.gain"),
        ("stalled-motor@0s", "1-mm", "motor"),
    ],
)
def test_a_wrong_part_fails_at_its_own_step_with_the_cause(tmp_path, fault: str, step: str, words: str) -> None:
    outcomes = brought_up(tmp_path / "b.json", fault)
    assert (outcomes[-1].step, outcomes[-1].verdict) == (step, "failed")
    assert words in outcomes[-1].cause
    assert all(outcome.verdict == "passed" for outcome in outcomes[:-1])


def test_an_encoder_of_another_scale_is_found_by_the_ruler(tmp_path) -> None:
    other = replace(WIRED, encoder=replace(WIRED.encoder, count=1e-5))
    outcomes = brought_up(tmp_path / "b.json", rig=other, parts=WIRED)
    assert outcomes[-1].step == "encoder"
    assert "encoder.count" in outcomes[-1].cause


def test_a_supply_whose_enable_line_does_not_cut_it_is_found_before_it_is_armed(tmp_path) -> None:
    parts = replace(WIRED, supply=replace(WIRED.supply, enable_line=False))
    outcomes = brought_up(tmp_path / "b.json", parts=parts)
    assert outcomes[-1].step == "coil"
    assert "does not cut the supply" in outcomes[-1].cause


def test_nothing_is_energised_before_the_step_that_says_so_and_each_of_these_asks(tmp_path) -> None:
    asked: list[str] = []

    with simulated(WIRED) as opened:
        simulator = opened.board.simulator

        def answer(step: BringUpStep) -> str:
            asked.append(step.name)
            if step.energised and not any(STEPS[NAMES.index(name)].energised for name in asked[:-1]):
                assert not simulator.truth.enable.any()
                assert not simulator.truth.duty.any()
                assert not opened.was_armed
            return "go"

        bring_up(opened, tmp_path / "b.json", OperatorStandIn(simulator, answer))
    assert asked == NAMES


def test_a_step_whose_ground_was_skipped_is_not_offered(tmp_path) -> None:
    outcomes = {
        outcome.step: outcome
        for outcome in brought_up(tmp_path / "b.json", answer=lambda step: "skip" if step.name == "encoder" else "go")
    }
    assert outcomes["encoder"].cause == "by the operator"
    assert {outcomes[name].verdict for name in ("1-mm", "5-mm", "homing")} == {"skipped"}
    assert outcomes["coil"].verdict == "passed"
    asked: list[str] = []
    again = brought_up(tmp_path / "b.json", answer=lambda step: asked.append(step.name) or "go")
    assert asked == ["encoder", "1-mm", "5-mm", "homing"]
    assert {outcome.verdict for outcome in again} == {"passed"}


def test_a_further_run_goes_on_where_the_file_ends(tmp_path) -> None:
    path = tmp_path / "b.json"
    brought_up(path, "inverted-cell@0s")
    asked: list[str] = []
    outcomes = brought_up(path, answer=lambda step: asked.append(step.name) or "go")
    assert asked == NAMES[NAMES.index("load-cell") :]
    assert {outcome.verdict for outcome in outcomes} == {"passed"}
    assert [row["step"] for row in json.loads(path.read_text())["steps"]] == NAMES


def test_what_other_settings_have_passed_does_not_count(tmp_path) -> None:
    path, asked = tmp_path / "b.json", []
    brought_up(path, answer=lambda step: "go" if step.name == "uno" else "stop")
    changed = replace(WIRED, encoder=replace(WIRED.encoder, index=0.003))
    brought_up(path, rig=changed, answer=lambda step: asked.append(step.name) or "stop")
    assert asked == ["uno"]


def test_the_file_can_be_sent_to_a_stranger(tmp_path) -> None:
    path = tmp_path / "b.json"
    private = replace(
        WIRED, specimen=replace(WIRED.specimen, card=""), wires=replace(WIRED.wires, supply_address=f"{Path.home()}/x")
    )
    brought_up(path, "unplugged-serial@0s", rig=private)
    text = path.read_text()
    document = json.loads(text)
    assert {"schema", "dampyr", "versions", "settings", "firmware", "board", "steps"} <= set(document)
    assert str(Path.home()) + "/" not in text
    assert str(tmp_path) not in text
    assert f"/home/{getpass.getuser()}" not in text
    told = without_private(f"{tmp_path}/rig.toml {Path.home()}/x", tmp_path)
    assert told == ".../rig.toml .../x"


def test_a_file_of_something_else_is_refused_and_left(tmp_path) -> None:
    path = tmp_path / "b.json"
    path.write_text("{}")
    with pytest.raises(FileError, match="not the file of a bring-up"):
        brought_up(path)
    assert path.read_text() == "{}"
