"""Least-squares identification: the truth comes back, and what cannot be known is said."""

import json

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.errors import InputError
from dampyr.identification import fit, score
from dampyr.models import Damper, Interpolation, Polynomial
from dampyr.records import Record
from dampyr.to_json import plain

VOLTS = (0.0, 1.0, 2.0, 3.0)
TRUTH = {
    "dahl.kx": Polynomial((800.0, 500.0, 100.0), 0.0, 3.0),
    "dahl.kw": Interpolation(VOLTS, (50.0, 210.0, 380.0, 560.0)),
    "dahl.rho": Polynomial((4000.0, -700.0), 0.0, 3.0),
}


def campaign(damper: Damper, noise: float = 0.0, per_voltage: int = 2) -> list[Record]:
    return [
        sine(damper, u, f"{u:g}V-{k}", 0.004 + 0.003 * k, 1.2 - 0.2 * k, noise, offset=100.0 + 7 * k, seed=10 * i + k)
        for i, u in enumerate(VOLTS)
        for k in range(per_voltage)
    ]


def test_one_record_gives_back_its_model_its_offset_and_its_start() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    fit_result = fit(sine(truth, 0.0, w0=-0.6), "dahl")
    assert fit_result.converged, fit_result.reason
    assert list(fit_result.parameters.values()) == pytest.approx([900.0, 70.0, 2500.0], rel=1e-6)
    assert fit_result.nuisances["test"].offset == pytest.approx(120.0, abs=1e-4)
    assert fit_result.nuisances["test"].states["dahl.w"] == pytest.approx(-0.6, abs=1e-4)


@pytest.mark.prove
def test_all_six_normalised_bouc_wen_parameters_come_back() -> None:
    values = {"c0": 600.0, "k0": 900.0, "kw": 120.0, "rho": 700.0, "sigma": 1.6, "n": 1.4}
    truth = Damper("bouc_wen", {f"bouc_wen.{k}": v for k, v in values.items()})
    fit_result = fit(sine(truth, 0.0), "bouc_wen")
    assert fit_result.converged, fit_result.reason
    assert list(fit_result.parameters.values()) == pytest.approx(list(values.values()), rel=1e-4)


def test_a_joint_fit_gives_back_laws_over_the_voltage() -> None:
    truth = Damper("dahl", TRUTH)
    fit_result = fit(campaign(truth), "dahl", laws={"dahl.kx": "polynomial:2", "dahl.rho": "polynomial:1"})
    assert fit_result.converged, fit_result.reason
    assert fit_result.damper is not None
    for name, law in TRUTH.items():
        np.testing.assert_allclose(fit_result.damper.all_laws[name].coefficients, law.coefficients, rtol=1e-5)


def test_voltages_that_differ_by_rounding_share_a_value_of_the_law_and_each_is_modelled() -> None:
    truth = Damper("dahl", TRUTH)
    records = [
        sine(truth, u, f"{k}", 0.005 + 0.001 * k, offset=0.0) for k, u in enumerate((0.0, 2.0, 2.0000004, 2.0, 0.0))
    ]
    fit_result = fit(records, "dahl")
    assert [label for label in fit_result.parameters if label.startswith("dahl.kw")] == [
        "dahl.kw @ 0 V",
        "dahl.kw @ 2 V",
    ]
    assert fit_result.parameters["dahl.kw @ 2 V"] == pytest.approx(380.0, rel=1e-5)
    assert max(one.l1 for one in fit_result.scores.values()) < 1e-4


def test_a_varying_voltage_gives_a_polynomial_law() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": Polynomial((60.0, 150.0), 0.0, 3.0), "dahl.rho": 2500.0})
    t = np.arange(0.0, 12.0, 0.005)
    u = 1.5 + 1.5 * np.sin(1.3 * t)
    x = 0.01 * np.sin(2 * np.pi * t)
    v = np.gradient(x, t)
    record = Record(t, x, truth.force(t, x, voltage=u, velocity=v) + 30.0, velocity=v, voltage=u)
    fit_result = fit(record, "dahl", laws={"dahl.kx": "constant", "dahl.kw": "polynomial:1", "dahl.rho": "constant"})
    assert fit_result.damper is not None
    np.testing.assert_allclose(fit_result.damper.coefficients, truth.coefficients, rtol=1e-3)


