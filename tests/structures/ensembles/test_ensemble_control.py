"""Ensembles whose inputs are control laws: the same as single responses, named, taken up after a kill."""

from __future__ import annotations

import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
from tests.endurance import Endurance

from dampyr.errors import DampyrWarning, FileError, InputError
from dampyr.ground_motions import GroundMotion, el_centro, kanai_tajimi
from dampyr.models import Damper
from dampyr.structures import (
    collect,
    control_law,
    ensemble,
    ensemble_cases,
    fragility,
    read_ensemble,
    respond,
    summary,
    two_storey,
    write_part,
)
from dampyr.structures.controller import module_of
from dampyr.structures.ensembles.store import Labels
from dampyr.structures.law_form import ControlLaw
from dampyr.structures.sensors import Sensor

HIGH = 3.212
MEASURES = ("rate",)
# A response at a given step says so where the forces of a few steps converged to 1e-9 and not to 1e-10.
STEPS_OF_A_RESPONSE = pytest.mark.filterwarnings(
    "ignore:the response is not to its accuracy:dampyr.errors.DampyrWarning"
)


@dataclass(frozen=True)
class Beyond(ControlLaw):
    """A law that asks for more than its greatest input."""


def decide(rate: float, low: float, high: float) -> float:
    return high + 0.1 if rate > 0.0 else low


@pytest.fixture(scope="module")
def motions() -> list[GroundMotion]:
    return two_motions(2.0, 1.2)


def two_motions(first: float, second: float) -> list[GroundMotion]:
    """Of different steps, which laws must fit both."""
    return [kanai_tajimi(first, dt=0.02, seed=1, pga=3.0), kanai_tajimi(second, dt=0.01, seed=2, pga=2.0)]


@pytest.fixture(scope="module")
def law() -> object:
    return control_law("on_off", high=HIGH)


FAULTS = {
    "stroke": Sensor(2e-5, 1e-5, 1e-5, delay=1),
    "rate": Sensor(1e-3, 1e-3, 1e-3, delay=1),
    "absolute_rate": Sensor(1e-3, 0.0, 0.0, 0.2, delay=2),
    "velocity": Sensor(1e-3, 1e-3, 1e-3, delay=1),
    "force": Sensor(3.0, 1.0, 1.0, 300.0),
    "accelerations": Sensor(0.05, 0.01, 0.01, delay=1),
}


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("clipped_optimal_lqg", 1),
        ("modulated_friction", 1),
        *(pytest.param(name, 1, marks=pytest.mark.prove) for name in ("bang_bang", "fuzzy", "power_driven")),
        pytest.param("clipped_optimal_lqg", 2, marks=pytest.mark.prove),
    ],
)
@STEPS_OF_A_RESPONSE
def test_lanes_take_the_steps_of_a_response_with_sensors_that_err(cubics: Damper, name: str, place: int) -> None:
    """Noise, bias, quantum, range and delay, the filter's memory, the coil's lag, at the same step with the same noise."""
    measures = module_of(control_law(name, high=HIGH)).MEASURES
    sensors = {measure: FAULTS[measure] for measure in measures if measure in FAULTS}
    law = control_law(name, high=HIGH, lag=0.01, sensors=sensors, seed=5)
    motion, scales = kanai_tajimi(3.0, dt=0.02, seed=1, pga=3.0), [0.5, 1.0, 1.5]
    dataset = ensemble(two_storey(), motion, {place: cubics}, law, scales, accuracy="strict").dataset
    assert dataset.attrs["one_by_one"] == 0
    assert dataset.attrs["judged_under_laws"] == 3
    for s, scale in enumerate(scales):
        one = respond(two_storey(), motion.scaled(scale), {place: cubics}, voltage=law, step=0.00125)
        here = dataset.isel(building=0, damper=0, input=0, motion=0, scale=s)
        np.testing.assert_allclose(here.drift, one.peak_drift, rtol=2e-3)
        np.testing.assert_allclose(here.acceleration, one.peak_acceleration, rtol=5e-3)
        np.testing.assert_allclose(here.force, one.peak_force, rtol=2e-3)
        np.testing.assert_allclose(here.energy, one.energy.dampers[:, -1], rtol=2e-3)


