"""What doctor says of a rig."""

from __future__ import annotations

from tests.rig.table import settings

from dampyr.rig.diagnosis import diagnose
from dampyr.rig.settings_file import write_settings


def test_a_rig_without_switches_is_told_so(tmp_path) -> None:
    for wired in (False, True):
        path = write_settings(settings(wired, wired, index="ctr1/PFI9" if wired else ""), tmp_path / "rig.toml")
        repairs = {each.what: each.repair for each in diagnose(path)}
        for what in ("end switches", "emergency stop", "encoder's index"):
            assert (repairs[what] is None) == wired
    assert "end switches now" not in repairs
