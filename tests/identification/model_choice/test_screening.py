"""The trials before the finalists: on few and short records, in rounds that a limit ends."""

from types import SimpleNamespace

import numpy as np
import pytest
from tests.identification.synthetic import sine
from tests.identification.tangent_campaign import VOLTS, campaign, without_velocity

from dampyr.identification import FitOptions
from dampyr.identification.model_choice import parallel, screening
from dampyr.identification.model_choice.screening import CUT, NOT_BEGUN, Trial, screen_all, screening_set, shortened
from dampyr.models import Damper
from dampyr.records import with_velocity


def test_the_screening_set_is_small_and_holds_every_input() -> None:
    many = campaign(9)
    small = screening_set(many)
    assert {r.voltage for r in small} == set(VOLTS)
    assert len(small) == 12
    slow = sine(
        Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0}), 0.0, frequency=0.2, seconds=60.0
    )
    short = shortened(slow)
    assert short.n < 2000 < slow.n
    assert short.time[-1] >= 4 / 0.2


def test_samples_are_left_out_after_the_velocity_is_derived() -> None:
    slow = without_velocity()[0]
    [thin] = screening_set([slow], 40.0)
    assert thin.n < slow.n / 5
    whole = with_velocity(slow, 40.0)
    at = np.searchsorted(whole.time, thin.time)
    np.testing.assert_array_equal(thin.velocity, whole.velocity[at])


@pytest.mark.parametrize(("deadline", "limit", "reason"), [(10.0, np.inf, CUT), (np.inf, 2.5, NOT_BEGUN)])
def test_a_search_that_ends_between_two_rounds_says_which_limit_ended_it(
    deadline: float, limit: float, reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each add-on halves the error and each trial spends 1 s of work; the clock jumps after the first round."""
    now = [0.0]
    monkeypatch.setattr(parallel, "time", SimpleNamespace(monotonic=lambda: now[0]))
    monkeypatch.setattr(screening, "trial", lambda model, *_: Trial(model, 0.5 ** model.count("+"), 0.0, "", 1.0))

    def progress(done: float) -> None:
        now[0] = 100.0 if done >= 1 / 2 else 0.0  # of four rounds, the first of bare models

    add_ons = ("spring", "compliance", "delay")
    [screened], unfinished = screen_all(["dahl"], [], FitOptions(add_ons=add_ons), None, progress, limit, deadline)
    done = [trial.model for trial in screened.trials if not trial.reason]
    assert done == ["dahl", "dahl + spring", "dahl + compliance", "dahl + delay"][: 3 if np.isfinite(limit) else 4]
    assert {trial.reason for trial in screened.trials} == {"", reason}
    assert unfinished == ["dahl"]


def test_a_model_of_many_numbers_far_behind_the_best_bare_one_gets_no_add_on(monkeypatch: pytest.MonkeyPatch) -> None:
    errors = {"bingham": 0.30, "bouc_wen": 0.14, "lugre": 0.12, "dahl + hyperbolic_tangent": 0.10}
    monkeypatch.setattr(
        screening,
        "trial",
        lambda model, *_: Trial(model, 0.9 * errors.get(model, 1.0) if model in errors else 0.09, 0.0, "", 1.0),
    )
    screened, _ = screen_all(list(errors), [], FitOptions(add_ons=("delay",)), None, lambda done: None)
    tried = {model.base: len(model.trials) for model in screened}
    assert (
        screen_all(["dahl"], [], FitOptions(add_ons=()), None, lambda done: None)[1] == []
    )  # nothing more was to be tried
    assert tried == {"bingham": 2, "bouc_wen": 1, "lugre": 2, "dahl + hyperbolic_tangent": 2}
