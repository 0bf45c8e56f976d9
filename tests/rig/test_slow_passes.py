"""Slow passes that are kept with the rig from run to run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from tests.interpreters import run_text

from dampyr.errors import DampyrWarning, FileError
from dampyr.rig import RigSettings
from dampyr.rig.calibration import calibration_of
from dampyr.rig.slow_passes import MOST, NAME, SlowPass, cell_of, load_passes, save_passes, usual_pass, with_run

PASS = SlowPass(135.0, 64.0, 6.5e-4, 21.0, 0.002, "D-17", "613.0 N/V +-0.003, 1000.0 Hz", "2026-11-27T10:00:00+00:00")


def test_what_is_kept_is_read_again(tmp_path: Path) -> None:
    silent = replace(PASS, specimen='a "2"', noise=float("nan"))
    assert load_passes(tmp_path) == ()
    save_passes(tmp_path, (PASS, silent))
    first, second = load_passes(tmp_path)
    assert first == PASS
    assert second.noise != second.noise
    assert replace(second, noise=0.0) == replace(silent, noise=0.0)


def test_a_pass_is_compared_with_those_that_are_like_it() -> None:
    assert usual_pass((PASS,), PASS) == PASS
    unlike: list[dict[str, object]] = [
        {"specimen": "D-18"}, {"cell": "610.0 N/V +-0.003, 1000.0 Hz"}, {"place": 0.01}, {"amplitude": 2e-3}, {"speed": 5e-3},
        {"voltage": 0.5},
    ]  # fmt: skip
    for change in unlike:
        assert usual_pass((replace(PASS, **change),), PASS) is None, change
    unnamed = replace(PASS, specimen="")
    assert usual_pass((unnamed,), unnamed) is None  # nobody knows which dampers they were


def test_it_is_compared_with_the_mean_of_those_as_warm_as_it() -> None:
    kept = tuple(
        replace(PASS, height=height, temperature=at) for height, at in ((64.0, 20.0), (66.0, 22.0), (50.0, 45.0))
    )
    cold, warm = usual_pass(kept, PASS), usual_pass(kept, replace(PASS, temperature=60.0))
    assert cold is not None
    assert warm is not None
    assert (cold.height, cold.temperature) == (65.0, 21.0)
    assert (warm.height, warm.temperature) == (50.0, 45.0)


def test_the_latest_of_each_temperature_are_kept_until_the_cell_is_calibrated_anew() -> None:
    other, hot = replace(PASS, specimen="D-18"), replace(PASS, temperature=40.0)
    kept: tuple[SlowPass, ...] = (other, hot)
    for k in range(MOST + 3):
        kept = with_run(kept, [replace(PASS, height=float(k))])
    assert other in kept
    assert hot in kept
    assert [one.height for one in kept[2:]] == [float(k) for k in range(3, MOST + 3)]
    calibrated = replace(PASS, cell="610.0 N/V +-0.003, 1000.0 Hz")
    assert with_run(kept, [calibrated]) == (other, calibrated)


def test_a_calibration_is_another_one_by_its_scale_and_not_by_its_zero() -> None:
    rig = RigSettings()
    calibration, (uncertainty, bandwidth) = calibration_of(rig), (0.01, 1000.0)
    cell = cell_of(calibration, uncertainty, bandwidth)
    assert cell_of(calibration.zeroed(0.02), uncertainty, bandwidth) == cell
    assert cell_of(replace(calibration, scale=calibration.scale * (1.0 + 1e-9)), uncertainty, bandwidth) != cell
    assert cell_of(calibration, 0.003, bandwidth) != cell
    assert cell_of(calibration, uncertainty, 900.0) != cell


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "version = 2",
            r"slow_passes\.toml: has the version 2, and this dampyr reads 1; take a newer one, or move it away",
        ),
        ("", "has the version 'none'"),
        ("version = 1\npass = 3", "pass = 3 must be a list of tables; or move it away"),
        ("version = 1\n[[pass]]\nmean = 3.0", r"pass 1\.height is missing; give it in N"),
        ("version = 1\n[[pass]]\nmean = 3.0\nheight = 1.0\nhigh = 2.0", r"pass 1\.high is not known"),
        ("version = 1\n[[pass", "is not valid TOML"),
    ],
)
def test_a_file_that_is_not_as_it_should_be_is_refused_with_a_sentence(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / NAME).write_text(text, "utf-8")
    with pytest.raises(FileError, match=words):
        load_passes(tmp_path)


def test_a_host_that_is_killed_while_it_writes_leaves_what_was_there(tmp_path: Path) -> None:
    save_passes(tmp_path, (PASS,))
    killed = run_text(
        "import os\nos.fsync = lambda _: os._exit(9)\n"
        "from pathlib import Path\nfrom dampyr.rig.slow_passes import load_passes, save_passes\n"
        f"folder = Path({str(tmp_path)!r})\nsave_passes(folder, 3 * load_passes(folder))"
    )
    assert killed.returncode == 9
    assert load_passes(tmp_path) == (PASS,)


def test_a_disk_that_takes_none_is_a_warning(tmp_path: Path) -> None:
    from tests.rig.test_damper_temperature import host

    from dampyr.rig.simulation.simulator import Simulator

    rig = host(Simulator(RigSettings()), tmp_path / "gone")
    with pytest.warns(DampyrWarning, match=r"the slow passes of this run were not kept: .*gone"):
        rig.keep_passes((PASS,))
