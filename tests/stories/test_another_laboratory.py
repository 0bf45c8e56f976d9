"""Another laboratory's files, from the first look to the prediction of an earthquake; and files with something wrong."""

from __future__ import annotations

import json
import os
import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path
from subprocess import PIPE, STDOUT, Popen

import numpy as np
import pytest
from click.testing import CliRunner, Result

from dampyr.cli import cli
from tests.endurance import Endurance
from tests.stories.laboratory import CURRENTS, HEADER, MOTIONS, READING, UNITS, columns, sine, text, write_laboratory

pytestmark = pytest.mark.prove

MODEL = "hyperbolic_tangent + spring + compliance"
TESTED = [MOTIONS[k] for k in (0, 2, 5)]  # 25 mm at 0.1 Hz, 10 mm at 1 Hz and 2 mm at 5 Hz
SAID = [word for channel, unit in UNITS.items() for word in ("--unit", f"{channel}={unit}")]


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(cli, [*map(str, arguments)], catch_exceptions=False)


def run_output(*arguments: str | Path) -> str:
    done = run(*arguments)
    assert done.exit_code == 0, done.stderr
    return done.stdout


def refused(*arguments: str | Path) -> str:
    """The one line of an orderly refusal."""
    done = run(*arguments)
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1, done.stderr
    return done.stderr


