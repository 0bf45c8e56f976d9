"""The specimen: one card of the original damper for rig, planner and demo, and cards that the simulated rig can hold."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from dampyr.campaigns.force_prediction import original_fit, specimen
from dampyr.rig import RigSettings, simulated
from dampyr.rig.settings import SpecimenSettings
from dampyr.rig.specimen import original_specimen, specimen_of

FITS = [  # V, F0 [N], k [N/m], c [N s/m], Fy [N], as fitted to the records of the original rig
    [0.0, 134.0, 910.0, 770.0, 58.0],
    [0.8712, 131.0, 1180.0, 1520.0, 202.0],
    [1.98, 124.0, 1390.0, 2100.0, 409.0],
    [3.212, 114.0, 810.0, 3350.0, 660.0],
]


def test_the_planner_and_the_simulated_rig_have_the_same_damper() -> None:
    assert specimen(RigSettings()) is original_specimen()
    assert np.array_equal(original_fit(), FITS)


def test_a_relative_card_lies_in_the_folder_of_the_settings(tmp_path: Path) -> None:
    original_specimen().without("offset").save(tmp_path / "other.toml")
    settings = RigSettings(specimen=SpecimenSettings(card="other.toml"))
    assert specimen_of(settings, tmp_path).composition.names == ("hyperbolic_tangent", "spring")


def test_a_card_with_a_velocity_bandwidth_can_be_tested_on_the_simulated_rig(tmp_path: Path) -> None:
    replace(original_specimen(), bandwidth=15.0).save(tmp_path / "fitted.toml")
    other = tmp_path / "rig.toml"
    other.write_text('[specimen]\ncard = "fitted.toml"\n', "utf-8")
    forces = []
    for settings in (None, other):
        with simulated(settings) as rig, rig.armed() as table:
            forces.append(table.signal(0.2))
    assert forces[0] == forces[1]
