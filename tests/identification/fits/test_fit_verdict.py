"""A fit is good only where its search converged and its model describes the records."""

from types import SimpleNamespace

import pytest

from dampyr.identification.fits.fit_verdict import fit_verdict


def verdict_of(*l1, converged=True, reason="converged"):
    """By the misfit of each record, and how the search ended."""
    return fit_verdict({f"r{k}": SimpleNamespace(l1=value) for k, value in enumerate(l1)}, converged, reason)


@pytest.mark.parametrize(
    ("l1", "kind", "words"),
    [
        ((0.03, 0.05), "good", "misfit 4 % of the force (L1 ratio): the model describes these records."),
        (
            (0.03, 0.02, 0.02, 0.02, 0.12),
            "fair",
            "misfit 4.2 % of the force (L1 ratio), 12 % in r4: the model describes these records roughly.",
        ),
        (
            (0.35, 0.79),
            "bad",
            "misfit 57 % of the force (L1 ratio), 79 % in r1: the model does not describe these records.",
        ),
        ((0.08,), "fair", "misfit 8 % of the force (L1 ratio): the model describes this record roughly."),
        ((0.13,), "bad", "misfit 13 % of the force (L1 ratio): the model does not describe this record."),
        ((float("nan"),), "bad", "misfit without a number (L1 ratio): the model does not describe this record."),
    ],
)
def test_the_words_say_both(l1, kind, words):
    verdict = verdict_of(*l1)
    assert (verdict.kind, verdict.words) == (kind, f"The search converged; {words}")


def test_a_search_that_stopped_is_never_good():
    verdict = verdict_of(0.01, converged=False, reason="stopped after 3 steps")
    assert verdict.kind == "bad"
    assert verdict.words.startswith("The search did not converge (stopped after 3 steps); misfit 1 %")


def test_a_verdict_that_is_not_good_is_a_finding_in_the_same_words():
    assert verdict_of(0.03).findings == ()
    [fair], [bad] = verdict_of(0.08).findings, verdict_of(0.38).findings
    assert (fair.severity, bad.severity) == ("doubt", "wrong")
    assert (
        str(bad) == "the search converged; misfit 38 % of the force (L1 ratio): the model does not describe this record"
    )
