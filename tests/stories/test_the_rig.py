"""From the simulated rig to parameters: the forty tests of the dissertation, recorded and identified by two commands."""

import time
from pathlib import Path

import pytest
from click.testing import CliRunner

from dampyr import identification, records
from dampyr.campaigns import read_journal
from dampyr.cli import cli
from dampyr.rig.specimen import original_specimen
from tests.endurance import Endurance

pytestmark = pytest.mark.prove

ROOT = Path(__file__).parents[2]
MODEL = "hyperbolic_tangent + spring + offset"


def run(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(cli, list(arguments), standalone_mode=False)
    code = result.exception.code if isinstance(result.exception, SystemExit) else result.exit_code
    return int(code or 0), result.output


def test_three_tests_and_their_fit(tmp_path: Path) -> None:
    code, output = run("run", str(ROOT / "examples/quick_campaign.toml"), "--out", str(tmp_path / "out"), "--json")
    assert code == 0, output
    assert {test.state for test in read_journal(tmp_path / "out")[0]} == {"complete"}
    card = tmp_path / "card.toml"
    code, output = run("identify", str(tmp_path / "out"), "--model", MODEL, "--save", str(card))
    assert code == 0, output
    assert card.is_file()


@pytest.mark.by_hand  # the demonstration is a campaign of 22 tests like it
@pytest.mark.endure
def test_the_forty_tests_faster_than_real_time_and_their_parameters(tmp_path: Path, endurance: Endurance) -> None:
    """Tables 4.2 to 4.5 on the default simulated rig; the specimen's parameters come back.

    Of 24 intervals of 95 %, 1.2 miss by chance. What the encoder's steps and the 70 Hz of the velocity leave comes on top: it
    is below 1.5 % of every parameter (most: below 0.3 %), and moves a few of them out of intervals that are narrower still.
    """
    begun = time.monotonic()
    code, output = run("run", str(ROOT / "examples/campaign.toml"), "--out", str(tmp_path / "out"), "--json")
    took = time.monotonic() - begun
    assert code == 0, output[-2000:]
    campaign = records.read_campaign(tmp_path / "out")
    assert len(campaign) == 40
    assert sorted({record.voltage for record in campaign}) == [0.0, 0.8712, 1.98, 3.212]
    recorded = sum(float(record.time[-1] - record.time[0]) for record in campaign)
    endurance.report("forty tests on a simulated rig", None, f"{recorded:.0f} s recorded in {took:.0f} s")
    if endurance.full:  # a busy machine takes longer
        assert took < recorded
    fit = identification.fit(campaign, MODEL)
    assert fit.converged
    laws, outside, intervals = original_specimen().all_laws, [], fit.intervals()
    for label, value in fit.parameters.items():
        name, _, volts = label.removesuffix(" V").partition(" @ ")
        truth = float(laws[name](float(volts)))
        assert value == pytest.approx(truth, rel=0.015), label
        low, high = intervals[label]
        if not low <= truth <= high:
            outside.append(label)
    assert len(outside) <= 5, outside
