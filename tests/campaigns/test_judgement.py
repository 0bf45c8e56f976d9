"""Judgement of specimens by every level that was asked: passed, failed or not judged, by closed forms and on the rig."""

from contextlib import closing
from dataclasses import replace
from math import pi, tanh
from pathlib import Path

import numpy as np
import pytest
from tests.campaigns.quick_rig import quick_rig, usual_settings
from tests.campaigns.specimen_folders import (
    LADDER,
    QUASI_STATIC,
    dahl,
    power_law,
    specimen_folder,
    with_other_contents,
)

from dampyr import campaigns, records
from dampyr.campaigns import Journal, RunControl, Stopped
from dampyr.campaigns.judgement import DesignLevel, judge, read_design
from dampyr.campaigns.kinds import kind
from dampyr.campaigns.run_control import Progress
from dampyr.errors import FileError, InputError
from dampyr.identification.acceptance_tests.device_criteria import Criterion
from dampyr.models import Damper
from dampyr.records.cycle_analysis.device_figures import power_law_energy

EXPONENT = 0.3
TO_THE_MEAN = [Criterion("energy", "all", "mean", "a test", -0.1, 0.1)]
TO_THE_DESIGN = [Criterion("energy", "all", "design", "a test", -0.15, 0.15)]
AMPLITUDES = [0.0008, 0.0016, 0.0024, 0.004, 0.0056, 0.008]
BNBC = {
    "name": "isolator",
    "operator": "me",
    "check_amplitude": 0.0,
    "rest_between": 0.1,
    "specimen": "SN 17",
    "protocol": {
        "kind": "bnbc_2020_isolator",
        "wind_displacement": "2 mm",
        "design_displacement": "8 mm",
        "maximum_displacement": "9 mm",
        "total_design_displacement": "8.5 mm",
        "total_maximum_displacement": "10 mm",
        "frequency": "1 Hz",
    },
}
NTC = QUASI_STATIC | {"check_amplitude": 0.0, "rest_between": 0.1, "specimen": "SN 17"}
KW, RHO = 100.0, 4000.0


def force_at(amplitude: float) -> float:
    return float(500.0 * (2 * pi * amplitude) ** EXPONENT)


def viscous(folder: Path, **changes: object) -> Path:
    return specimen_folder(folder, LADDER, power_law(EXPONENT), **changes)  # type: ignore[arg-type]


DESIGN = [DesignLevel(a, energy=power_law_energy(force_at(a), a, EXPONENT)) for a in AMPLITUDES]


def dahl_energy(amplitude: float) -> float:
    """w goes between -tanh(rho D) and tanh(rho D) along every leg."""
    return 4 * KW * (amplitude - tanh(RHO * amplitude) / RHO)


def test_the_energy_of_a_power_law_is_that_of_its_closed_form_at_every_level(tmp_path: Path) -> None:
    judged = judge(viscous(tmp_path), TO_THE_DESIGN, DESIGN)
    assert judged.verdict == "passed"
    [specimen] = judged.specimens
    assert [len(level.cycles) for level in specimen.levels] == [3, 3, 3, 2, 2, 1]  # the cycles of the ladder
    for level, amplitude in zip(specimen.levels, AMPLITUDES, strict=True):
        for cycle in level.cycles:
            assert cycle.value == pytest.approx(power_law_energy(force_at(amplitude), amplitude, EXPONENT), rel=5e-3)
            assert (cycle.lower, cycle.upper) == pytest.approx((0.85 * cycle.reference, 1.15 * cycle.reference))


@pytest.mark.parametrize("criteria", ["ntc_2018_viscous", "ntc_2018_linear"])
def test_the_figures_of_dahl_are_those_of_its_closed_form_in_five_cycles_from_turn_to_turn(
    tmp_path: Path, criteria: str
) -> None:
    [design] = dahl_design(QUASI_STATIC)
    judged = judge(specimen_folder(tmp_path, QUASI_STATIC, dahl(KW, RHO)), criteria, [design])
    assert judged.verdict == "passed"
    [level] = judged.specimens[0].levels
    assert (level.asked, level.run) == (5, 5)
    for cycle in level.cycles:
        assert cycle.value == pytest.approx(design.values[cycle.criterion.quantity], rel=5e-3)


