"""What a person should look at: each thing once, the worst first."""

import json
import pickle
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.errors import FindingWarning, InputError
from dampyr.findings import OF_DAMPER, Finding, Findings, handed_on, worst_first
from dampyr.ground_motions import el_centro
from dampyr.hybrid.delayed_hybrid import delayed_result
from dampyr.models import Damper, Interpolation
from dampyr.structures import respond, two_storey


def test_the_worst_comes_first_and_everything_once() -> None:
    note, doubt, wrong = (Finding(severity, f"{severity} words") for severity in ("note", "doubt", "wrong"))
    assert worst_first([note, doubt], [doubt, wrong, note]) == (wrong, doubt, note)
    with pytest.raises(InputError, match="severity = 'bad' is not allowed; choose wrong, doubt, note"):
        Finding("bad", "words")  # type: ignore[arg-type]


def test_what_is_said_alike_of_several_records_is_one_finding_with_their_names() -> None:
    counts = {"a": 790, "b": 12, "c": 3, "d": 5, "e": 1}
    saturated = [Finding("doubt", f"force may be saturated: {n} samples", (name,)) for name, n in counts.items()]
    gap = Finding("doubt", "gap of 0.4 s at 2 s", ("b",))
    first, second = worst_first(saturated, [gap])
    assert str(first) == "a: force may be saturated: 790 samples; likewise b, c, d and 1 more"
    assert first.about == tuple(counts)
    assert second is gap


def test_findings_are_made_when_they_are_looked_at_and_travel_as_a_tuple() -> None:
    calls = []
    later = Findings(lambda: calls.append(1) or [Finding("note", "words")])  # type: ignore[func-returns-value]
    assert not calls
    assert pickle.loads(pickle.dumps(later)) == (Finding("note", "words"),)
    assert (len(later), later[0].words, len(calls)) == (1, "words", 1)


@dataclass
class Result:
    findings: Sequence[Finding]


def test_what_differs_in_more_than_numbers_is_not_merged() -> None:
    """Both begin alike, up to a number; and lists, and one sample or many, are said alike."""
    mean = "at 0 V the residual's mean differs between the directions"
    variance = "at 0, 1.98 V, 15 to 35 % of the residual's variance does not change its sign"
    some = [Finding("doubt", words, (name,)) for name, words in (("a", mean), ("a", variance), ("b", variance))]
    assert [(one.words, one.about) for one in worst_first(some)] == [(mean, ("a",)), (variance, ("a", "b"))]
    alike = ["force has 1 false sample, it seems: at 2.5 s", "force has 2 false samples, it seems: at 2.5, 4.5 s"]
    assert len({Finding("doubt", words).kind for words in alike}) == 1


def test_cases_that_leave_different_limits_say_each_its_own() -> None:
    laws = {"dahl.kx": 900.0, "dahl.kw": Interpolation((0.0, 3.0), (50.0, 600.0)), "dahl.rho": 2500.0}
    damper = Damper("dahl", laws, ranges={"displacement": (0.0, 0.012), "velocity": (0.0, 0.05)})
    with pytest.warns(FindingWarning):
        result = respond(two_storey(), el_centro(), damper, voltage=[0.0, 3.0])
    said = {name: response.doubts for name, response in result.cases.items() if response.sites}
    assert len(said["0 V"]) > len(said["3 V"]) > 0  # only the velocity leaves its range with the strong damper
    assert {str(one) for one in result.findings} == {
        f"{name}: {words}" for name, some in said.items() for words in some
    }


def test_what_matters_is_handed_on_with_its_source_and_notes_stay_behind() -> None:
    wrong, note = Finding("wrong", "loops create 2 J", ("a",)), Finding("note", "good to know")
    doubt = Finding("doubt", "force may be saturated: 12 samples", ("b",))
    assert handed_on([Result([note, doubt]), Result([wrong])]) == (wrong, doubt)
    of_damper = handed_on([Result([doubt, note])], OF_DAMPER)
    assert [str(one) for one in of_damper] == ["the damper's fit: b: force may be saturated: 12 samples"]
    assert handed_on([Result(of_damper)], "another") == of_damper  # who said it first is named


def test_what_is_said_of_the_same_record_besides_is_not_handed_on_too() -> None:
    of_card = Finding("doubt", "force may be saturated: 12 samples", ("b",))
    same, other = (Finding("doubt", "force may be saturated: 3 samples", (name,)) for name in ("b", "c"))
    assert handed_on([Result([of_card])], OF_DAMPER, besides=[same]) == ()
    assert len(handed_on([Result([of_card])], OF_DAMPER, besides=[other])) == 1
    assert len(worst_first([replace(of_card, source=OF_DAMPER)], [same])) == 2  # a damper's and a record's are two


def test_a_finding_is_read_as_a_sentence_and_comes_back_from_its_table() -> None:
    plain, named = Finding("note", "good to know"), Finding("doubt", "gap of 0.4 s", ("rec",), OF_DAMPER)
    assert plain.sentence == "Good to know."
    assert replace(named, source="").sentence == "rec: gap of 0.4 s."  # the name of a record keeps its letters
    assert named.sentence == "The damper's fit: rec: gap of 0.4 s."
    question = Finding("wrong", "its loops create 2 J; force sign inverted?", ("rec",))
    assert question.sentence == "rec: its loops create 2 J; force sign inverted?"  # and no full stop after its mark
    for one in (plain, named):
        assert Finding.from_dict(json.loads(json.dumps(one.as_dict()))) == one
    assert plain.as_dict() == {"severity": "note", "words": "good to know"}


@pytest.fixture(scope="module")
def card(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A damper in doubt, calibrated on a tenth of a millimetre."""
    laws = {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0}
    doubt = Finding("doubt", "force may be saturated: 12 samples", ("rec",))
    damper = Damper("dahl", laws, ranges={"displacement": (0.0, 1e-4)}, findings=(doubt, Finding("note", "quiet")))
    return damper.save(tmp_path_factory.mktemp("card") / "card.toml")


def test_a_response_has_the_doubts_of_its_damper_and_its_own_and_warns_of_these(card: Path) -> None:
    with pytest.warns(FindingWarning, match="it was calibrated up to 0.0001 m"):
        response = respond(two_storey(), el_centro(), {1: Damper.load(card)}, voltage=0.0)
    first, second = response.findings
    assert str(first) == "the damper's fit: rec: force may be saturated: 12 samples"
    assert second.words == response.doubts[0]
    assert response.as_dict()["findings"] == [first.as_dict(), second.as_dict()]
    assert response.to_xarray().attrs["findings"] == [str(first), str(second)]
    assert "look at" in repr(response)
    assert "and 1 more finding" in repr(response)


def test_the_command_says_each_once_below_its_table(card: Path) -> None:
    words = ["simulate", str(card), "--voltage", "0", "--voltage", "1"]
    done = CliRunner().invoke(cli, words, catch_exceptions=False)
    assert "it was calibrated up to" not in done.stderr
    text = " ".join(done.stdout.split())
    assert text.count("it was calibrated up to 0.0001 m") == 1  # a damper without input: the same in both cases
    assert text.count("force may be saturated: 12 samples") == 1
    assert "quiet" not in text


@pytest.mark.prove
def test_a_hybrid_test_has_the_doubts_of_its_damper(card: Path) -> None:
    with pytest.warns(FindingWarning):
        result = delayed_result(two_storey(), el_centro(), Damper.load(card), 0.001)
    assert [one.source for one in result.findings] == [OF_DAMPER, ""]
    assert result.as_dict()["findings"] == [one.as_dict() for one in result.findings]
