"""A plane frame from two tables: known solutions, held to what its nodes do; each kind of mistake has its sentence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dampyr import structures
from dampyr.errors import FileError
from dampyr.structures.plane_frame import read_frame

NODES = """
node,x [mm],y [mm],mass horizontal [t],mass vertical [kg],mass rotational [kg m^2],fixed x,fixed y,fixed rotation,x follows node
1,0,0,0,0,0,1,1,1,
2,6000,0,0,0,0,1,1,1,
3,0,4000,10,1e4,0,0,0,0,
4,6000,4000,10,1e4,0,0,0,0,3
""".lstrip()
ELEMENTS = """element,node i,node j,EI [kN m^2],EA [kN],kind
1,1,3,20000,1e6,frame
2,2,4,20000,1e6,frame
3,3,4,40000,1e6,frame
"""
FILE = """
name = "portal"
nodes = "nodes.csv"
elements = "elements.csv"
floors = ["3"]
damping_ratio = 0.02
"""


def written(folder: Path, nodes: str = NODES, elements: str = ELEMENTS, text: str = FILE) -> Path:
    for name, content in (("nodes.csv", nodes), ("elements.csv", elements), ("portal.toml", text)):
        (folder / name).write_text(content, "utf-8")
    return folder / "portal.toml"


def stiffness(folder: Path) -> float:
    """Of the portal's floor, against a horizontal force."""
    frame = read_frame(folder / "nodes.csv", folder / "elements.csv")
    force = np.zeros(len(frame.labels))
    force[frame.labels.index("3 x")] = 1.0
    return float(1.0 / np.linalg.solve(frame.K, force)[frame.labels.index("3 x")])


def test_the_portal_is_that_of_the_books(tmp_path: Path) -> None:
    r"""Columns that do not stretch, k = 24 EI (6 r + 1) / (h^3 (6 r + 4)), r = EI_b h / (EI_c L)."""
    written(tmp_path, elements=ELEMENTS.replace("1e6", "1e13"))
    r = (40000.0 * 4.0) / (20000.0 * 6.0)
    expected = 24 * 20e6 / 4.0**3 * (6 * r + 1) / (6 * r + 4)
    assert stiffness(tmp_path) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("ends", ["1,2", "2,1"])
def test_a_leaning_cantilever(tmp_path: Path, ends: str) -> None:
    """A beam at any angle answers with EA/L along it and 3 EI/L^3 across it."""
    nodes = NODES.splitlines()[0] + "\n1,0,0,0,0,0,1,1,1,\n2,3000,4000,1,1000,0,0,0,0,\n"
    written(tmp_path, nodes, ELEMENTS.splitlines()[0] + f"\n1,{ends},3000,5e4,frame\n")
    frame = read_frame(tmp_path / "nodes.csv", tmp_path / "elements.csv")
    moved = np.linalg.solve(frame.K, np.eye(3)[:, :2])[:2]
    along, across = np.array([0.6, 0.8]), np.array([-0.8, 0.6])
    assert along @ moved @ along == pytest.approx(5.0 / 5e7, rel=1e-9)
    assert across @ moved @ across == pytest.approx(5.0**3 / (3 * 3e6), rel=1e-9)
    assert abs(along @ moved @ across) < 1e-18


def test_a_truss_bends_nothing(tmp_path: Path) -> None:
    written(tmp_path)
    stiff = stiffness(tmp_path)
    written(tmp_path, elements=ELEMENTS.replace("40000,1e6,frame", "40000,1e6,truss (both ends pinned)"))
    assert stiffness(tmp_path) == pytest.approx(2 * 3 * 20e6 / 4.0**3, rel=1e-9)  # two cantilevers
    assert stiff > 2 * stiffness(tmp_path)


def test_loaded_it_is_a_building(tmp_path: Path) -> None:
    loaded = structures.load(written(tmp_path))
    assert (loaded.name, loaded.floors, loaded.n) == ("portal", ("3",), 1)
    assert loaded.frequencies[0] == pytest.approx(np.sqrt(stiffness(tmp_path) / 20e3) / (2 * np.pi), rel=1e-3)
    assert loaded.damping_ratios == pytest.approx([0.02])
    double = structures.load(written(tmp_path, text=FILE + "frames = 2\n"))
    np.testing.assert_allclose(double.M, 2 * loaded.M)
    np.testing.assert_allclose(double.K, 2 * loaded.K)
    modal = structures.load(written(tmp_path, text=FILE + 'method = "modal"\n'))
    assert modal.damping_ratios == pytest.approx([0.02])


@pytest.mark.parametrize(
    ("nodes", "elements", "text", "words"),
    [
        (NODES.replace("x [mm]", "z [mm]"), ELEMENTS, FILE, r"nodes.csv: lacks x in its first line; it must name node, x, y"),
        (NODES.replace("x [mm]", "x [kg]"), ELEMENTS, FILE, r"nodes.csv: line 2: x = '0' must be a number in kg"),
        (NODES.replace("6000,4000", "far,4000"), ELEMENTS, FILE, r"nodes.csv: line 5: x = 'far' must be a number in mm"),
        (NODES.replace("0,0,0,3\n", "0,0,0,9\n"), ELEMENTS, FILE, "line 5: node 4 follows 9; it must be another node"),
        (NODES.replace("0,0,0,3\n", "0,0,2,3\n"), ELEMENTS, FILE, "line 5: fixed rotation = '2' must be 1 or 0"),
        (NODES.replace("\n4,", "\n3,"), ELEMENTS, FILE, "line 5: node 3 is given twice"),
        (NODES.replace("10,1e4", "-10,1e4", 1), ELEMENTS, FILE, "line 4: mass horizontal = -10000 is negative"),
        (NODES, ELEMENTS.replace("3,3,4", "3,3,7"), FILE, "elements.csv: line 4: node 7 is not in nodes.csv"),
        (NODES, ELEMENTS.replace("3,3,4", "3,3,3"), FILE, "elements.csv: line 4: its length must be more than 0"),
        (NODES, ELEMENTS.replace("frame\n3", "beam\n3"), FILE, "line 3: kind 'beam' is not known; write frame or truss"),
        (NODES, ELEMENTS.replace(",frame\n3", "\n3"), FILE, "line 3 has 5 cells; it must have 6"),
        (NODES, ELEMENTS, FILE.replace('["3"]', '["4"]'), "portal.toml: floor '4' is not a node with a mass that is free in x"),
        (NODES, ELEMENTS, FILE.replace('["3"]', "[]"), "a frame needs frames of at least 1, floors, and a damping_ratio"),
        (NODES, ELEMENTS, FILE.replace("nodes.csv", "absent.csv"), "absent.csv: cannot be read as a table"),
        (NODES, ELEMENTS.partition("2,2,4")[0], FILE, "what has no mass (.*4 rotation.*) is not held by springs"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_with_its_line(tmp_path: Path, nodes: str, elements: str, text: str, words: str) -> None:
    with pytest.raises(FileError, match=words) as raised:
        structures.load(written(tmp_path, nodes, elements, text))
    assert "\n" not in str(raised.value)
