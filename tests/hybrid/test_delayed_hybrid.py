"""A damper's model on a late actuator against the building that is all computed, with the lag known wrongly, and refusals."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from tests.hybrid.chapter_5 import HARDEST_QUICK, PRINTED, SHAKES, VOLTAGES, shaken, strong_part

from dampyr.cli import cli
from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.hybrid import run_delayed
from dampyr.hybrid.delayed_hybrid import delayed_result
from dampyr.structures import two_storey
from dampyr.studies import raminelli_2020


@pytest.mark.parametrize(
    ("voltage", "motion"),
    [
        *((value, strong_part) for value in VOLTAGES),
        *(pytest.param(value, el_centro, marks=pytest.mark.prove) for value in VOLTAGES),
    ],
)
def test_chapter_5_on_an_actuator_10_ms_late_is_within_2_percent_of_the_computed_peak(voltage, motion):
    """Floor 5, aim 2 %; in fact a hundredth of a percent with the lag as it is."""
    result = delayed_result(two_storey(), motion(), raminelli_2020.damper(), 0.010, voltage)
    assert 1e3 * result.computed.peak_displacement[0] == pytest.approx(PRINTED[voltage], rel=2e-5)
    assert np.abs(result.differences).max() < 1e-4
    assert result.energy_error < 1e-4
    assert result.tracking_error < 1e-4


@pytest.mark.parametrize("wrong", [-0.003, 0.003])
@pytest.mark.parametrize("voltage", HARDEST_QUICK)
@pytest.mark.parametrize("motion", SHAKES)
def test_a_lag_known_3_ms_wrongly_is_followed(voltage, wrong, motion):
    result = delayed_result(two_storey(), motion(), raminelli_2020.damper(), 0.010, voltage, lag_error=wrong)
    assert np.abs(result.differences).max() < 5e-3
    assert abs(result.lag) < 2e-3  # of 3 ms; where little moves at the end it goes back to what it began with


def test_without_compensation_it_is_stopped_with_the_reason():
    with pytest.raises(
        InputError, match=r"would be unstable on an actuator 10 ms late that is taken for 0 ms late.*after 0\.\d+ s"
    ):
        delayed_result(
            two_storey(), strong_part(), raminelli_2020.damper(), 0.010, 3.212, lag_error=0.010, adaptive=False
        )
    held = run_delayed(shaken(3.212, None, lag=0.010), raminelli_2020.damper(), 0.010, 0.0)
    assert not held.over  # a force that is held over 10 ms is not enough either
    assert run_delayed(shaken(0.0, None, lag=0.010), raminelli_2020.damper(), 0.010, 0.0).over


def test_a_short_motion_runs_to_its_end():
    motion = GroundMotion(np.zeros(5), 0.02)
    result = delayed_result(two_storey(), motion, raminelli_2020.damper(), 0.010)
    assert np.all(result.displacement == 0.0)  # nothing moved, and nothing was divided by it


def test_a_control_law_on_the_command_line() -> None:
    words = ["hybrid", "--structure", "two_storey", "--duration", "3", "--scale", "0.5"]
    law = ["--control", "clipped_optimal:lag=10ms"]
    done = CliRunner().invoke(cli, [*words, *law, "--delay", "0.005", "--json"])
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["law"] == "clipped_optimal 0 to 3.212 V, lag 0.01 s"
    for more, message in (
        ([*law, "--delay", "0.005", "--voltage", "1"], "--voltage and --control both set the input"),
    ):
        refused = CliRunner().invoke(cli, [*words, *more])
        assert refused.exit_code == 2
        assert message in refused.stderr
