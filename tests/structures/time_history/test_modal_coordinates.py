"""A large structure on a few floors, by modes: exact modes, a static answer that is whole, and an error that is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lsim
from tests.structures.begin_of_el_centro import short

import dampyr as dp
from dampyr import structures
from dampyr.errors import FileError
from dampyr.structures.time_history.modal_coordinates import ModalBuilding, modal_response

TALL = structures.shear_building([2e4] * 20, np.linspace(60e6, 20e6, 20), damping_ratio=0.02)
FLOORS = list(range(2, 21, 2))


def loaded(folder: Path) -> ModalBuilding:
    np.savez(folder / "tall.npz", M=np.diag(TALL.M), C=TALL.C, K=TALL.K)
    lines = [f'{letter} = {{ file = "tall.npz" }}' for letter in "MCK"]
    (folder / "tall.toml").write_text("\n".join([*lines, f"keep = {FLOORS}", 'name = "tall"']), "utf-8")
    made = structures.load(folder / "tall.toml")
    assert isinstance(made, ModalBuilding)
    return made


def test_the_modes_that_are_kept_are_exact(tmp_path: Path) -> None:
    made = loaded(tmp_path)
    assert (made.n, made.retained_modes) == (10, tuple(range(1, 9)))
    np.testing.assert_allclose(made.frequencies[:8], TALL.frequencies[:8], rtol=1e-8)
    np.testing.assert_allclose(made.damping_ratios[:8], TALL.damping_ratios[:8], rtol=1e-6)
    static = np.linalg.solve(TALL.K, TALL.M @ np.ones(20))
    np.testing.assert_allclose(
        np.linalg.solve(made.K, made.M @ made.influence), static[np.array(FLOORS) - 1], rtol=1e-9
    )
    np.testing.assert_allclose(made.recover(static[np.array(FLOORS) - 1]), static, rtol=1e-6)


def test_its_error_without_dampers_is_what_it_says(tmp_path: Path) -> None:
    """Of the modes and static answers alone: its state space on its ten floors, by scipy's exact steps, beside all of TALL."""
    made, motion = loaded(tmp_path), short(8.0)
    motion = dp.ground_motions.resampled(motion, 0.005, "linear")
    model, at = structures.state_space(made), np.array(FLOORS) - 1
    _, acceleration, z = lsim((model.A, model.E[:, None], model.C, model.F[:, None]), motion.acceleration, motion.time)
    whole = structures.respond(TALL, motion)
    drifts = [np.max(np.abs(np.diff(x, axis=0, prepend=0.0)), axis=1) for x in (z[:, :10].T, whole.displacement[at])]
    shear = made.influence @ made.M @ acceleration.T + made.ground_terms()[1] * motion.acceleration
    pairs = {
        "displacement": (np.max(np.abs(z[:, :10]), axis=0), np.max(np.abs(whole.displacement[at]), axis=1)),
        "drift": (drifts[0], drifts[1]),
        "acceleration": (np.max(np.abs(acceleration), axis=0), np.max(np.abs(whole.acceleration[at]), axis=1)),
        "base_shear": (np.max(np.abs(shear)), np.max(np.abs(whole.base_shear))),
    }
    truncation = made.truncation_errors(motion)
    for name, (mine, other) in pairs.items():
        seen = float(np.max(np.abs(mine / other - 1.0)))
        assert getattr(truncation, name) == pytest.approx(seen, abs=2e-4), name
    assert 0.0 < truncation.displacement < truncation.drift < truncation.acceleration < 0.06


def test_modes_alone_are_the_linear_response() -> None:
    motion = short(8.0)
    squares, shapes = TALL.modes()
    x, acceleration, shear = modal_response(
        shapes, squares, TALL.damping_ratios, shapes.T @ TALL.M @ np.ones(20), motion
    )
    whole = structures.respond(TALL, motion)
    np.testing.assert_allclose(x, whole.displacement, atol=1e-8 * np.max(np.abs(x)))
    np.testing.assert_allclose(acceleration, whole.acceleration, atol=1e-8 * np.max(np.abs(acceleration)))
    np.testing.assert_allclose(-shear, whole.base_shear, atol=1e-8 * np.max(np.abs(shear)))


@pytest.mark.parametrize("suffix", ["txt", "csv", "npz", "mat"])
def test_matrices_come_from_files(tmp_path: Path, suffix: str) -> None:
    from scipy.io import savemat
    from scipy.sparse import csc_matrix

    K = np.array([[3000.0, -1000.0], [-1000.0, 1000.0]])
    path = tmp_path / f"k.{suffix}"
    if suffix in ("txt", "csv"):
        np.savetxt(path, K, delimiter="," if suffix == "csv" else " ")
    elif suffix == "npz":
        np.savez(path, K=K, other=1.0)
    else:
        savemat(path, {"K": csc_matrix(K), "other": 1.0})
    np.savetxt(tmp_path / "m.txt", [1.0, 2.0])
    text = f'M = {{ file = "m.txt", unit = "t" }}\nK = {{ file = "k.{suffix}", unit = "kN/m" }}\ndamping_ratio = 0.02\n'
    (tmp_path / "one.toml").write_text(text, "utf-8")
    made = structures.load(tmp_path / "one.toml")
    np.testing.assert_allclose(made.K, 1e3 * K)
    np.testing.assert_allclose(made.M, np.diag([1000.0, 2000.0]))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('M = { file = "absent.txt" }', "absent.txt: cannot be read"),
        ('M = { file = "m.npz" }', "m.npz: holds A, B and no M; name one with M.variable"),
        ('M = { file = "m.npz", variable = "A" }', r"m.npz: holds M of shape \(2, 3\); it must be square"),
        ('M = { file = "m.npz", name = "A" }', "M.name"),
        ('M = { file = 3 }', "M.file = 3 must be a text"),
        ('M = { file = "words.txt" }', "words.txt: is not a matrix"),
        ('M = { file = "m.npz", variable = "B", unit = "m" }', "M.unit: "),
        ('M = [1, 1]\nkeep = [3]', r"keep = \[3\] must be different degrees of freedom from 1 to 2"),
        ('M = [1, 1]\nframes = 2', "frames belongs to nodes and elements"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_line(tmp_path: Path, text: str, words: str) -> None:
    np.savez(tmp_path / "m.npz", A=np.ones((2, 3)), B=np.ones(2))
    (tmp_path / "words.txt").write_text("one two\n", "utf-8")
    (tmp_path / "one.toml").write_text(text + "\nK = [[3, -1], [-1, 1]]\ndamping_ratio = 0.02\n", "utf-8")
    with pytest.raises(FileError, match=words) as raised:
        structures.load(tmp_path / "one.toml")
    assert "\n" not in str(raised.value)
