"""The plan: what it tells of each test, earthquakes scaled to the rig, and the examples that come with dampyr."""

from csv import DictReader
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from tests.campaigns.learned_sine import campaign, sine

from dampyr import campaigns
from dampyr.campaigns import available_steps, perform, plan
from dampyr.campaigns.kinds import kind
from dampyr.campaigns.learning import (
    TRIES,
)
from dampyr.campaigns.planned_tests import WAYS
from dampyr.errors import FileError, InputError, MissingData
from dampyr.rig import RigSettings, simulated
from dampyr.studies import raminelli_2020

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SINE = {"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz", "voltage": "1.98 V"}


def read(*steps, **header):
    return campaigns.campaign_of({"step": list(steps), **header})


def test_a_planned_sine_in_numbers():
    damper = raminelli_2020.damper()
    [test] = plan(read(SINE), RigSettings(), damper).tests
    assert test.duration == pytest.approx(2.0 + 22.0 + 0.5)
    assert test.peak_speed == pytest.approx(2 * np.pi * 0.008)
    assert (test.peak_position, test.peak_voltage) == (0.008, 1.98)
    drive = test.drive
    t = np.arange(drive.n) * drive.period
    force = damper.force(t, drive.displacement, voltage=1.98, velocity=np.gradient(drive.displacement, 0.01))
    assert test.peak_force == pytest.approx(np.abs(force).max())
    kx, kw, rho = damper.values(1.98)
    cycle = np.pi * kx * 2 * np.pi * 0.008**2 + 4 * kw * (0.008 - np.tanh(rho * 0.008) / rho)
    assert 20 * cycle < test.energy < 22 * cycle


def test_the_duration_counts_rests_and_the_stroke_before():
    campaign_plan = plan(read(SINE, SINE, rest_between="7 s", check_amplitude="2 mm"))
    assert campaign_plan.preliminary is not None
    assert np.abs(campaign_plan.preliminary.displacement).max() == pytest.approx(0.002)
    assert campaign_plan.duration == pytest.approx(2 * (24.5 + WAYS) + 7.0 + campaign_plan.preliminary.duration)
    without = plan(read(SINE, check_amplitude=0))
    assert without.preliminary is None
    assert without.duration == pytest.approx(24.5 + WAYS)


@pytest.mark.by_hand  # minutes of simulated time
def test_a_campaign_takes_as_long_as_its_plan_says_and_homing(tmp_path: Path) -> None:
    with simulated() as rig:
        campaign_plan = plan(campaigns.read(EXAMPLES / "every_kind.toml"), rig.settings)
        with rig.armed() as table:
            table.home()
        begun = rig.board.simulator.time
        perform(campaign_plan, rig, tmp_path / "out")
        took = rig.board.simulator.time - begun
    assert took == pytest.approx(campaign_plan.duration, rel=0.05)


def test_without_a_card_the_plan_says_that_the_force_is_not_known():
    assert "force is unknown" in plan(read(SINE)).notes[0]
    assert plan(read(SINE), damper=raminelli_2020.damper()).notes == ()


def test_all_refusals_come_together():
    campaign_plan = plan(
        read(SINE, SINE | {"amplitude": "30 mm"}, SINE | {"voltage": ["0 V", "9 V"]}, check_amplitude="40 mm")
    )
    assert len(campaign_plan.refusals) == 3
    assert campaign_plan.refusals[0].startswith("the stroke before the first test: goes 40 mm")
    assert campaign_plan.refusals[1].startswith("step 2, ")
    assert campaign_plan.refusals[2].startswith("step 3, sine 8 mm at 1 Hz, 9 V: needs 9 V")
    assert [test.peak_force is None for test in campaign_plan.tests] == [False, False, False, True]
    with pytest.raises(InputError, match=r"step 2, .*; step 3, "):
        campaign_plan.require()


def test_a_repeated_test_is_refused_once():
    assert len(plan(read(SINE | {"amplitude": "30 mm", "repeats": 3})).refusals) == 1


def test_an_earthquake_is_scaled_to_what_the_rig_can_do_and_says_so():
    [test] = plan(read({"kind": "earthquake"})).tests
    assert test.refusal == ""
    assert 0.1 < test.step.scale < 0.3
    assert test.test.step.scale == 1.0
    assert test.notes[0].startswith(
        f"scaled to {test.step.scale:g} instead of 1: at 1 it goes 144.7 mm from the middle"
    )
    assert "and it needs 322 mm/s, the actuator gives" in test.notes[0]
    assert test.name == "01-earthquake-el_centro-scale1-0V"
    shape, scaled = kind("earthquake")().drive(RigSettings()).displacement, test.drive.displacement
    np.testing.assert_allclose(scaled, test.step.scale * shape, atol=1e-12)


