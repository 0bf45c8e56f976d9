"""``--temperature``: a card whose laws depend on it, where a building or another tool needs one damper."""

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from dampyr.cli import cli
from dampyr.models import Constant, Damper, Interpolation, WithTemperature

COLD, WARM = 15.0, 45.0  # degC


def run(*args: str | Path) -> Result:
    return CliRunner().invoke(cli, [str(arg) for arg in args], catch_exceptions=False)


@pytest.fixture
def card(tmp_path: Path) -> Path:
    inputs = (0.0, 2.0)
    laws = {
        "dahl.kx": WithTemperature(
            Interpolation(inputs, (900.0, 2700.0)), Interpolation(inputs, (500.0, 1500.0)), (COLD, WARM)
        ),
        "dahl.kw": Constant(300.0, 0.0, 2.0),
        "dahl.rho": Constant(9000.0, 0.0, 2.0),
    }
    return Damper("dahl", laws).save(tmp_path / "card.toml")


def test_a_building_feels_a_warm_damper_less(card: Path) -> None:
    peaks = []
    for temperature in ("15", "45"):
        shown = run("simulate", card, "--voltage", "2", "--temperature", temperature, "--json")
        assert shown.exit_code == 0, shown.stderr
        peaks.append(shown.stdout)
    assert peaks[0] != peaks[1]


def test_without_one_nothing_is_guessed(card: Path, tmp_path: Path) -> None:
    words = "depend on its temperature; give --temperature from 15 to 45, in °C"
    for args in (
        ("simulate", card, "--voltage", "2"),
        ("ensemble", card, "--voltage", "2"),
        ("export", card, "--to", "c"),
    ):
        refused = run(*args)
        assert refused.exit_code == 2
        assert words in " ".join(refused.stderr.split())
    refused = run("simulate", card, "--voltage", "2", "--temperature", "60")
    assert refused.exit_code == 2
    assert "60 °C is outside the calibrated temperatures 15 to 45 °C" in " ".join(refused.stderr.split())
    written = run("export", card, "--to", "c", "--temperature", "30", "--out", tmp_path)
    assert written.exit_code == 0, written.stderr
    assert (tmp_path / "damper.c").exists()


def test_where_nothing_depends_on_it_it_is_refused() -> None:
    refused = run("simulate", "--voltage", "2", "--temperature", "30")
    assert refused.exit_code == 2
    assert "no parameter of this damper depends on its temperature; leave out --temperature" in refused.stderr
