"""Instruments by their names or folders, and folders that are none."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from tests.rig.instruments.laboratory import rig_file

from dampyr.errors import FileError, InputError
from dampyr.rig import load_settings, simulated
from dampyr.rig.diagnosis import diagnose
from dampyr.rig.instruments import catalogue


def test_the_catalogue() -> None:
    assert catalogue.available("acquisition") == ["ni-daqmx"]
    assert catalogue.available("drive") == ["arduino-uno"]
    assert catalogue.available("supply") == ["analogue-output"]


@pytest.mark.parametrize(
    ("wires", "words"),
    [
        ({"acquisition": "ni-daqm"}, r"wires.acquisition = 'ni-daqm' is not known; did you mean 'ni-daqmx'\?"),
        ({"drive": "ni-daqmx"}, "wires.drive = 'ni-daqmx' is not known; .*arduino-uno.* or give the path of a folder"),
        ({"supply": "analog-output"}, "did you mean 'analogue-output'"),
        ({"acquisition": "./nowhere"}, "nowhere: wires.acquisition names this folder, and there is none"),
        (
            {"acquisition": "./empty"},
            "empty: has no .*py; wires.acquisition names a folder with driver.py and simulated.py",
        ),
        ({"acquisition": "./broken"}, "cannot be imported: SyntaxError"),
        ({"acquisition": "./nothing"}, r"nothing: .*py has no "),
        (
            {"acquisition": "./poor"},
            r"poor: its driver has no index_counts\(\) and no queue\(\), which is needed of an acq",
        ),
        ({"supply": "./poor"}, "no latency, which is needed of a supply"),
    ],
)
def test_an_instrument_that_is_none_is_a_sentence(tmp_path: Path, wires: dict[str, str], words: str) -> None:
    for name, text in (("broken", "def"), ("nothing", "")):
        for file in ("driver.py", "simulated.py"):
            (tmp_path / name).mkdir(exist_ok=True)
            (tmp_path / name / file).write_text(text)
    (tmp_path / "empty").mkdir()
    (tmp_path / "poor").mkdir()
    methods = "start = read = write = stop = close = identity = lambda self, *given: None"
    (tmp_path / "poor" / "driver.py").write_text(
        f"class Poor:\n    {methods}\n\ndef connect(rig):\n    return Poor()\n"
    )
    (tmp_path / "poor" / "simulated.py").write_text(
        "from .driver import Poor\n\ndef in_process(simulator):\n    return Poor()\n"
    )
    path = rig_file(tmp_path, **wires)
    with pytest.raises(InputError, match=words):
        simulated(path)
    [(role, name)] = wires.items()
    findings = {each.what: each for each in diagnose(path)}
    assert findings[role].observed == name
    assert re.search(words, str(findings["connection"].repair))


def test_a_simulated_end_without_its_function_says_what_is_missing(laboratory: Path) -> None:
    path = laboratory / "our_board" / "simulated.py"
    path.write_text(path.read_text().replace("def in_process(", "def in_this_process("))
    with pytest.raises(FileError, match=r"simulated.py has no in_process\(\)"):
        simulated(rig_file(laboratory, acquisition="./our_board"))


def test_a_relative_folder_lies_beside_the_rigs_file(laboratory: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir("/")
    rig = load_settings(laboratory / "rig.toml")
    absolute = catalogue.with_absolute_folders(rig, laboratory)
    assert absolute.wires.acquisition == str(laboratory / "our_board")
    assert absolute.wires.drive == "arduino-uno"
    assert replace(absolute, wires=rig.wires) == rig
