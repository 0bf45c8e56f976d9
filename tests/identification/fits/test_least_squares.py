"""The fit of one model by least squares: weights, its cost, its time, and records that cannot be fitted."""

import numpy as np
import pytest
from tests.identification.campaign_of_dahl import TRUTH, campaign
from tests.identification.synthetic import sine

from dampyr.errors import InputError
from dampyr.identification import fit
from dampyr.models import Damper


def test_every_record_counts_the_same_or_every_sample() -> None:
    soft, stiff = (Damper("dahl", {"dahl.kx": kx, "dahl.kw": 70.0, "dahl.rho": 2500.0}) for kx in (900.0, 1100.0))
    pair = [sine(soft, 0.0, "short", seconds=4.5), sine(stiff, 0.0, "long", seconds=40.5)]
    values = {w: fit(pair, "dahl", weighting=w).parameters["dahl.kx"] for w in ("records", "samples")}
    assert values["records"] == pytest.approx(1000.0, abs=15.0)
    assert values["samples"] == pytest.approx(1080.0, abs=15.0)
    with pytest.raises(InputError, match="weighting = 'cycles' is not known; choose from records, samples"):
        fit(pair, "dahl", weighting="cycles")


def test_a_fit_that_is_out_of_time_says_so_and_gives_what_it_reached() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    fit_result = fit(sine(truth, 0.0, noise=1.0), "dahl", seconds=1e-9)
    assert not fit_result.converged
    assert "its time was used up" in fit_result.reason
    assert fit_result.damper is not None
    with pytest.raises(InputError, match="seconds = -1 s is not allowed; it must be greater than 0"):
        fit(sine(truth, 0.0), "dahl", seconds=-1.0)


@pytest.mark.parametrize(
    ("changes", "options", "words"),
    [
        ({"role": "validation"}, {}, "only validation records are chosen, and these are never fitted"),
        ({"voltage": None}, {}, "voltage is not known"),
        ({"displacement": np.zeros(1200), "velocity": np.zeros(1200)}, {}, "no motion"),
        ({"force": np.full(1200, 3.0)}, {}, "force is constant at 3 N"),
        ({}, {"laws": "polynomial:2"}, "cannot give a law"),
        ({}, {"laws": {"dahl.q": "constant"}}, r"'dahl\.q'; dahl has dahl\.kx"),
        ({}, {"fixed": {"dahl.rho": -1.0}}, "greater than 0"),
        ({}, {"fixed": {"dahl.kx": 1.0, "dahl.kw": 1.0, "dahl.rho": 1.0}}, "every parameter is fixed"),
    ],
)
def test_fits_that_cannot_be_are_refused(changes: dict, options: dict, words: str) -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    record = sine(truth, 0.0).replace(note="changed", **changes)
    with pytest.raises(InputError, match=words):
        fit(record, "dahl", **options)


def test_records_of_two_kinds_of_input_are_refused() -> None:
    damper = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    one, other = sine(damper, 0.0, "a"), sine(damper, 0.0, "b").replace(note="", voltage=None, current=0.1)
    with pytest.raises(InputError, match="a has a voltage and b a current as its input"):
        fit([one, other], "dahl")
    for model in ("dahl", None):  # a search for a model says so before it begins
        with pytest.raises(InputError, match="two records are called 'a'"):
            fit([one, one], model)


def test_a_fit_is_the_same_twice() -> None:
    records = campaign(Damper("dahl", TRUTH), noise=2.0)
    assert fit(records, "dahl").parameters == fit(records, "dahl").parameters


def test_the_cost_that_the_search_follows_is_the_true_one() -> None:
    truth = Damper("dahl", TRUTH)
    fit_result = fit(campaign(truth, noise=3.0), "dahl")
    residuals = [
        one.weight * (one.force - force)
        for one, force in zip(fit_result.problem.pieces, fit_result.forces, strict=True)
    ]
    assert fit_result.outcome.cost == pytest.approx(0.5 * sum(float(r @ r) for r in residuals), rel=1e-9)