def test_numbers_beside_laws_are_as_without_them(cubics: Damper, motions: list, law: object) -> None:
    inputs = [0.0, law, HIGH]
    dataset = ensemble(two_storey(), motions, [None, cubics], inputs, [0.5, 2.0], accuracy="strict").dataset
    alone = ensemble(two_storey(), motions, cubics, [0.0, HIGH], [0.5, 2.0], accuracy="strict").dataset
    np.testing.assert_array_equal(dataset.drift[:, 1, [0, 2]], alone.drift[:, 0])


@STEPS_OF_A_RESPONSE
def test_forces_that_jump_with_the_input_are_those_of_a_response(cubics: Damper) -> None:
    """Without a lag of the coil: the peaks of force and acceleration at the instant of a decision count."""
    law, motion = control_law("fuzzy", high=HIGH), kanai_tajimi(3.0, dt=0.02, seed=1, pga=3.0)
    dataset = ensemble(two_storey(), motion, {2: cubics}, law, [1.0, 1.5], accuracy="strict").dataset
    for s, scale in enumerate((1.0, 1.5)):
        one = respond(two_storey(), motion.scaled(scale), {2: cubics}, voltage=law, step=0.00125)
        here = dataset.isel(building=0, damper=0, input=0, motion=0, scale=s)
        np.testing.assert_allclose(here.force, one.peak_force, rtol=2e-3)
        np.testing.assert_allclose(here.acceleration, one.peak_acceleration, rtol=1e-2)


@pytest.mark.prove
def test_a_seed_is_the_noise_of_a_case(cubics: Damper) -> None:
    sensors = {"force": Sensor(noise=10.0), "absolute_rate": Sensor(noise=0.01)}
    laws = [control_law("bang_bang", high=HIGH, sensors=sensors, seed=seed) for seed in (1, 2, 1)]
    peaks = ensemble(two_storey(), kanai_tajimi(3.0, 0.02, seed=1, pga=3.0), cubics, laws).dataset.drift[0, 0, :, 0, 0]
    np.testing.assert_array_equal(peaks[0], peaks[2])
    assert abs(float(peaks[1, 0] / peaks[0, 0]) - 1.0) > 1e-4


@pytest.mark.prove
def test_means_under_a_law_change_little_with_the_step_though_single_cases_do(cubics: Damper) -> None:
    """The means of 200 scales at 2.5 ms beside those at 1.25 ms, and what the ensemble says of it."""
    law, scales = control_law("clipped_optimal", high=HIGH), np.linspace(0.2, 2.0, 200)
    motion = kanai_tajimi(10.0, 0.01, seed=(7, 1), pga=3.0)
    fast, strict = (ensemble(two_storey(), motion, cubics, law, scales, accuracy=a) for a in ("fast", "strict"))
    ratio = (fast.dataset.drift / strict.dataset.drift).values.squeeze()
    assert abs(ratio.mean() - 1.0) < 3e-3
    assert np.abs(ratio - 1.0).max() > 0.01
    [note] = [finding for finding in fast.findings if "under control laws" in finding.words]
    assert note.severity == "note"
    assert fast.dataset.attrs["changed_under_laws"] > 0
    few = [ensemble(two_storey(), motion, cubics, law, scales[::5], accuracy=a).dataset for a in ("fast", "strict")]
    for quantity in ("drift", "acceleration", "force"):  # all 40 are judged, at half the step, which is that of strict
        change = (few[0][quantity] / few[1][quantity] - 1.0).values.reshape(40, -1).mean(axis=1)
        assert few[0].attrs[f"change_of_mean_{quantity}"] == pytest.approx(change.mean(), rel=1e-6)
        assert few[0].attrs[f"error_of_mean_{quantity}"] == pytest.approx(2.0 * change.std() / np.sqrt(40), rel=1e-6)
    told, error = (fast.dataset.attrs[f"{part}_of_mean_drift"] for part in ("change", "error"))
    assert abs(told - (ratio.mean() - 1.0)) < 2.0 * error
    assert 1e-4 < error < 0.02


