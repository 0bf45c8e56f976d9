"""``dampyr validate``: the scores of a card on records, and its forces as files."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from tests.identification.synthetic import sine

from dampyr.cli import cli
from dampyr.models import Constant, Damper
from dampyr.records import write

CARD = Damper("dahl", {"dahl.kx": Constant(900.0, 0.0, 2.0), "dahl.kw": 150.0, "dahl.rho": 3000.0})


def run(*args: str | Path) -> Result:
    return CliRunner().invoke(cli, ["validate", *map(str, args)], catch_exceptions=False)


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A card, a record of its damper, and one of a damper whose force is a tenth stronger."""
    folder = tmp_path_factory.mktemp("lab")
    CARD.save(folder / "card.toml")
    exact = sine(CARD, 1.0, "exact", offset=0.0)
    write(exact, folder / "exact.h5")
    write(exact.replace(note="stronger", name="strong", force=1.1 * exact.force), folder / "strong.h5")
    return folder


def test_the_error_is_the_part_of_the_force_that_the_card_lacks(lab: Path) -> None:
    done = run(lab / "card.toml", lab / "exact.h5", lab / "strong.h5", "--json")
    assert done.exit_code == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["scores"]["exact"]["l1"] < 1e-6
    assert answer["scores"]["strong"]["l1"] == pytest.approx(0.1 / 1.1, rel=1e-3)
    assert answer["forces"] == []


def test_forces_are_written_and_only_its_own_files_are_replaced(lab: Path, tmp_path: Path) -> None:
    forces = tmp_path / "forces"
    for _ in range(2):  # again, over its own file
        done = run(lab / "card.toml", lab / "strong.h5", "--forces", forces)
        assert done.exit_code == 0, done.stderr
        assert f"forces: 1 file in {forces}" in done.stdout
    (path,) = forces.iterdir()
    lines = [line for line in path.read_text("utf-8").splitlines() if line[:1].isdigit()]
    measured, predicted = np.array([line.split(",") for line in lines], dtype=float).T[2:]
    offset = measured - 1.1 * predicted  # the zero of the load cell that was found: one number
    assert np.ptp(offset) < 1e-4 * np.abs(measured).max()
    path.write_text("mine")
    refused = run(lab / "card.toml", lab / "strong.h5", "--forces", forces)
    assert refused.exit_code == 2
    assert path.name in refused.stderr
    assert path.read_text() == "mine"


def test_a_voltage_beyond_the_card_is_not_scored(lab: Path, tmp_path: Path) -> None:
    write(sine(CARD, 1.0, "beyond").replace(note="told", voltage=9.0), tmp_path / "beyond.h5")
    done = run(lab / "card.toml", lab / "exact.h5", tmp_path / "beyond.h5")
    assert "9 V is outside the calibrated range 0 to 2 V" in " ".join(f"{done.stdout} {done.stderr}".split())
