"""Faults of every kind at random moments of campaigns: the rig always ends at rest with the coil off, and says why."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from tests.endurance import Endurance

from dampyr import records
from dampyr.campaigns import perform, read_journal
from dampyr.errors import RigFault
from dampyr.rig import simulated
from dampyr.rig.simulation.faults import KINDS, FaultSpec

SHORT = """
name = "short"
rest_between = "0.1 s"
check_amplitude = "{check} mm"
[[step]]
kind = "sine"
amplitude = "{amplitude} mm"
frequency = "2 Hz"
voltage = ["0 V", "1.5 V"]
cycles = 1
rest_before = "0.1 s"
"""
SPAN = 12.0  # s in which a fault begins: longer than a campaign, so that some come after it
WATCHED = 2.0  # s after which the table rests, whatever happened: the watchdog acts after 0.15 s


def drawn(draw: np.random.Generator) -> FaultSpec:
    """A fault of a random kind, moment and length; its size is the usual one."""
    kind = str(draw.choice([name for name in KINDS if name != "late-samples"]))  # which delays the wall clock
    lasts = float(draw.choice([0.05, 0.5, np.inf]))
    return FaultSpec(kind, float(draw.uniform(0.0, SPAN)), lasts)


@pytest.mark.prove
@pytest.mark.endure
def test_the_rig_rests_whatever_goes_wrong_and_whenever(tmp_path: Path, endurance: Endurance) -> None:
    seed, count, ended = 20201126, endurance.count(1500), Counter[str]()
    reasons: set[str] = set()
    draw = np.random.default_rng(seed)
    for k in range(count):
        faults = [drawn(draw) for _ in range(int(draw.integers(1, 3)))]
        path, out = tmp_path / "short.toml", tmp_path / str(k)
        path.write_text(SHORT.format(check=draw.choice([0, 1]), amplitude=draw.choice([2, 5])), "utf-8")
        rig = simulated(faults=faults, in_process=True, seed=k)
        simulator = rig.board.simulator
        try:
            perform(path, rig, out)
            ended["complete"] += 1
        except RigFault as problem:
            ended[problem.ring or "no answer"] += 1
            reasons.add(str(problem))
        simulator.run_unattended(WATCHED)
        assert not simulator.twin.enabled, faults
        assert simulator.command == 0.0, faults
        assert not np.isnan(simulator.at_rest_since), faults
        assert not np.isnan(simulator.coil_dead_since), faults
        if (out / "journal.sqlite").is_file():
            tests, _ = read_journal(out)
            complete = [test.name for test in tests if test.state == "complete"]
            for name in complete:
                assert records.read(out / f"{name}.h5").n > 400, faults
            assert all(test.reason for test in tests if test.state == "failed"), faults
    assert "" not in reasons
    assert ended["complete"] > 0.05 * count
    assert ended["interlock"] > 0.05 * count
    assert ended["firmware"] > 0.05 * count
    endurance.report(
        "one or two faults of the rig at random moments of a campaign",
        seed,
        f"{count} campaigns: {', '.join(f'{how} {number}' for how, number in ended.most_common())}; "
        "each time at rest with the coil off",
    )


@pytest.mark.parametrize(("start", "check"), [(3.7, 1), (3.7, 0)])
def test_a_motor_that_stands_on_the_way_to_a_test_ends_the_campaign_as_a_fault(
    tmp_path: Path, start: float, check: int
) -> None:
    (tmp_path / "short.toml").write_text(SHORT.format(check=check, amplitude=5), "utf-8")
    rig = simulated(faults=[FaultSpec("stalled-motor", start, np.inf)], in_process=True)
    with pytest.raises(RigFault, match=r"look at the motor|is the motor blocked"):
        perform(tmp_path / "short.toml", rig, tmp_path / "out")
