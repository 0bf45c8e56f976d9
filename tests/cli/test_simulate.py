import json

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.ground_motions import el_centro
from dampyr.structures import respond, two_storey
from dampyr.studies import raminelli_2020


def simulate(*arguments: str) -> dict:
    done = CliRunner().invoke(cli, ["simulate", "--voltage", "1.98", "--json", *arguments], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


@pytest.mark.parametrize(
    ("arguments", "place", "site"),
    [
        ((), 1, "storey 1"),
        (("--storey", "2"), 2, "storey 2"),
        (("--between", "0", "2"), (0, 2), "0-2"),
        (("--between", "ground", "2"), (0, 2), "0-2"),
        (("--between", "1", "2"), 2, "storey 2"),
    ],
)
def test_the_damper_stands_where_it_is_said(arguments, place, site):
    told = simulate(*arguments)["1.98 V"]
    expected = respond(two_storey(), el_centro(), {place: raminelli_2020.damper()}, voltage=1.98)
    assert told["sites"] == [site]
    assert told["peak_displacement_m"] == pytest.approx(expected.peak_displacement, rel=1e-9)


def test_a_brace_lets_the_building_move_more():
    told, rigid = simulate("--brace", "2e5"), simulate()
    braced = respond(two_storey(), el_centro(), {1: raminelli_2020.damper().on_brace(2e5)}, voltage=1.98)
    assert told["1.98 V"]["peak_displacement_m"] == pytest.approx(braced.peak_displacement, rel=1e-9)
    assert np.max(told["1.98 V"]["peak_drift_m"]) > 1.02 * np.max(rigid["1.98 V"]["peak_drift_m"])
    assert told["no damper"]["sites"] == []


def test_one_place_is_enough():
    done = CliRunner().invoke(cli, ["simulate", "--voltage", "0", "--storey", "1", "--between", "0", "2"])
    assert done.exit_code == 2
    assert "both --storey and --between" in done.stderr


def test_the_page_names_the_floors(tmp_path):
    simulate("--between", "0", "2", "--report", str(tmp_path / "page.html"))
    assert "1.98 V: damper, 0-2." in (tmp_path / "page.html").read_text(encoding="utf-8")