def test_a_weak_last_level_fails_and_is_the_worst(tmp_path: Path) -> None:
    judged = judge(viscous(tmp_path, factors={6: 0.6}), TO_THE_DESIGN, DESIGN)
    [specimen] = judged.specimens
    assert [level.verdict for level in specimen.levels] == ["passed"] * 5 + ["failed"]
    assert judged.verdict == "failed"
    assert specimen.worst is not None
    level, cycle = specimen.worst
    assert (level.amplitude, cycle.used) == (pytest.approx(0.008), pytest.approx(0.4 / 0.15, rel=0.02))


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"states": {6: "planned"}}, "the test was not run"),
        ({"states": {6: "stopped"}}, "the test stopped: by the operator"),
        ({"states": {6: "running"}}, "the test was interrupted"),
        ({"lasting": {1: 0.75}}, "3 cycles are asked, its record has 2; run the test again"),
    ],
)
def test_a_level_that_was_not_run_to_its_end_is_not_judged(
    tmp_path: Path, changes: dict[str, object], reason: str
) -> None:
    judged = judge(viscous(tmp_path, **changes), TO_THE_DESIGN, DESIGN)
    assert judged.verdict == "not judged"
    assert [why for level in judged.specimens[0].levels for why in level.unjudged] == [reason]
    assert judge(viscous(tmp_path / "weak", factors={2: 0.6}, **changes), TO_THE_DESIGN, DESIGN).verdict == "failed"


def test_a_complete_test_whose_file_is_gone_is_not_judged(tmp_path: Path) -> None:
    folder = viscous(tmp_path)
    next(folder.glob("03-*.h5")).unlink()
    judged = judge(folder, TO_THE_DESIGN, DESIGN)
    assert judged.verdict == "not judged"
    assert "has no file" in judged.specimens[0].levels[2].unjudged[0]


def test_what_the_design_leaves_out_is_not_judged(tmp_path: Path) -> None:
    judged = judge(viscous(tmp_path), TO_THE_DESIGN, DESIGN[:5])
    assert judged.verdict == "not judged"
    assert judged.specimens[0].levels[5].unjudged == ("energy: the design's value is missing; give it",)
    assert judge(tmp_path, TO_THE_MEAN).verdict == "passed"  # criteria that need no design


def test_a_motion_that_misses_its_amplitude_is_not_judged(tmp_path: Path) -> None:
    folder = viscous(tmp_path)
    [path] = folder.glob("06-*.h5")
    record = records.read(path)
    path.unlink()
    records.write(record.replace(note="less", displacement=0.85 * record.displacement, velocity=None), path)
    [level] = judge(folder, TO_THE_MEAN).specimens[0].levels[5:]
    assert (level.verdict, level.unjudged) == ("not judged", ("6.8 mm were reached of 8 mm in cycle 1",))


def test_a_single_cycle_that_falls_short_is_enough(tmp_path: Path) -> None:
    folder = viscous(tmp_path)
    [path] = folder.glob("03-*.h5")
    record = records.read(path)
    path.unlink()
    last = record.time > record.time[0] + 5.0  # 2 s of rest, a cycle of run-in, two whole ones
    less = np.where(last, 0.8, 1.0) * record.displacement
    records.write(record.replace(note="less", displacement=less, velocity=None), path)
    assert judge(folder, TO_THE_MEAN).specimens[0].levels[2].unjudged == ("1.92 mm were reached of 2.4 mm in cycle 3",)


def test_a_design_with_a_frequency_is_of_no_level_without_one() -> None:
    sine, slow = (kind(name)(0.004, value) for name, value in (("sine", 1.0), ("quasi_static", 0.01)))
    assert [DesignLevel(0.004, frequency=1.0).fits(step) for step in (sine, slow)] == [True, False]
    assert [DesignLevel(0.004, voltage=0.0).fits(step) for step in (sine, slow)] == [True, True]


def test_a_record_in_which_something_is_wrong_is_not_judged_and_its_findings_are_told(tmp_path: Path) -> None:
    folder = viscous(tmp_path)
    [path] = folder.glob("06-*.h5")
    record = records.read(path)
    path.unlink()
    records.write(record.replace(note="turned", force=-record.force), path)
    judged = judge(folder, TO_THE_MEAN)
    wrong = [finding for finding in judged.findings if finding.severity == "wrong"]
    assert wrong
    assert judged.verdict == "not judged"
    assert wrong[0].words in judged.specimens[0].levels[5].unjudged[0]


