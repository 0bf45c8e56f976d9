"""What a fit can be asked for: losses, nuisances, ties, several starts; and the fits that must say why they fail."""

import numpy as np
import pytest
from scipy.optimize import minimize
from tests.identification.synthetic import sine

from dampyr.errors import InputError
from dampyr.identification import FitOptions, fit
from dampyr.identification.scoring.validation import cross_validate
from dampyr.models import Damper, Interpolation
from dampyr.records import Record

DAHL = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
NUMBERS = np.array([900.0, 70.0, 2500.0])


def values(fit_result) -> np.ndarray:
    return np.array(list(fit_result.parameters.values()))


def spiked(record: Record) -> Record:
    """One sample in forty with a spike of the load cell, on the way out only."""
    spikes = np.zeros(record.n)
    spikes[150::40] = 400.0 * (record.velocity[150::40] > 0)
    return record.replace(note="spikes", force=record.force + spikes)


# losses


@pytest.mark.parametrize("loss", ["huber", "l1"])
def test_spikes_move_squares_and_not_the_robust_losses(loss: str) -> None:
    record = spiked(sine(DAHL, 0.0, noise=2.0, seconds=12.0))
    squares, robust = fit(record, "dahl"), fit(record, "dahl", loss=loss)
    assert robust.converged, robust.reason
    assert np.max(np.abs(values(squares)[:2] / NUMBERS[:2] - 1)) > 0.08
    np.testing.assert_allclose(values(robust), NUMBERS, rtol=0.03)


@pytest.mark.parametrize("loss", ["huber", "l1"])
def test_without_outliers_the_losses_agree_within_their_errors(loss: str) -> None:
    record = sine(DAHL, 0.0, noise=3.0, seconds=15.0)
    squares, robust = fit(record, "dahl"), fit(record, "dahl", loss=loss)
    errors = np.array(list(robust.stderr.values()))
    assert np.all(np.abs(values(robust) - NUMBERS) < 4 * errors)
    assert np.all(np.abs(values(robust) - values(squares)) < 3 * errors)


@pytest.mark.parametrize("loss", ["huber", pytest.param("l1", marks=pytest.mark.prove)])
def test_the_errors_of_the_robust_losses_are_of_the_right_size(loss: str) -> None:
    numbers, errors, naive = [], [], []
    for seed in range(20):
        fit_result = fit(sine(DAHL, 0.0, noise=4.0, seed=seed, seconds=12.0), "dahl", loss=loss)
        numbers.append(values(fit_result))
        errors.append(list(fit_result.stderr.values()))
        naive.append(list(fit_result.naive_stderr.values()))
    for each in (errors, naive):
        ratio = np.std(numbers, axis=0) / np.mean(each, axis=0)
        assert np.all((ratio > 0.6) & (ratio < 1.6)), ratio


