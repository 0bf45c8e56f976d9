"""Learning of a drive: the law on plants in closed form, when it ends, and which steps of a campaign learn."""

import numpy as np
import pytest
from scipy import signal
from tests.campaigns.learned_sine import campaign, sine, swung

from dampyr import campaigns
from dampyr.campaigns.learning import (
    CUTOFF,
    LEAD,
    REACHED,
    ROSE,
    SPENT,
    Tracking,
    at_set_points,
    best_of,
    ended_because,
    next_set_points,
    tracking,
)
from dampyr.errors import InputError
from dampyr.rig import Drive

Array = np.ndarray
LEARNS = ["earthquake", "friction", "gas_force", "low_velocity", "quasi_static", "random", "random_voltage", "sine", "sweep",
          "voltage_steps"]  # fmt: skip


def plant(u: Array, gain: float, delay: float) -> Array:
    time = np.arange(u.size) * 0.01
    return gain * np.interp(time - delay, time, u)


@pytest.mark.parametrize("frequency", [0.5, 1.0, 2.0, 4.0])
@pytest.mark.parametrize(("gain", "delay"), [(0.95, 0.0), (0.9, 0.02), (1.05, 0.01), (0.8, 0.03)])
def test_on_a_linear_plant_the_error_falls_as_its_closed_form_says(frequency: float, gain: float, delay: float) -> None:
    """In the steady cycles e_(k+1) = (1 - Q P e^(j w lead)) e_k, and P = gain e^(-j w delay)."""
    wanted = swung(frequency).displacement
    # 8 of the 12 steady cycles, clear of rest and tapers
    middle = slice(round((2 + 4 / frequency) / 0.01), round((2 + 12 / frequency) / 0.01))
    w = 2 * np.pi * frequency
    b, a = signal.butter(2, 2 * CUTOFF * 0.01)
    filtered = abs(signal.freqz(b, a, [w * 0.01])[1][0]) ** 2
    ratio = abs(1 - filtered * gain * np.exp(1j * w * (LEAD - delay)))
    u, rms = wanted, []
    for _ in range(3):
        x = plant(u, gain, delay)
        rms.append(np.sqrt(np.mean((wanted - x)[middle] ** 2)))
        u = next_set_points(wanted, u, x, 0.01)
    assert rms[0] == pytest.approx(abs(1 - gain * np.exp(-1j * w * delay)) * 0.01 / np.sqrt(2), rel=0.03)
    # interpolation of the delays between set points, and what the ends leak into the middle
    assert rms[1] / rms[0] == pytest.approx(ratio, rel=0.03, abs=0.006)
    assert rms[2] / rms[0] == pytest.approx(ratio**2, rel=0.06, abs=0.006)


def test_a_plant_of_the_wrong_sign_makes_the_error_rise_and_that_ends_it() -> None:
    wanted = swung(1.0)
    u, tries = wanted.displacement, []
    while not (reason := ended_because(tries)):
        x = plant(u, -0.5, 0.0)
        tries.append(tracking(wanted, x))
        u = next_set_points(wanted.displacement, u, x, 0.01)
    assert (reason, len(tries), best_of(tries)) == (ROSE, 2, 0)


def test_the_drive_begins_and_ends_where_the_table_rests() -> None:
    wanted = swung(1.0).displacement
    u = next_set_points(wanted, wanted, wanted - 0.001, 0.01)  # a table that stands off everywhere
    assert (u[0], u[-1]) == (wanted[0], wanted[-1])
    assert np.abs(np.diff(u - wanted)).max() < 5e-5
    np.testing.assert_allclose((u - wanted)[100:-100], 0.001, rtol=1e-6)


