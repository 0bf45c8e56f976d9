"""Motions of supports in a file: what each table means, each mistake in a sentence, and the command that takes it."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import dampyr as dp
from dampyr.cli import cli
from dampyr.errors import FileError, MissingData
from dampyr.structures import SupportMotions, load, read_supports, respond

TABLE = "time [s],W [g],E [m/s^2]\n" + "".join(
    f"{0.01 * k:.2f},{np.sin(k / 9):.6f},{np.cos(k / 7):.6f}\n" for k in range(300)
)
MOTIONS = """
[west]
file = "quake.csv"
columns = { acceleration = "W [g]" }
scale = 0.5

[east]
file = "quake.csv"
columns = { acceleration = "E [m/s^2]" }
delay = "200 ms"
"""
BRIDGE = """
name = "bridge"
M = ["20 t", "20 t"]
K = { unit = "MN/m", values = [[9, -4, -5, 0], [-4, 11, 0, -7], [-5, 0, 5, 0], [0, -7, 0, 7]] }
damping_ratio = 0.02
supports = ["west", "east"]
"""
LOADS = 'name = "blow"\ntime = [0, "10 ms", "20 ms", 1]\n[forces]\n2 = [0, "50 kN", 0, 0]\n'


def told(done: Result) -> dict[str, list[float]]:
    """The only case of a response."""
    (case,) = json.loads(done.stdout).values()
    return case


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, text in {"quake.csv": TABLE, "piers.toml": MOTIONS, "bridge.toml": BRIDGE, "blow.toml": LOADS}.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def test_the_motions_are_those_of_the_tables(folder: Path) -> None:
    motions = read_supports(folder / "piers.toml")
    values = np.loadtxt(folder / "quake.csv", delimiter=",", skiprows=1)
    west, east = motions.motions["west"], motions.motions["east"]
    np.testing.assert_allclose(west.acceleration, np.pad(0.5 * 9.80665 * values[:, 1], (0, 20)), rtol=1e-12)
    np.testing.assert_allclose(east.acceleration, np.pad(values[:, 2], (20, 0)), rtol=1e-12)
    assert (motions.dt, motions.n, motions.name) == (0.01, 320, "piers")


def test_a_motion_by_its_name(folder: Path) -> None:
    (folder / "two.toml").write_text('west = { motion = "el_centro" }\neast = { motion = "el_centro", delay = 0.4 }')
    motions = read_supports(folder / "two.toml", "two piers")
    assert (motions.name, motions.n) == ("two piers", dp.ground_motions.el_centro().n + 20)


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ("scale = 0.5", "factor = 0.5", "west.factor is not known"),
        ("scale = 0.5", 'scale = "1 mm"', "west.scale = '1 mm'"),
        ('columns = { acceleration = "W [g]" }\n', 'columns = { acceleration = "N" }\n', "quake.csv"),
        ('"200 ms"', '"-1 s"', "east.delay = -1"),
        (
            '"200 ms"',
            '"205 ms"',
            r"east: delay = 0.205 s is not a whole number of its motion's samples of 0.01 s; give 0.2",
        ),
        ('file = "quake.csv"\ncolumns = { acceleration = "W [g]" }', "", "west: takes either file or motion"),
        (
            'file = "quake.csv"\ncolumns = { acceleration = "W [g]" }',
            'motion = "el_centro"',
            "the motions have steps of 0.01 s, 0.02 s; resample",
        ),
        (
            'file = "quake.csv"',
            'motion = "el_centro"',
            "west: has component, columns, units or dt, which are of a file",
        ),
        ('file = "quake.csv"', 'motion = "kobe"', "west.motion = 'kobe' is not known"),
        ('file = "quake.csv"', 'file = "../quake.csv"', "west: file = '../quake.csv' leads out of the folder"),
        (MOTIONS, "", "there is no support; give each a table"),
        (MOTIONS, "west = 3", "west = 3 is not a table"),
        (MOTIONS, "[west", "is not valid TOML"),
    ],
)
def test_each_mistake_has_its_sentence(folder: Path, before: str, after: str, says: str) -> None:
    assert before in MOTIONS
    (folder / "piers.toml").write_text(MOTIONS.replace(before, after, 1))
    with pytest.raises(FileError, match=says) as problem:
        read_supports(folder / "piers.toml")
    assert "\n" not in str(problem.value)


def test_a_file_that_is_not_there(folder: Path) -> None:
    with pytest.raises(MissingData, match="there is no such file"):
        read_supports(folder / "none.toml")
    (folder / "piers.toml").write_text(MOTIONS.replace("quake.csv", "none.csv"))
    with pytest.raises(MissingData, match=r"none\.csv"):
        read_supports(folder / "piers.toml")


def test_the_command_answers_as_the_call_does(folder: Path) -> None:
    words = ["simulate", "--structure", "bridge.toml", "--without-damper", "--supports", "piers.toml"]
    done = CliRunner().invoke(cli, [*words, "--json", "--report", "page.html"])
    assert done.exit_code == 0, done.output
    bridge = load("bridge.toml")
    assert isinstance(bridge, dp.structures.Building)
    same = respond(bridge, read_supports("piers.toml"))
    assert told(done)["peak_displacement_m"] == pytest.approx(same.peak_displacement.tolist(), rel=1e-12)
    assert (folder / "page.html").is_file()
    pushed = CliRunner().invoke(cli, [*words, "--loads", "blow.toml", "--json"])
    blow = dp.structures.FloorLoads([0.0, 0.01, 0.02, 1.0], {2: [0.0, 5e4, 0.0, 0.0]})
    both = respond(bridge, read_supports("piers.toml"), loads=blow)
    assert told(pushed)["peak_displacement_m"] == pytest.approx(both.peak_displacement.tolist(), rel=1e-12)
    alone = CliRunner().invoke(cli, [*words[:-2], "--loads", "blow.toml", "--json"])
    rests = SupportMotions({name: dp.ground_motions.GroundMotion(np.zeros(101), 0.01) for name in bridge.supports})
    expected = respond(bridge, rests, loads=blow).peak_displacement
    assert told(alone)["peak_displacement_m"] == pytest.approx(expected.tolist(), rel=1e-4)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (
            ["--structure", "bridge.toml"],
            "bridge stands on several supports (west, east); give their motions with --supports",
        ),
        (["--supports", "piers.toml"], "--supports is of a structure on several supports, and"),
        (["--structure", "bridge.toml", "--supports", "piers.toml", "--scale", "2"], "--scale is of one ground motion"),
        (
            ["--structure", "bridge.toml", "--supports", "piers.toml", "--motion", "quake.csv"],
            "--motion is of one ground",
        ),
        (
            ["--structure", "bridge.toml", "--supports", "one.toml"],
            "motions are given for west; bridge stands on west, east",
        ),
        (["--structure", "bridge.toml", "--loads", "blow.toml", "--load-unit", "kN"], "here each force has its own"),
    ],
)
def test_the_command_says_what_does_not_fit(folder: Path, words: list[str], says: str) -> None:
    (folder / "one.toml").write_text('[west]\nmotion = "el_centro"')
    done = CliRunner().invoke(cli, ["simulate", "--without-damper", *words])
    assert (done.exit_code, says in done.stderr) == (2, True), done.stderr


def test_loads_in_lists(folder: Path) -> None:
    loads = dp.structures.read_loads("blow.toml")
    assert (loads.name, loads.peaks, loads.time.tolist()) == ("blow", {"2": 5e4}, [0.0, 0.01, 0.02, 1.0])
    for before, after, says in (
        ("50 kN", "50 mm", r"forces\['2'\] = '50 mm': the unit"),
        ("[forces]\n", "", "2 is not known"),
        (', "50 kN"', "", "the forces of floor 2 have shape"),
        ("10 ms", "30 ms", "time goes from 0.03 to 0.02 s"),
        ("time", "times", "times is not known; did you mean 'time'"),
    ):
        Path("wrong.toml").write_text(LOADS.replace(before, after, 1))
        with pytest.raises(FileError, match=says):
            dp.structures.read_loads("wrong.toml")