def test_l1_minimises_the_sum_of_the_ratios_that_are_scored() -> None:
    """A quiet and a noisy record that disagree: a record's noise does not decide how much it counts."""
    quiet, noisy = (Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": kw, "dahl.rho": 2500.0}) for kw in (300.0, 330.0))
    pair = [sine(quiet, 0.0, "quiet", noise=3.0, seconds=12.0), sine(noisy, 0.0, "noisy", noise=60.0, seconds=12.0)]

    def ratios(kw: float | None) -> tuple[float, float]:
        fit_result = fit(pair, "dahl", loss="l1", fixed={"dahl.rho": 2500.0} | ({} if kw is None else {"dahl.kw": kw}))
        total = 0.0
        for piece, force in zip(fit_result.problem.pieces, fit_result.forces, strict=True):
            middle = np.mean(np.quantile(piece.force, (0.01, 0.99)))
            total += np.sum(np.abs(piece.force - force)) / np.sum(np.abs(piece.force - middle))
        return fit_result.parameters.get("dahl.kw", 0.0), total

    best, least = ratios(None)
    grid = np.arange(303.0, 330.0, 4.0)
    assert abs(grid[np.argmin([ratios(kw)[1] for kw in grid])] - best) <= 3.0
    assert min(ratios(kw)[1] for kw in (best - 4.0, best + 4.0)) > least


def test_l1_is_the_least_sum_of_absolute_residuals_that_scipy_finds() -> None:
    record = spiked(sine(DAHL, 0.0, noise=3.0, seconds=10.0))
    fit_result = fit(record, "dahl", loss="l1")
    t, x, v = record.time, record.displacement, record.velocity
    first = record.n - fit_result.forces[0].size

    def absolute(z: np.ndarray) -> float:
        kx, kw, rho, offset, w0 = z * [900.0, 70.0, 2500.0, 100.0, 1.0]
        damper = Damper("dahl", {"dahl.kx": kx, "dahl.kw": kw, "dahl.rho": rho})
        force = damper.force(t[first:], x[first:], 0.0, velocity=v[first:], state0=[np.clip(w0, -1, 1)])
        return float(np.sum(np.abs(record.force[first:] - force - offset)))

    ours = absolute(
        np.array(
            [*values(fit_result), fit_result.nuisances["test"].offset, fit_result.nuisances["test"].states["dahl.w"]]
        )
        / [900.0, 70.0, 2500.0, 100.0, 1.0]
    )
    theirs = minimize(
        absolute, [1.0, 1.0, 1.0, 1.2, 0.0], method="Nelder-Mead", options={"maxiter": 3000, "xatol": 1e-7}
    )
    assert ours == pytest.approx(theirs.fun, rel=2e-3)
    assert ours < absolute(np.append(values(fit(record, "dahl")) / NUMBERS, [1.2, 0.0]))


# nuisances


def gained(gains: list[float], viscosities: list[float]) -> list[Record]:
    records = []
    for k, (gain, warmth) in enumerate(zip(gains, viscosities, strict=True)):
        laws = {"dahl.kx": 900.0 * warmth, "dahl.kw": 70.0, "dahl.rho": 2500.0}
        record = sine(
            Damper("dahl", laws), 0.0, f"r{k}", 0.006 + 0.001 * k, 1.2 - 0.1 * k, noise=0.5, seed=k, offset=0.0
        )
        records.append(record.replace(note="its own gain", force=gain * record.force + 100.0 + k))
    return records


def test_gains_of_the_load_cell_come_back_relative_to_their_mean() -> None:
    gains = [1.04, 0.97, 1.02, 0.98, 1.0, 0.99]
    fit_result = fit(gained(gains, [1.0] * 6), "dahl", nuisances=("offset", "state", "gain"))
    assert fit_result.converged, fit_result.reason
    mean = float(np.exp(np.mean(np.log(gains))))
    ours = [n.gain for n in fit_result.nuisances.values()]
    np.testing.assert_allclose(ours, np.array(gains) / mean, rtol=2e-3)
    assert np.mean(np.log(ours)) == pytest.approx(0.0, abs=1e-6)
    np.testing.assert_allclose(values(fit_result), NUMBERS * [mean, mean, 1.0], rtol=0.01)
    assert fit_result.nuisance_spread["gain"] == pytest.approx(np.std(gains, ddof=1), rel=0.1)
    assert fit(gained(gains, [1.0] * 6), "dahl").nuisances["r0"].gain == 1.0


def test_temperatures_scale_the_viscosity_alone() -> None:
    warmth = [1.15, 0.9, 1.05, 0.95, 1.0, 0.97]
    fit_result = fit(gained([1.0] * 6, warmth), "dahl", nuisances=("offset", "state", "temperature"))
    mean = float(np.exp(np.mean(np.log(warmth))))
    np.testing.assert_allclose(
        [n.temperature for n in fit_result.nuisances.values()], np.array(warmth) / mean, rtol=0.02
    )
    assert fit_result.parameters["dahl.kx"] == pytest.approx(900.0 * mean, rel=0.01)
    plain = fit(gained([1.0] * 6, warmth), "dahl")
    assert fit_result.scores["r0"].l1 < 0.5 * plain.scores["r0"].l1


def test_states_and_offsets_can_be_left_out() -> None:
    record = sine(DAHL, 0.0, offset=0.0)
    fit_result = fit(record, "dahl", nuisances=())
    np.testing.assert_allclose(values(fit_result), NUMBERS, rtol=1e-5)
    assert fit_result.nuisances["test"].offset == 0.0
    assert fit_result.nuisances["test"].states["dahl.w"] == 0.0


# ties


def test_a_tied_parameter_takes_the_law_of_the_other_and_is_counted_once() -> None:
    laws = {"dahl.kx": 800.0, "dahl.kw": Interpolation((0.0, 1.0), (60.0, 90.0)), "dahl.rho": 3000.0}
    laws |= {"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.v0": 0.01, "hyperbolic_tangent.s": 0.0}
    laws |= {"hyperbolic_tangent.ft": Interpolation((0.0, 1.0), (60.0, 90.0))}
    truth = Damper("dahl + hyperbolic_tangent", laws)
    records = [sine(truth, u, f"{u:g}-{k}", 0.004 + 0.003 * k) for u in (0.0, 1.0) for k in range(3)]
    fit_result = fit(
        records,
        "dahl + hyperbolic_tangent",
        fixed={"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.s": 0.0},
        tied={"hyperbolic_tangent.ft": "dahl.kw"},
    )
    assert not any("ft" in label for label in fit_result.parameters)
    assert fit_result.damper is not None
    assert fit_result.damper.all_laws["hyperbolic_tangent.ft"](1.0) == pytest.approx(90.0, rel=1e-4)
    assert fit_result.damper.all_laws["dahl.kw"](0.0) == pytest.approx(60.0, rel=1e-4)
    names = list(fit_result.damper.all_laws)
    sizes = [len(law.coefficients) for law in fit_result.damper.all_laws.values()]
    starts = np.cumsum([0, *sizes])
    kw, ft = starts[names.index("dahl.kw")], starts[names.index("hyperbolic_tangent.ft")]
    assert (
        fit_result.damper.covariance[kw, kw]
        == fit_result.damper.covariance[ft, ft]
        == fit_result.damper.covariance[kw, ft]
    )


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"tied": {"dahl.q": "dahl.kw"}}, r"tied names 'dahl\.q'; dahl \+ spring has"),
        ({"tied": {"dahl.kw": "dahl.q"}}, r"tied names 'dahl\.q'"),
        ({"tied": {"dahl.kw": "dahl.kx"}}, "are in N and N s/m; only parameters of the same unit"),
        ({"tied": {"dahl.kw": "dahl.kw"}}, "tied itself"),
        ({"tied": {"dahl.kw": "dahl.kx", "dahl.kx": "dahl.kw"}}, "tied itself"),
        ({"tied": {"dahl.kw": "dahl.kx"}, "fixed": {"dahl.kw": 3.0}}, "fixed and tied"),
        ({"loss": "cubes"}, "loss = 'cubes' is not known; did you mean 'huber'\\? choose from squares, huber, l1"),
        (
            {"nuisances": ("offset", "weather")},
            "nuisances = 'weather' is not known; choose from offset, state, gain, temperature",
        ),
        ({"nuisances": ("gain",)}, "only record at 0 V, so its gain cannot be distinguished"),
        ({"starts": 0}, "starts = 0 is not allowed"),
    ],
)
def test_options_that_cannot_be_are_refused(options: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        fit(sine(DAHL, 0.0), "dahl + spring", **options)


def test_no_temperature_without_viscosity() -> None:
    records = [sine(Damper("spring", {"spring.k0": 900.0}), 0.0, f"r{k}") for k in range(2)]
    with pytest.raises(InputError, match="no parameter in N s/m"):
        fit(records, "spring", nuisances=("offset", "temperature"))


# several starts


TWO_MINIMA = {
    "maxwell_slip": {"kx": 252.5, "kw": 74.44, "rho": 311.0},
    "hysteretic_biviscous": {"c": 143.4, "fy": 58.45, "vy": 0.02111, "vh": 0.02627},
}


@pytest.mark.prove
@pytest.mark.parametrize("model", TWO_MINIMA)
def test_several_starts_find_the_lower_of_two_minima(model: str) -> None:
    truth = {f"{model}.{name}": value for name, value in TWO_MINIMA[model].items()}
    record = sine(Damper(model, truth), 0.0, amplitude=0.008, noise=0.3, seconds=5.0)
    one, many = fit(record, model), fit(record, model, starts=8, seed=0)
    assert one.outcome.cost > 2 * many.outcome.cost
    np.testing.assert_allclose(values(many), list(truth.values()), rtol=0.05)
    assert many.starts[0] == 8
    assert 1 <= many.starts[1] < 8
    assert any("of 8 starts ended in the same optimum" in note for note in map(str, many.findings))
    assert fit(record, model, starts=8, seed=0).parameters == many.parameters


def test_all_starts_of_a_plain_problem_agree() -> None:
    fit_result = fit(sine(DAHL, 0.0, noise=1.0), "dahl", starts=6)
    assert fit_result.starts == (6, 6)
    np.testing.assert_allclose(values(fit_result), values(fit(sine(DAHL, 0.0, noise=1.0), "dahl")), rtol=1e-4)


def test_cross_validation_takes_the_same_options() -> None:
    records = gained([1.0, 1.02, 0.98, 1.0, 1.01, 0.99], [1.0] * 6)
    done = cross_validate(
        records, "dahl", options=FitOptions(folds=2, loss="huber", nuisances=("offset", "state", "gain"), starts=2)
    )
    assert max(s.l1 for s in done.scores.values()) < 0.06


# fits that must fail


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
