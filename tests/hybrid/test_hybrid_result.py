"""What a hybrid test on the simulated rig has shown, against the rig's ground truth and another integrator."""

import json
from pathlib import Path

import numpy as np
import pytest
from tests.hybrid.on_the_rig import run

from dampyr import campaigns, records
from dampyr.campaigns import hybrid_result, perform, plan
from dampyr.errors import InputError
from dampyr.hybrid.hybrid_result import HybridResult
from dampyr.rig import Rig, simulated
from dampyr.show.pages.result_page import write_page


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> tuple[HybridResult, Rig, Path]:
    """A test at 0.8712 V, begun with the table in mid-stroke."""
    folder = tmp_path_factory.mktemp("hybrid")
    with simulated() as rig:
        with rig.armed() as table:
            table.home()
            table.go(0.011)
        return run(folder, rig), rig, folder


@pytest.mark.prove
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
