"""dampyr run: the dry run."""

import json
from pathlib import Path

from click.testing import CliRunner

from dampyr.cli import cli

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
BAD = '[[step]]\nkind = "sine"\namplitude = "20 mm"\nfrequency = ["0.1 Hz", "2 Hz", "3 Hz"]\n'


def run(*arguments):
    return CliRunner().invoke(cli, ["run", *map(str, arguments)])


def test_a_dry_run_prints_every_test():
    done = run(EXAMPLES / "quick_campaign.toml", "--dry-run")
    assert done.exit_code == 0
    assert "quick: 3 tests on shaking table" in done.stdout
    assert "02-sine-8mm-1Hz-1.98V" in done.stdout
    assert done.stderr == ""


def test_a_real_rig_without_a_card_is_told_that_the_force_is_not_known(tmp_path):
    (tmp_path / "rig.toml").write_text('[wires]\nserial = "COM3"\n')
    done = run(EXAMPLES / "quick_campaign.toml", "--dry-run", "--rig", tmp_path / "rig.toml")
    assert "its force is not known, a conservative envelope" in done.stdout


def test_refusals_stand_in_one_line_each(tmp_path):
    (tmp_path / "bad.toml").write_text(BAD)
    done = run(tmp_path / "bad.toml", "--dry-run")
    assert done.exit_code == 2
    lines = done.stderr.splitlines()
    assert [line.partition(":")[0] for line in lines] == ["dampyr", "dampyr"]
    assert "step 1, sine 20 mm at 2 Hz, 0 V: needs 251.3 mm/s" in lines[0]
    assert "03-sine-20mm-3Hz-0V" in done.stdout


def test_for_machines_in_si(tmp_path):
    (tmp_path / "bad.toml").write_text(BAD)
    told = json.loads(run(tmp_path / "bad.toml", "--dry-run", "--json").stdout)
    assert [test["step"]["amplitude"] for test in told["tests"]] == [0.02] * 3
    assert [bool(test["refusal"]) for test in told["tests"]] == [False, True, True]
    assert len(told["refusals"]) == 2


def test_a_seed_changes_the_order_and_no_name():
    orders = []
    for seed in ("1", "2"):
        told = json.loads(run(EXAMPLES / "every_kind.toml", "--dry-run", "--json", "--seed", seed).stdout)
        orders.append([test["name"] for test in told["tests"]])
    assert orders[0] != orders[1]
    assert sorted(orders[0]) == sorted(orders[1])


def test_a_campaign_that_is_refused_does_not_run(tmp_path):
    (tmp_path / "bad.toml").write_text(BAD)
    done = run(tmp_path / "bad.toml", "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert "needs 251.3 mm/s" in done.stderr
    assert not (tmp_path / "out").exists()
