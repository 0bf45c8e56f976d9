"""A search on the command line: its axes, what it prints, and what is refused."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.cli._search_axes import searched
from dampyr.errors import InputError
from dampyr.structures import control_law
from dampyr.studies import raminelli_2020

SHORT = ["--synthetic", "4", "--duration", "2"]


def run(*words: str):
    return CliRunner().invoke(cli, ["arena", *words])


def test_axes_make_the_candidates() -> None:
    damper = raminelli_2020.damper()
    law = control_law("bang_bang", high=3.212, lag=0.01)
    inputs, places = searched(
        damper,
        ("voltage=0.5,1:2:0.5", "bang_bang.period=0.005,0.01", "clipped_optimal.effort=0.1", "place=1,0-2"),
        [0.0, law],
        ("bang_bang:lag=10ms",),
    )
    assert inputs[:5] == [0.0, 0.5, 1.0, 1.5, 2.0]
    assert [(type(each).__name__, each.period, each.lag) for each in inputs[5:]] == [
        ("BangBang", 0.005, 0.01), ("BangBang", 0.01, 0.01), ("ClippedOptimal", 0.005, 0.0),
    ]  # fmt: skip
    assert inputs[-1].effort == 0.1
    assert places == [1, ("0", "2")]


@pytest.mark.parametrize(
    ("axis", "message"),
    [
        ("place=one", "'one' is no place; write a storey"),
        ("voltage", "is no axis; write it as in voltage=0:3:0.5"),
        ("voltage=3:0:1", "neither a number nor a range"),
        ("voltage=0:1:1e-9", "at most 10000 are allowed"),
        ("current=1", "this damper takes a voltage; leave it out"),
        ("weather=1", "'weather' is no axis; it may be voltage"),
        ("bang_bang.beauty=1", "'beauty' is not a setting of bang_bang"),
        ("nothing.lag=1", "nothing"),
    ],
)
def test_what_is_wrong_is_said(axis: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        searched(raminelli_2020.damper(), (axis,), [], ())


def test_a_search_is_printed_with_its_band_and_goes_on_from_its_folder(tmp_path: Path) -> None:
    words = ["--search", "voltage=0:2:1", "--search", "place=1,2", *SHORT, "--out", str(tmp_path / "files")]
    done = run(*words, "--finalists", "3", "--report", str(tmp_path / "page.html"))
    assert done.exit_code == 0, done.output
    assert "motions that were not used for choosing" in " ".join(done.output.split())
    assert (tmp_path / "files" / "judging_3.h5").is_file()
    assert "Which is best" in (tmp_path / "page.html").read_text("utf-8")
    found = json.loads(run(*words, "--json").stdout)
    assert len(found["names"]) == 6
    assert len(found["ratio"]) == 5
    assert set(found["chosen_by"]).isdisjoint(found["judged_on"])


def test_options_that_do_not_go_together_are_refused(tmp_path: Path) -> None:
    for words, message in (
        (["--finalists", "3", "--voltage", "0"], "--finalists belongs to --search"),
        (["--search", "place=1,2", "--read", str(tmp_path / "x.h5")], "leave one of them out"),
        (["--search", "place=1,2", "--voltage", "0", "--without-damper"], "--without-damper has no input to choose"),
        (["--search", "place=1,2", "--voltage", "0"], "a search needs 4 motions or more"),
    ):
        done = run(*words)
        assert done.exit_code == 2, words
        assert message in done.stderr