@pytest.mark.by_hand
@pytest.mark.parametrize("name", ["clipped_optimal", "bang_bang"])
def test_mean_peaks_of_a_thousand_scales_are_those_of_responses(
    cubics: Damper, endurance: Endurance, name: str
) -> None:
    """Against `respond`, whose own judge looks at each case; in the mean, and in the middle of the cases."""
    law, scales = control_law(name, high=HIGH), np.linspace(0.1, 2.08, endurance.count(1000))
    responses = [respond(two_storey(), el_centro().scaled(s), {1: cubics}, voltage=law) for s in scales]
    figures = [f"{sum(r.converged for r in responses)} of {len(scales)} responses converged"]
    for accuracy, of_drift, of_others in (("fast", 5e-3, 1.2e-2), ("strict", 3e-3, 6e-3)):
        dataset = ensemble(two_storey(), el_centro(), cubics, law, scales, accuracy=accuracy).dataset
        shifts = {}
        for quantity in ("drift", "acceleration", "force"):
            true = np.array([getattr(r, f"peak_{quantity}") for r in responses])
            ours = dataset[quantity].values.reshape(true.shape)
            shifts[quantity] = float(np.abs(ours.mean(axis=0) / true.mean(axis=0) - 1.0).max())
            middle = float(np.median(np.abs(ours / true - 1.0)))
            figures.append(f"{accuracy}, {quantity}: mean {100 * shifts[quantity]:.2g} %, median {100 * middle:.2g} %")
        if endurance.full:
            assert shifts["drift"] < of_drift
            assert max(shifts["acceleration"], shifts["force"]) < of_others
    endurance.report(
        f"mean peaks under {name}, El Centro at 1,000 scales, beside those of `respond`", None, "; ".join(figures)
    )


def test_laws_are_named_on_their_axis(cubics: Damper, motions: list, law: object) -> None:
    lagging = control_law("on_off", high=HIGH, lag=0.01)
    dataset = ensemble(two_storey(), motions[1], cubics, [1.0, law, lagging], [1.0, 2.0]).dataset
    names = ["1 V", "on_off 0 to 3.212 V", "on_off 0 to 3.212 V, lag 0.01 s"]
    assert dataset.input_name.values.tolist() == names
    assert np.array_equal(dataset.input, [1.0, np.nan, np.nan], equal_nan=True)
    assert float(dataset.drift.sel(input=1.0)[0, 0, 0, 0, 0]) == float(dataset.drift[0, 0, 0, 0, 0, 0])
    assert [row.name for row in summary(dataset)][::2] == names
    assert [curve.name for curve in fragility(dataset, limit=0.01, draws=10).curves] == names


def test_one_law_need_not_be_a_list(cubics: Damper, motions: list, law: object) -> None:
    assert ensemble(two_storey(), motions[1], cubics, law).dataset.sizes["input"] == 1


