"""Criteria as data: read with their source, judged on every level that was asked."""

import numpy as np
import pytest

import dampyr as dp
from dampyr.errors import FileError, InputError
from dampyr.identification.acceptance_tests.device_criteria import (
    Criterion,
    RequiredLevel,
    judge_by_criteria,
    read_criteria,
)
from dampyr.records.cycle_analysis.device_figures import power_law_energy

D, F = 0.008, 1.0
FORCE = 500.0 * (2 * np.pi * F * D) ** 0.3
DESIGN = {"largest_force": FORCE, "energy": power_law_energy(FORCE, D, 0.3)}
VISCOUS = read_criteria("ntc_2018_viscous")
ASKED = (RequiredLevel(D, 5, DESIGN),)


def run(factor=1.0, fade=0.0, amplitude=D, cycles=5):
    t = np.arange(cycles * 2000 + 1) / 2000 / F
    x, v = amplitude * np.sin(2 * np.pi * F * t), amplitude * 2 * np.pi * F * np.cos(2 * np.pi * F * t)
    force = 500.0 * factor * (1 - fade * np.minimum(np.floor(t * F), cycles - 1)) * np.sign(v) * np.abs(v) ** 0.3
    return dp.records.Record(t, x, force, voltage=0.0)


def judge(*records, asked=ASKED, criteria=VISCOUS):
    return judge_by_criteria(records, criteria, asked)


def failing(judged):
    return {(c.criterion.quantity, c.criterion.reference, c.cycle) for c in judged.cycles if not c.holds}


def test_a_damper_as_designed_passes_by_every_cycle():
    judged = judge(run())
    assert judged.verdict == "passed"
    assert [c.cycle for c in judged.cycles] == [3, 3, 1, 2, 3, 4, 5]


def test_energy_of_20_percent_more_passes_table_iii_and_16_percent_less_fails():
    energy_only = [c for c in VISCOUS if c.quantity == "energy"]
    assert judge(run(1.20), criteria=energy_only).verdict == "passed"
    assert judge(run(0.86), criteria=energy_only).verdict == "passed"
    assert failing(judge(run(0.84), criteria=energy_only)) == {("energy", "design", 3)}
    assert failing(judge(run(1.20))) == {("largest_force", "design", 3)}  # the force has an upper side


def test_a_fading_damper_fails_against_its_third_cycle():
    judged = judge(run(1 / 0.92, fade=0.04, cycles=6), asked=[RequiredLevel(D, 6, DESIGN)])
    assert failing(judged) == {("energy", "cycle 3", 6)}


def test_a_level_that_was_not_run_or_not_long_enough_is_not_judged():
    larger = RequiredLevel(2 * D, 3, DESIGN)
    judged = judge(run(), asked=[RequiredLevel(D, 5, DESIGN), larger])
    assert (judged.verdict, judged.unjudged) == (
        "not judged",
        ("16 mm: 3 cycles are asked, 0 were run; run the level again",),
    )
    assert judge(run(), asked=[RequiredLevel(D, 10, DESIGN)]).verdict == "not judged"
    assert judge(run(), asked=[RequiredLevel(D, 5)]).verdict == "not judged"


def test_a_failure_stands_though_another_level_was_not_run():
    assert judge(run(0.5), asked=[RequiredLevel(D, 5, DESIGN), RequiredLevel(2 * D, 3, DESIGN)]).verdict == "failed"


def test_the_template_is_refused_until_it_is_filled(tmp_path):
    with pytest.raises(FileError, match="criterion 1 has no source"):
        read_criteria("template")
    path = tmp_path / "mine.toml"
    rows = '[[criterion]]\nquantity = "energy"\ncycles = "all"\nreference = "mean"\nsource = "our own"\n'
    path.write_text(rows)
    with pytest.raises(FileError, match="criterion 1 has no limit"):
        read_criteria(path)
    path.write_text(rows + "lower = -0.15\n")
    assert read_criteria(path)[0].upper is None
    path.write_text(rows + "lower = 0.15\nupper = -0.15\n")
    with pytest.raises(FileError, match="is above upper"):
        read_criteria(path)


def test_a_name_that_is_not_shipped_is_refused_with_those_that_are():
    with pytest.raises(InputError, match=r"'asce_7' is not among the criteria; .*ntc_2018_viscous"):
        read_criteria("asce_7")


def test_how_much_of_a_limit_a_value_takes_counts_on_its_own_side():
    [force, energy, *_] = judge(run(0.94)).cycles
    assert (force.used, energy.used) == (pytest.approx(0.06 / 0.15, rel=5e-3), pytest.approx(0.06 / 0.15, rel=0.02))
    [force, energy, *_] = judge(run(1.06)).cycles
    assert (force.used, energy.used) == (pytest.approx(0.06 / 0.15, rel=5e-3), 0.0)  # energy has no upper side
    narrow = Criterion("energy", "all", "cycle 3", "a test", 0.0, 0.1)
    used = [cycle.used for cycle in judge(run(fade=0.04), criteria=[narrow]).cycles]
    assert used == [
        pytest.approx(0.04 * 2 / 0.92 / 0.1, rel=0.02),
        pytest.approx(0.04 / 0.92 / 0.1, rel=0.05),
        0.0,
        np.inf,
        np.inf,
    ]
