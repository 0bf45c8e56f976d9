"""A hybrid test on the simulated rig: refused, stopped, run again, from the command line."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from tests.hybrid.on_the_rig import HEAVY, run, settings

from dampyr.campaigns import hybrid_result, planned_hybrid
from dampyr.campaigns.steps.hybrid import Hybrid
from dampyr.cli import cli
from dampyr.errors import InputError, RigFault
from dampyr.rig import RigSettings, simulated
from dampyr.studies import raminelli_2020


@pytest.mark.parametrize(
    "voltage", [pytest.param(0.4, marks=pytest.mark.prove), 0.8712, pytest.param(3.212, marks=pytest.mark.prove)]
)
def test_the_light_building_of_chapter_5_is_refused_where_it_would_be_unstable(voltage):
    planned = planned_hybrid({"kind": "hybrid", "structure": "two_storey", "voltage": voltage, "duration": 3.0})
    assert len(planned.refusals) == 1
    assert "the hybrid test would be unstable: with set points that leave 84 ms ahead" in planned.refusals[0]
    assert "take a heavier building, a lower voltage, or a shorter board.block than 40 ms" in planned.refusals[0]
    (note, *_) = planned.tests[0].notes
    assert note.startswith("scaled to")
    assert "the actuator gives" in note


def test_the_heavy_one_is_refused_where_a_millisecond_would_make_it_unstable():
    planned = planned_hybrid({"kind": "hybrid", "voltage": 3.212, "duration": 3.0})
    assert "ms that are not known, the error of energy passes 10 % after" in planned.refusals[0]


def test_a_model_of_its_own_is_refused_outside_its_range(tmp_path):
    damper = raminelli_2020.damper()
    laws = {name: law if isinstance(law, float) else replace(law, high=0.5) for name, law in damper.laws.items()}
    replace(damper, laws=laws).save(tmp_path / "narrow.toml")
    planned = planned_hybrid(settings(tmp_path, model=str(tmp_path / "narrow.toml"), voltage=0.8712))
    assert "the model was calibrated from 0 to 0.5 V" in planned.refusals[0]


def test_a_slower_clock_is_refused_for_a_damper_that_depends_on_the_velocity(tmp_path):
    planned = planned_hybrid(settings(tmp_path, clock=5.0))
    assert "clock = 5 changes the damper's force by" in planned.refusals[0]


def test_it_stops_where_the_error_of_energy_passes_its_limit(tmp_path, monkeypatch):
    monkeypatch.setattr("dampyr.campaigns.steps.hybrid.LAG_ERROR", 0.0)  # or the plan would refuse it
    with simulated() as rig:
        with pytest.raises(
            RigFault, match=r"stopped after \d\.\d\d s of the structure's time: the table's lag put 0 % of"
        ):
            run(tmp_path, rig, energy_limit=0.001)
        assert rig.uno.heartbeat().speed == 0
        with pytest.raises(InputError):
            hybrid_result(next((tmp_path / "out").glob("*.h5")))


def test_it_stops_where_the_damper_is_twice_as_strong_as_its_model(tmp_path):
    """The plan lets it pass, as the model says; the building then wants to move faster than the table may."""
    damper = raminelli_2020.damper()
    laws = {
        name: law if name.endswith(".rho") else replace(law, coefficients=tuple(0.5 * c for c in law.coefficients))
        for name, law in damper.all_laws.items()
    }
    card = replace(damper, laws=laws, covariance=None).save(tmp_path / "weak.toml")
    # The limit of energy is out of the way: it may be passed first.
    heavy = {"structure": "heavy_two_storey", "voltage": 3.212, "scale": 1.0, "energy_limit": 1.0}
    with simulated() as rig:
        with pytest.raises(RigFault, match=r"the building wants to move at \d+ mm/s, the limit is 120 mm/s"):
            run(tmp_path, rig, **heavy, model=str(card))
        assert rig.uno.heartbeat().speed == 0


def test_the_command_plans_runs_and_goes_on(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "heavy.toml").write_text(HEAVY)
    words = ["hybrid", "--structure", "heavy.toml", "--duration", "1", "--scale", "0.1", "--out", "out"]
    missing = CliRunner().invoke(cli, words[:-2])
    assert (missing.exit_code, "--out is missing" in missing.stderr) == (2, True)
    first = CliRunner().invoke(cli, [*words, "--json", "--report", "page.html"])
    assert first.exit_code == 0, first.output
    shown = json.loads(first.stdout)
    assert (shown["scale"], max(map(abs, shown["differences"])) < 0.07) == (0.1, True)  # peaks of half a millimetre
    assert (tmp_path / "page.html").is_file()
    again = CliRunner().invoke(cli, [*words, "--json"])
    assert json.loads(again.stdout) == shown  # it is complete: nothing moves
    (record,) = (tmp_path / "out").glob("*.h5")
    told = CliRunner().invoke(cli, ["hybrid", "--record", str(record), "--json", "--report", "told.html"])
    assert json.loads(told.stdout) == shown
    assert (tmp_path / "told.html").is_file()


def test_the_command_says_what_is_wrong(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for words, expected in (
        (["--delay", "0.2"], "delay = 0.2 s is not allowed"),
        (["--delay", "0.01", "--dry-run"], "--dry-run is of a rig, and --delay computes the actuator"),
        (["--delay", "0.01", "--clock", "2"], "--clock is of a rig"),
        (["--record", "x.h5", "--scale", "2"], "--scale is of a test that is run"),
        (["--record", "none.h5"], "none.h5"),
        (["--lag-error", "0.001", "--dry-run"], "--lag-error is of --delay"),
        (["--structure", "none.toml", "--dry-run"], "there is no such file"),
        (["--voltage", "9", "--duration", "2", "--dry-run"], "needs 9 V at the coil"),
        (["--storey", "5", "--dry-run"], "storey"),
        (["--scale", "0", "--dry-run"], "scale = 0"),
    ):
        result = CliRunner().invoke(cli, ["hybrid", *words])
        assert result.exit_code == 2, words
        assert expected in result.stderr.splitlines()[-1], (words, result.stderr)


@pytest.mark.prove
@pytest.mark.parametrize("voltage", [0.0, 2.0])
def test_at_other_voltages_over_ten_seconds(tmp_path, voltage):
    with simulated() as rig:
        result = run(tmp_path, rig, voltage=voltage, duration=10.0, scale=1.0)
    assert np.abs(result.differences).max() < 0.05


@pytest.mark.prove
def test_over_the_wires_in_a_process_of_its_own(tmp_path, monkeypatch):
    pytest.importorskip("nidaqmx")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "heavy.toml").write_text(HEAVY)
    words = [
        "hybrid",
        "--structure",
        "heavy.toml",
        "--duration",
        "4",
        "--scale",
        "0.15",
        "--voltage",
        "0.8712",
        "--out",
        "out",
    ]
    done = CliRunner().invoke(cli, [*words, "--json"])
    assert done.exit_code == 0, done.output
    assert max(map(abs, json.loads(done.stdout)["differences"])) < 0.05


def test_a_step_computes_a_response_once_and_anew_where_its_card_has_changed(tmp_path):
    """The plan looks at it for each limit, at each scale that it tries."""
    card, rig = tmp_path / "damper.toml", RigSettings()
    damper = raminelli_2020.damper()
    damper.save(card)
    with_card = Hybrid(duration=1.0, model=str(card))
    for step in (Hybrid(duration=1.0), with_card):
        assert step.computed(rig) is step.computed(rig)
    before = with_card.computed(rig).peak_displacement[0]
    damper.with_coefficients(1.1 * damper.coefficients).save(card)
    assert with_card.computed(rig).peak_displacement[0] != before
