"""What a person should look at: each thing once, the worst first."""

import pickle

import pytest

from dampyr.errors import InputError
from dampyr.findings import Finding, Findings, worst_first


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
