"""Requests of the Building page as buildings and motions: closed forms, and what is refused."""

import numpy as np
import pytest

pytest.importorskip("fastapi")
from pydantic import ValidationError

from dampyr.console.building_schemas import (
    BuildingRequest,
    DamperRequest,
    EnsembleRequest,
    MotionRequest,
    ResponseRequest,
    files_read,
    published_structure,
)
from dampyr.errors import InputError
from dampyr.ground_motions import el_centro
from dampyr.models import Damper
from dampyr.studies import raminelli_2020


def test_a_shear_building_has_its_masses_and_its_chain_of_stiffnesses(data):
    building = BuildingRequest(kind="shear", masses=[2.0, 3.0], stiffnesses=[500.0, 300.0]).building(data)
    np.testing.assert_array_equal(building.M, np.diag([2.0, 3.0]))
    np.testing.assert_allclose(building.K, [[800.0, -300.0], [-300.0, 300.0]])


def test_a_motion_is_scaled_to_its_peak_and_synthetic_ones_differ_by_their_seeds(data):
    scaled = MotionRequest(pga=2.5).motion(data)
    record = el_centro()
    assert np.abs(scaled.acceleration).max() == pytest.approx(2.5)
    np.testing.assert_allclose(scaled.acceleration, 2.5 / record.pga * np.asarray(record.acceleration))
    synthetic = MotionRequest(kind="kanai_tajimi", seed=5, duration=3.0)
    first, second = synthetic.motions(data, 2)
    assert not np.array_equal(first.acceleration, second.acceleration)
    np.testing.assert_array_equal(synthetic.motion(data).acceleration, first.acceleration)
    ensemble = EnsembleRequest(motion=synthetic, motions=2, seed=5)
    np.testing.assert_array_equal(ensemble.synthetic_or_one(data)[1].acceleration, second.acceleration)


def test_a_damper_without_an_input_is_one_case_and_refuses_inputs_and_laws():
    damper = Damper("dahl", {"kx": 1200.0, "kw": 200.0, "rho": 2000.0}, input="none")
    assert DamperRequest().inputs_by_kind(damper) == {"voltage": [None]}
    for given in ({"inputs": [0.0]}, {"laws": ["on_off"]}):
        with pytest.raises(InputError, match="has no input, and inputs or control laws are given; leave them out"):
            DamperRequest(**given).inputs_by_kind(damper)


def test_inputs_are_numbers_then_laws():
    damper = raminelli_2020.damper()
    numbers = DamperRequest(inputs=[0.0, 1.98], laws=["on_off"]).inputs_by_kind(damper)["voltage"]
    assert numbers[:2] == [0.0, 1.98]
    assert len(numbers) == 3
    with pytest.raises(InputError, match="no input and no control law is given"):
        DamperRequest().inputs_by_kind(damper)


def test_a_published_structure_is_never_a_file(data, monkeypatch):
    (data / "mine.toml").write_text("masses = [1]\nstiffnesses = [2]\n")
    monkeypatch.chdir(data)
    with pytest.raises(InputError, match="is not a published structure; choose from"):
        published_structure("mine.toml")


def test_the_files_that_a_request_reads_are_named(data):
    for folder, name in (("structures", "tower.toml"), ("motions", "kobe.csv"), ("cards", "mine.toml")):
        (data / folder).mkdir()
        (data / folder / name).write_text("")
    request = ResponseRequest(
        building={"kind": "file", "name": "tower.toml"},
        motion={"kind": "file", "file": "kobe.csv"},
        damper={"name": "cards/mine.toml", "inputs": [1.0]},
    )
    named = [path.relative_to(data).as_posix() for path in files_read(data, request)]
    assert named == ["structures/tower.toml", "cards/mine.toml", "motions/kobe.csv"]
    assert files_read(data, ResponseRequest()) == []


@pytest.mark.parametrize(
    "wrong", [{"masses": [0.0]}, {"masses": [1e16]}, {"damping": 1.0}, {"storeys": 2}, {"masses": [1.0] * 41}]
)
def test_numbers_that_cannot_be_computed_with_are_refused(wrong):
    with pytest.raises(ValidationError):
        BuildingRequest(kind="shear", **wrong)


def test_a_storey_has_one_damper():
    damper = raminelli_2020.damper()
    assert DamperRequest(storeys=[1, 2]).placed(damper) == {1: damper, 2: damper}
    with pytest.raises(InputError, match="named twice"):
        DamperRequest(storeys=[2, 2]).placed(damper)
