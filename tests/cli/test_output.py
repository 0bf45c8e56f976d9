"""Tables for people, JSON for machines."""

import json
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from dampyr.cli._frame import in_option_words
from dampyr.cli._output import plain, print_json, print_table


@dataclass(frozen=True)
class Thing:
    """Something to print."""

    values: np.ndarray
    where: Path
    more: MappingProxyType


def test_json_holds_what_our_data_hold(capsys: pytest.CaptureFixture[str]) -> None:
    thing = Thing(np.array([[1.5, np.nan], [np.inf, -np.inf]]), Path("a/b"), MappingProxyType({3: (True, None)}))
    print_json({"thing": thing, "number": np.float64(0.1), "count": np.int64(3), "ρ": "µ"})
    printed = capsys.readouterr().out
    assert json.loads(printed) == {
        "thing": {"values": [[1.5, None], ["inf", "-inf"]], "where": "a/b", "more": {"3": [True, None]}},
        "number": 0.1,
        "count": 3,
        "ρ": "µ",
    }
    assert "ρ" in printed
    assert "NaN" not in printed


def test_json_refuses_what_it_cannot_hold() -> None:
    with pytest.raises(TypeError, match="object has no place in JSON"):
        plain({"a": object()})


def test_a_table_keeps_every_word_and_number(capsys: pytest.CaptureFixture[str]) -> None:
    long = "a sentence that is " + "very " * 60 + "long"
    rows = [["kw", 380.6114, None, long], ["[bold]kx[/bold]", np.float64(2.5762), True, 7]]
    print_table("Parameters [1]", ["name", "value", "set", "note"], rows, ["", "N", "", ""], notes=["see [2]"])
    printed = capsys.readouterr().out
    for words in ("Parameters [1]", "380.6", "2.576", "–", "yes", "[bold]kx[/bold]", "see [2]"):
        assert words in printed
    assert printed.count("very") == 60
    assert "\x1b" not in printed
    assert all(line == line.rstrip() for line in printed.splitlines())


@pytest.mark.parametrize(
    ("sentence", "typed"),
    [
        ("stay inside it, or pass allow_extrapolation=True", "stay inside it, or add --allow-extrapolation"),
        ("it is not known; read it with voltage= (or current=)", "it is not known; declare it with --voltage (or --current)"),
        ("a.AT2 names no unit; declare it, such as units='g'", "a.AT2 names no unit; declare it with --motion-unit g"),
        ("give the seconds between samples, such as dt=0.02", "give the seconds between samples with --dt 0.02"),
        ("give one, --dt 0.001 or dt=0.001", "give one, --dt 0.001"),
        ("name one, --variable NAME or variable=NAME", "name one, --variable NAME"),
        ("name one, --variable 1 or variable='1', or read all", "name one, --variable 1, or read all"),
        ("declare it, such as --motion-unit g, units='g' or units='m/s^2'", "declare it, such as --motion-unit g"),
        ("say --column time=0 --column force=1 or columns={'time': 0, 'force': 1}", "say --column time=0 --column force=1"),
        ("give --factor force='0.005 N' or factors={'force': '0.005 N'}; 2 N", "give --factor force='0.005 N'; 2 N"),
        ("--dt 0.01 or dt=0.01 (s), which goes before", "--dt 0.01 (s), which goes before"),
    ],
)  # fmt: skip
def test_a_terminal_is_told_options_and_not_arguments_of_python(sentence: str, typed: str) -> None:
    assert in_option_words(sentence) == typed
