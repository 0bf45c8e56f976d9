"""Quiroz (2022): the rows without control within 2 % of the replica, and what cannot be checked is said."""

import json

import pytest

from dampyr.errors import MissingData
from dampyr.studies import quiroz_2022


@pytest.fixture(scope="module")
def run(data_root, tmp_path_factory):
    if not (data_root / "vrths_2020").is_dir():
        pytest.skip(
            f"data absent: no folder {data_root / 'vrths_2020'}; set DAMPYR_DATA to the folder that holds the data"
        )
    return quiroz_2022.reproduce(data_root / "vrths_2020", tmp_path_factory.mktemp("quiroz"))


@pytest.mark.prove
def test_every_row_without_control_is_within_two_per_cent(run):
    checked = [value for value in run.compared if value.verdict != "cannot be checked"]
    assert len(checked) == 29
    assert [value for value in checked if value.verdict != "agrees"] == []
    for value in checked:
        assert value.ours == pytest.approx(value.published, rel=0.006)


@pytest.mark.prove
def test_what_needs_an_observer_cannot_be_checked_and_the_page_says_so(run):
    unchecked = [value for value in run.compared if value.verdict == "cannot be checked"]
    assert [value.published for value in unchecked] == [2.483, 8.433, 2.773, 4.048]
    assert "Kalman filter" in run.left_out[0]
    assert "Kalman filter" in run.page.read_text("utf-8")
    numbers = json.loads((run.page.parent / "quiroz_2022.json").read_text("utf-8"))
    assert len(numbers["compared"]) == len(run.compared)


def test_without_the_motions_it_says_where_they_are_published(tmp_path):
    with pytest.raises(MissingData, match="get it from"):
        quiroz_2022.reproduce(tmp_path)
