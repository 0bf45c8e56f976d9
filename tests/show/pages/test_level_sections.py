"""Levels of records by session, and what their predictive bands hold."""

from dataclasses import replace

import numpy as np
import pytest
from tests.show.fit_examples import DAHL, records

from dampyr.identification import Fit, Score
from dampyr.identification.parameter_uncertainty.levels import Levels
from dampyr.identification.scoring.scoring_window import Window
from dampyr.identification.scoring.validate import Validated
from dampyr.show.pages.blocks import Text
from dampyr.show.pages.level_sections import bands_section, levels_section
from dampyr.show.table import Table


def test_the_mean_level_of_a_session_is_the_geometric_one(joint: Fit) -> None:
    level = {"a": 1.1, "b": 1.1**3, "c": 0.98}
    session = {"a": "monday", "b": "monday", "c": "tuesday"}
    levels = Levels(level, session, 0.02, 2.0, 0.05, 1.0, 0.05, True, True, "", "")
    section = levels_section(replace(joint, levels=levels))
    assert section is not None
    text, table = section.blocks
    assert isinstance(text, Text)
    assert isinstance(table, Table)
    assert "Within a session records differ by 2 %" in text.text
    first, second = table.rows
    assert (first[0], first[1]) == ("monday", 2)
    assert first[2:] == pytest.approx([100 * (1.1**2 - 1.0), 100 * np.log(1.1) * np.sqrt(2.0)])
    assert list(second) == ["tuesday", 1, pytest.approx(-2.0), None]  # one record has no spread


def test_without_levels_there_is_no_section(joint: Fit) -> None:
    assert levels_section(replace(joint, levels=None)) is None


def test_without_bands_the_levels_stand_alone_and_say_why() -> None:
    [record] = records((0.0,), 1)
    score = Score(0.1, 0.2, 0.96, 0.1, 0.01, -0.02, 3.0, Window(0, 10, 0.0, 1.0), 1.02)
    validated = Validated("card", DAHL, (record,), {record.name: score}, {})
    text, table = bands_section(validated).blocks
    assert isinstance(text, Text)
    assert text.text == "No bands were asked for."
    assert isinstance(table, Table)
    assert table.rows[0][2] == 1.02
    assert len(bands_section(replace(validated, no_band="the card states no errors")).blocks) == 1
