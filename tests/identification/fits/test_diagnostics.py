"""What is said of residuals: trends with their probability, once, and none of chance."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import spearmanr
from tests.identification.residual_traces import NOISE, N, V, ar1, trace
from tests.identification.synthetic import DAHL, sine

from dampyr.identification import analyse, fit
from dampyr.identification.fits.diagnostics import findings, residual_findings, trends
from dampyr.identification.fits.residuals import (
    Residuals,
)
from dampyr.models import Damper


def test_a_part_that_does_not_turn_round_is_uneven_and_one_that_does_is_not() -> None:
    """A dashpot harder in one direction leaves c|v|: both means are 0 once the offset is taken, and it is still found."""
    harder = 200.0 * np.abs(V)
    harder -= harder.mean()
    analysis = analyse([trace(harder + 0.2 * NOISE)])
    group = analysis.groups[0]
    assert abs(group.sides["out"].mean - group.sides["in"].mean) < 0.2
    assert group.asymmetry == pytest.approx(np.std(harder), rel=0.05)
    assert any(
        "at 1 V" in text and "does not change its sign" in text for text in map(str, residual_findings(analysis))
    )
    odd = analyse([trace(4000.0 * V**3 + 0.2 * NOISE)])
    assert odd.groups[0].asymmetry < 0.1 * odd.whole.rms
    assert not any("does not change its sign" in text for text in map(str, residual_findings(odd)))


@pytest.mark.parametrize(
    ("phi", "count", "most"),
    [(0.99, 40, 3), *(pytest.param(phi, 100, 5, marks=pytest.mark.prove) for phi in (0.0, 0.95, 0.99, 0.999))],
)
def test_chance_alone_seldom_looks_uneven(phi: float, count: int, most: int) -> None:
    odd = [analyse([trace(ar1(phi, 1.0, seed=s))]) for s in range(count)]
    assert sum("change its sign" in text for analysis in odd for text in map(str, residual_findings(analysis))) <= most


def campaign(
    sizes: np.ndarray, frequencies: np.ndarray, inputs: np.ndarray, strokes: np.ndarray | None = None
) -> Residuals:
    """Records of the given rms over spread; the series themselves are all alike."""
    strokes = 0.02 + 0.0 * frequencies if strokes is None else strokes
    named = [f"r{k}" for k in range(sizes.size)]
    base = analyse([trace(NOISE[:N], name, u=float(u)) for name, u in zip(named, inputs, strict=True)])
    records = tuple(
        replace(r, relative=float(s), frequency=float(f), stroke=float(x))
        for r, s, f, x in zip(base.records, sizes, frequencies, strokes, strict=True)
    )
    return replace(base, records=records)


def test_a_trend_is_spearmans_and_is_told_with_its_probability() -> None:
    f = np.linspace(0.5, 1.4, 10)
    size = np.array([5, 4, 6, 7, 9, 8, 10, 12, 11, 13.0]) / 100
    analysis = campaign(size, f, np.zeros(10))
    (one,) = trends(analysis)
    expected = spearmanr(f, size)
    assert (one.rank, one.p, one.records) == (pytest.approx(expected[0]), pytest.approx(expected[1]), 10)
    assert one.counts
    assert any(
        "at 0 V the residual relative to the force grows with frequency (rank correlation 0.96" in t
        for t in findings(analysis)
    )


def test_what_goes_together_in_the_records_is_not_told_apart() -> None:
    f = np.linspace(0.5, 1.4, 10)
    analysis = campaign(0.05 + 0.02 * f, f, np.zeros(10), strokes=0.03 / f)
    statements = [text for text in findings(analysis) if "rank correlation" in text]
    assert len(statements) == 1
    assert "grows with frequency" in statements[0]
    assert "or with stroke: in these records the two go together (−1.00)" in statements[0]


@pytest.mark.parametrize(
    ("campaigns", "most"),
    [(40, 6), pytest.param(150, 14, marks=pytest.mark.prove)],  # 5 % are expected; one more by chance in 1 %
)
def test_among_campaigns_without_trend_few_are_told_of_one(campaigns: int, most: int) -> None:
    rng = np.random.default_rng(11)
    base = campaign(np.ones(32), np.ones(32), np.repeat([0.0, 1.0, 2.0, 3.0], 8))
    alarms = 0
    for _ in range(campaigns):
        drawn = rng.uniform(size=(32, 3))
        records = tuple(
            replace(r, relative=a, frequency=b, stroke=c)
            for r, (a, b, c) in zip(base.records, drawn.tolist(), strict=True)
        )
        campaign_trends = trends(replace(base, records=records))
        assert len(campaign_trends) == 9
        alarms += any(one.counts for one in campaign_trends)
    assert alarms <= most


def test_few_records_make_no_trend() -> None:
    analysis = campaign(np.array([1.0, 2, 3, 4]), np.array([1.0, 2, 3, 4]), np.arange(4.0))
    assert trends(analysis) == ()


def test_an_inverted_force_is_no_fit() -> None:
    record = sine(DAHL, 0.0, noise=1.0)
    fit_result = fit(record.replace(note="turned round", force=-record.force), "dahl")
    assert not fit_result.converged
    assert "the force sign is inverted" in fit_result.reason


def test_motion_inside_pre_sliding_is_told() -> None:
    stiff = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 30.0})
    fit_result = fit(sine(stiff, 0.0, amplitude=0.002, noise=0.3), "dahl")
    assert any(
        "never leaves pre-sliding" in note and "larger amplitudes" in note for note in map(str, fit_result.findings)
    )
    assert not any("pre-sliding" in note for note in map(str, fit(sine(DAHL, 0.0), "dahl").findings))


def test_an_amplitude_of_a_few_steps_of_the_encoder_is_told() -> None:
    record = sine(DAHL, 0.0, amplitude=0.00004, noise=1.0)
    rough = record.replace(note="5 um steps", displacement=np.round(record.displacement / 5e-6) * 5e-6)
    fit_result = fit(rough, "dahl")
    assert any("takes only 17 values over 0.08 mm" in note for note in map(str, fit_result.findings))