@pytest.mark.parametrize("period", [0.001, 0.01, 0.05])
def test_what_is_too_fast_for_the_table_is_left_alone(period: float) -> None:
    time = np.arange(round(6.0 / period)) * period
    fast = 1e-4 * np.sin(2 * np.pi * min(40.0, 0.49 / period) * time)
    u = next_set_points(np.zeros(time.size), np.zeros(time.size), fast, period)
    assert np.abs(u[time.size // 3 : -time.size // 3]).max() < 0.05 * 1e-4


def test_the_error_is_the_greatest_distance_over_half_of_the_peak_to_peak() -> None:
    wanted = Drive(0.01, [0.0, 0.0, 0.004, -0.006, 0.0], np.zeros(5))
    figures = tracking(wanted, np.array([0.0, 0.0, 0.0035, -0.006, 0.0]))
    assert figures.error == pytest.approx(0.0005 / 0.005)
    assert figures.rms == pytest.approx(0.1 / np.sqrt(5))
    with pytest.raises(InputError, match="does not change"):
        tracking(Drive(0.01, np.zeros(5), np.zeros(5)), np.zeros(5))


def test_samples_begin_with_the_first_set_point_that_is_recorded() -> None:
    drive = Drive(0.01, np.arange(6.0), np.zeros(6), record_from=2)
    time = 7.0 + np.arange(31) * 0.001
    np.testing.assert_allclose(at_set_points(drive, time, 2.0 + (time - 7.0) / 0.01), [2.0, 2.0, 2.0, 3.0, 4.0, 5.0])
    with pytest.raises(InputError, match="record the whole drive"):
        at_set_points(drive, time[:15], time[:15])


@pytest.mark.parametrize(
    ("errors", "reason"),
    [
        ([], ""), ([0.05], ""), ([0.02], REACHED), ([0.05, 0.01], REACHED), ([0.05, 0.051], ROSE), ([0.05, 0.04], ""),
        ([0.09, 0.08, 0.07, 0.06], ""), ([0.09, 0.08, 0.07, 0.06, 0.05], SPENT), ([0.09, 0.08, 0.07, 0.06, 0.061], ROSE),
    ],
)  # fmt: skip
def test_learning_ends_within_the_tolerance_on_a_rise_or_after_five_tries(errors: list[float], reason: str) -> None:
    assert ended_because([Tracking(each, 0.4 * each) for each in errors]) == reason


def test_a_rise_is_one_of_the_rms_and_the_best_try_that_of_the_least_error() -> None:
    scattered = [Tracking(0.13, 0.07), Tracking(0.029, 0.011), Tracking(0.03, 0.007)]
    assert ended_because(scattered) == ""
    assert best_of(scattered) == 1


def test_a_campaign_without_learning_is_what_it_was() -> None:
    """The digest as the release before wrote it: folders that were begun with it go on."""
    steps = [
        {"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz", "voltage": ["0 V", "1.98 V"], "repeats": 2},
        {"kind": "sweep", "amplitude": "2 mm", "start": "0.3 Hz", "stop": "3 Hz"},
        {"kind": "earthquake", "scale": 0.2},
    ]
    before = campaigns.campaign_of({"step": steps})
    assert before.digest == before.path_digest == "7325b28d1657af01"
    for changed in ({"learn": True}, {"fit_limits": True}):
        now = campaigns.campaign_of({"step": [steps[0], steps[1] | changed, steps[2]]})
        assert now.digest != before.digest
    assert campaigns.campaign_of({"learn": True, "step": steps}).digest != before.digest


@pytest.mark.parametrize("kind", ["rest", "reversals", "warm_up"])
def test_a_kind_that_follows_no_set_points_to_their_end_cannot_learn(kind: str) -> None:
    fields = {
        "rest": {"duration": "1 s"}, "reversals": {"half_period": "0.5 s"},
        "warm_up": {"amplitude": "5 mm", "frequency": "1 Hz"},
    }[kind]  # fmt: skip
    with pytest.raises(
        InputError, match=rf"step 1\.learn = true is not allowed for the kind {kind}.*{', '.join(LEARNS)}"
    ):
        campaign({"kind": kind, **fields, "learn": True})
    [test] = campaign({"kind": kind, **fields}, learn=True).tests
    assert not test.learn


def test_the_header_lets_every_step_learn_but_those_that_say_no() -> None:
    tests = campaign(
        sine(), {**sine(), "learn": False}, {k: v for k, v in sine().items() if k != "learn"}, learn=True
    ).tests
    assert [test.learn for test in tests] == [True, False, True]
