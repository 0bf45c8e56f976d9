import json

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.structures import FloorLoads, control_law, respond, two_storey
from dampyr.structures.control_laws import describe_law, law_of
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
        pytest.param(("--between", "ground", "2"), (0, 2), "0-2", marks=pytest.mark.prove),
        pytest.param(("--between", "1", "2"), 2, "storey 2", marks=pytest.mark.prove),
    ],
)
def test_the_damper_stands_where_it_is_said(arguments, place, site):
    case = simulate(*arguments)["1.98 V"]
    expected = respond(two_storey(), el_centro(), {place: raminelli_2020.damper()}, voltage=1.98)
    assert case["sites"] == [site]
    assert case["peak_displacement_m"] == pytest.approx(expected.peak_displacement, rel=1e-9)


def test_it_goes_on_after_the_record():
    done = CliRunner().invoke(cli, ["simulate", "--voltage", "1.98", "--after", "2.5s"], catch_exceptions=False)
    text = " ".join(done.stdout.split())
    assert "The response ends 2.5 s after the record" in text
    assert "% of a peak of displacement or drift, " in text  # what the error is of, and that of the others beside it
    assert "% of acceleration, " in text
    assert simulate("--after", "2500ms")["no damper"]["after_s"] == 2.5
    assert simulate()["1.98 V"]["after_s"] == 0.0
    refused = CliRunner().invoke(cli, ["simulate", "--voltage", "1.98", "--after", "3mm"])
    assert (refused.exit_code, "the unit 'mm' does not measure what 's' measures" in refused.stderr) == (2, True)


@pytest.mark.prove
def test_a_brace_lets_the_building_move_more():
    flexible, rigid = simulate("--brace", "2e5"), simulate()
    braced = respond(two_storey(), el_centro(), {1: raminelli_2020.damper().on_brace(2e5)}, voltage=1.98)
    assert flexible["1.98 V"]["peak_displacement_m"] == pytest.approx(braced.peak_displacement, rel=1e-9)
    assert np.max(flexible["1.98 V"]["peak_drift_m"]) > 1.02 * np.max(rigid["1.98 V"]["peak_drift_m"])
    assert flexible["no damper"]["sites"] == []


def test_a_damper_in_each_of_several_storeys():
    both = simulate("--storey", "1", "--storey", "2")["1.98 V"]
    damper = raminelli_2020.damper()
    ours = respond(two_storey(), el_centro(), {1: damper, 2: damper}, voltage=1.98)
    assert both["peak_displacement_m"] == pytest.approx(ours.peak_displacement, rel=1e-9)
    assert len(both["sites"]) == 2
    twice = CliRunner().invoke(cli, ["simulate", "--voltage", "0", "--storey", "1", "--storey", "1"])
    assert "a storey is named twice (1, 1)" in twice.stderr
    assert twice.exit_code == 2


def test_one_place_is_enough():
    done = CliRunner().invoke(cli, ["simulate", "--voltage", "0", "--storey", "1", "--between", "0", "2"])
    assert done.exit_code == 2
    assert "both --storey and --between" in done.stderr


def test_the_page_names_the_floors(tmp_path):
    simulate("--between", "0", "2", "--report", str(tmp_path / "page.html"))
    assert "damper, 0-2;" in (tmp_path / "page.html").read_text(encoding="utf-8")


@pytest.mark.prove
def test_control_laws_are_cases_beside_numbers():
    cases = simulate("--control", "on_off", "--control", "clipped_optimal:lag=10ms,effort=0.1,high=3")
    names = ["no damper", "1.98 V", "on_off 0 to 3.212 V", "clipped_optimal 0 to 3 V, lag 0.01 s, effort 0.1"]
    assert list(cases) == names
    law = control_law("clipped_optimal", high=3.0, lag=0.01, effort=0.1)
    expected = respond(two_storey(), el_centro(), {1: raminelli_2020.damper()}, voltage=law)
    assert cases[names[3]]["peak_drift_m"] == pytest.approx(expected.peak_drift, rel=1e-9)
    assert cases[names[3]]["mean_input"] == pytest.approx(expected.mean_input)
    assert cases["1.98 V"]["mean_input"] == pytest.approx([1.98])


