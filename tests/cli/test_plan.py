"""dampyr plan: a table, a campaign file, JSON, and one line for what is wrong."""

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from tests.cli.asked_once import asked_once
from tests.planning.laboratory import DAHL

from dampyr import campaigns, planning
from dampyr.cli import cli
from dampyr.rig import RigSettings

QUICK = ("--seconds", "4", "--at", "0", "--at", "1.98", "--kind", "voltage_steps", "--tests", "2")
SMALL = ("--seconds", "4", "--at", "1.98", "--kind", "sine", "--tests", "1")


@pytest.fixture
def card(tmp_path: Path) -> Path:
    return DAHL.save(tmp_path / "damper.toml")


@pytest.fixture(scope="module")
def proposals() -> dict[str, Any]:
    """What was computed."""
    return {}


@pytest.fixture
def proposed_once(proposals: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """The quick proposal is computed once: these tests are of what is printed and written."""
    monkeypatch.setattr(planning, "propose", asked_once(planning.propose, proposals))


def plan(*arguments):
    return CliRunner().invoke(cli, ["plan", *map(str, arguments)])


def test_the_help_shows_examples():
    text = plan("--help").stdout
    assert "dampyr plan --card damper.toml --rig rig.toml --tests 6 --out next.toml" in text
    assert "dampyr plan tests --model dahl" in text


@pytest.mark.usefixtures("proposed_once")
def test_a_plan_is_a_table_and_a_campaign_that_runs(card, tmp_path):
    out = tmp_path / "next.toml"
    done = plan("--card", card, *QUICK, "--out", out, "--figure", tmp_path / "tests.png")
    assert done.exit_code == 0, done.stderr
    assert "2 tests for all parameters" in done.stdout
    assert "intervals that would be wider without it" in done.stdout
    assert f"Next: dampyr run {out}" in done.stdout
    assert campaigns.plan(campaigns.read(out), RigSettings(), DAHL).refusals == ()
    assert (tmp_path / "tests.png").stat().st_size > 10_000
    again = plan("--card", card, *QUICK, "--out", out)
    assert again.exit_code == 2
    assert "is there already; give another --out, or remove it" in again.stderr


@pytest.mark.usefixtures("proposed_once")
def test_json_holds_tests_and_intervals(card):
    done = plan("--card", card, *QUICK, "--json")
    assert done.exit_code == 0, done.stderr
    answer = json.loads(done.stdout)
    assert len(answer["tests"]) == 2
    assert answer["tests"][0]["step"]["kind"] == "voltage_steps"
    assert "dahl.rho @ 1.98 V" in answer["half_width_after"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--goal", "speed"], "goal = 'speed' is not known; choose from parameters, peak"),
        (["--goal", "peak"], "--goal peak needs the damper's --voltage in the earthquake"),
        (["--voltage", "1"], "--structure, --motion and --voltage are of --goal peak"),
        (["--target", "dahl.kz=5%", *SMALL], "target names 'dahl.kz'; choose among dahl.kx, dahl.kw, dahl.rho"),
        (["--target", "dahl.rho=small"], "--target small: 'small' is not a quantity"),
        (["--at", "9"], "voltage = 9 V is outside of 0 to 3.212 V"),
        (["--perform"], "--out is missing; give a folder for the rounds of tests"),
    ],
)
def test_what_is_wrong_is_one_line(card, arguments, words):
    done = plan("--card", card, *arguments)
    assert done.exit_code == 2
    assert words in done.stderr
    assert len(done.stderr.strip().splitlines()[-1]) > 10
    assert "Traceback" not in done.stderr
