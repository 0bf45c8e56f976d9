"""Rigs that the console can connect to."""

import pytest

pytest.importorskip("fastapi")

from dampyr.console.rigs import ORIGINAL, opened, rig_file, rig_names, rig_settings
from dampyr.errors import InputError
from dampyr.rig import RigSettings


def test_a_rig_with_an_error_in_its_file_is_listed_with_it(client, data):
    (data / "rigs" / "lab").mkdir(parents=True)
    (data / "rigs" / "lab" / "rig.toml").write_text("[actuator]\nspeeed = 1\n")
    problem = client.get("/api/bench/rigs").json()[1]
    assert problem["name"] == "lab"
    assert "is not known" in problem["problem"]


def test_a_rig_is_the_file_of_its_folder_and_the_original_one_has_none(data):
    for name in ("b", "a"):
        (data / "rigs" / name).mkdir(parents=True)
        (data / "rigs" / name / "rig.toml").write_text(f'name = "rig {name}"\n')
    (data / "rigs" / "empty").mkdir()
    assert rig_names(data) == ["a", "b"]
    assert rig_file(data, "a") == data / "rigs" / "a" / "rig.toml"
    assert rig_settings(data, "a").name == "rig a"
    assert (rig_file(data, ORIGINAL), rig_settings(data, ORIGINAL)) == (None, RigSettings())
    for name in ("empty", "../rigs/a", "c"):
        with pytest.raises(InputError, match="is not known; choose from a, b"):
            rig_file(data, name)


def test_the_original_rig_has_no_wires(data):
    with pytest.raises(InputError, match="has no wires here; simulate it"):
        opened(data, ORIGINAL, simulate=False)
