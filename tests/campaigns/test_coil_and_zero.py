"""Coil and zero of the force: what a rig that reads its coil sees, and what slow passes between the tests see."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.campaigns.quick_rig import usual_settings

from dampyr import records
from dampyr.campaigns import campaign_of, perform
from dampyr.errors import RigFault
from dampyr.records import Record
from dampyr.records.formats import h5
from dampyr.rig import RigSettings, simulated

Performed = Callable[..., list[Record]]


def wired(coil_voltage: str = "ai2", coil_current: str = "ai3") -> RigSettings:
    """A rig that reads its coil."""
    settings = usual_settings()
    return replace(settings, wires=replace(settings.wires, coil_voltage=coil_voltage, coil_current=coil_current))


@pytest.fixture(params=[pytest.param((2, 2), id="short"), pytest.param((4, 5), id="long", marks=pytest.mark.by_hand)])
def performed(tmp_path: Path, request: pytest.FixtureRequest) -> Performed:
    cycles, faster = request.param
    step = {"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz", "cycles": cycles, "voltage": ["0.5 V", "1.98 V"]}
    last = step | {"amplitude": "5 mm", "frequency": "2 Hz", "cycles": faster, "voltage": "0 V"}

    def run(*faults: str, rig: RigSettings | None = None, parts: RigSettings | None = None) -> list[Record]:
        with simulated(rig or wired(), faults=faults, parts=parts) as opened:
            perform(campaign_of({"rest_between": "0.5 s", "step": [step, last]}), opened, tmp_path / "out")
        return records.read_campaign(tmp_path / "out")

    return run


def marks(some: list[Record]) -> list[tuple[str, ...]]:
    return [record.marks for record in some]


def test_a_good_campaign_has_no_mark_and_its_voltage_is_read_back(performed: Performed, tmp_path: Path) -> None:
    good = performed()
    assert marks(good) == [()] * 3
    assert [record.voltage for record in good] == pytest.approx([0.5, 1.98, 0.0], abs=1e-3)
    assert good[0].voltage != 0.5  # a reading, not what was commanded
    assert good[0].provenance["voltage"] == "read back on ai2"
    assert all(record.uncertainty["force"].parts["shift of the zero"] < 2.5 for record in good)
    raw = h5.read_raw(tmp_path / "out" / "02-sine-8mm-1Hz-1.98V.h5")
    current = raw["coil_current"].gain * raw["coil_current"].values
    assert np.median(current) == pytest.approx(1.98 / 4.4, rel=2e-3)
    assert raw["command"].values.max() >= 1.98


def test_a_voltage_that_changes_in_a_test_is_read_back_too(tmp_path: Path) -> None:
    step = {
        "kind": "voltage_steps",
        "amplitude": "5 mm",
        "frequency": "1 Hz",
        "voltages": ["0 V", "1.5 V"],
        "hold": "1 s",
    }
    with simulated(wired()) as opened:
        perform(campaign_of({"step": [step]}), opened, tmp_path / "out")
    (record,) = records.read_campaign(tmp_path / "out")
    assert isinstance(record.voltage, np.ndarray)
    assert record.marks == ()
    assert np.ptp(record.voltage) == pytest.approx(1.5, abs=2e-3)
    assert len(np.unique(record.voltage)) > 2  # readings


def test_a_dead_supply_spoils_a_test(performed: Performed, tmp_path: Path) -> None:
    with pytest.raises(RigFault, match=r"spoiled: the coil has 0 V where 0\.5 V were commanded"):
        performed("dead-supply@9s")
    record = records.read(tmp_path / "out" / "01-sine-8mm-1Hz-0.5V.h5")
    assert record.provenance["complete"] == "no"
    assert "look at the supply" in record.marks[0]


def test_a_broken_coil_spoils_a_test(performed: Performed) -> None:
    with pytest.raises(RigFault, match=r"0 A flow through the coil at 0\.5 V"):
        performed("open-coil@9s")


def test_a_broken_coil_is_seen_where_only_the_current_is_read(performed: Performed) -> None:
    with pytest.raises(RigFault, match=r"A flow through the coil at 0\.5 V"):
        performed("open-coil@9s", rig=wired(coil_voltage=""))


def test_a_coil_that_is_hotter_than_the_damper_is_thought_to_be_is_marked(performed: Performed) -> None:
    first, second, third = marks(performed("hot-specimen@9s"))
    assert "that of 79 degC, and the damper is at 20 degC as estimated" in first[0]
    assert "off by 18" in second[0]
    assert third == ()  # at 0 V a coil's resistance does not show


def test_a_supply_of_another_gain_is_marked(performed: Performed) -> None:
    weak = replace(wired(), supply=replace(wired().supply, gain=0.9))
    first, second, third = performed(parts=weak)
    assert (first.voltage, second.voltage, third.voltage) == pytest.approx((0.45, 1.782, 0.0), abs=2e-3)
    assert "the coil has 1.78 V where 1.98 V were commanded" in second.marks[0]


def test_without_readings_a_record_says_that_its_voltage_is_the_commanded_one(performed: Performed) -> None:
    for record in performed("dead-supply@9s", rig=usual_settings()):
        assert record.marks == ()
        assert record.provenance["voltage"].startswith("as commanded: nothing reads the coil's")


@pytest.mark.parametrize("rate", ["1", pytest.param("-0.3", marks=pytest.mark.prove)])
def test_a_zero_that_drifts_slowly_is_seen_by_the_slow_passes(performed: Performed, rate: str) -> None:
    marked = marks(performed(f"drifting-cell={rate}@5s"))
    assert any("the force's zero moved by" in mark for test in marked for mark in test)
    assert "since the run began" in marked[-1][0] or "in the test" in marked[-1][0]


@pytest.mark.parametrize(
    ("fault", "first"),
    [
        ("cell-gain=0.95@13s", "in the test"),
        pytest.param("cell-gain=1.1@13s", "in the test", marks=pytest.mark.prove),
        pytest.param("cell-gain=0.8@13s", "in the test", marks=pytest.mark.prove),
    ],
)
def test_a_gain_of_the_cell_that_changes_is_seen_by_the_slow_passes(
    performed: Performed, fault: str, first: str
) -> None:
    """A gain of 5 % is not told as a zero that moved, although the static force of the damper changes with it."""
    marked = marks(performed(fault))
    assert first in marked[0][-1]
    assert all("the gain of the load cell's chain has changed" in test[-1] for test in marked)
    assert all("since the run began" in test[-1] for test in marked[1:])
    assert not any("zero moved" in mark for test in marked for mark in test)


def test_a_force_that_was_there_before_the_run_is_seen_by_the_damper_s_card(performed: Performed) -> None:
    """A shunt that somebody has forgotten: no pass differs from another one."""
    marked = marks(performed("shunted-cell=200@0.1s"))
    assert all("by the damper's card it is" in test[0] and len(test) == 1 for test in marked)


def test_a_cell_that_grows_slow_is_seen_by_its_noise(performed: Performed, tmp_path: Path) -> None:
    with suppress(RigFault):  # at rest so little of its noise may be left that a later test is spoiled
        performed("cell-slow=20Hz@17s")
    marked = marks(records.read_campaign(tmp_path / "out"))
    assert marked
    assert all("its amplifier has grown slow" in test[0] for test in marked)


def test_a_supply_that_stands_is_seen_where_its_voltage_is_read_and_by_the_slow_passes_where_not(
    performed: Performed,
) -> None:
    first, *_ = marks(performed("supply-stuck@17s", rig=usual_settings()))
    assert "the coil has a voltage where 0 V are commanded" in first[0]


def test_a_supply_whose_gain_falls_is_marked_where_its_voltage_is_read(performed: Performed) -> None:
    assert "the coil has" in marks(performed("supply-gain=0.9@9s"))[0][0]


def test_counts_that_were_lost_go_into_the_uncertainty(tmp_path: Path) -> None:
    """One count: too few to end the test, and seen at the index."""
    campaign = campaign_of({"step": [{"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz", "cycles": 2}]})
    lost = {}
    for fault in ((), ("slipped-encoder=10um@10s",)):
        folder = tmp_path / str(len(fault))
        with simulated(wired(), faults=fault) as opened:
            perform(campaign, opened, folder)
        (record,) = records.read_campaign(folder)
        lost[fault] = record.uncertainty["displacement"].parts["lost counts"]
    assert lost[()] == 0.0
    assert lost["slipped-encoder=10um@10s",] == pytest.approx(10e-6 / np.sqrt(3.0))
