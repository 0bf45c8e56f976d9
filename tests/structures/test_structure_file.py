"""A structure from its TOML file: storeys or matrices, in any unit; each kind of mistake has its sentence."""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.signal import StateSpace, lsim
from tests.structures.test_torsion import by_centre_and_turn

import dampyr as dp
from dampyr.errors import FileError, InputError, MissingData

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


TURNING = """
name = "plan"
masses = ["20 t", "16 t"]
inertias = ["400 t m^2", 2.6e5]
centres = ["40 cm", -0.3]
damping_ratio = 0.03
frames = [
  { position = "-5 m", stiffnesses = ["6 kN/mm", 5e6] },
  { position = 1.0, stiffnesses = [4e6, 3e6] },
  { position = 6, stiffnesses = [9e6, 7e6] },
]
"""
BRIDGE = """
name = "bridge"
M = ["20 t", "20 t"]
K = { unit = "MN/m", values = [[9, -4, -5, 0], [-4, 11, 0, -7], [-5, 0, 5, 0], [0, -7, 0, 7]] }
C = { unit = "kN s/m", values = [[36, -16], [-16, 44]] }
supports = ["west", "east"]
"""


def test_floors_that_turn_are_the_building_of_python_and_of_its_frames(tmp_path: Path) -> None:
    loaded = dp.structures.load(written(tmp_path, TURNING))
    frames = {-5.0: [6e6, 5e6], 1.0: [4e6, 3e6], 6.0: [9e6, 7e6]}
    same = dp.structures.torsional_building([2e4, 1.6e4], [4e5, 2.6e5], frames, [0.4, -0.3], damping_ratio=0.03)
    assert type(loaded) is type(same)
    assert (loaded.floors, loaded.lines, loaded.name) == (same.floors, (-5.0, 6.0), "plan")
    for letter in "MCK":
        np.testing.assert_allclose(getattr(loaded, letter), getattr(same, letter), rtol=1e-12)
    M, K = by_centre_and_turn()
    np.testing.assert_allclose((2 * np.pi * loaded.frequencies) ** 2, eigh(K, M, eigvals_only=True), rtol=1e-9)
    across = dp.structures.load(
        written(tmp_path, TURNING + 'torsional_stiffness = "5 MN m/rad"\nlines = [-6.0, "6 m"]')
    )
    M, K = by_centre_and_turn(5e6)
    np.testing.assert_allclose((2 * np.pi * across.frequencies) ** 2, eigh(K, M, eigvals_only=True), rtol=1e-9)
    assert across.lines == (-6.0, 6.0)


def test_several_supports_answer_as_scipy_has_them(tmp_path: Path) -> None:
    """x = q + R y: the whole with its supports in absolute displacements, integrated by scipy."""
    bridge = dp.structures.load(written(tmp_path, BRIDGE))
    assert (bridge.supports, bridge.n) == (("west", "east"), 2)
    t = 0.01 * np.arange(400)
    a = np.array([np.sin(7 * t) * np.exp(-t), np.where(t > 0.4, np.sin(5 * (t - 0.4)), 0.0)])
    motions = {
        name: dp.ground_motions.GroundMotion(row, 0.01, name) for name, row in zip(bridge.supports, a, strict=True)
    }
    response = dp.structures.respond(bridge, dp.structures.SupportMotions(motions), step=0.01)
    K = 1e6 * np.array([[9, -4, -5, 0], [-4, 11, 0, -7]], dtype=float)
    C, R = 1e3 * np.array([[36, -16], [-16, 44]], dtype=float), -np.linalg.solve(K[:, :2], K[:, 2:])
    state = np.block([[np.zeros((2, 2)), np.eye(2)], [-K[:, :2] / 2e4, -C / 2e4]])
    system = StateSpace(state, np.vstack([np.zeros((2, 2)), -R]), np.eye(4)[:2], np.zeros((2, 2)))
    _, q, _ = lsim(system, a.T, t)
    np.testing.assert_allclose(response.displacement.T, q, atol=1e-9 * np.abs(q).max())


def test_ratios_of_a_structure_on_supports_are_those_of_its_floors(tmp_path: Path) -> None:
    text = BRIDGE[: BRIDGE.index("C =")] + 'supports = ["west", "east"]\ndamping_ratio = [0.02, 0.04]'
    np.testing.assert_allclose(dp.structures.load(written(tmp_path, text)).damping_ratios, [0.02, 0.04])
    rayleigh = dp.structures.load(written(tmp_path, text.replace("[0.02, 0.04]", '0.03\nmethod = "rayleigh"')))
    np.testing.assert_allclose(rayleigh.damping_ratios, 0.03)


def held_in_files() -> dict[str, dp.structures.Building]:
    K = 1e6 * np.array([[9.1, -4, -5.1, 0], [-4, 11, 0, -7], [-5.1, 0, 5.1, 0], [0, -7, 0, 7]])
    frames = {-5.0: [6e6, 5e6], 1.0: [4e6, 3e6], 6.0: [9e6, 7e6]}
    return {
        "storeys": dp.structures.shear_building([150.0, 140.0, 120.0], [140e3, 110e3, 80e3], damping_ratio=0.03),
        "influence": dp.structures.Building(
            np.diag([2.0, 3.0]), np.zeros((2, 2)), [[3e3, -1e3], [-1e3, 1.1e3]], "two", ["low", "high"], [1.0, 0.3]
        ),
        "turning": dp.structures.torsional_building(
            [2e4, 1.6e4], [4e5, 2.6e5], frames, [0.4, -0.3], damping_ratio=0.03, names=("a", "b")
        ),
        "supports": dp.structures.with_supports(
            np.diag([2e4, 1.9e4]), 0.004 * K, K, ("west", "east"), ("deck", "roof")
        ),
    }


