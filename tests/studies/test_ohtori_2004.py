"""The 20-storey benchmark frame: its published frequencies, and its elastic response beside that of an independent Newmark."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import dampyr as dp
from dampyr.cli import cli
from dampyr.structures.time_history.modal_coordinates import ModalBuilding
from dampyr.studies import ohtori_2004

Array = np.ndarray
HEIGHTS, MASSES = np.array(ohtori_2004.STOREY_HEIGHTS), np.array(ohtori_2004.FLOOR_MASSES)
PUBLISHED = [0.0070835, 7.37645e6, 0.304389, 0.915664]  # drift ratio, base shear N, x_max m, v_max m/s
END, STEP = 100.0, 0.01  # s


@pytest.fixture(scope="module")
def building() -> ModalBuilding:
    made = dp.studies.load_structure("ohtori_2004")
    assert isinstance(made, ModalBuilding)
    return made


@pytest.fixture(scope="module")
def el_centro(data_root: Path) -> dp.ground_motions.GroundMotion:
    path = data_root / "ground-motions" / "elcentro.dat"
    if not path.is_file():
        pytest.skip(f"data absent: no file {path}; set DAMPYR_DATA to the folder that holds the data")
    return dp.ground_motions.read(path, units="g")


def test_the_published_frequencies(building: ModalBuilding) -> None:
    """To the digits that are printed; 291 degrees of freedom."""
    assert len(building.squares) == 291
    whole = np.sqrt(building.squares) / (2 * np.pi)
    assert [f"{f:.4g}" for f in whole[:5]] == ["0.2613", "0.7526", "1.299", "1.827", "2.398"]
    np.testing.assert_allclose(building.frequencies[:5], whole[:5], rtol=1e-6)
    assert building.damping_ratios[[0, 4]] == pytest.approx([0.02, 0.02], rel=1e-5)
    assert building.n == 20
    assert building.mass_share > 0.999


def newmark(building: ModalBuilding, a: Array, h: float) -> Array:
    """Drift ratio, base shear, x_max and v_max of all modes by Newmark's average acceleration, step by step."""
    squares, ratios, push = building.squares, building.ratios, building.pushes
    damping = 2 * ratios * np.sqrt(squares)
    q, v, acceleration = np.zeros(291), np.zeros(291), -push * a[0]
    stiffness = squares + 2 * damping / h + 4 / h**2
    peaks = np.zeros(4)
    for ground in a[1:]:
        load = -push * ground + 4 / h**2 * q + 4 / h * v + acceleration + damping * (2 / h * q + v)
        new = load / stiffness
        speed = 2 / h * (new - q) - v
        q, v, acceleration = new, speed, 4 / h**2 * (new - q) - 4 / h * v - acceleration
        x = building.shapes @ q
        total = building.shapes @ acceleration + ground
        drift = np.diff(x, prepend=0.0) / HEIGHTS
        now = [np.max(np.abs(drift)), abs(MASSES @ total), np.max(np.abs(x)), np.max(np.abs(building.shapes @ v))]
        peaks = np.maximum(peaks, now)
    return peaks


def peaks_of(building: ModalBuilding, motion: dp.ground_motions.GroundMotion) -> Array:
    fine = dp.ground_motions.resampled(motion, STEP, "linear")
    response = dp.structures.respond(building, fine, after=END - fine.time[-1])
    shear = np.max(np.abs(MASSES @ response.acceleration))
    return np.array(
        [
            np.max(response.peak_drift / HEIGHTS), shear,
            np.max(response.peak_displacement), np.max(np.abs(response.velocity)),
        ]
    )  # fmt: skip


@pytest.mark.prove
def test_el_centro_is_the_limit_of_newmark(building: ModalBuilding, el_centro: dp.ground_motions.GroundMotion) -> None:
    """Within 0.1 % of what two steps of Newmark's rule, of second order, tend to."""
    limit = []
    for h in (0.005, 0.0025):
        times = np.arange(0.0, END + h / 2, h)
        limit.append(newmark(building, np.interp(times, el_centro.time, el_centro.acceleration, right=0.0), h))
    expected = limit[1] + (limit[1] - limit[0]) / 3
    mine = peaks_of(building, el_centro)
    print(mine, expected, 100 * (mine / expected - 1))
    np.testing.assert_allclose(mine, expected, rtol=1e-3)


@pytest.mark.prove
def test_el_centro_is_the_published_row(building: ModalBuilding, el_centro: dp.ground_motions.GroundMotion) -> None:
    """Within 0.6 %; the speed within 0.9 %: of this record it is 0.9238 m/s in the limit of the step."""
    mine = peaks_of(building, el_centro)
    print(mine, 100 * (mine / PUBLISHED - 1))
    np.testing.assert_allclose(mine[:3], PUBLISHED[:3], rtol=6e-3)
    np.testing.assert_allclose(mine[3], PUBLISHED[3], rtol=9e-3)


@pytest.mark.prove
def test_it_tells_its_error(building: ModalBuilding, el_centro: dp.ground_motions.GroundMotion) -> None:
    truncation = building.truncation_errors(el_centro)
    assert 0.0 < truncation.displacement < 5e-4
    assert 0.0 < truncation.drift < 4e-3
    assert truncation.drift < truncation.acceleration < 0.1


@pytest.mark.prove
def test_the_command_knows_it() -> None:
    words = ("simulate", "--structure", "ohtori_2004", "--without-damper")
    done = CliRunner().invoke(cli, words, catch_exceptions=False)
    assert done.exit_code == 0, done.output
    assert "40 coordinates for 291 degrees of freedom; beside all modes" in " ".join(done.stdout.split())
    assert "largest of 20 floors" in " ".join(done.stdout.split())
    case = json.loads(CliRunner().invoke(cli, [*words, "--json"], catch_exceptions=False).stdout)["no damper"]
    assert len(case["peak_drift_m"]) == 20
    assert 0.0 < case["truncation_error_displacement"] < case["truncation_error_drift"] < 5e-4
    assert case["truncation_error_drift"] < case["truncation_error_acceleration"] < 1e-3


@pytest.mark.prove
def test_the_study_agrees_where_the_record_allows_it(data_root: Path, el_centro: object, tmp_path: Path) -> None:
    run = ohtori_2004.reproduce(data_root, tmp_path)
    verdicts = {(value.artefact, value.quantity): value.verdict for value in run.compared}
    assert [name for name, verdict in verdicts.items() if verdict == "differs"] == [("El Centro", "largest speed")]
    assert sum(verdict == "agrees" for verdict in verdicts.values()) == 9
    assert (tmp_path / "ohtori_2004.html").is_file()


def test_the_study_without_a_record_says_what_it_left_out(tmp_path: Path) -> None:
    run = ohtori_2004.reproduce(tmp_path)
    assert sum(value.verdict == "agrees" for value in run.compared) == 5
    assert any("elcentro.dat" in omission for omission in run.left_out)
