"""Ensembles whose inputs are control laws: the same as single responses, named, taken up after a kill."""

from __future__ import annotations

import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from itertools import product
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import DampyrWarning, FileError, InputError
from dampyr.ground_motions import GroundMotion, kanai_tajimi
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
from dampyr.structures.ensembles.store import Labels

HIGH = 3.212


@pytest.fixture(scope="module")
def motions() -> list[GroundMotion]:
    return two_motions(2.0, 1.2)


def two_motions(first: float, second: float) -> list[GroundMotion]:
    """Of different steps, which laws must fit both."""
    return [kanai_tajimi(first, dt=0.02, seed=1, pga=3.0), kanai_tajimi(second, dt=0.01, seed=2, pga=2.0)]


@pytest.fixture(scope="module")
def law() -> object:
    return control_law("on_off", high=HIGH)


@pytest.mark.parametrize(
    ("seconds", "second", "firsts"),
    [((2.0, 1.2), "on_off", [0]), pytest.param((4.0, 3.0), "clipped_optimal", [0, 1], marks=pytest.mark.prove)],
    ids=["short", "long"],
)
def test_the_peaks_are_those_of_single_responses(
    cubics: Damper, law: object, seconds: tuple[float, float], second: str, firsts: list[int]
) -> None:
    """Of every second case of short motions, and of every case."""
    motions, lagging = two_motions(*seconds), control_law(second, high=HIGH, lag=0.01)
    inputs = [0.0, law, HIGH, lagging]
    dataset = ensemble(two_storey(), motions, [None, cubics], inputs, [0.5, 2.0], accuracy="strict").dataset
    assert dataset.attrs["one_by_one"] == 2 * 2 * 2
    assert dataset.attrs["error_estimate"] < 1e-3
    for u, k, first in product((1, 3), (0, 1), firsts):
        s = (k + u // 2 + first) % 2
        motion = motions[k].scaled((0.5, 2.0)[s])
        one = respond(two_storey(), motion, {1: cubics}, voltage=inputs[u], accuracy=5e-5)
        here = dataset.isel(building=0, damper=1, input=u, motion=k, scale=s)
        np.testing.assert_allclose(here.drift, one.peak_drift, rtol=1e-3)
        np.testing.assert_allclose(here.displacement, one.peak_displacement, rtol=1e-3)
        np.testing.assert_allclose(here.energy, one.energy.dampers[:, -1], rtol=2e-3)
    alone = ensemble(two_storey(), motions, cubics, [0.0, HIGH], [0.5, 2.0], accuracy="strict").dataset
    np.testing.assert_array_equal(
        dataset.drift[:, 1, [0, 2]], alone.drift[:, 0]
    )  # numbers beside laws are as without them


@pytest.mark.prove
def test_no_case_under_a_law_is_off_by_a_decision_that_fell_the_other_way(cubics: Damper) -> None:
    """At the step of the rule some of these are: by 35 % the worst of them."""
    law = control_law("lyapunov", high=HIGH)
    motions = [kanai_tajimi(10.0, 0.01, seed=(7, k), pga=3.0) for k in range(1, 6)]
    dataset = ensemble(two_storey(), motions, cubics, law, [0.5, 2.0]).dataset
    assert dataset.attrs["judged"] == dataset.attrs["one_by_one"] == 10
    for k, motion in enumerate(motions):
        for s, scale in enumerate((0.5, 2.0)):
            one = respond(two_storey(), motion.scaled(scale), {1: cubics}, voltage=law, accuracy=2e-5)
            np.testing.assert_allclose(dataset.drift[0, 0, 0, k, s], one.peak_drift, rtol=1e-3)


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
    cubics: Damper, law: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dampyr.structures.time_history.step_size.MAX_STEP_COUNT", 1000)
    motion = kanai_tajimi(3.0, dt=0.02, seed=3, pga=3.0)
    with pytest.warns(DampyrWarning, match="2 cases under control laws are not to their accuracy"):
        dataset = ensemble(two_storey(), motion, cubics, [law, 1.0], [0.5, 1.0], out=tmp_path / "e.h5").dataset
    assert dataset.attrs["unconverged"] == 2
    assert read_ensemble(tmp_path / "e.h5").dataset.identical(dataset)
