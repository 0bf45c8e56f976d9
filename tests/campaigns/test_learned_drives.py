"""Files of learned drives: what one is for, and what is put aside."""

import json
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.campaigns.learned_sine import swung

from dampyr.campaigns.learned_drives import FOLDER, LearnedDrive, drive_key, load_learned, save_learned
from dampyr.campaigns.learning import (
    Tracking,
)
from dampyr.campaigns.steps.sine import Sine
from dampyr.errors import DampyrWarning
from dampyr.rig import RigSettings


def test_a_learned_drive_is_for_one_path_one_rig_and_one_specimen() -> None:
    drive = Sine(0.008, 0.84, 3.212).drive(RigSettings())
    settings = RigSettings()
    slower = with_actuator(settings, free_speed=0.07)
    keys = {
        drive_key(drive, settings, {}),
        drive_key(drive, slower, {}),
        drive_key(drive, settings, {"specimen": "number 2"}),
        drive_key(Sine(0.008, 0.84, 3.0).drive(settings), settings, {}),
        drive_key(Sine(0.008, 0.85, 3.212).drive(settings), settings, {}),
    }
    assert len(keys) == 5
    assert drive_key(Sine(0.008, 0.84, 3.212).drive(settings), RigSettings(), {}) in keys


def with_actuator(settings: RigSettings, **actuator: float) -> RigSettings:
    return replace(settings, actuator=replace(settings.actuator, **actuator))


@pytest.mark.parametrize(
    "change",
    [
        {"set_points_m": [0.0, 1.0]}, {"error": -1.0}, {"format": 99}, {"key": "another"}, {"time": None, "rms": "x"},
        {"set_points_m": None},
    ],
)  # fmt: skip
def test_a_file_that_is_no_learned_drive_is_put_aside(change: dict[str, Any], tmp_path: Path) -> None:
    wanted = swung(1.0)
    learned = LearnedDrive("k", "a sine", wanted.displacement, Tracking(0.01, 0.004), "2026-11-23T00:00:00+00:00")
    path = save_learned(tmp_path / FOLDER, "sine", learned, wanted)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        again = load_learned(tmp_path / FOLDER, "sine", "k", wanted)
    assert again is not None
    np.testing.assert_allclose(again.set_points, wanted.displacement, atol=1e-10)
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.warns(DampyrWarning, match="holds no learned drive"):
        assert load_learned(tmp_path / FOLDER, "sine", "k", wanted) is None
    assert not path.exists()
