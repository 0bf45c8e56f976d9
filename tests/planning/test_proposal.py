"""A proposal: a campaign file that runs, with what it promises; and what is refused before anything moves."""

import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.identification.synthetic import sine
from tests.planning.laboratory import DAHL

from dampyr import campaigns
from dampyr.errors import FileError, InputError
from dampyr.planning import propose
from dampyr.planning.proposal import Proposal
from dampyr.records import Record
from dampyr.rig import RigSettings
from dampyr.show.planning.proposal import envelope_figure
from dampyr.to_json import plain

QUICK = {"seconds": 4.0, "voltages": (0.0, 1.98), "kinds": ("sine", "voltage_steps")}
RIG = RigSettings()


@pytest.fixture(scope="module")
def proposal() -> Proposal:
    return propose(DAHL, RIG, tests=4, **QUICK)


def test_a_proposal_is_a_campaign_that_the_rig_can_do(proposal: Proposal, tmp_path: Path) -> None:
    path = proposal.save(tmp_path / "next.toml")
    plan = campaigns.plan(campaigns.read(path), RIG, DAHL)
    assert plan.refusals == ()
    assert [test.step for test in plan.campaign.tests] == [test.candidate.step for test in proposal.tests]
    assert plan.campaign.digest == proposal.campaign().digest
    assert tomllib.loads(proposal.text)["name"] == "planned"
    with pytest.raises(FileError, match="next"):
        proposal.save(path)


def test_a_proposal_says_what_is_expected_and_why(proposal: Proposal) -> None:
    assert set(proposal.after) >= {"dahl.kx @ 0 V", "dahl.rho @ 1.98 V"}
    assert all(0.0 < half < 1.0 for label, half in proposal.after.items() if label.startswith("dahl.kw"))
    assert "%" in proposal.tests[0].why
    assert any("no covariance" in note for note in proposal.notes)
    assert "4 of" in repr(proposal)
    assert plain(proposal.as_dict())["tests"][0]["kind"] in ("sine", "voltage_steps")
    assert envelope_figure(proposal).axes[0].get_xlabel() == "frequency [Hz]"
    of_card = propose(
        replace(DAHL, covariance=np.diag((0.01 * DAHL.coefficients) ** 2)),
        RIG,
        tests=2,
        **{**QUICK, "kinds": ("sine",)},
    )
    assert of_card.before["dahl.kw @ 0 V"] == pytest.approx(0.0196, rel=0.01)


@pytest.mark.prove
def test_no_interval_is_promised_wider_than_the_records_give_it() -> None:
    """Of laws by values a test at one voltage says nothing of the other."""
    records = [
        sine(DAHL, u, f"{u:g}V-{k}", 0.06 / (2 * np.pi * f), float(f), seconds=4.0, noise=5.0, seed=k)
        for u in (0.0, 1.98)
        for k, f in enumerate(np.geomspace(0.5, 2.0, 4))
    ]
    one = propose(records, RIG, model="dahl", laws="interpolation", tests=1, seconds=4.0, kinds=("sine",))
    (tested,) = {test.candidate.step.voltage for test in one.tests}
    for label, half in one.after.items():
        assert half <= one.before[label] * (1 + 1e-12), label
        if not label.endswith(f"@ {tested:g} V"):
            assert half == pytest.approx(one.before[label], rel=0.5)


@pytest.mark.prove
def test_laws_by_interpolation_leave_steps_of_voltage_out() -> None:
    plain_laws = propose(DAHL, RIG, tests=3, laws="interpolation", **QUICK)
    assert {test.candidate.kind for test in plain_laws.tests} == {"sine"}
    assert any("no steps of voltage" in note for note in plain_laws.notes)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"goal": "speed"}, "goal = 'speed' is not known; choose from parameters, peak"),
        ({"goal": "peak"}, "the goal peak needs a structure, a motion and a voltage"),
        ({"targets": {"dahl.kz": 0.05}}, "target names 'dahl.kz'; choose among dahl.kx, dahl.kw, dahl.rho"),
        (
            {"targets": {"dahl.rho": 5.0}},
            r"targets\['dahl.rho'\] = 5 is not allowed; it must be .* at most 1; 0.1 is 10 %",
        ),
        ({"tests": 0}, "tests = 0 is not allowed; it must be at least 1 and at most 60"),
        ({"duration": 3.0}, "duration = 3 s is shorter than the shortest candidate"),
        ({"voltages": (0.0, 5.0)}, "voltage = 5 V is outside of 0 to 3.212 V"),
        ({"peak_target": 0.1}, "the target of a peak is a share of it"),
    ],
)
def test_what_cannot_be_planned_for_is_one_line(given: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        propose(DAHL, RIG, **{"seconds": 4.0, "voltages": (1.98,), "kinds": ("sine",), **given})


@pytest.mark.prove
def test_a_proposal_says_whether_its_tests_settle_what_sessions_do() -> None:
    def records(*sessions: str | None) -> list[Record]:
        return [
            sine(DAHL, u, f"{u:g}V-{k}", 0.06 / (2 * np.pi * f), float(f), seconds=4.0).replace(
                note="of a session", measurement_session=session
            )
            for u, session in zip((0.0, 1.98), sessions, strict=True)
            for k, f in enumerate((0.5, 1.0, 2.0))
        ]

    def note(given: list[Record], **options: object) -> str:
        proposed = propose(given, RIG, model="dahl", laws="polynomial:1", seconds=4.0, **options)  # type: ignore[arg-type]
        return " ".join(proposed.notes)

    steps = {"kinds": ("voltage_steps",), "tests": 1}
    unstated = note(records(None, None), **steps)
    assert (
        "8 % (standard deviation) is assumed between sessions; these tests, made in one session, settle it" in unstated
    )
    assert "state the session of the earlier records, too (measurement_session)" in unstated
    stated = note(records("Monday", "Tuesday"), **steps)
    assert "no voltage was measured in two sessions" in stated
    assert "state the session" not in stated
    one = note(records("Monday", "Tuesday"), kinds=("sine",), tests=1)
    assert re.search(r"add a test at (0|1\.98) V to the session of these tests", one)
    assert "repeat one of these tests on another day or after a new mounting" in note(
        records("Monday", "Monday"), **steps
    )


def test_records_need_a_model_and_a_real_rig_needs_a_card() -> None:
    with pytest.raises(InputError, match="records are given without a model; name one, such as dahl"):
        propose([sine(DAHL, 0.0)], RIG)
    wired = replace(RIG, wires=replace(RIG.wires, serial="COM3"))
    with pytest.raises(InputError, match="nothing is known of the damper, not even a card"):
        propose(None, wired)