def test_a_varying_voltage_gives_a_law_of_what_the_state_remembers() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 90.0, "dahl.rho": Polynomial((500.0, 200.0), 0.0, 3.0)})
    t = np.arange(0.0, 12.0, 0.005)
    u = 1.5 + 1.5 * np.sin(9.0 * t)
    x = 0.004 * np.sin(2 * np.pi * t)
    v = np.gradient(x, t)
    record = Record(t, x, truth.force(t, x, voltage=u, velocity=v) + 30.0, velocity=v, voltage=u)
    fit_result = fit(record, "dahl", laws={"dahl.kx": "constant", "dahl.kw": "constant", "dahl.rho": "polynomial:1"})
    assert fit_result.converged
    assert fit_result.iterations < 12
    assert fit_result.damper is not None
    np.testing.assert_allclose(fit_result.damper.coefficients, truth.coefficients, rtol=1e-6)


@pytest.mark.prove
def test_the_first_try_composition_comes_back() -> None:
    laws = {"dahl.kx": 800.0, "dahl.kw": 60.0, "dahl.rho": 900.0, "spring.k0": 1500.0, "delay.tau": 0.0085}
    laws |= {"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.ft": 90.0}
    laws |= {"hyperbolic_tangent.v0": 0.008, "hyperbolic_tangent.s": 0.0}
    truth = Damper("dahl + hyperbolic_tangent + spring + delay", laws)
    records = [sine(truth, 0.0, f"r{k}", 0.004 + 0.004 * k, 0.5 + 0.4 * k) for k in range(3)]
    fixed = {"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.s": 0.0}
    fit_result = fit(records, "dahl + hyperbolic_tangent + spring + delay", fixed=fixed)
    free = {name: value for name, value in laws.items() if name not in fixed}
    assert fit_result.parameters == pytest.approx(free, rel=1e-3)
    assert fit_result.scores["r0"].l1 < 1e-4


def test_fixed_parameters_stay_and_are_no_longer_estimated() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    fit_result = fit(sine(truth, 0.0, noise=1.0), "dahl", fixed={"dahl.rho": 2500.0})
    assert "dahl.rho" not in fit_result.parameters
    assert fit_result.damper is not None
    assert fit_result.damper.at(0.0).rho == 2500.0
    assert fit_result.damper.covariance[2, 2] == 0.0


def test_errors_with_noise_are_of_the_right_size() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    numbers, errors = [], []
    for seed in range(24):
        fit_result = fit(sine(truth, 0.0, noise=4.0, seed=seed, seconds=12.0), "dahl")
        numbers.append(list(fit_result.parameters.values()))
        errors.append(list(fit_result.stderr.values()))
    ratio = np.std(numbers, axis=0) / np.mean(errors, axis=0)
    assert np.all((ratio > 0.6) & (ratio < 1.7)), ratio
    np.testing.assert_allclose(np.mean(numbers, axis=0), [900.0, 70.0, 2500.0], rtol=0.02)


def test_correlated_residuals_widen_the_errors() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    records = []
    for k in range(12):
        record = sine(truth, 0.0, f"r{k}")
        rng = np.random.default_rng(k)
        gain = 1.0 + 0.05 * rng.standard_normal()
        records.append(record.replace(note="another gain", force=record.force * gain))
    fit_result = fit(records, "dahl")
    assert fit_result.clusters == "record"
    assert fit_result.stderr["dahl.kw"] > 5 * fit_result.naive_stderr["dahl.kw"]
    assert fit_result.stderr["dahl.kw"] == pytest.approx(70.0 * 0.05 / np.sqrt(12), rel=0.5)


