"""The published campaign, fitted: figures to beat on real records."""

from dataclasses import replace

import numpy as np
import pytest
from tests.endurance import Endurance

from dampyr.identification import FitOptions, fit, score
from dampyr.identification.scoring.validation import cross_validate
from dampyr.models import Interpolation, Polynomial
from dampyr.records.files.campaign_folder import campaign_rows

FLOORS = {0.0: 8.8, 0.8712: 8.0, 1.98: 12.7, 3.212: 14.3}  # %, mean L1 of the plain Dahl model fitted per record


@pytest.fixture(scope="module")
def records(published_fit_records):
    return published_fit_records


@pytest.mark.prove
def test_all_38_files_are_fitted_each_to_the_floors(records) -> None:
    fits = {record.name: fit(record, "dahl") for record in records}
    assert len(fits) == 38
    assert all(fit_result.converged for fit_result in fits.values())
    for voltage, floor in FLOORS.items():
        group = [r for r in records if r.voltage == pytest.approx(voltage)]
        fitted = [fits[r.name].scores[r.name].l1 for r in group]
        free = [score(fits[r.name].damper, r).l1 for r in group]
        assert 100 * np.mean(fitted) <= floor
        assert 100 * np.mean(free) <= floor


def test_a_joint_fit_is_one_call_and_close_to_the_separate_ones(records, published_fit) -> None:
    fit_result = published_fit
    assert fit_result.converged
    assert fit_result.clusters == "record"
    means = [np.mean([fit_result.scores[r.name].l1 for r in records if r.voltage == pytest.approx(u)]) for u in FLOORS]
    assert np.all(100 * np.array(means) < [9.3, 8.0, 13.7, 17.1])
    assert fit_result.damper.range == (0.0, 3.212)


@pytest.mark.prove
def test_the_first_try_composition_beats_plain_dahl_by_far(records) -> None:
    fit_result = fit(
        [r for r in records if r.voltage > 3],
        "dahl + hyperbolic_tangent + spring + delay",
        fixed={"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.s": 0.0},
    )
    assert 100 * np.mean([s.l1 for s in fit_result.scores.values()]) < 6.2


WINNER = "shutting_bleed + compliance + place_friction + spring"  # of `leaderboard`, which `make endure` runs
CONSTANT = {"spring.k0": "constant"}  # that it found to have one value


@pytest.mark.prove
@pytest.mark.endure
def test_records_and_voltages_that_it_never_saw_are_predicted_as_the_docs_say(records, endurance: Endurance) -> None:
    """Random parts by three seeds: floor 4.1 %, aim 3.7 %; a voltage left out: floor 7.5 and 8.5 %, aim 6.5 and 7.0 %."""
    options = FitOptions(bandwidth=18.2, steps=300, laws=CONSTANT)
    by_record = [
        cross_validate(records, WINNER, options=replace(options, seed=seed)).by_input
        for seed in range(endurance.count(3))
    ]
    printed = {0.0: 3.9, 0.8712: 3.0, 1.98: 3.7, 3.212: 3.7}
    assert {u: 100 * l1 for u, l1 in by_record[0].items()} == pytest.approx(printed, abs=0.06)
    assert all(100 * np.mean(list(each.values())) < 3.7 for each in by_record)
    by_voltage = cross_validate(records, WINNER, "input", options).by_input
    assert {u: 100 * l1 for u, l1 in by_voltage.items()} == pytest.approx({0.8712: 5.9, 1.98: 7.9}, abs=0.06)


@pytest.mark.prove
@pytest.mark.endure
def test_twenty_numbers_predict_better_than_a_black_box_of_three_thousand(records, endurance: Endurance) -> None:
    """All of the parts but those of the gap constant over the voltage, by the velocity as recorded: 4.01 % by three seeds,
    where a network of two layers of 48 has 4.04 %."""
    model = "shutting_bleed + place_friction + spring + compliance"
    options = FitOptions(laws={"spring.k0": "constant", "compliance.s": "constant"})
    for seed in range(endurance.count(3)):
        found = cross_validate(records, model, options=replace(options, seed=seed)).by_input
        assert 100 * np.mean(list(found.values())) < 4.1
    left_out = cross_validate(records, model, "input", options).by_input
    assert 100 * left_out[0.8712] < 7.5
    assert 100 * left_out[1.98] < 8.5


def test_the_cubics_pass_through_the_table_means_at_the_true_voltages() -> None:
    rows = [row for row in campaign_rows() if row.published]
    volts = np.array(sorted({row.voltage for row in rows}))
    cubics = {
        "kx": (802.0, 493.1, 34.2, 85.5),
        "kw": (50.237, 201.92, -24.866, 3.6157),
        "rho": (42745.0, -39038.0, 17881.0, -2836.8),
    }
    for name, printed in cubics.items():
        means = np.array([np.mean([r.published[name] for r in rows if r.voltage == u]) for u in volts])
        if name == "rho":
            assert abs(means[0] / 42744.8 - 1) == pytest.approx(0.005, abs=0.0003)
            means[0] = 42744.8
        through = np.polynomial.polynomial.polyfit(volts, means, 3)
        law = Polynomial(printed, 0.0, 3.212)
        assert np.max(np.abs(law(volts) / means - 1)) < 4e-4
        np.testing.assert_allclose(Polynomial(tuple(through), 0.0, 3.212)(volts), means, rtol=1e-9)
        assert np.all(np.isfinite(Interpolation(tuple(volts), tuple(means))(np.linspace(0, 3.212, 9))))
