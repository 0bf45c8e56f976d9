"""A structure from its TOML file: storeys or matrices, in any unit; each kind of mistake has its sentence."""

from pathlib import Path

import numpy as np
import pytest

import dampyr as dp
from dampyr.errors import FileError, MissingData

STOREYS = """
name = "three storeys"
masses = ["1 t", "1000 kg", 800]
stiffnesses = ["2 kN/mm", "2000 kN/m", 1.5e6]
damping_ratio = 0.02
"""
MATRICES = """
M = ["1 t", 1000]
K = { unit = "kN/m", values = [[3000, -1000], [-1000, 1000]] }
damping_ratio = [0.03, 0.05]
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "structure.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_storeys_are_the_shear_building(tmp_path: Path) -> None:
    loaded = dp.structures.load(written(tmp_path, STOREYS))
    same = dp.structures.shear_building([1000.0, 1000.0, 800.0], [2e6, 2e6, 1.5e6], damping_ratio=0.02)
    assert loaded.name == "three storeys"
    for letter in "MCK":
        np.testing.assert_allclose(getattr(loaded, letter), getattr(same, letter), rtol=1e-12)


def test_dashpots_modes_and_method(tmp_path: Path) -> None:
    text = STOREYS.replace("damping_ratio = 0.02", 'dashpots = ["2 N s/mm", 1000, 500]')
    assert dp.structures.load(written(tmp_path, text)).C[0, 0] == pytest.approx(3000.0)
    modal = dp.structures.load(written(tmp_path, STOREYS + 'method = "modal"'))
    np.testing.assert_allclose(modal.damping_ratios, 0.02)
    chosen = dp.structures.load(written(tmp_path, STOREYS.replace("0.02", "[0.02, 0.03]") + "modes = [1, 3]"))
    np.testing.assert_allclose(chosen.damping_ratios[[0, 2]], [0.02, 0.03])


def test_matrices_with_modal_ratios(tmp_path: Path) -> None:
    loaded = dp.structures.load(written(tmp_path, MATRICES))
    np.testing.assert_allclose(loaded.M, np.diag([1000.0, 1000.0]))
    np.testing.assert_allclose(loaded.K, [[3e6, -1e6], [-1e6, 1e6]])
    np.testing.assert_allclose(loaded.damping_ratios, [0.03, 0.05])


def test_matrices_with_their_own_damping_labels_and_influence(tmp_path: Path) -> None:
    text = MATRICES.replace("damping_ratio = [0.03, 0.05]", 'C = [["4 N s/mm", -1000], [-1000, 1000]]')
    loaded = dp.structures.load(written(tmp_path, text + 'floors = ["low", "high"]\ninfluence = [1.0, 0.5]'))
    np.testing.assert_allclose(loaded.C, [[4000.0, -1000.0], [-1000.0, 1000.0]])
    assert loaded.floors == ("low", "high")
    np.testing.assert_allclose(loaded.influence, [1.0, 0.5])


def test_the_structure_can_be_shaken(tmp_path: Path) -> None:
    response = dp.structures.respond(dp.structures.load(written(tmp_path, STOREYS)), dp.ground_motions.el_centro())
    assert 1e-3 < response.peak_drift[0] < 1.0


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ("M =", "mass =", "mass is not known; did you mean 'masses'?"),
        ("damping_ratio", "damping_ratios", "did you mean 'damping_ratio'?"),
        ("K = {", "stiffnesses = [1.0]\nK = {", "stiffnesses belong to storeys and K, M to matrices"),
        ('M = ["1 t", 1000]', "", "M is missing; give it in kg"),
        ('"1 t"', '"1 mm"', r"M\[1\] = '1 mm': the unit 'mm' does not measure what 'kg' measures"),
        ('"1 t"', "true", r"M\[1\] = True must be a number in kg"),
        ('"1 t"', "-1000", "M has the eigenvalue -1000"),
        ("kN/m", "kN/parsnip", "unknown unit 'kN/parsnip'"),
        ("unit =", "units =", "K.units is not known; did you mean 'unit'?"),
        (', values = [[3000, -1000], [-1000, 1000]]', "", "K.values is missing"),
        ("[3000, -1000]", "[3000]", "K has 2 rows of 1, 2 numbers; it must be square"),
        ("[3000, -1000]", "[3000, -900]", "K is not symmetric"),
        ("[3000, -1000]", "[1000, -1000]", "K is not positive definite"),
        ("[3000, -1000]", "[100, -1000]", "K has the eigenvalue"),
        ("[3000, -1000], [-1000, 1000]", "[3000]", "differ in size"),
        ("damping_ratio = [0.03, 0.05]", "", "either C or damping_ratio"),
        ("[0.03, 0.05]", "[0.03, 0.05, 0.05]", "3 damping ratios are given"),
        ("[0.03, 0.05]", "[0.03, 1.5]", "damping_ratio = 1.5 is not allowed"),
        ("[0.03, 0.05]", '0.03\nmethod = "modl"', "did you mean 'modal'?"),
        ("[0.03, 0.05]", '0.03\nmethod = "rayleigh"\nmodes = [1]', "must be two modes"),
        ("M =", "M ", "is not valid TOML"),
    ],
)  # fmt: skip
def test_each_mistake_has_its_sentence(tmp_path: Path, before: str, after: str, says: str) -> None:
    assert before in MATRICES
    path = written(tmp_path, MATRICES.replace(before, after))
    with pytest.raises(FileError, match=says) as problem:
        dp.structures.load(path)
    assert str(problem.value).startswith(str(path))


def test_mistakes_of_storeys(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="3 masses and 2 stiffnesses"):
        dp.structures.load(written(tmp_path, STOREYS.replace(", 1.5e6", "")))
    with pytest.raises(FileError, match="masses = '1 N'"):
        dp.structures.load(written(tmp_path, STOREYS.replace("1 t", "1 N")))
    with pytest.raises(FileError, match="there is no structure; give masses"):
        dp.structures.load(written(tmp_path, 'name = "nothing"'))
    with pytest.raises(MissingData, match="there is no such file"):
        dp.structures.load(tmp_path / "absent.toml")


SECRET = "root:x:0:0:root:/root:/bin/bash"


@pytest.mark.parametrize("where", ["absolute", "above", "link"])
@pytest.mark.parametrize("kind", ["matrix", "frame"])
def test_only_files_of_its_own_folder_are_read(kind: str, where: str, tmp_path: Path) -> None:
    """And no message repeats what another file holds."""
    folder, outside = tmp_path / "lab", tmp_path / "secret.csv"
    folder.mkdir()
    outside.write_text(SECRET)
    if where == "link":
        (folder / "link.csv").symlink_to(outside)
    name = {"absolute": str(outside), "above": "../secret.csv", "link": "link.csv"}[where]
    text = (
        f'M = {{ file = "{name}" }}\nK = [1.0]\ndamping_ratio = 0.02\n'
        if kind == "matrix"
        else f'nodes = "{name}"\nelements = "{name}"\nfloors = ["1"]\ndamping_ratio = 0.02\n'
    )
    with pytest.raises(FileError, match=r"leads out of the folder of the structure; .*copy the file there") as caught:
        dp.structures.load(written(folder, text))
    assert "root" not in str(caught.value).replace(str(tmp_path), "")


@pytest.mark.parametrize(
    ("content", "place"), [("1 2\n3 " + SECRET, "row 2, column 2"), ("1 2\n3\n", "row 2"), (SECRET, "row 1, column 1")]
)
def test_a_file_that_is_no_matrix_is_refused_without_what_it_holds(content: str, place: str, tmp_path: Path) -> None:
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "m.txt").write_text(content)
    with pytest.raises(FileError, match=f"m.txt: is not a matrix of numbers, see {place}; give text") as caught:
        dp.structures.load(written(tmp_path, 'M = { file = "below/m.txt" }\nK = [1.0]\ndamping_ratio = 0.02\n'))
    assert "root:x" not in str(caught.value)


def test_the_first_line_of_a_file_that_is_no_table_is_not_repeated(tmp_path: Path) -> None:
    (tmp_path / "n.csv").write_text(SECRET)
    text = 'nodes = "n.csv"\nelements = "n.csv"\nfloors = ["1"]\ndamping_ratio = 0.02\n'
    with pytest.raises(FileError, match=r"n.csv: lacks .* in its first line; it must name node") as caught:
        dp.structures.load(written(tmp_path, text))
    assert "root:x" not in str(caught.value)
