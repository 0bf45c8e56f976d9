"""The motions of the benchmark, for all its tests."""

from pathlib import Path

import pytest

from dampyr.ground_motions import GroundMotion
from dampyr.studies import vrths_2020


@pytest.fixture(scope="session")
def motions(data_root: Path) -> Path:
    """The folder of the benchmark's motions, or a skip."""
    folder = data_root / "vrths_2020"
    if not folder.is_dir():
        pytest.skip(f"data absent: no folder {folder}; set DAMPYR_DATA to the folder that holds the data")
    return folder


@pytest.fixture(scope="session")
def el_centro(motions: Path) -> GroundMotion:
    return vrths_2020.motion("El Centro", motions)
