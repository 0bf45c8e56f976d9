"""The study without the campaign, which takes two seconds, and the campaign of one file."""

import shutil
from pathlib import Path

import pytest

from dampyr.studies import raminelli_2020
from dampyr.studies.raminelli_2020.campaign_records import PublishedCampaign, load
from dampyr.studies.raminelli_2020.study import Study
from dampyr.studies.raminelli_2020.study_part import StudyPart


@pytest.fixture(scope="session")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Study:
    """The study on a machine without the data."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("DAMPYR_DATA", str(tmp_path_factory.mktemp("no-data")))
        return raminelli_2020.reproduce(out=tmp_path_factory.mktemp("bare"))


def part_of(study: Study, title: str) -> StudyPart:
    [part] = [part for part in study.parts if part.title.startswith(title)]
    return part


@pytest.fixture(scope="session")
def second(bare: Study) -> StudyPart:
    """Chapter 2."""
    return part_of(bare, "Chapter 2")


@pytest.fixture(scope="session")
def fifth(bare: Study) -> StudyPart:
    """Chapter 5."""
    return part_of(bare, "Chapter 5")


@pytest.fixture(scope="session")
def one_file(campaign_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> PublishedCampaign:
    """The campaign with the file of one test at 0 V and no other."""
    folder = tmp_path_factory.mktemp("one-file")
    for name in ("campaign.csv", "ensaio5.1.mat"):
        shutil.copy(campaign_folder / name, folder / name)
    return load(folder, lambda stage, done: None)
