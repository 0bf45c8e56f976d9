"""A hybrid test on the simulated rig: with what the rig's ground truth says, refused, stopped, run again."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr import campaigns, records
from dampyr.campaigns import hybrid_result, perform, plan, planned_hybrid
from dampyr.cli import cli
from dampyr.errors import InputError, RigFault
from dampyr.hybrid.hybrid_result import HybridResult
from dampyr.hybrid.rig_drive import STOPPING, way_back
from dampyr.rig import Rig, simulated
from dampyr.show.pages.result_page import write_page
from dampyr.studies import raminelli_2020

HEAVY = """name = "two storeys of 1.5 t"
masses = ["1.458 t", "1.458 t"]
stiffnesses = ["655.5 kN/m", "655.5 kN/m"]
damping_ratio = 0.03
"""


def heavy(folder: Path) -> str:
    path = folder / "heavy.toml"
    path.write_text(HEAVY)
    return str(path)


def settings(folder: Path, **changes: object) -> dict[str, object]:
    step = {
        "kind": "hybrid",
        "structure": heavy(folder),
        "voltage": 0.8712,
        "duration": 4.0,
        "scale": 0.15,
        "rest_before": "0.2 s",
    }
    return step | changes


def run(folder: Path, rig: Rig, **changes: object) -> HybridResult:
    planned = planned_hybrid(settings(folder, **changes))
    planned.require()
    perform(planned, rig, folder / "out")
    return hybrid_result(folder / "out" / f"{planned.tests[0].name}.h5")


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> tuple[HybridResult, Rig, Path]:
    """A test at 0.8712 V, begun with the table in mid-stroke."""
    folder = tmp_path_factory.mktemp("hybrid")
    with simulated() as rig:
        with rig.armed() as table:
            table.home()
            table.go(0.011)
        return run(folder, rig), rig, folder


def test_the_peaks_are_within_5_percent_of_the_computed_ones(done):
    result, _, _ = done
    assert np.abs(result.differences).max() < 0.03  # floor 5 %
    assert result.energy_error < 0.03
    assert abs(result.lag) < 0.002
    assert result.tracking_error < 0.15


def test_the_result_is_that_of_the_record(done):
    """The target is the building's response to the measured force, by another integrator."""
    from scipy.integrate import solve_ivp

    from dampyr.structures import load

    result, _, folder = done
    building = load(folder / "heavy.toml")
    computed = result.computed
    inverse = np.linalg.inv(building.M)

    def slope(t, z):
        ground = np.interp(t, computed.time, computed.ground_acceleration)
        force = result.force[min(int(t / 0.002 + 1e-9), len(result.force) - 1)]
        pull = building.M @ building.influence * ground + building.connection(1) * force
        return np.concatenate([z[2:], -inverse @ (building.C @ z[2:] + building.K @ z[:2] + pull)])

    solved = solve_ivp(
        slope, (0.0, 2.0), np.zeros(4), t_eval=np.arange(0, 2.0, 0.1), max_step=2e-3, rtol=1e-7, atol=1e-10
    )
    ours = result.displacement[:, ::50][:, : len(solved.t)]
    np.testing.assert_allclose(ours, solved.y[:2], atol=2e-6)


def test_the_table_really_was_where_the_record_says(done):
    result, rig, _ = done
    truth = rig.board.simulator.truth
    at = np.linspace(0.0, truth.time[-1], 4 * len(truth.time))
    where = np.interp(at, truth.time, truth.position)
    step = int(np.argmax(np.abs(result.achieved)))
    assert np.abs(where - result.achieved[step]).min() < 2e-5
    assert np.abs(result.achieved).max() > 2e-3


def test_the_record_says_what_it_is(done):
    result, _, folder = done
    (path,) = (folder / "out").glob("*.h5")
    record = records.read(path)
    assert record.provenance["kind"] == "hybrid"
    step = json.loads(record.provenance["step"])
    assert (step["scale"], step["voltage"]) == (0.15, 0.8712)
    assert result.scale == 0.15
    assert result.as_dict()["peaks_m"] == result.peaks.tolist()
    assert {"floor_1_m", "floor_2_m", "target_m", "achieved_m", "force_N"} <= set(
        result.to_dataframe().reset_index().columns
    )


def test_a_page_of_it(done, tmp_path):
    result, _, _ = done
    text = write_page(result, tmp_path / "page.html").read_text("utf-8")
    assert "hybrid test: heavy+el_centro" in text.lower()
    assert "The peaks differ by up to" in text


def test_a_record_of_another_kind_is_refused(done, tmp_path):
    step = {"kind": "sine", "amplitude": "4 mm", "frequency": "1 Hz", "cycles": 1}
    campaign = campaigns.campaign_of({"check_amplitude": 0, "step": [step]})
    with simulated() as rig:
        perform(plan(campaign), rig, tmp_path)
    with pytest.raises(InputError, match="'sine', and not hybrid"):
        hybrid_result(next(tmp_path.glob("*.h5")))


@pytest.mark.parametrize(
    "voltage", [pytest.param(0.4, marks=pytest.mark.prove), 0.8712, pytest.param(3.212, marks=pytest.mark.prove)]
)
def test_the_light_building_of_chapter_5_is_refused_where_it_would_be_unstable(voltage):
    planned = planned_hybrid({"kind": "hybrid", "structure": "two_storey", "voltage": voltage, "duration": 3.0})
    assert len(planned.refusals) == 1
    assert "the hybrid test would be unstable: with set points that leave 52 ms ahead" in planned.refusals[0]
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
    with simulated() as rig:
        with pytest.raises(RigFault, match=r"the building wants to move at \d+ mm/s, the limit is 120 mm/s"):
            run(tmp_path, rig, structure="heavy_two_storey", voltage=3.212, model=str(card), scale=1.0)
        assert rig.uno.heartbeat().speed == 0


def test_the_way_back_ends_at_rest_in_the_middle():
    t = np.linspace(0.0, STOPPING, 3001)
    x = way_back(0.008, 0.03, t)
    v = np.gradient(x, t)
    assert (x[0], x[-1]) == (pytest.approx(0.008), pytest.approx(0.0, abs=1e-12))
    assert (v[0], v[-1]) == (pytest.approx(0.03, rel=0.01), pytest.approx(0.0, abs=1e-4))


def test_the_command_plans_runs_and_goes_on(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "heavy.toml").write_text(HEAVY)
    words = ["hybrid", "--structure", "heavy.toml", "--duration", "2", "--scale", "0.1", "--out", "out"]
    missing = CliRunner().invoke(cli, words[:-2])
    assert (missing.exit_code, "--out is missing" in missing.stderr) == (2, True)
    first = CliRunner().invoke(cli, [*words, "--json", "--report", "page.html"])
    assert first.exit_code == 0, first.output
    shown = json.loads(first.stdout)
    assert (shown["scale"], max(map(abs, shown["differences"])) < 0.05) == (0.1, True)
    assert (tmp_path / "page.html").is_file()
    again = CliRunner().invoke(cli, [*words, "--json"])
    assert json.loads(again.stdout) == shown  # it is complete: nothing moves


def test_the_command_says_what_is_wrong(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for words, expected in (
        (["--delay", "0.2"], "delay = 0.2 s is not allowed"),
        (["--delay", "0.01", "--dry-run"], "leave --rig, --out and the rig's options out"),
        (["--delay", "0.01", "--clock", "2"], "leave --clock out"),
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
