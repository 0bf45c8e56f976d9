"""What a reading.toml says of a folder's files: units, roles, inputs, sections, and what is wrong in it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.records.text_files import UNITS, four_files, say

from dampyr.errors import FileError
from dampyr.records import read, read_campaign


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return four_files(tmp_path)


def test_units_roles_and_inputs_are_said_once(folder: Path) -> None:
    say(folder, 'validation = ["quake*"]\ncurrent = "*_{}A"')
    assert [(r.name, r.current) for r in read_campaign(folder)] == [
        ("run2_0.25A", 0.25), ("run2_0.5A", 0.5), ("run10_0.5A", 0.5),
    ]  # fmt: skip
    [quake] = read_campaign(folder, role="validation")
    assert (quake.role, quake.current) == ("validation", 1.5)
    assert "role validation from reading.toml" in quake.history
    assert read(folder / "run2_0.25A.txt").current == 0.25
    assert read(folder / "run2_0.25A.txt", current=0.3).current == 0.3


def test_inputs_as_a_table_or_a_number(folder: Path) -> None:
    say(folder, 'voltage = {"run2_*" = 1.0, "run10_0.5A.txt" = 2.0}')
    assert [r.voltage for r in read_campaign(folder)] == [None, 1.0, 1.0, 2.0]
    say(folder, "voltage = 3")
    assert {r.voltage for r in read_campaign(folder)} == {3.0}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("validation = [", "is not valid TOML"),
        (
            "valid = []",
            "'valid' is not known; choose from units, columns, factors, offsets, thousands, encoding, delimiter, voltage, ",
        ),
        ('validation = "quake*"', "is not a list of patterns"),
        ('validation = ["earth*"]', "'earth*' matches no file of the folder"),
        ('current = "run{}"', "current = 'run{}' does not match the file quake_1,5A.txt"),
        ('current = "no number"', "must hold {} once"),
        ('current = "{}_{}"', "must hold {} once"),
        ("current = true", "is neither a number"),
        ("current = 1\nvoltage = 1", "a record has one input"),
        ("no_input = true\nvoltage = 1", "voltage and no_input are both given; a record has one input"),
        ("no_input = 1", "no_input = 1 is not allowed; write true where the dampers have no input"),
        ('current = {"run*" = 1, "run2*" = 2}', "gives run2_0.25A.txt both 1 and 2 A"),
        ("units = 3", "is not a table"),
        ('columns = {stroke = "x"}', "'stroke', which is not a channel"),
        ("columns = {force = 1.5}", "columns['force'] = 1.5 must be a text or a whole number"),
    ],
)
def test_a_wrong_reading_toml_is_one_line(folder: Path, text: str, words: str) -> None:
    (folder / "reading.toml").write_text(text, encoding="utf-8")
    with pytest.raises(FileError) as caught:
        read_campaign(folder, units=UNITS)
    message = str(caught.value)
    assert message.startswith(str(folder / "reading.toml"))
    assert words in message
    assert "\n" not in message


SECTIONS = """
force_sign = -1
measurement_session = "day 1"
specimen = {"run*" = "no. 1", "quake*" = "no. 2"}
current = "*_{}A"

[[files]]
pattern = ["quake*", "run10*"]
force_sign = 1
[files.units]
force = "kN"

