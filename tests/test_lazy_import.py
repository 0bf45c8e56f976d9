"""``import dampyr`` is light: no package and no heavy library is loaded before it is needed.

What is loaded is asserted, not how long it takes: a list of modules is the same on every machine.
"""

import json

import pytest

import dampyr
from tests.interpreters import run_text

HEAVY = {"numpy", "scipy", "xarray", "matplotlib", "pint", "numba", "h5py", "pandas", "pooch", "jinja2"}
PACKAGES = [
    "records",
    "models",
    "identification",
    "ground_motions",
    "structures",
    "show",
    "export",
    "studies",
    "rig",
    "campaigns",
]


def loaded_by(statement: str) -> set[str]:
    """The modules that a fresh interpreter holds after ``statement``."""
    code = f"{statement}\nimport sys, json; print(json.dumps(sorted(sys.modules)))"
    run = run_text(code, loaded=())
    assert run.returncode == 0, run.stderr
    return set(json.loads(run.stdout.splitlines()[-1]))


def test_import_loads_no_package_and_no_heavy_library() -> None:
    loaded = loaded_by("import dampyr")
    assert {name for name in loaded if name.split(".")[0] == "dampyr"} == {"dampyr"}
    assert not HEAVY & loaded


@pytest.mark.parametrize("package", PACKAGES)
def test_entering_a_room_loads_only_light_libraries(package: str) -> None:
    """A room needs numpy at most; what compiles, plots or opens files is loaded by the call that uses it."""
    loaded = loaded_by(f"import dampyr; dampyr.{package}")
    assert f"dampyr.{package}" in loaded
    assert not (HEAVY - {"numpy"}) & loaded


def test_every_room_is_listed() -> None:
    assert set(PACKAGES) <= set(dir(dampyr))


def test_an_unknown_room_names_the_rooms() -> None:
    with pytest.raises(AttributeError, match=r"'recods'.*its packages are records, models"):
        _ = dampyr.recods


@pytest.mark.parametrize("module", ["limits", "jobs.ensemble", "jobs.identify", "jobs.respond", "jobs.validate"])
def test_an_upload_and_a_job_of_the_console_start_without_its_web_server(module: str) -> None:
    loaded = loaded_by(f"import dampyr.console.job_work, dampyr.console.{module}")
    assert not (HEAVY - {"numpy"} | {"fastapi", "starlette", "uvicorn", "nidaqmx", "serial"}) & loaded
