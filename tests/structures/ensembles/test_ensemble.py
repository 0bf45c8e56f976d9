"""Ensembles against single responses, whoever runs them and however the work is cut."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import FileError, InputError
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.models import Damper
from dampyr.show.structures.ensemble_result import trust
from dampyr.structures import collect, ensemble, read_ensemble, respond, two_storey, write_part
from dampyr.structures.ensembles.ensemble_grid import cases

pytestmark = pytest.mark.filterwarnings("ignore:.*was calibrated:dampyr.errors.DampyrWarning")


@pytest.mark.parametrize("first", [0.5, pytest.param(2.0, marks=pytest.mark.prove)])
def test_the_peaks_are_those_of_single_responses(cubics: Damper, motions: list[GroundMotion], first: float) -> None:
    """Of every second case, beginning with the scale ``first``."""
    dataset = ensemble(two_storey(), motions, cubics, [0.0, 2.25], [0.5, 2.0], accuracy="strict").dataset
    assert dataset.attrs["error_estimate"] < 5e-4
    for j, u in enumerate((0.0, 2.25)):
        for k, motion in enumerate(motions):
            scale = first if (j + k) % 2 == 0 else 1.0 / first
            one = respond(two_storey(), motion.scaled(scale), {1: cubics}, voltage=u, accuracy=5e-5)
            here = dataset.isel(building=0, damper=0, motion=k).sel(input=u, scale=scale)
            np.testing.assert_allclose(here.displacement, one.peak_displacement, rtol=1e-3)
            np.testing.assert_allclose(here.drift, one.peak_drift, rtol=1e-3)
            np.testing.assert_allclose(here.force, one.peak_force, rtol=1e-3)
            np.testing.assert_allclose(here.stroke, one.peak_drift[:1], rtol=1e-3)
            np.testing.assert_allclose(here.energy, one.energy.dampers[:, -1], rtol=2e-3)
            np.testing.assert_allclose(here.acceleration, one.peak_acceleration, rtol=2e-2)


def test_cases_go_on_after_their_records(cubics: Damper, tmp_path: Path) -> None:
    """As `respond` does; the file, its parts and the page say for how long, and a file without it is another ensemble."""
    short = GroundMotion(el_centro().acceleration[:110], 0.02, "start of El Centro")
    given = (two_storey(), short, [None, cubics], 1.0)
    data = ensemble(*given, accuracy="strict", after=2.5, out=tmp_path / "peaks.h5").dataset
    for k, dampers in enumerate(({}, {1: cubics})):
        one = respond(two_storey(), short, dampers, voltage=1.0 if dampers else None, after=2.5)
        np.testing.assert_allclose(data.drift.values[0, k].ravel(), one.peak_drift, rtol=1e-3)
    assert data.drift.values[0, 0].ravel()[1] > 1.05 * ensemble(*given).dataset.drift.values[0, 0].ravel()[1]
    assert read_ensemble(tmp_path / "peaks.h5").dataset.identical(data)
    assert data.attrs["after_s"] == 2.5
    assert "Each case ends 2.5 s after the record." in trust(data)
    with pytest.raises(FileError, match="holds another ensemble"):
        ensemble(*given, accuracy="strict", out=tmp_path / "peaks.h5")
    write_part(cases(*given, accuracy="strict", after=2.5), 1, 1, tmp_path / "parts")
    assert collect(tmp_path / "parts").dataset.attrs["after_s"] == 2.5
    with pytest.raises(InputError, match="after = -1 s is not allowed"):
        ensemble(*given, after=-1)


@pytest.mark.parametrize("precision", [64, pytest.param(32, marks=pytest.mark.prove)])
def test_a_bare_building(precision: int) -> None:
    dataset = ensemble(two_storey(), el_centro(), scales=[1.0, -1.0], precision=precision).dataset
    np.testing.assert_allclose(dataset.displacement[0, 0, 0, 0, 0, 0], 45.5340e-3, rtol=1e-4)  # FACTS, finding 13
    np.testing.assert_array_equal(dataset.displacement[..., 0, :], dataset.displacement[..., 1, :])
    assert "force" not in dataset or dataset.sizes["site"] == 0


@pytest.mark.prove
def test_single_precision_is_good_for_four_digits(cubics: Damper) -> None:
    double, single = (ensemble(two_storey(), el_centro(), cubics, [1.0], precision=p).dataset for p in (64, 32))
    np.testing.assert_allclose(single.drift, double.drift, rtol=2e-4)
    assert not np.array_equal(single.drift, double.drift)


def test_bit_identical_whoever_runs_it(cubics: Damper, motions: list[GroundMotion]) -> None:
    given = (two_storey(), motions, cubics, [0.0, 1.0], np.linspace(0.2, 2.0, 23))
    alone = ensemble(*given).dataset
    with ThreadPoolExecutor(1) as one, ProcessPoolExecutor(2, mp_context=get_context("spawn")) as processes:
        for executor in (one, processes):
            assert ensemble(*given, executor).dataset.identical(alone)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"voltage": [1.0], "current": [1.0]}, "both voltage= and current="),
        ({"voltage": ["a"]}, "voltage: 'a' is not a quantity; write a number and a unit"),
        ({"accuracy": "rough"}, "choose from fast, strict"),
        ({"precision": 16}, "choose from 64, 32"),
        ({"quantities": ["shear"]}, "choose from displacement"),
        ({"scales": []}, "must be finite numbers"),
        ({"dampers": []}, "dampers is empty"),
        ({"voltage": None}, "has no voltage"),
        ({"voltage": [9.0]}, "range"),
    ],
)
def test_what_is_wrong_is_said_before_anything_runs(cubics: Damper, given: dict, message: str) -> None:
    arguments = {"dampers": cubics, "voltage": [0.0]} | given
    with pytest.raises(ValueError, match=message):
        ensemble(two_storey(), el_centro(), **arguments)