[[files]]
pattern = "run10*"
voltage = 2
measurement_session = "day 2"
"""


def test_a_section_goes_before_what_stands_above_it(folder: Path) -> None:
    (folder / "reading.toml").write_text(
        SECTIONS + '[units]\ntime = "s"\ndisplacement = "mm"\nforce = "N"\n', encoding="utf-8"
    )
    quake, first, _, tenth = read_campaign(folder)
    assert np.max(quake.force) == pytest.approx(50e3)
    assert np.max(first.force) < 50.0  # its largest was the first sample, now the smallest
    assert first.force[0] == pytest.approx(-50.0)
    assert tenth.force[0] == pytest.approx(50e3)
    assert [r.input for r in (quake, first, tenth)] == ["A", "A", "V"]
    assert tenth.voltage == 2.0
    assert [r.specimen for r in (quake, first, tenth)] == ["no. 2", "no. 1", "no. 1"]
    assert [r.measurement_session for r in (quake, first, tenth)] == ["day 1", "day 1", "day 2"]
    assert read(folder / "run10_0.5A.txt", current=0.5, specimen="no. 3").specimen == "no. 3"
    assert "measurement_session 'day 2' as stated" in tenth.history


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("files = 3", "files = 3 is not a list of tables; write each as [[files]] with its pattern"),
        ("[[files]]\nheader = 1", "[[files]] 1: pattern = None is not a pattern; write it as in"),
        ('[[files]]\npattern = "earth*"', "'earth*' matches no file of the folder"),
        (
            '[[files]]\npattern = "run*"\nvalidation = ["a"]',
            "[[files]] 1: 'validation' is not known; choose from pattern, units,",
        ),
        ('[[files]]\npattern = "run*"\nheader = -1', "[[files]] 1: header = -1 is not allowed; it must be at least 0"),
        ('[[files]]\npattern = "run*"\nforce_sign = 2', "[[files]] 1: force_sign = 2 is not allowed; it must be -1"),
        (
            '[[files]]\npattern = "run*"\ndt = "2 mm"',
            "[[files]] 1: dt: the unit 'mm' does not measure what 's' measures",
        ),
        ('[[files]]\npattern = "run*"\ndt = -1', "[[files]] 1: dt = -1 s is not allowed; it must be greater than 0"),
        ('[[files]]\npattern = "run*"\nvariable = ""', "[[files]] 1: variable = '' is not a name"),
        ('[[files]]\npattern = "run*"\nvoltage = 1\ncurrent = 1', "[[files]] 1: voltage and current are both given"),
        ('specimen = " "', "specimen = ' ' is not a name; give one line of text"),
        ("measurement_session = 2026-03-01", "is not a text; give a name in quotes"),
        (
            'specimen = {"run*" = "a", "run2*" = "b"}',
            "specimen gives run2_0.25A.txt both 'a' and 'b'; make the patterns exclusive",
        ),
        (
            '[[files]]\npattern = "run*"\nheader = 1\n[[files]]\npattern = "run2*"\nheader = 0',
            "'run*' and 'run2*' give run2_0.25A.txt two values of header, 1 and 0; make the patterns exclusive",
        ),
        (
            '[[files]]\npattern = "run*"\nunits.force = "N"\n[[files]]\npattern = "run2*"\nunits.force = "kN"',
            "'run*' and 'run2*' give run2_0.25A.txt two values of units.force, 'N' and 'kN'",
        ),
        (
            '[[files]]\npattern = "run*"\nvoltage = 1\n[[files]]\npattern = "run2*"\ncurrent = 1',
            "'run*' and 'run2*' give run2_0.25A.txt a voltage and a current; a record has one input",
        ),
    ],
)
def test_a_wrong_section_is_one_line(folder: Path, text: str, words: str) -> None:
    (folder / "reading.toml").write_text(text, encoding="utf-8")
    with pytest.raises(FileError) as caught:
        read_campaign(folder, units=UNITS)
    message = str(caught.value)
    assert message.startswith(str(folder / "reading.toml"))
    assert words in message
    assert "\n" not in message


def test_two_sections_may_say_the_same(folder: Path) -> None:
    same = '[[files]]\npattern = "{}"\nheader = 1\nunits = {{force = "N"}}\n'
    (folder / "reading.toml").write_text(same.format("run*") + same.format("run2*"), encoding="utf-8")
    units = {"time": "s", "displacement": "mm", "force": "N"}
    assert len(read_campaign(folder, units=units)) == 4
