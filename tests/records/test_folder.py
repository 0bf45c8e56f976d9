"""Folders of record files without a table, and the reading.toml beside them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import DampyrWarning, FileError, InputError, MissingData
from dampyr.records import Record, nominal_inputs, read, read_campaign, write

UNITS = {"time": "s", "displacement": "mm", "force": "N"}


def put(path: Path, header: str = "Time\tDisplacement\tForce", force: float = 50.0, extra: float | None = None) -> Path:
    t = 0.01 * np.arange(300)
    rows = np.column_stack(
        [t, 5 * np.sin(6 * t), force * np.cos(6 * t)] + ([t * 0 + extra] if extra is not None else [])
    )
    np.savetxt(path, rows, delimiter="\t", header=header, comments="", fmt="%.6f")
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("run10_0.5A.txt", "run2_0.25A.txt", "run2_0.5A.csv", "quake_1,5A.txt"):
        put(tmp_path / name)
    return tmp_path


def say(folder: Path, text: str) -> None:
    (folder / "reading.toml").write_text(
        text + '\n[units]\ntime = "s"\ndisplacement = "mm"\nforce = "N"\n', encoding="utf-8"
    )


def test_every_file_is_a_record_named_by_its_stem_in_natural_order(folder: Path) -> None:
    records = read_campaign(folder, units=UNITS, current=0.5)
    assert [r.name for r in records] == ["quake_1,5A", "run2_0.25A", "run2_0.5A", "run10_0.5A"]
    assert {r.current for r in records} == {0.5}
    np.testing.assert_allclose(np.max(records[0].displacement), 5e-3, rtol=1e-3)


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
        ("valid = []", "'valid' is not known; choose from units, columns, voltage, current, dt, variable, header, "),
        ('validation = "quake*"', "is not a list of patterns"),
        ('validation = ["earth*"]', "'earth*' matches no file of the folder"),
        ('current = "run{}"', "current = 'run{}' does not match the file quake_1,5A.txt"),
        ('current = "no number"', "must hold {} once"),
        ('current = "{}_{}"', "must hold {} once"),
        ("current = true", "is neither a number"),
        ("current = 1\nvoltage = 1", "a record has one input"),
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


def test_texts_without_numbers_are_left_out_and_named(folder: Path) -> None:
    (folder / "README.txt").write_text("Two lines.\n2 operators in May, 1 damper\n", encoding="utf-8")
    with pytest.warns(DampyrWarning, match=r"left out, no line of numbers: README\.txt"):
        assert len(read_campaign(folder, units=UNITS)) == 4


def test_a_file_that_cannot_be_read_is_named_and_can_be_ignored(folder: Path) -> None:
    (folder / "zero.txt").write_text("Time\tForce\n0.0\t1.0\n0.1\t2.0\n", encoding="utf-8")
    with pytest.raises(FileError, match=r"zero\.txt: no column is the displacement .*ignore it in reading\.toml"):
        read_campaign(folder, units=UNITS)
    say(folder, 'ignore = ["zero*"]')
    assert len(read_campaign(folder)) == 4


def test_two_records_of_one_name(folder: Path) -> None:
    put(folder / "run2_0.25A.csv")
    with pytest.raises(InputError, match=r"2 records are called 'run2_0.25A' \(from .*csv, .*txt\)"):
        read_campaign(folder, units=UNITS)


def test_own_files_stand_beside_text(folder: Path) -> None:
    record = read(folder / "run2_0.5A.csv", units=UNITS)
    write(record.replace(note="renamed", name="own"), folder / "run3.h5")
    assert [r.name for r in read_campaign(folder, units=UNITS)][2:] == ["run2_0.5A", "own", "run10_0.5A"]


def test_nothing_but_prose(tmp_path: Path) -> None:
    (tmp_path / "notes.md").write_text("1 2\n", encoding="utf-8")
    with pytest.raises(MissingData, match="the folder has no records"):
        read_campaign(tmp_path)


def test_an_input_beside_a_campaign_table_is_refused(tmp_path: Path) -> None:
    head = "file,table,row,voltage_V,peak_to_peak_mm,frequency_Hz\n"
    (tmp_path / "campaign.csv").write_text(head, encoding="utf-8")
    with pytest.raises(InputError, match=r"current = 1 A was given, but .*campaign\.csv says it of each file"):
        read_campaign(tmp_path, current=1.0)


def test_a_measured_column_gives_way_to_what_is_stated_where_it_agrees(tmp_path: Path) -> None:
    header = "time [s]\tdisplacement [mm]\tforce [N]\tcurrent [A]"
    path = put(tmp_path / "a.txt", header, extra=0.497)
    assert read(path).current == pytest.approx(0.497)
    stated = read(path, current=0.5)
    assert stated.current == 0.5
    assert "current 0.5 A as stated; 0.497 A as measured" in stated.history
    with pytest.raises(FileError, match=r"current = 1 A was given, but the file's column has 0\.497 to 0\.497 A"):
        read(path, current=1.0)


def test_one_of_two_inputs_can_be_left_out(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    rows = "\n".join(f"{k} {k} {k} 2.2 0.5" for k in range(9))
    path.write_text(f"t[s] x[mm] f[N] u[V] i[A]\n{rows}\n", encoding="utf-8")
    with pytest.raises(FileError, match=r"voltage and current are both given.*--column voltage=-"):
        read(path)
    for none in (None, "-"):
        assert read(path, columns={"voltage": none}).current == 0.5


def measured(value: float, noise: float = 0.005, n: int = 2000, seed: int = 0, **fields: object) -> Record:
    t = 0.002 * np.arange(n)
    values = value + noise * np.random.default_rng(seed).standard_normal(n)
    return Record(t, np.sin(t), np.cos(t), current=values, **fields)


def test_noisy_constants_that_agree_are_one_input() -> None:
    values = (-0.0141, 0.4996, 0.5003, 1.4991, 1.5027)
    records = [measured(value, seed=k) for k, value in enumerate(values)]
    nominal_records = nominal_inputs(records)
    assert [r.current for r in nominal_records] == [0.0, 0.5, 0.5, 1.501, 1.501]
    assert "constant but for noise, 0.4995 A as measured: counts as 0.5 A" in nominal_records[1].history[-1]
    assert all(isinstance(r.current, np.ndarray) for r in records)
    again = nominal_inputs(nominal_records)
    assert [r.current for r in again] == [r.current for r in nominal_records]


def test_inputs_that_differ_by_more_than_the_tolerance_stay_apart() -> None:
    nominal_records = nominal_inputs([measured(value, seed=k) for k, value in enumerate((1.0, 1.04, 1.5))])
    assert [r.current for r in nominal_records] == [1.0, 1.04, 1.5]
    chain = [measured(1.0 + 0.02 * k, noise=0.0, seed=k) for k in range(6)]
    assert len({r.input_value for r in nominal_inputs(chain)}) == 6


@pytest.mark.parametrize("shape", ["step", "ramp", "on and off", "wave"])
def test_an_input_that_varies_keeps_its_channel(shape: str) -> None:
    t = 0.002 * np.arange(2000)
    u = {
        "step": np.where(t < 3.0, 0.5, 0.6),
        "ramp": 0.5 + 0.03 * t,
        "on and off": 0.75 + 0.75 * np.sign(np.sin(60.0 * t)),
        "wave": 0.75 + 0.2 * np.sin(60.0 * t),
    }[shape]
    record = Record(t, np.sin(t), np.cos(t), current=u)
    [varying, constant] = nominal_inputs([record, measured(1.0)])
    assert varying is record
    assert constant.current == 1.0


def test_what_was_stated_stays_and_draws_what_was_measured() -> None:
    stated = [Record(*np.tile(np.arange(9.0), (3, 1)), current=value) for value in (0.0, 1.00, 1.01)]
    nominal_records = nominal_inputs([*stated, measured(0.997)])
    assert [r.current for r in nominal_records] == [0.0, 1.00, 1.01, 1.00]
    assert nominal_records[1] is stated[1]
    assert nominal_inputs([measured(1.497)], nominal_values=(0.0, 1.5))[0].current == 1.5


def test_volts_and_amperes_are_not_mixed() -> None:
    volts = Record(*np.tile(np.arange(9.0), (3, 1)), voltage=1.0, name="v")
    with pytest.raises(InputError, match="v has a voltage and record a current"):
        nominal_inputs([volts, measured(1.0)])


@pytest.mark.parametrize(
    ("name", "pattern", "value"),
    [
        ("sine_0p25A", "*_{}A", 0.25),
        ("sine_0x25A", "*_{}A", 0.25),
        ("sine_1X5A", "*_{}A", 1.5),
        ("sine_2P5A", "sine_{}A", 2.5),
        ("0,25A", "{}A", 0.25),
        ("sine0x25A", "*{}A", 0.25),
        ("sine0p125A", "sine*{}A", 0.125),
        ("run_10A", "*_{}A", 10.0),
        ("5mmx2A", "*{}A", 2.0),
        ("run5x2A", "run*x{}A", 2.0),
        ("step12p25A", "step*p{}A", 25.0),
    ],
)
def test_an_input_in_a_name_may_have_a_letter_for_its_point(
    tmp_path: Path, name: str, pattern: str, value: float
) -> None:
    put(tmp_path / f"{name}.txt")
    say(tmp_path, f'current = "{pattern}"')
    assert read(tmp_path / f"{name}.txt").current == value


def test_names_with_inputs_are_listed_in_the_order_of_the_inputs(tmp_path: Path) -> None:
    for text in ("10A", "1A", "0,5A", "0p25A", "0x125A", "0.75A"):
        put(tmp_path / f"sine_{text}.txt")
    say(tmp_path, 'current = "*_{}A"')
    assert [r.current for r in read_campaign(tmp_path)] == [0.125, 0.25, 0.5, 0.75, 1.0, 10.0]


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


def test_a_campaign_table_may_name_sessions_and_specimens(folder: Path) -> None:
    head = "file,table,row,voltage_V,peak_to_peak_mm,frequency_Hz,measurement_session,specimen\n"
    rows = "run2_0.25A.txt,4.1,1,0.5,10,1, day 1 ,no. 7\nrun2_0.5A.csv,4.1,2,1.0,10,1,,\n"
    (folder / "campaign.csv").write_text(head + rows, encoding="utf-8")
    first, second = read_campaign(folder, units=UNITS)
    assert (first.measurement_session, first.specimen) == ("day 1", "no. 7")
    assert (second.measurement_session, second.specimen) == (None, None)
    assert read_campaign(folder, units=UNITS, specimen="no. 8")[1].specimen == "no. 8"


def test_files_of_one_name_are_no_tries_of_one_test(tmp_path):
    t = 0.01 * np.arange(100)
    for k in range(2):
        write(Record(t, np.sin(t), np.cos(t), voltage=0.0, name="sine"), tmp_path / f"{k}.h5")
    with pytest.raises(
        InputError, match=r"2 records are called 'sine' \(from .*\); ignore or rename all but one .* inside"
    ):
        read_campaign(tmp_path)