def test_a_record_that_does_not_state_its_cycles_is_not_judged(tmp_path: Path) -> None:
    folder = viscous(tmp_path)
    [path] = folder.glob("06-*.h5")
    record = records.read(path)
    path.unlink()
    records.write(record.replace(note="as before", provenance={}), path)
    assert "does not state its steady cycles" in judge(folder, TO_THE_MEAN).specimens[0].levels[5].unjudged[0]


def test_a_record_that_ends_before_its_first_cycle_does_is_not_judged(tmp_path: Path) -> None:
    judged = judge(viscous(tmp_path, lasting={6: 0.6}), TO_THE_MEAN)  # 3.3 s: rest, run-in, and a part of the cycle
    assert (judged.verdict, judged.specimens[0].levels[5].run) == ("not judged", 0)
    assert "no whole cycle" in judged.specimens[0].levels[5].unjudged[0]


def test_several_folders_are_several_specimens(tmp_path: Path) -> None:
    good = viscous(tmp_path / "good", specimen="SN 1")
    weak = viscous(tmp_path / "weak", specimen="SN 2", factors={4: 0.6})
    judged = judge([good, weak], TO_THE_DESIGN, DESIGN)
    assert [(s.specimen, s.verdict) for s in judged.specimens] == [("SN 1", "passed"), ("SN 2", "failed")]
    assert judged.verdict == "failed"
    assert judged.origin.specimens == ("SN 1", "SN 2")


def test_a_specimen_without_a_record_has_the_name_that_its_campaign_states(tmp_path: Path) -> None:
    folder = viscous(tmp_path, states=dict.fromkeys(range(1, 7), "planned"))
    assert judge(folder, TO_THE_MEAN).specimens[0].specimen == tmp_path.name
    with closing(Journal(folder)) as journal:
        journal.set_metadata({"rig": '{"specimen": {"name": "SN 8"}}'})
    assert judge(folder, TO_THE_MEAN).specimens[0].specimen == "SN 8"
    with closing(Journal(folder)) as journal:
        journal.set_metadata({"source": 'specimen = "SN 9"\n[protocol]\n'})
    judged = judge(folder, TO_THE_MEAN)
    assert (judged.specimens[0].specimen, judged.verdict) == ("SN 9", "not judged")


def test_the_design_is_read_from_a_file_with_units(tmp_path: Path) -> None:
    path = tmp_path / "design.toml"
    path.write_text('[[level]]\namplitude = "8 mm"\nvoltage = "0 V"\nenergy = "30 J"\neffective_stiffness = "2 N/mm"\n')
    [level] = read_design(path)
    assert (level.amplitude, level.values) == (0.008, {"energy": 30.0, "effective_stiffness": 2000.0})
    path.write_text('[[level]]\namplitude = "8 mm"\nenergy = "30 N"\n')
    with pytest.raises(FileError, match=r"level 1\.energy"):
        read_design(path)
    path.write_text('amplitude = "8 mm"\n')
    with pytest.raises(FileError, match=r"needs tables \[\[level\]\]"):
        read_design(path)


@pytest.mark.parametrize(
    ("design", "sentence"),
    [
        ([DesignLevel(0.009)], "no campaign asks the design's level of 9 mm"),
        ([DesignLevel(0.008, voltage=1.0)], "no campaign asks the design's level of 8 mm"),
        ([DesignLevel(0.008), DesignLevel(0.008, frequency=1.0)], "2 levels of the design fit sine 8 mm at 1 Hz, 0 V"),
    ],
)
def test_a_design_that_fits_no_level_or_one_twice_is_refused(
    tmp_path: Path, design: list[DesignLevel], sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence):
        judge(viscous(tmp_path), TO_THE_DESIGN, design)


def test_folders_that_cannot_be_judged_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"has no journal\.sqlite; give the folder of a campaign"):
        judge(tmp_path, TO_THE_MEAN)
    with pytest.raises(InputError, match="nothing to judge"):
        judge([], TO_THE_MEAN)
    folder = viscous(tmp_path / "a")
    with_other_contents(folder, [["01-rest", "rest", {"duration": 1.0}]])
    with pytest.raises(InputError, match="no test of its campaign has cycles to judge"):
        judge(folder, TO_THE_MEAN)