@pytest.mark.prove  # test_ensemble.py does so without laws
def test_bit_identical_whoever_runs_it(
    cubics: Damper, motions: list, law: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dampyr.structures.ensembles.ensemble_grid.CASES_PER_SHARD", 4)
    given = (two_storey(), motions, cubics, [law, 0.5], [0.5, 1.0, 1.5])
    with ThreadPoolExecutor(1) as one, ProcessPoolExecutor(2, mp_context=get_context("spawn")) as processes:
        assert ensemble(*given, processes).dataset.identical(ensemble(*given, one).dataset)


def test_a_killed_run_goes_on(
    cubics: Damper, motions: list, law: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dampyr.structures.ensembles.ensemble_grid.CASES_PER_SHARD", 2)
    given = (two_storey(), motions, cubics, [law, 0.5], [0.5, 1.0])
    path = tmp_path / "e.h5"

    def killed(done: int, size: int) -> None:
        raise KeyboardInterrupt

    with ThreadPoolExecutor(1) as pool:
        with pytest.raises(KeyboardInterrupt):
            ensemble(*given, pool, out=path, progress=killed)
        again: list[int] = []
        dataset = ensemble(*given, pool, out=path, progress=lambda done, size: again.append(done)).dataset
        assert again == [4, 6, 8]
        assert dataset.identical(ensemble(*given, pool).dataset)
    assert read_ensemble(path).dataset.identical(dataset)
    other = control_law("on_off", high=HIGH, period=0.01)
    with pytest.raises(FileError, match="holds another ensemble"):
        ensemble(*given[:3], [other, 0.5], given[4], out=path)


@pytest.mark.prove  # test_job_array.py does so without laws
def test_parts_put_together_are_the_whole(cubics: Damper, motions: list, law: object, tmp_path: Path) -> None:
    given = (two_storey(), motions, cubics, [law, 0.5], [0.5, 1.0])
    for part in (1, 2):
        write_part(ensemble_cases(*given), part, 2, tmp_path)
    np.testing.assert_array_equal(collect(tmp_path).dataset.drift, ensemble(*given).dataset.drift)


def test_the_digest_is_that_of_every_setting(cubics: Damper, motions: list) -> None:
    settings = [{}, {"low": 0.1}, {"high": 3.0}, {"period": 0.01}, {"lag": 0.002}]
    laws = [control_law("skyhook", **({"high": HIGH} | each)) for each in settings]
    laws += [control_law("skyhook", high=HIGH, ratio=0.5), control_law("on_off", high=HIGH)]
    laws += [
        control_law("skyhook", high=HIGH, seed=2),
        control_law("skyhook", high=HIGH, sensors={"rate": Sensor(noise=1e-3)}),
    ]
    digests = [ensemble_cases(two_storey(), motions, cubics, [law]).digest for law in laws]
    assert len(set(digests)) == len(laws)
    again = control_law("skyhook", high=HIGH)
    assert ensemble_cases(two_storey(), motions, cubics, [again]).digest == digests[0]


def test_labels_of_files_from_before_are_read(cubics: Damper, motions: list) -> None:
    labels = Labels.of(ensemble_cases(two_storey(), motions, [None, cubics], [0.0, 1.5]))
    older = Labels.read(labels.text().replace(', "input_name": ["0 V", "1.5 V"]', ""))
    assert older.input_name == []
    values = {"drift": np.zeros((8, 1, 2))}
    assert older.dataset(values, {}).identical(labels.dataset(values, {}))


@pytest.mark.parametrize(
    ("inputs", "more", "message"),
    [
        ([control_law("on_off", high=5.0)], {}, "5 V is outside the calibrated range"),
        ([control_law("on_off", high=1.0, period=0.0061234)], {}, "does not fit the motion's"),
        ([control_law("lyapunov", high=1.0, weights=(1.0, 2.0))], {}, "give 4 numbers"),
        ([control_law("on_off", high=1.0), "a"], {}, "is not a quantity|must be finite numbers"),
        ([control_law("on_off", high=1.0)], {"device": "gpu"}, "constant inputs only"),
    ],
)
def test_what_is_wrong_is_said_before_anything_runs(
    cubics: Damper, motions: list, inputs: list, more: dict, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.modules["dampyr.structures.ensembles.ensemble"], "run", lambda *_: pytest.fail("it ran"))
    with pytest.raises(ValueError, match=message):
        ensemble(two_storey(), motions, cubics, inputs, **more)


def test_a_law_of_current_is_refused_where_the_damper_takes_a_voltage(cubics: Damper, motions: list) -> None:
    with pytest.raises(InputError, match="takes a voltage"):
        ensemble(two_storey(), motions, cubics, current=[control_law("on_off", high=1.0)])


def test_cases_that_do_not_converge_are_counted_and_said(
    cubics: Damper, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of those that run one by one, as a sensor is late by more samples than an engine keeps."""
    monkeypatch.setattr("dampyr.structures.time_history.step_size.MAX_STEP_COUNT", 1000)
    law = control_law("on_off", high=HIGH, sensors={"rate": Sensor(delay=9)})
    motion = kanai_tajimi(3.0, dt=0.02, seed=3, pga=3.0)
    with pytest.warns(DampyrWarning, match="2 cases under control laws are not to their accuracy"):
        dataset = ensemble(two_storey(), motion, cubics, [law, 1.0], [0.5, 1.0], out=tmp_path / "e.h5").dataset
    assert dataset.attrs["unconverged"] == dataset.attrs["one_by_one"] == 2
    assert read_ensemble(tmp_path / "e.h5").dataset.identical(dataset)


def test_a_law_that_leaves_its_range_is_refused_in_lanes_too(cubics: Damper) -> None:
    with pytest.raises(InputError, match=r"asked for 3.312; it must stay between its low = 0 and high = 3.212"):
        ensemble(two_storey(), kanai_tajimi(2.0, 0.02, seed=1, pga=3.0), cubics, Beyond(0.0, HIGH))