def test_what_the_records_do_not_determine_has_an_infinite_error() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    fixed = {"hyperbolic_tangent.ft": 1e-3, "hyperbolic_tangent.v0": 0.01, "hyperbolic_tangent.s": 0.0}
    laws = {"hyperbolic_tangent.c": "constant"}
    fit_result = fit(sine(truth, 0.0, noise=1.0), "dahl + hyperbolic_tangent", fixed=fixed, laws=laws)
    assert fit_result.stderr["dahl.kx"] == np.inf
    assert fit_result.stderr["hyperbolic_tangent.c"] == np.inf
    assert np.isfinite(fit_result.stderr["dahl.kw"])
    assert any("do not determine" in note for note in map(str, fit_result.findings))


def test_of_two_dashpots_one_is_held_and_the_note_says_which() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    fixed = {"hyperbolic_tangent.ft": 1e-3, "hyperbolic_tangent.v0": 0.01, "hyperbolic_tangent.s": 0.0}
    fit_result = fit(sine(truth, 0.0, noise=1.0), "dahl + hyperbolic_tangent", fixed=fixed)
    assert "hyperbolic_tangent.c" not in fit_result.parameters
    assert fit_result.parameters["dahl.kx"] == pytest.approx(900.0, rel=0.02)
    assert np.isfinite(fit_result.stderr["dahl.kx"])
    assert any(
        note.startswith("hyperbolic_tangent.c is held at 0, as dahl.kx") for note in map(str, fit_result.findings)
    )


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


def test_a_record_that_settling_takes_most_of_is_scored_from_its_start_and_the_note_says_so() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    short = sine(truth, 0.0, "short", seconds=2.7)
    fit_result = fit(short, "dahl")
    assert fit_result.scores["short"].window.start == pytest.approx(0.5, abs=0.02)
    assert any("short: too short for a settling of 2 s" in note for note in map(str, fit_result.findings))
    assert fit(short, "dahl", settling=0.5).scores["short"].window.start == pytest.approx(1.0, abs=0.02)
    with pytest.raises(
        InputError, match=r"its motion lasts 2.19 s and settling takes the first 2 s of it, so 0.19 s \(3\d"
    ):
        score(truth, short)


def test_a_record_without_reversal_does_not_give_rho() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    t = np.arange(0.0, 5.0, 0.01)
    x = 0.004 * t
    v = np.full(t.size, 0.004)
    force = truth.force(t, x, voltage=0.0, velocity=v, state0=[1.0])
    record = Record(t, x, force + np.random.default_rng(0).normal(0, 1, t.size), velocity=v, voltage=0.0)
    fit_result = fit(record, "dahl")
    assert not np.isfinite(fit_result.stderr["dahl.rho"])


def test_an_inverted_force_is_told() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    record = sine(truth, 0.0)
    fit_result = fit(record.replace(note="turned round", force=-record.force), "dahl")
    assert any("sign inverted" in note for note in map(str, fit_result.findings))


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


def test_laws_that_the_voltages_cannot_carry_are_refused() -> None:
    damper = Damper("dahl", TRUTH)
    records = [sine(damper, u, f"{u}") for u in (0.0, 1.0)]
    with pytest.raises(InputError, match=r"2 inputs cannot give a polynomial of degree 2 .* lower it to 1"):
        fit(records, "dahl", laws="polynomial:2")
    with pytest.raises(InputError, match="'spline' is an unknown law"):
        fit(records, "dahl", laws="spline")


def test_records_of_two_kinds_of_input_are_refused() -> None:
    damper = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    one, other = sine(damper, 0.0, "a"), sine(damper, 0.0, "b").replace(note="", voltage=None, current=0.1)
    with pytest.raises(InputError, match="a has a voltage and b a current as its input"):
        fit([one, other], "dahl")
    with pytest.raises(InputError, match="two records are called 'a'"):
        fit([one, one], "dahl")


def test_a_fit_is_the_same_twice() -> None:
    records = campaign(Damper("dahl", TRUTH), noise=2.0)
    assert fit(records, "dahl").parameters == fit(records, "dahl").parameters