@pytest.fixture(scope="module")
def as_it_came(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_laboratory(tmp_path_factory.mktemp("rig") / "tests", TESTED)


@pytest.fixture(scope="module")
def laboratory(as_it_came: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder with its units and roles said once."""
    folder = tmp_path_factory.mktemp("said") / "tests"
    shutil.copytree(as_it_came, folder)
    (folder / "reading.toml").write_text(READING)
    return folder


@pytest.fixture(scope="module")
def card(laboratory: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("card") / "card.toml"
    run_output("identify", laboratory, "--model", MODEL, "--save", path)
    return path


def test_the_first_look_says_what_is_missing(as_it_came: Path) -> None:
    done = run("records", as_it_came)
    assert done.exit_code == 2
    note, line = done.stderr.splitlines()
    assert note.endswith("left out, no line of numbers: README.txt")
    assert (
        "earthquake_0.7A.txt: the columns 'Time', 'Displacement', 'Force', 'Velocity', 'Current' have no unit" in line
    )
    assert "17 records" in run_output("records", as_it_came, *SAID)


def test_the_records_are_listed_by_what_was_set(laboratory: Path) -> None:
    done = run("records", laboratory)
    listed, by_input = done.stdout.split("By input")
    assert "-0.014" in done.stderr
    assert "in 3 records counts as 0 A; " in done.stderr
    inputs = [float(line.split()[0]) for line in by_input.splitlines() if line.split()[1:2] == ["A"]]
    assert inputs == sorted(inputs)
    np.testing.assert_allclose(inputs, sorted([*CURRENTS, 0.7, 1.2]), atol=0.004)
    names = [line.split()[0] for line in listed.splitlines() if line.startswith("  sine")]
    assert names[:2] == ["sine_2mm_5Hz_0A", "sine_2mm_5Hz_0.25A"]
    assert len(names) == len(CURRENTS) * len(TESTED)
    [quake] = [line for line in listed.splitlines() if "earthquake_0.7A" in line]
    assert quake.split()[1] == "validation"
    assert "no repeating cycle: strongest at" in quake


def test_the_earthquake_is_predicted(laboratory: Path, card: Path, tmp_path: Path) -> None:
    done = run("validate", card, laboratory, "--role", "validation", "--forces", tmp_path / "forces")
    assert done.exit_code == 0, done.stderr
    assert "Energy –: no whole cycle in the window, so it is not scored." in done.stdout
    assert "nan" not in done.stdout
    assert "Mean L1" in done.stdout
    scores = json.loads(run_output("validate", card, laboratory, "--role", "validation", "--json"))["scores"]
    assert list(scores) == ["earthquake_0.7A", "earthquake_1.2A"]
    assert all(score["l1"] < 0.10 and not score["fitted_on"] for score in scores.values())
    for name, score in scores.items():
        _, _, force, predicted = np.loadtxt(tmp_path / "forces" / f"{name}.csv", delimiter=",", skiprows=3).T
        part = slice(score["window"]["first"], score["window"]["last"] + 1)
        middle = np.mean(np.quantile(force[part], (0.01, 0.99)))
        l1 = np.sum(np.abs(predicted - force)[part]) / np.sum(np.abs(force[part] - middle))
        assert l1 == pytest.approx(score["l1"], rel=1e-4)


def test_a_model_that_remembers_the_path_predicts_better(laboratory: Path, tmp_path: Path) -> None:
    card = tmp_path / "card.toml"
    run_output("identify", laboratory, "--model", "dahl + hyperbolic_tangent + compliance", "--save", card)
    scores = json.loads(run_output("validate", card, laboratory, "--role", "validation", "--json"))["scores"]
    assert all(score["l1"] < 0.02 for score in scores.values())


@pytest.mark.by_hand
def test_the_leaderboard_finds_a_model_that_predicts_both_earthquakes(tmp_path: Path, endurance: Endurance) -> None:
    """Thirty sines, nothing compiled before: under five minutes on two cores, and never silent for ten seconds."""
    laboratory, card = write_laboratory(tmp_path / "tests"), tmp_path / "card.toml"
    (laboratory / "reading.toml").write_text(READING)
    command = [sys.executable, "-m", "dampyr", "identify", str(laboratory), "--save", str(card)]
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path / "cache"), "NUMBA_CACHE_DIR": str(tmp_path / "numba")}
    heard = [time.monotonic()]
    with Popen(command, env=environment, stdout=PIPE, stderr=STDOUT, text=True) as choice:
        assert choice.stdout is not None
        for _ in choice.stdout:
            heard.append(time.monotonic())
    heard.append(time.monotonic())
    assert choice.returncode == 0
    seconds, silence = heard[-1] - heard[0], float(np.max(np.diff(heard)))
    scores = json.loads(run_output("validate", card, laboratory, "--role", "validation", "--json"))["scores"]
    assert list(scores) == ["earthquake_0.7A", "earthquake_1.2A"]
    errors = " and ".join(f"{100 * score['l1']:.2g} %" for score in scores.values())
    endurance.report(
        "`dampyr identify` without a model on 30 sines of a simulated laboratory, cache empty",
        None,
        f"{seconds:.0f} s, no line for {silence:.1f} s at most; L1 of the two earthquakes {errors}",
    )
    assert all(score["l1"] < 0.02 for score in scores.values())
    assert seconds < 300.0
    assert silence < 10.0


def test_the_scores_are_told_by_input(laboratory: Path, card: Path) -> None:
    rows = json.loads(run_output("validate", card, laboratory, "--band", "none", "--json"))["by_input"]
    inputs = [row["input"] for row in rows]
    assert inputs == sorted(inputs)
    assert [row["records"] for row in rows] == [3, 3, 3, 1, 3, 1, 3]
    assert all(row["mean_l1"] <= row["worst_l1"] < 0.12 for row in rows)


def test_a_page_of_the_prediction(laboratory: Path, card: Path, tmp_path: Path) -> None:
    pytest.importorskip("dampyr.show.pages.validate_page", reason="the page of a validation is not there yet")
    shown = run_output("validate", card, laboratory, "--role", "validation", "--report", tmp_path / "v.html")
    assert f"page: {tmp_path / 'v.html'}" in shown
    assert "earthquake_1.2A" in (tmp_path / "v.html").read_text(encoding="utf-8")


def test_two_records_of_one_name_are_not_scored_as_one(laboratory: Path, card: Path) -> None:
    line = run("validate", card, laboratory / "earthquake_0.7A.txt", laboratory).stderr.splitlines()[-1]
    assert "2 records are called 'earthquake_0.7A'; rename" in line


def test_forces_replace_their_own_files_only(laboratory: Path, card: Path, tmp_path: Path) -> None:
    quake = laboratory / "earthquake_0.7A.txt"
    for _ in range(2):
        run_output("validate", card, quake, "--forces", tmp_path)
    (tmp_path / "earthquake_0.7A.csv").write_text("mine\n")
    line = run("validate", card, quake, "--forces", tmp_path).stderr.splitlines()[-1]
    assert "was not written by dampyr; choose another folder" in line
    assert (tmp_path / "earthquake_0.7A.csv").read_text() == "mine\n"


def test_the_current_of_a_single_file_may_lie_at_the_edge_of_the_card(
    laboratory: Path, card: Path, tmp_path: Path
) -> None:
    """Its measured 1.508 A is the card's 1.5 A, and -0.014 A its 0: no extrapolation."""
    for current in (0.0, 1.5):
        rows = columns(*sine(10.0, 1.0), current, np.random.default_rng(5))
        rows[:, 4] += 0.005
        path = tmp_path / f"again_{current:g}A.txt"
        path.write_text(text(rows))
        assert "again" in run_output("validate", card, path, *SAID)


def rows_of(current: float = 0.5) -> np.ndarray:
    return columns(*sine(5.0, 2.0), current, np.random.default_rng(3))


def spoilt(change: Callable[[np.ndarray], None]) -> str:
    rows = rows_of()
    change(rows)
    return text(rows)


def doubled(rows: np.ndarray) -> None:
    rows[57, 0] = rows[56, 0]


def shifted(rows: np.ndarray) -> None:
    rows[:, 0] += 1234.5


def inverted(rows: np.ndarray) -> None:
    rows[:, 3] *= -1.0


def test_a_column_that_is_missing(tmp_path: Path) -> None:
    lines = [line.rsplit("\t", 2)[0] for line in text(rows_of()).splitlines()]
    (tmp_path / "a.txt").write_text("\n".join(lines))
    line = refused("records", tmp_path / "a.txt", *SAID)
    assert "no column is the force (there: Time, Displacement, Velocity); declare which, --column force=NAME" in line


def test_a_time_stamp_that_comes_twice(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text(spoilt(doubled))
    line = refused("identify", tmp_path, *SAID)
    assert (
        "lines 58 and 59 have the same time stamp (1 such pair); cut out one of two equal lines, or, where the " in line
    )


@pytest.mark.usefixtures("no_trials")
@pytest.mark.parametrize("command", ["records", "identify"])
def test_an_inverted_force_is_flagged(tmp_path: Path, command: str) -> None:
    (tmp_path / "a.txt").write_text(spoilt(inverted))
    (tmp_path / "b.txt").write_text(text(rows_of()))
    done = run(command, tmp_path, *SAID, *(["--model", "bingham"] if command == "identify" else []))
    assert done.stdout.count("force sign inverted?") == 1
    assert "a: its loops create energy" in done.stdout or command == "records"


def measured(path: Path, *options: str) -> dict[str, float]:
    [record] = json.loads(run_output("records", path, *options, "--json"))["records"]
    assert record["input_value"] == pytest.approx(0.5, abs=0.002)
    return {
        key: record["measured"][key] for key in ("frequency_hz", "peak_to_peak_m", "mean_force", "energy_per_cycle")
    }


def in_inches(rows: np.ndarray) -> str:
    units = "time [s]\tdisplacement [in]\tvelocity [in/s]\tforce [kN]\tcurrent [mA]"
    lines = ["\t".join(f"{value:.8f}" for value in row) for row in rows / [1.0, 25.4, 25.4, 1e3, 1e-3]]
    return "\n".join([units, *lines])


@pytest.mark.parametrize(
    ("written", "options"),
    [
        (text(rows_of()).replace(".", ","), SAID),
        (text(rows_of(), HEADER.replace("\t", ";"), ";").replace(".", ","), SAID),
        (text(rows_of(), end="\r\n") + "\r\n\r\n", SAID),
        (spoilt(shifted), SAID),
        (text(rows_of(), HEADER + "\nsec\tmm\tmm/s\tN\tA"), []),
        (in_inches(rows_of()), []),
        (text(rows_of()).replace("Force", "Load cell"), [*SAID, "--column", "force=Load cell"]),
        (text(rows_of()), [*SAID, "--current", "0.5"]),
    ],
    ids=["decimal commas", "semicolons", "Windows", "late start", "units below", "in and kN", "named", "current said"],
)
def test_the_same_test_written_otherwise(tmp_path: Path, written: str, options: list[str]) -> None:
    (tmp_path / "plain.txt").write_text(text(rows_of()))
    (tmp_path / "other.txt").write_bytes(written.encode())
    expected = measured(tmp_path / "plain.txt", *SAID)
    assert measured(tmp_path / "other.txt", *options) == pytest.approx(expected, rel=1e-4)


def test_a_current_that_the_file_contradicts(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text(text(rows_of()))
    line = refused("identify", tmp_path / "a.txt", *SAID, "--current", "1.5")
    assert "current = 1.5 A was given, but the file's column has" in line
    assert "leave current out" in line
