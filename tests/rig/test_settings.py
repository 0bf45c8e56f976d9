"""Settings of a rig, as files of earlier versions have them and with what is not allowed together."""

from __future__ import annotations

from pathlib import Path

import pytest

from dampyr.errors import FileError, InputError
from dampyr.rig import RigSettings, load_settings
from dampyr.rig.settings import Limits


def test_old_rig_files_have_no_switches(tmp_path) -> None:
    (tmp_path / "rig.toml").write_text('name = "old"\n[limits]\nstroke = 0.074\n')
    old = load_settings(tmp_path / "rig.toml")
    assert not old.wires.end_switches
    assert old.travel == pytest.approx(0.0365)


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
