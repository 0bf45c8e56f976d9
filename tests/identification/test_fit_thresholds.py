"""A judgement is a field of `FitThresholds`: a changed one changes what is said, and no number."""

import numpy as np
import pytest
from tests.identification.campaign_of_dahl import campaign
from tests.identification.synthetic import sine

from dampyr.errors import InputError
from dampyr.identification import fit, identifiability
from dampyr.identification.fit_thresholds import FitThresholds
from dampyr.identification.fits.motion_coverage import list_motions_beyond
from dampyr.models import Damper
from dampyr.records import RecordThresholds

DAHL = Damper("dahl", {"kx": 1500.0, "kw": 100.0, "rho": 400.0})


@pytest.fixture(scope="module")
def records():
    """Of a damper that Bingham's model misses by some percent."""
    return campaign(DAHL, noise=1.0)


def said(result):
    return {finding.words for finding in result.findings}


@pytest.mark.usefixtures("no_trials")
def test_a_changed_threshold_changes_the_verdict_and_no_number(records):
    usual = fit(records, "bingham")
    l1 = float(np.mean([score.l1 for score in usual.scores.values()]))
    assert 0.0 < l1 < 0.9
    lax = fit(records, "bingham", thresholds=FitThresholds(good_misfit=0.9, misfit=0.95))
    strict = fit(records, "bingham", thresholds=FitThresholds(good_misfit=0.0, misfit=0.5 * l1))
    assert (lax.verdict.kind, strict.verdict.kind) == ("good", "bad")
    assert lax.parameters == usual.parameters == strict.parameters
    np.testing.assert_equal(lax.stderr, strict.stderr)
    assert any("does not describe" in words for words in said(strict))
    assert strict.damper is not None
    assert any("does not describe" in finding.words for finding in strict.damper.findings)
    assert lax.damper is not None
    assert lax.damper.provenance["thresholds"] == "good_misfit = 0.9, misfit = 0.95"
    assert usual.damper is not None
    assert "thresholds" not in usual.damper.provenance


def test_thresholds_of_records_are_stated_by_what_is_fitted_to_them(records, tmp_path):
    long = [record.replace(note="a bridge", thresholds=RecordThresholds(unlikely_stroke=4.0)) for record in records]
    damper = fit(long, "dahl").damper
    assert damper is not None
    card = Damper.load(damper.save(tmp_path / "card.toml"))
    assert card.provenance["thresholds"] == "unlikely_stroke = 4 m"


@pytest.mark.usefixtures("no_trials")
def test_residuals_and_what_is_said_of_single_records_follow_the_thresholds(records):
    usual = fit(records, "bingham")
    assert usual.residuals.misfits
    lax = fit(records, "bingham", thresholds=FitThresholds(correlated=1e6, beyond_noise=1e6, resolved_steps=10**6))
    assert lax.residuals.misfits == ()
    assert not any("the model misses more than noise" in words for words in said(lax))
    assert sum("its resolution hides the loop" in words for words in said(lax)) == len(records)


def test_pairs_that_trade_against_each_other_follow_the_thresholds():
    records = campaign(DAHL, noise=1.0)
    pairs = [
        sum(finding.kind == "pair" for finding in identifiability(fit(records, "dahl", thresholds=limits)).inseparable)
        for limits in (FitThresholds(trading=0.0), FitThresholds(trading=1.0))
    ]
    assert pairs[0] > pairs[1] == 0


def test_a_planned_motion_is_extrapolated_by_the_thresholds():
    fitted = [sine(DAHL, 1.0, "large", 0.01, 1.0)]
    planned = [sine(DAHL, 1.0, "small", 0.007, 1.0)]
    assert "small" in list_motions_beyond(fitted, planned)
    assert list_motions_beyond(fitted, planned, FitThresholds(outside_margin=0.5)) == {}


def test_a_threshold_outside_of_its_range_is_refused():
    with pytest.raises(InputError, match=r"misfit = 1\.2 is not allowed; it must be at least 0 and at most 1"):
        FitThresholds(misfit=1.2)
    with pytest.raises(
        InputError, match=r"good_misfit = 0\.05 is above misfit = 0\.01; lower good_misfit, or raise misfit"
    ):
        FitThresholds(misfit=0.01)
