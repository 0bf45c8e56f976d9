"""A control law in C: it compiles without a warning and decides on samples as Python does, and what it reads is said."""

import shutil
import subprocess

import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.errors import InputError
from dampyr.export import export
from dampyr.structures import available_control_laws, control_law, shear_building
from dampyr.studies import raminelli_2020

needs_make = pytest.mark.skipif(
    shutil.which("make") is None or shutil.which("gcc") is None, reason="make or gcc is missing: C cannot be compiled"
)
QUICK = ("clipped_optimal_lqg", "modulated_friction", "fuzzy", "passive_on")  # every other one is a proof
TOWER = shear_building([2e3] * 3, [3e6] * 3, damping_ratio=0.02, name="tower")


@needs_make
@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.prove] * (name not in QUICK)) for name in available_control_laws()],
)
def test_a_law_in_c_decides_as_in_python(tmp_path, name: str, single: bool) -> None:
    law = control_law(name, high=3.0)
    export(raminelli_2020.damper(), "c", tmp_path, control=law, structure=TOWER, place=2, single=single)
    made = subprocess.run(["make", "-s", "-C", str(tmp_path), "test"], capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stdout + made.stderr
    assert made.stderr == ""
    assert "damper_law: largest difference" in made.stdout


@needs_make
def test_a_law_that_errs_in_c_is_found_by_its_samples(tmp_path) -> None:
    export(raminelli_2020.damper(), "c", tmp_path, control=control_law("clipped_optimal", high=3.0))
    source = tmp_path / "damper_law.c"
    source.write_text(
        source.read_text("utf-8").replace(" > 0.0 ?", " < 0.0 ?").replace("> 0.0) ?", "< 0.0) ?"), "utf-8"
    )
    made = subprocess.run(["make", "-s", "-C", str(tmp_path), "test"], capture_output=True, text=True, check=False)
    assert made.returncode != 0


def test_the_header_says_what_is_measured(tmp_path) -> None:
    law = control_law("clipped_optimal_lqg", high=3.0)
    export(raminelli_2020.damper(), "c", tmp_path, control=law, structure=TOWER, place=2)
    header = (tmp_path / "damper_law.h").read_text("utf-8")
    for line in (
        "y[0]  absolute accelerations of all floors, floor 1 [m/s^2]",
        "y[2]  absolute accelerations of all floors, floor 3 [m/s^2]",
        "y[3]  force of the damper, positive against positive rate [N]",
        "clipped_optimal_lqg 0 to 3 V of tower",
        "#define DAMPER_LAW_PERIOD 0.005 /* s */",
    ):
        assert line in header


def test_on_the_command_line(tmp_path) -> None:
    words = ["export", "raminelli_2020", "--to", "c", "--out", str(tmp_path), "--control", "on_off:high=2,period=10ms"]
    done = CliRunner().invoke(cli, words)
    assert done.exit_code == 0, done.output
    assert "damper_law.c" in done.output
    assert "PERIOD 0.01" in (tmp_path / "damper_law.h").read_text("utf-8")
    refused = CliRunner().invoke(
        cli, ["export", "raminelli_2020", "--to", "c", "--storey", "2", "--out", str(tmp_path)]
    )
    assert refused.exit_code == 2
    assert "give --control LAW" in refused.stderr


def test_what_is_wrong_is_said(tmp_path) -> None:
    damper = raminelli_2020.damper()
    for law, message in (
        (3.0, "control is a float"),
        (control_law("on_off", high=9.0), "9 V is outside the calibrated range"),
    ):
        with pytest.raises(InputError, match=message):
            export(damper, "c", tmp_path / "out", control=law)
    assert not (tmp_path / "out").exists()
    with pytest.raises(InputError, match="control is not an option of the export matlab"):
        export(damper, "matlab", tmp_path / "out", control=control_law("on_off", high=1.0))