def test_tests_that_are_no_level_stand_beside(tmp_path: Path) -> None:
    folder = viscous(tmp_path, states={2: "planned", 3: "planned", 4: "planned", 5: "planned"})
    sine = {"amplitude": 0.008, "frequency": 1.0, "voltage": 0.0, "cycles": 1}
    name = next(folder.glob("06-*.h5")).stem
    with_other_contents(folder, [["01-gas", "gas_force", {"amplitude": 0.01}], [name, "sine", sine]])
    [specimen] = judge(folder, TO_THE_DESIGN, DESIGN[5:]).specimens
    assert (specimen.verdict, specimen.beside, len(specimen.levels)) == ("passed", ("01-gas",), 1)


def performed(folder: Path, document: dict[str, object], kw: float, stop_at: str = "") -> Path:
    """A campaign on the simulated rig, whose specimen is a Dahl damper; stopped in the test of that number."""
    folder.mkdir()
    Damper("dahl", {"dahl.kx": 0.0, "dahl.kw": kw, "dahl.rho": RHO}).save(folder / "card.toml")
    parts = usual_settings()
    parts = replace(parts, specimen=replace(parts.specimen, card=str(folder / "card.toml")))
    control = RunControl()

    def stop(progress: Progress) -> None:
        if stop_at and progress.name.startswith(stop_at) and progress.fraction > 0.5:
            control.stop()

    campaign = campaigns.campaign_of(document)
    if stop_at:
        with pytest.raises(Stopped):
            campaigns.perform(campaign, quick_rig(settings=parts), folder / "out", stop, control)
    else:
        campaigns.perform(campaign, quick_rig(settings=parts), folder / "out")
    return folder / "out"


def dahl_design(document: dict[str, object]) -> list[DesignLevel]:
    """Closed forms at the amplitudes of a campaign's tests."""
    levels = []
    for amplitude in sorted({test.step.amplitude for test in campaigns.campaign_of(document).tests}):
        force, energy = KW * tanh(RHO * amplitude), dahl_energy(amplitude)
        damping = energy / (2 * pi * force * amplitude)
        levels.append(DesignLevel(amplitude, None, None, force, energy, force / amplitude, force, damping))
    return levels


@pytest.mark.prove
@pytest.mark.parametrize(
    "document",
    [NTC, pytest.param(BNBC, marks=pytest.mark.by_hand)],
    ids=["ntc_2018_quasi_static", "bnbc_2020_isolator"],
)
def test_on_the_simulated_rig_a_good_specimen_passes_and_a_weak_and_an_unfinished_one_do_not(
    tmp_path: Path, document: dict[str, object]
) -> None:
    """The design is the closed form of Dahl; the weak specimen has 0.6 of its force."""
    design = dahl_design(document)
    good, weak = performed(tmp_path / "good", document, KW), performed(tmp_path / "weak", document, 0.6 * KW)
    folders = [good, weak]
    if document is NTC:  # of the longer campaign a third run shows no more
        last = f"{len(campaigns.campaign_of(document).tests):02}"
        folders.append(performed(tmp_path / "unfinished", document, KW, stop_at=last))
    judged = judge(folders, "ntc_2018_viscous", design)
    assert [specimen.verdict for specimen in judged.specimens] == ["passed", "failed", "not judged"][: len(folders)]
    assert {specimen.specimen for specimen in judged.specimens[:2]} == {"SN 17"}
    assert judged.origin.kind == "simulated"
    failed = {
        (cycle.criterion.quantity, cycle.criterion.reference)
        for level in judged.specimens[1].levels
        for cycle in level.cycles
        if not cycle.holds
    }
    assert failed == {("largest_force", "design"), ("energy", "design")}
    reasons = [reason for specimen in judged.specimens[2:] for level in specimen.levels for reason in level.unjudged]
    assert reasons == ["the test stopped: by the operator"] * (len(folders) - 2)
    for level in judged.specimens[0].levels:
        reached = np.mean([cycle.amplitude for cycle in level.cycles])
        measured = np.mean([cycle.value for cycle in level.cycles if cycle.criterion.reference == "cycle 3"])
        assert measured == pytest.approx(dahl_energy(float(reached)), rel=0.02)