@pytest.mark.prove  # a kernel of its own is compiled
def test_weights_are_parted_by_slashes():
    cases = simulate("--control", "lyapunov:weights=1/2/3/4")
    assert list(cases)[2] == "lyapunov 0 to 3.212 V, weights (1 2 3 4)"


def test_weights_between_slashes_are_those_of_the_law():
    law = law_of("lyapunov:weights=1/2/3/4", raminelli_2020.damper())
    assert law == control_law("lyapunov", low=0.0, high=3.212, weights=(1, 2, 3, 4))
    assert describe_law(law, "V") == "lyapunov 0 to 3.212 V, weights (1 2 3 4)"


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("on_of", "is not among the control laws; did you mean 'on_off'?"),
        ("on_off:fast", "'fast' is not a setting; write it as in on_off:period=0.01,lag=0.005"),
        ("on_off:high=much", "high = 'much' of on_off is not a number"),
        ("on_off:gain=2", "'gain' is not a setting of on_off"),
        ("on_off:high=9", "9 V is outside the calibrated range 0 to 3.212 V"),
        ("lyapunov:weights=1/a", "is not numbers"),
    ],
)
def test_a_wrong_law_is_one_line(given, message):
    done = CliRunner().invoke(cli, ["simulate", "--control", given])
    assert done.exit_code == 2
    assert message in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_loads_act_alone_or_with_a_motion(tmp_path):
    table, motion = tmp_path / "wind.csv", tmp_path / "quake.csv"
    table.write_text("time [s],floor 1,floor 2\n0,0,0\n0.5,0.03,-0.06\n1,0,0\n")
    motion.write_text("time [s],acceleration [m/s^2]\n0,0\n0.02,1\n0.04,-1\n0.06,0\n")
    loads = FloorLoads([0.0, 0.5, 1.0], {"floor 1": [0.0, 30.0, 0.0], "floor 2": [0.0, -60.0, 0.0]})
    shaken = GroundMotion([0.0, 1.0, -1.0, 0.0], 0.02)
    for arguments, given in (((), None), (("--motion", str(motion)), shaken)):
        told = simulate("--loads", str(table), "--load-unit", "kN", *arguments)
        for name, damper in (("no damper", {}), ("1.98 V", {1: raminelli_2020.damper()})):
            ours = respond(two_storey(), given, damper, voltage=1.98 if damper else None, loads=loads)
            assert told[name]["peak_displacement_m"] == pytest.approx(ours.peak_displacement, rel=1e-9)
            assert told[name]["loads"]["peak_N"] == {"floor 1": 30.0, "floor 2": 60.0}
    words = ["simulate", "--voltage", "0", "--loads", str(table)]
    shown = CliRunner().invoke(cli, [*words, "--load-unit", "kN"], catch_exceptions=False).stdout
    assert "Loads on floors, wind: floor 1 peak 30 N, floor 2 peak 60 N." in " ".join(shown.split())
    for more, message in (
        ((), "the column 'floor 1' has no unit; write it in the header"),
        (
            ("--load-unit", "kN", "--scale", "2"),
            "--scale is of a ground motion, and the loads act alone; give --motion",
        ),
        (("--load-unit", "kN", "--unit", "time=ms"), "--unit is of a ground motion"),
        (("--load-unit", "mm"), "does not measure"),
    ):
        refused = CliRunner().invoke(cli, [*words, *more])
        assert (refused.exit_code, message in refused.stderr) == (2, True), refused.stderr
    refused = CliRunner().invoke(cli, ["simulate", "--voltage", "0", "--load-unit", "kN"])
    assert "--load-unit is of the table of --loads" in refused.stderr
