"""Campaigns that several files of tests look at, performed once; a test that changes a folder copies it."""

import shutil
from pathlib import Path

import pytest
from tests.campaigns import quick_rig as rigs
from tests.campaigns.quick_rig import QUICK, SHORT, TWO, TWO_SINES, quick_rig

from dampyr.campaigns import perform


@pytest.fixture(autouse=True)
def proving(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """A proof reads the rig as it ships."""
    monkeypatch.setattr(rigs, "proving", request.node.get_closest_marker("prove") is not None)


@pytest.fixture(scope="session")
def drifted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a campaign whose load cell drifts by 5 N/s."""
    folder = tmp_path_factory.mktemp("drifted")
    (folder / "short.toml").write_text(SHORT.format(voltage='["0 V", "1 V"]'))
    return perform(folder / "short.toml", quick_rig("drifting-cell=5@2s", settings=QUICK), folder / "out").folder


@pytest.fixture(scope="session")
def two_sines(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a campaign of two short sines, ``short.toml``, and its records, ``out``."""
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "short.toml").write_text(TWO_SINES)
    perform(folder / "short.toml", quick_rig(settings=QUICK), folder / "out")
    return folder


@pytest.fixture
def lab(two_sines: Path, tmp_path: Path) -> Path:
    """A copy of it, to be changed."""
    return Path(shutil.copytree(two_sines, tmp_path / "lab"))


@pytest.fixture
def two(tmp_path: Path) -> Path:
    """The file of a campaign of two tests."""
    path = tmp_path / "two.toml"
    path.write_text(TWO, encoding="utf-8")
    return path