def test_the_calibrated_ranges_are_those_of_the_records() -> None:
    fit_result = fit(campaign(Damper("dahl", TRUTH)), "dahl")
    assert fit_result.damper is not None
    assert fit_result.damper.range == (0.0, 3.0)
    assert fit_result.damper.ranges["displacement"][1] == pytest.approx(0.007, rel=0.05)
    assert fit_result.damper.ranges["frequency"] == pytest.approx((1.0, 1.2), rel=0.02)


def test_a_free_run_of_the_fit_scores_like_the_fit() -> None:
    records = campaign(Damper("dahl", TRUTH), noise=2.0)
    fit_result = fit(records, "dahl")
    assert fit_result.damper is not None
    for record in records:
        assert score(fit_result.damper, record).l1 == pytest.approx(fit_result.scores[record.name].l1, rel=0.02)


def test_clustered_errors_are_those_of_the_mean_of_independent_records() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    gains = 1.0 + 0.02 * np.array([-1.3, 0.4, 0.9, -0.2, 1.6, -1.4])
    records = []
    for k, gain in enumerate(gains):
        record = sine(truth, 0.0, f"r{k}", offset=0.0)
        records.append(record.replace(note="another gain", force=record.force * gain))
    fixed = {"dahl.kx": 0.0, "dahl.rho": 2500.0}
    pure = [
        r.replace(note="friction only", force=(r.force - gain * 900.0 * r.velocity))
        for r, gain in zip(records, gains, strict=True)
    ]
    fit_result = fit(pure, "dahl", fixed=fixed)
    assert fit_result.clusters == "record"
    assert fit_result.stderr["dahl.kw"] == pytest.approx(70.0 * np.std(gains, ddof=1) / np.sqrt(gains.size), rel=0.03)


def test_errors_pay_for_the_offset() -> None:
    rng = np.random.default_rng(5)
    t = np.arange(0.0, 20.0, 0.01)
    x = 0.05 + 0.01 * np.sin(2 * np.pi * t)
    force = 4000.0 * x + rng.normal(0.0, 2.0, t.size)
    fit_result = fit(Record(t, x, force, velocity=np.gradient(x, t), voltage=0.0), "spring")
    exact = 2.0 / np.sqrt(np.sum((x - x.mean()) ** 2))
    assert fit_result.naive_stderr["spring.k0"] == pytest.approx(exact, rel=0.06)
    assert fit_result.parameters["spring.k0"] == pytest.approx(4000.0, abs=4 * exact)


def test_the_cost_that_the_search_follows_is_the_true_one() -> None:
    truth = Damper("dahl", TRUTH)
    fit_result = fit(campaign(truth, noise=3.0), "dahl")
    residuals = [
        one.weight * (one.force - force)
        for one, force in zip(fit_result.problem.pieces, fit_result.forces, strict=True)
    ]
    assert fit_result.outcome.cost == pytest.approx(0.5 * sum(float(r @ r) for r in residuals), rel=1e-9)


def test_intervals_are_students() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    fit_result = fit([sine(truth, 0.0, f"r{k}", noise=3.0, seed=k) for k in range(6)], "dahl")
    assert fit_result.freedom["dahl.kw"] == pytest.approx(5.0, abs=0.1)
    low, high = fit_result.intervals(0.95)["dahl.kw"]
    assert (high - low) / 2 == pytest.approx(2.5706 * fit_result.stderr["dahl.kw"], rel=0.02)
    with pytest.raises(InputError, match="between 0 and 1"):
        fit_result.intervals(95)


def test_a_fit_as_a_dict_has_every_number_by_its_label() -> None:
    fit_result = fit(
        sine(Damper("dahl", {"dahl.kx": 800.0, "dahl.kw": 55.0, "dahl.rho": 2500.0}), 0.0, noise=1.0), "dahl"
    )
    data = plain(fit_result.as_dict())
    assert json.loads(json.dumps(data)) == data
    assert list(data["parameters"]) == list(data["stderr"]) == list(data["intervals_95"]) == list(fit_result.parameters)
    assert data["intervals_95"] == dict.fromkeys(fit_result.within_records)
    assert data["scores"] == {name: plain(score) for name, score in fit_result.scores.items()}
