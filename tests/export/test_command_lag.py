"""A damper whose coil follows its command, in C, as an FMU and in MATLAB: the force is `Damper.force`'s at the command."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from tests.export.kinds import test_fmu, test_matlab

from dampyr.export import export
from dampyr.models import Damper
from dampyr.studies import raminelli_2020

LAGGED = Damper("dahl + lag", dict(raminelli_2020.damper().all_laws) | {"lag.tau": 0.02})
PROMPT = Damper("dahl + lag", dict(raminelli_2020.damper().all_laws) | {"lag.tau": 0.0})


@pytest.mark.prove
@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is missing")
@pytest.mark.parametrize("damper", [LAGGED, PROMPT], ids=["20 ms", "none"])
@pytest.mark.parametrize("single", [False, True])
def test_c_follows_the_command(tmp_path: Path, damper: Damper, single: bool) -> None:
    """By the replay that is written beside it: 1e-9 of the largest force, single precision 1e-4."""
    export(damper, "c", tmp_path, single=single)
    done = subprocess.run(["make", "-s", "test"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "largest difference" in done.stdout
    flags = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-fsyntax-only"]
    subprocess.run(["gcc", *flags, "damper.c"], cwd=tmp_path, check=True)


@pytest.mark.prove
@pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is missing")
@pytest.mark.parametrize("fmi", [2, 3])
def test_an_fmu_follows_the_command_and_shows_what_acts(tmp_path: Path, fmi: int) -> None:
    n = 3000
    [path] = export(LAGGED, "fmu", tmp_path, fmi=fmi)
    with test_fmu.instance(path) as one:
        force = one.walk(n, displacement=test_fmu.X, velocity=test_fmu.V, voltage=test_fmu.U)
        kw = one.get("dahl.kw")
    expected = LAGGED.force(test_fmu.T[:n], test_fmu.X[:n], velocity=test_fmu.V[:n], voltage=test_fmu.U[:n])
    test_fmu.close(force, expected)
    at_once = PROMPT.force(test_fmu.T[:n], test_fmu.X[:n], velocity=test_fmu.V[:n], voltage=test_fmu.U[:n])
    assert np.max(np.abs(expected - at_once)) > 0.03 * np.max(np.abs(expected))  # the lag shows on this path
    acting = float(_acting(test_fmu.T[:n], test_fmu.U[:n], 0.02))
    assert kw == pytest.approx(LAGGED.all_laws["dahl.kw"](acting), rel=1e-9)


def _acting(t: np.ndarray, command: np.ndarray, tau: float) -> float:
    """The lag of a command by an explicit march of a hundredth of each step, extrapolated from two: an own integration."""

    def march(parts: int) -> float:
        u = float(command[0])
        for k in range(1, t.size):
            h = (t[k] - t[k - 1]) / parts
            for j in range(parts):
                begin, end = (command[k - 1] + (command[k] - command[k - 1]) * (j + e) / parts for e in (0, 1))
                u += 0.5 * h * ((begin - u) + (end - (u + h * (begin - u) / tau))) / tau  # Heun's
        return u

    coarse, fine = march(4), march(8)
    return fine + (fine - coarse) / 3.0


@pytest.mark.prove
@test_matlab.needs_octave
def test_matlab_follows_the_command_and_goes_on(tmp_path: Path) -> None:
    export(LAGGED, "matlab", tmp_path, name="damper")
    test_matlab.octave(
        tmp_path,
        [
            test_matlab.save("damper(T, X, V, U)", "whole.txt"),
            "[a, s] = damper(T(1:700), X(1:700), V(1:700), U(1:700));",
            test_matlab.save("[a; damper(T(701:end), X(701:end), V(701:end), U(701:end), s)]", "parts.txt"),
        ],
    )
    expected = LAGGED.force(test_matlab.T, test_matlab.X, velocity=test_matlab.V, voltage=test_matlab.U)
    for file in ("whole.txt", "parts.txt"):
        found = np.loadtxt(tmp_path / file)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())
