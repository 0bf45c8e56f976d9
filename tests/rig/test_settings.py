"""Settings of a rig, as files of earlier versions have them and with what is not allowed together."""

from __future__ import annotations

from pathlib import Path

import pytest

from dampyr.errors import FileError, InputError
from dampyr.rig import RigSettings, load_settings
from dampyr.rig.settings import Actuator, Limits, Wires


def test_old_rig_files_have_no_switches(tmp_path) -> None:
    (tmp_path / "rig.toml").write_text('name = "old"\n[limits]\nstroke = 0.074\n')
    old = load_settings(tmp_path / "rig.toml")
    assert not old.wires.end_switches
    assert old.travel == pytest.approx(0.0364)


def test_a_filter_is_short_against_the_encoders_edges(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"board.encoder_filter = 6.425 us is too long for edges .* 12.5 us apart"):
        RigSettings(limits=Limits(speed=0.4))
    path = tmp_path / "rig.toml"
    for speed, width in (("0.12 m/s", 6.425e-6), ("0.4 m/s", 125e-9)):  # a file of an earlier version names none
        path.write_text(f'[limits]\nspeed = "{speed}"\n')
        assert load_settings(path).board.encoder_filter == width
    path.write_text('[limits]\nspeed = "0.4 m/s"\n[encoder]\ncount = "50 nm"\nmax_speed = 1.0')
    assert load_settings(path).board.encoder_filter == 0.0
    path.write_text('[limits]\nspeed = "0.4 m/s"\n[board]\nencoder_filter = "6.425 us"\n')
    with pytest.raises(FileError, match="encoder_filter"):
        load_settings(path)
    path.write_text("limits = 3\n")
    with pytest.raises(FileError, match="limits"):
        load_settings(path)


def test_limits_of_the_motor_that_contradict_its_parts_are_refused() -> None:
    def motor(wired: bool = False, **values: float) -> RigSettings:
        return RigSettings(actuator=Actuator(**values), wires=Wires(bridge_current=wired))

    with pytest.raises(InputError, match=r"max_duty = 0\.3 moves nothing"):
        motor(max_duty=0.3, dead_band=0.4)
    with pytest.raises(InputError, match=r"max_current = 50 A is outside of what the Uno reads .* to 42.5 A"):
        motor(wired=True, max_current=50.0)
    with pytest.raises(
        InputError, match=r"no_load_current = 14 A is not less than actuator.full_load_current = 13.2 A"
    ):
        motor(no_load_current=14.0)
    assert motor(max_current=50.0).max_current_steps == 0  # not wired: not looked at
    assert motor(wired=True).motor_current(motor(wired=True).max_current_steps) == pytest.approx(20.0, abs=0.05)
