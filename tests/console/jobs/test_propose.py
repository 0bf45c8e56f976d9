"""The job that proposes tests, in this process: from records, for a peak, as the command writes it."""

import pytest

pytest.importorskip("fastapi")

from tests.identification.synthetic import sine

from dampyr import campaigns, planning
from dampyr.console.jobs import DATA, propose
from dampyr.console.proposals import ProposalRequest
from dampyr.console.safe_paths import OWN
from dampyr.records import write
from dampyr.studies import published_damper, raminelli_2020

FOLDER = (OWN, "jobs", "0123456789abcdef")


def test_a_proposal_from_a_damper_is_that_of_the_library(data):
    asked = {"tests": 1, "seconds": 4.0, "voltages": [1.98], "kinds": ["sine"], "targets": {"dahl.rho": 0.2}}
    request, stages = ProposalRequest(damper="raminelli_2020", **asked), []
    result = propose.run(request.model_dump(), data.joinpath(*FOLDER), lambda stage, done: stages.append(done))
    ours = planning.propose(published_damper("raminelli_2020"), **asked)
    assert result["text"] == ours.text
    assert result["notice"] == ours.origin.notice
    for words in ("--card raminelli_2020", "--target dahl.rho=20%", "--at 1.98", "--kind sine", "--seconds 4"):
        assert words in result["command"]
    (data / "next.toml").write_text(result["text"])
    assert len(campaigns.plan(data / "next.toml").tests) == len(result[DATA]["tests"]) == 1
    assert stages
    assert all(0.0 <= done <= 1.0 for done in stages)


@pytest.mark.prove
def test_a_proposal_from_records_and_for_a_peak(data):
    for k, voltage in enumerate((0.0, 1.98)):
        write(sine(raminelli_2020.damper(), voltage, f"r{k}", noise=2.0, seconds=4.0), data / f"r{k}.h5")
    request = ProposalRequest(
        records=["data/r0.h5", "data/r1.h5"],
        tests=1,
        seconds=4.0,
        voltages=[0.0, 1.98],
        kinds=["sine"],
        model="dahl",
        goal="peak",
        voltage=1.98,
        peak_target=0.02,
    )
    result = propose.run(request.model_dump(), data.joinpath(*FOLDER), lambda stage, done: None)
    assert result["intervals"]["rows"][-1][0] == "the largest drift at 1.98 V"
    assert "--goal peak" in result["command"]
    assert "--peak-target 2%" in result["command"]