def test_an_earthquake_that_must_not_be_scaled_is_refused():
    [text] = plan(read({"kind": "earthquake", "fit_limits": False})).refusals
    assert "lower the scale to 0.2" in text
    [small] = plan(read({"kind": "earthquake", "scale": 0.05})).tests
    assert small.notes == ()
    assert small.step.scale == 0.05


def test_what_leaves_the_range_of_the_card_is_a_note():
    fit = raminelli_2020.damper()
    narrow = type(fit)(fit.parts, fit.laws, ranges={"displacement": (0.0, 0.005)})
    [test] = plan(read(SINE), damper=narrow).tests
    assert "displacement reaches 0.008 m" in test.notes[0]


def test_a_test_that_may_warm_the_damper_to_its_limit_says_so():
    [test] = plan(read(SINE | {"cycles": 3000})).tests
    assert "kJ into the damper" in test.notes[0]


def test_the_forty_sines_of_the_dissertation_pass_with_the_default_rig():
    campaign_plan = plan(EXAMPLES / "campaign.toml")
    assert campaign_plan.refusals == ()
    assert plan(campaign_plan.campaign).refusals == ()  # by the envelope, too
    text = (files("dampyr.records") / "labcontrol_campaign.csv").read_text(encoding="utf-8")
    rows = [row for row in DictReader(text.splitlines()) if row["table"].startswith("4.")]
    assert len(rows) == len(campaign_plan.tests) == 40
    for row, test in zip(rows, campaign_plan.tests, strict=True):
        assert 2e3 * test.step.amplitude == pytest.approx(float(row["peak_to_peak_mm"]), rel=1e-12)
        assert test.step.frequency == float(row["frequency_Hz"])
        assert test.step.voltage == float(row["voltage_V"])
        assert 18.0 < test.duration < 33.0


def test_the_quick_campaign_is_quick():
    campaign_plan = plan(EXAMPLES / "quick_campaign.toml")
    assert campaign_plan.refusals == ()
    assert len(campaign_plan.tests) == 3
    assert campaign_plan.duration < 30.0


def test_an_example_shows_thirteen_kinds_and_passes():
    campaign_plan = plan(EXAMPLES / "every_kind.toml")
    assert campaign_plan.refusals == ()
    shown = {test.kind for test in campaign_plan.tests}
    assert shown <= set(available_steps())
    assert len(shown) == 13


def test_the_card_of_a_rig_lies_beside_it(tmp_path):
    raminelli_2020.damper().save(tmp_path / "card.toml")
    (tmp_path / "rig.toml").write_text('name = "mine"\n[specimen]\ncard = "card.toml"\n')
    campaign_plan = plan(EXAMPLES / "quick_campaign.toml", tmp_path / "rig.toml", seed=9)
    assert campaign_plan.damper is not None
    assert campaign_plan.rig.name == "mine"
    assert campaign_plan.campaign.header.seed == 9
    (tmp_path / "card.toml").unlink()
    with pytest.raises((MissingData, FileError), match=r"card\.toml"):
        plan(EXAMPLES / "quick_campaign.toml", tmp_path / "rig.toml")


def test_a_plan_counts_the_tries_as_at_most_five() -> None:
    without, learning = plan(campaign(sine(learn=False))), plan(campaign(sine()))
    assert learning.duration == pytest.approx((TRIES + 1) * without.duration + TRIES * 0.2)
    assert "its drive is learned first, in at most 5 tries" in learning.tests[0].notes


def test_a_sweep_is_lowered_to_what_the_rig_can_do_where_it_asks_for_it() -> None:
    sweep = {
        "kind": "sweep",
        "amplitude": "8 mm",
        "start": "0.5 Hz",
        "stop": "3 Hz",
        "duration": "10 s",
        "voltage": "1.98 V",
    }
    refused = plan(campaign(sweep)).tests[0]
    assert "lower the amplitude to" in refused.refusal
    [test] = plan(campaign(sweep | {"fit_limits": True})).tests
    assert not test.refusal
    assert test.fitted.startswith(
        f"amplitude lowered to {1e3 * test.step.amplitude:g} mm instead of 8 mm: at 8 mm it needs"
    )
    assert f"lower the amplitude to {1e3 * test.step.amplitude:g} mm" in refused.refusal