@pytest.mark.parametrize("kind", ["storeys", "influence", "turning", "supports"])
def test_what_was_saved_answers_the_same_numbers_to_the_last_bit(kind: str, tmp_path: Path) -> None:
    building = held_in_files()[kind]
    again = dp.structures.load(dp.structures.save(building, tmp_path / "saved.toml"))
    assert (type(again), again.name, again.floors) == (type(building), building.name, building.floors)
    assert again.floors_below == building.floors_below
    quake = dp.ground_motions.el_centro()
    short = quake.changed(quake.acceleration[:200], "its begin")
    motion = dp.structures.SupportMotions({"west": short, "east": short.scaled(0.7)}) if kind == "supports" else short
    damper = dp.studies.raminelli_2020.damper()
    dampers = None if kind == "supports" else {1: damper}
    before, after = (
        dp.structures.respond(b, motion, dampers, **({} if dampers is None else {"voltage": 1.0}))
        for b in (building, again)
    )
    for name in ("displacement", "velocity", "acceleration"):
        np.testing.assert_array_equal(getattr(before, name), getattr(after, name))
    if kind == "turning":
        np.testing.assert_array_equal(again.rotation, building.rotation)
        np.testing.assert_array_equal(again.centres, building.centres)


def test_what_a_file_would_not_keep_is_not_saved(tmp_path: Path) -> None:
    tall = dp.structures.shear_building([1e3] * 4, [1e6] * 4, damping_ratio=0.02)
    with pytest.warns(dp.errors.DampyrWarning):
        small = tall.condensed([2, 4])
    car = dp.structures.half_car(580.0, 900.0, 1.2, 1.4, 45.0, 18e3, 190e3, 300.0)
    for building in (small, car):
        with pytest.raises(InputError, match="of which a file would not keep everything; save the structure that"):
            dp.structures.save(building, tmp_path / "saved.toml")
    with pytest.raises(InputError, match="can move without a spring"):
        dp.structures.save(dp.structures.Building([[1.0]], [[0.0]], [[0.0]]), tmp_path / "saved.toml")
    assert not (tmp_path / "saved.toml").exists()
    with pytest.raises(FileError, match="cannot be written"):
        dp.structures.save(tall, tmp_path / "none" / "saved.toml")


@pytest.mark.parametrize(
    ("text", "before", "after", "says"),
    [
        (TURNING, "inertias", "inertia", "inertia is not known; did you mean 'inertias'"),
        (TURNING, 'inertias = ["400 t m^2", 2.6e5]', "inertias = [4e5]", "2 masses and 1 inertias do not match"),
        (TURNING, "400 t m^2", "400 t m", "inertias = '400 t m': the unit"),
        (TURNING, 'position = "-5 m"', 'position = "-5 kg"', "frames.position = '-5 kg': the unit"),
        (TURNING, 'position = "-5 m", ', "", "frames.position is missing"),
        (TURNING, "position = 1.0", "position = 6.0", "two frames stand at one position; add their stiffnesses up"),
        (TURNING, "[4e6, 3e6]", "[4e6, 3e6, 2e6]", "the frame at 1.0 m"),
        (TURNING, "damping_ratio = 0.03", 'lines = [1, 1]', "give two different positions in m"),
        (TURNING, "damping_ratio = 0.03", 'names = ["one"]', "must be two names"),
        (TURNING, TURNING[TURNING.index("frames"):], "", "frames is missing"),
        (TURNING, TURNING[TURNING.index("frames"):], "frames = 3", "frames = 3 must be a table"),
        (BRIDGE, '"east"]', '"east", "mid", "far"]', "K has 4 rows for 4 supports"),
        (BRIDGE, '"east"]', '"west"]', "give different names"),
        (BRIDGE, '"east"]', '"east"]\nkeep = [1]', "keep is not of a structure on several supports"),
        (BRIDGE, '"east"]', '"east"]\ninfluence = [1, 1]', "influence is not of a structure on several supports"),
        (BRIDGE, 'supports = ["west", "east"]', "below = [0, 0]", "below belongs to a structure on several supports"),
        (BRIDGE, '"east"]', '"east"]\nbelow = [2, 0]', "below = "),
        (BRIDGE, '"east"]', '"east"]\nsupport_influence = [[1, 0]]', "support_influence has 1 rows of 2 numbers"),
        (BRIDGE, "[[36, -16], [-16, 44]]", "[[36]]", "C has shape"),
        (MATRICES, "M =", "lines = [1, 1]\nM =", "lines = .* must be two different positions in m"),
        (MATRICES, "M =", "lines = [1, 2]\nM =", "two degrees of freedom each and a centre in m; there are 2 and 0"),
        (MATRICES, "M =", "lines = [1, 2]\nkeep = [1]\nM =", "keep is not of floors that turn"),
    ],
)  # fmt: skip
def test_mistakes_of_floors_that_turn_and_of_supports(
    tmp_path: Path, text: str, before: str, after: str, says: str
) -> None:
    assert before in text
    path = written(tmp_path, text.replace(before, after, 1))
    with pytest.raises(FileError, match=says) as problem:
        dp.structures.load(path)
    assert str(problem.value).startswith(str(path))
    assert "\n" not in str(problem.value)
