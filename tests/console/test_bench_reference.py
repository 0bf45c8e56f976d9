"""Cycles of a test beside those of a reference."""

import numpy as np
import pytest

from dampyr.console.bench_reference import CycleJudge, of_record
from dampyr.records import Record
from dampyr.rig.interlock import Samples


@pytest.mark.parametrize(("factor", "passes"), [(1.0, True), (1.1, True), (1.25, False), (0.8, False)])
@pytest.mark.parametrize("centre", [0.0, 0.005])
def test_a_cycle_passes_within_the_tolerance(factor: float, passes: bool, centre: float) -> None:
    time = np.arange(0.0, 10.0, 1e-3)
    grow = np.clip(time / 2, 0, 1) * np.clip((10 - time) / 2, 0, 1)
    x = 0.01 * grow * np.sin(2 * np.pi * time)
    force = 500.0 * np.tanh(np.gradient(x, time) / 1e-3) + 2000.0 * np.gradient(x, time)
    reference = of_record(Record(time, x + centre, force, voltage=0.0), "a")
    assert reference.measures.energy == pytest.approx(4 * 500 * 0.01 + 2000 * np.pi * 0.01**2 * 2 * np.pi, rel=0.02)
    judge = CycleJudge(reference, 0.15)
    judged = []
    for k in range(0, len(time), 40):
        part = slice(k, k + 40)
        none = np.zeros((1, 40))
        samples = Samples(
            k, time[part], x[part] + centre, factor * force[part], None, none, none[0].astype(int), none[0], None
        )  # type: ignore[arg-type]
        judged += judge.take(samples)
    assert [cycle.number for cycle in judged] == [1, 2, 3, 4, 5, 6]
    assert all(cycle.passed is passes for cycle in judged)
    assert judged[2].energy == pytest.approx(factor - 1.0, abs=1e-3)
