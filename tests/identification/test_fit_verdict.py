"""A fit is good only where its search converged and its model describes the records."""

from types import SimpleNamespace

import pytest

from dampyr.identification.fit_verdict import DESCRIBES, MISSES, fit_verdict


def fitted(*l1, converged=True, reason="converged"):
    """What the verdict is made from: how the search ended, and the misfit of each record."""
    scores = {f"r{k}": SimpleNamespace(l1=value) for k, value in enumerate(l1)}
    return SimpleNamespace(converged=converged, reason=reason, scores=scores)


@pytest.mark.parametrize(
    ("l1", "kind", "words"),
    [
        ((0.03, 0.05), "good", "misfit 4 % of the force (L1 ratio): the model describes these records."),
        ((0.08,), "fair", "misfit 8 % of the force (L1 ratio): the model describes this record roughly."),
        ((0.13,), "bad", "misfit 13 % of the force (L1 ratio): the model does not describe this record."),
        ((float("nan"),), "bad", "misfit without a number (L1 ratio): the model does not describe this record."),
    ],
)
def test_the_words_say_both(l1, kind, words):
    verdict = fit_verdict(fitted(*l1))
    assert (verdict.kind, verdict.words) == (kind, f"The search converged; {words}")


def test_a_search_that_stopped_is_never_good():
    verdict = fit_verdict(fitted(0.01, converged=False, reason="stopped after 3 steps"))
    assert verdict.kind == "bad"
    assert verdict.words.startswith("The search did not converge (stopped after 3 steps); misfit 1 %")
    assert 0 < DESCRIBES < MISSES
