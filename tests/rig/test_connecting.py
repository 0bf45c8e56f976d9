"""Rigs that are opened: what they say of themselves, and what cannot be opened."""

from dataclasses import replace
from pathlib import Path

import pytest
from tests.rig.wires.process import over_wires_here

from dampyr.errors import RigFault
from dampyr.rig import RigSettings, connect, simulated
from dampyr.rig.damper_temperature import load_temperature, save_temperature


def test_a_rig_says_where_it_is() -> None:
    with over_wires_here() as wired, simulated() as here:
        assert "simulated in a process of its own" in repr(wired)
        assert "simulated in this process" in repr(here)
        assert wired.origin.kind == here.origin.kind == "simulated"
        assert "simulated" not in wired.identity  # its board speaks as a real one does


def test_a_simulated_damper_is_a_new_one(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text("")
    save_temperature(tmp_path, 60.0)
    with simulated(tmp_path / "rig.toml") as rig:
        assert rig.warmth.temperature == 20.0
        with rig.armed() as table:
            table.rest(0.1)
    saved = load_temperature(tmp_path)
    assert saved is not None
    assert saved.temperature == 60.0


def test_what_cannot_be_opened_there_is_told_here() -> None:
    settings = RigSettings()
    absent = replace(settings, wires=replace(settings.wires, serial="/dev/no-such-port"))
    with pytest.raises(RigFault, match="/dev/no-such-port: there is no such serial port; plug the Uno in"):
        connect(absent)
