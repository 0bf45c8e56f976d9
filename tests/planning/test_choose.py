"""The choice of tests against all choices there are."""

from itertools import combinations

import numpy as np
from tests.planning.laboratory import DAHL, VOLTAGES

from dampyr.campaigns.steps.sine import Sine
from dampyr.planning.choose import ParameterGoal, best_tests, pool_of
from dampyr.planning.expected_information import (
    assumed_spread,
    expected_information,
    expected_record,
    layout,
)
from dampyr.rig import RigSettings

RIG = RigSettings()
STEPS = [
    Sine(a, f, u, cycles=4) for u in (0.0, 3.212) for a, f in ((0.010, 0.8), (0.004, 2.0), (0.002, 2.0), (0.001, 4.0))
]


def test_five_of_eight_are_the_best_of_all_five() -> None:
    records = [expected_record(step.drive(RIG), DAHL, RIG, f"{k}") for k, step in enumerate(STEPS)]
    plan = layout(DAHL, [float(np.mean(r.voltage)) for r in records if r.voltage is not None])
    spread = assumed_spread(plan)
    pool = pool_of(
        plan, [], [expected_information(plan, r, spread) for r in records], spread, np.ones(len(plan.labels))
    )
    goal = ParameterGoal(np.where(plan.held, 0.0, 1.0))
    times = [step.drive(RIG).duration for step in STEPS]
    chosen = best_tests(plan, pool, 5, goal, times)
    every = {c: pool.criterion(plan, c, goal) for c in combinations(range(8), 5)}
    assert pool.criterion(plan, chosen, goal) <= min(every.values()) + 0.02
    assert len(set(chosen)) == 5
    short = best_tests(plan, pool, 8, goal, times, time=sum(sorted(times)[:3]))
    assert sum(times[k] for k in short) <= sum(sorted(times)[:3])


def test_a_target_ends_the_choice_early() -> None:
    records = [
        expected_record(Sine(0.004, 1.5, u, cycles=6).drive(RIG), DAHL, RIG, f"{u}-{k}")
        for k in range(4)
        for u in VOLTAGES
    ]
    plan = layout(DAHL, [float(np.mean(r.voltage)) for r in records if r.voltage is not None])
    spread = assumed_spread(plan)
    pool = pool_of(
        plan, [], [expected_information(plan, r, spread) for r in records], spread, np.ones(len(plan.labels))
    )
    goal = ParameterGoal(
        np.ones(len(plan.labels)), np.where([label == "dahl.kw @ 0 V" for label in plan.labels], 0.3, np.inf)
    )
    chosen = best_tests(plan, pool, 16, goal, [10.0] * 16, enough=0.0)
    assert len(chosen) < 6
    assert goal is not None
    assert pool.criterion(plan, chosen, goal) <= 0.0
