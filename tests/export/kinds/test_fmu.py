"""The FMU: valid by FMPy, its force that of dampyr, native code without Python."""

from __future__ import annotations

import shutil
import subprocess
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu
from tests.export.every_law import everything

from dampyr.errors import InputError
from dampyr.export import export
from dampyr.models import Damper
from dampyr.models.inverse import REASONS
from dampyr.studies import raminelli_2020

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is missing: an FMU cannot be compiled")
N = 10_000
T = np.linspace(0.0, 10.0, N)
X = 0.01 * np.sin(6.0 * T + 0.5 * T**2)
V = 0.01 * (6.0 + T) * np.cos(6.0 * T + 0.5 * T**2)
U = 1.5 + 1.4 * np.sin(5.0 * T)
BOTH = pytest.mark.parametrize("fmi", [2, 3])


class Instance:
    """An instance of an FMU, in the same words for both versions of the standard."""

    def __init__(self, path: Path, name: str = "one") -> None:
        about = fmpy.read_model_description(str(path))
        kind = FMU2Slave if about.fmiVersion.startswith("2") else FMU3Slave
        self.references = {each.name: each.valueReference for each in about.modelVariables}
        self.unit: Any = kind(
            guid=about.guid, unzipDirectory=fmpy.extract(str(path)), modelIdentifier="damper", instanceName=name
        )
        self.second = kind is FMU2Slave
        self.messages: list[str] = []
        self.unit.instantiate(**self._callbacks())
        if self.second:
            self.unit.setupExperiment(startTime=float(T[0]))
        self.unit.enterInitializationMode()

    def _callbacks(self) -> dict[str, Any]:
        return {}

    def set(self, **values: float) -> None:
        write = self.unit.setReal if self.second else self.unit.setFloat64
        write([self.references[name] for name in values], [float(value) for value in values.values()])

    def get(self, name: str = "force") -> float:
        read = self.unit.getReal if self.second else self.unit.getFloat64
        return float(read([self.references[name]])[0])

    def walk(self, n: int = N, first: int = 0, **columns: Any) -> np.ndarray:
        """The force read after the inputs of each time are set, from sample ``first`` to ``n``."""
        force = []
        for k in range(first, n):
            if k:
                self.unit.doStep(float(T[k - 1]), float(T[k] - T[k - 1]))
            self.set(**{name: values[k] for name, values in columns.items()})
            if not k:
                self.unit.exitInitializationMode()
            force.append(self.get())
        return np.array(force)


@contextmanager
def instance(path: Path, name: str = "one") -> Iterator[Instance]:
    made = Instance(path, name)
    try:
        yield made
    finally:
        made.unit.freeInstance()


def written(folder: Path, damper: Damper | None = None, **options: Any) -> Path:
    [path] = export(damper or everything(), "fmu", folder, **options)
    return path


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    """The FMU of `everything`, compiled once for each version of the standard."""
    return {fmi: written(tmp_path_factory.mktemp(f"fmi{fmi}"), fmi=fmi) for fmi in (2, 3)}


def close(ours: np.ndarray, expected: np.ndarray) -> None:
    np.testing.assert_allclose(ours, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


@BOTH
def test_it_is_valid_and_its_force_is_that_of_dampyr(compiled: dict[int, Path], fmi: int) -> None:
    """10,000 samples of a path with a varying input, to 1e-9 of the largest force."""
    path = compiled[fmi]
    assert validate_fmu(str(path)) == []
    with instance(path) as one:
        force = one.walk(displacement=X, velocity=V, voltage=U)
    close(force, everything().force(T, X, velocity=V, voltage=U))


@pytest.mark.parametrize("fmi", [2, pytest.param(3, marks=pytest.mark.prove)])
def test_fmpy_simulates_it_and_the_force_lags_by_a_step(tmp_path: Path, fmi: int) -> None:
    """A master that reads before it sets sees the force of the inputs it set last."""
    damper = raminelli_2020.damper()
    signals = np.rec.fromarrays([T, X, V, U], names=["time", "displacement", "velocity", "voltage"])
    result = fmpy.simulate_fmu(
        str(written(tmp_path, damper, fmi=fmi)), start_time=0.0, stop_time=T[-1], step_size=T[1], output_interval=T[1],
        input=signals, output=["force", "dahl.kw"],
    )  # fmt: skip
    force = damper.force(T, X, velocity=V, voltage=U)
    assert len(result) == N
    close(result["force"][1:], force[:-1])
    names = list(damper.all_laws)
    kw = np.array([damper.values(float(u))[names.index("dahl.kw")] for u in U[:50]])
    np.testing.assert_allclose(result["dahl.kw"][1:51], kw, rtol=1e-12)


@BOTH
@pytest.mark.parametrize("drive", ["displacement", "velocity"])
@pytest.mark.prove
def test_what_is_not_driven_is_derived(tmp_path: Path, fmi: int, drive: str) -> None:
    damper = everything().without("delay")
    slope = np.concatenate([[0.0], np.diff(X) / np.diff(T)])
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (V[1:] + V[:-1]) * np.diff(T))])
    x, v = (X, slope) if drive == "displacement" else (integral, V)
    with instance(written(tmp_path, damper, fmi=fmi, drive=drive)) as one:
        force = one.walk(2000, **{drive: x if drive == "displacement" else v}, voltage=U)
        with pytest.raises(FMICallException):
            one.set(**{"velocity" if drive == "displacement" else "displacement": 1.0})
    close(force, damper.force(T[:2000], x[:2000], velocity=v[:2000], voltage=U[:2000]))


@pytest.mark.parametrize("fmi", [2, pytest.param(3, marks=pytest.mark.prove)])
def test_two_instances_do_not_disturb_each_other(compiled: dict[int, Path], fmi: int) -> None:
    path = compiled[fmi]
    with instance(path, "a") as a, instance(path, "b") as b:
        first, second = [], []
        for k in range(1000):
            for one, sign, into in ((a, 1.0, first), (b, -0.5, second)):
                if k:
                    one.unit.doStep(float(T[k - 1]), float(T[k] - T[k - 1]))
                one.set(displacement=sign * X[k], velocity=sign * V[k], voltage=U[k])
                if not k:
                    one.unit.exitInitializationMode()
                into.append(one.get())
    for sign, force in ((1.0, first), (-0.5, second)):
        expected = everything().force(T[:1000], sign * X[:1000], velocity=sign * V[:1000], voltage=U[:1000])
        close(np.array(force), expected)


@BOTH
def test_reset_and_stored_states_repeat_the_path(compiled: dict[int, Path], fmi: int) -> None:
    path = {"displacement": X, "velocity": V, "voltage": U}
    with instance(compiled[fmi]) as one:
        begun = one.walk(500, **path)
        state = one.unit.getFMUState() if not one.second else one.unit.getFMUstate()
        gone_on = one.walk(1000, 500, **path)
        (one.unit.setFMUState if not one.second else one.unit.setFMUstate)(state)
        np.testing.assert_array_equal(one.walk(1000, 500, **path), gone_on)
        one.unit.reset()
        if one.second:
            one.unit.setupExperiment(startTime=0.0)
        one.unit.enterInitializationMode()
        np.testing.assert_array_equal(one.walk(500, **path), begun)


def test_derivatives_of_the_inputs_look_ahead(compiled: dict[int, Path]) -> None:
    """FMI 2: with the slopes to the next sample, the force is right before the next inputs are set."""
    slopes = [np.append(np.diff(each) / np.diff(T), 0.0) for each in (X, V, U)]
    expected = everything().force(T, X, velocity=V, voltage=U)
    force = []
    with instance(compiled[2]) as one:
        references = [one.references[name] for name in ("displacement", "velocity", "voltage")]
        for k in range(2000):
            if k:
                one.unit.doStep(float(T[k - 1]), float(T[k] - T[k - 1]))
                force.append(one.get())
            one.set(displacement=X[k], velocity=V[k], voltage=U[k])
            if not k:
                one.unit.exitInitializationMode()
            one.unit.setRealInputDerivatives(references, [1, 1, 1], [float(each[k]) for each in slopes])
    close(np.array(force), expected[1:2000])


@BOTH
def test_what_is_out_of_range_is_an_error(compiled: dict[int, Path], fmi: int) -> None:
    with instance(compiled[fmi]) as one:
        one.set(displacement=0.0, velocity=0.0, voltage=3.5)
        one.unit.exitInitializationMode()
        with pytest.raises(FMICallException):
            one.get()
        with pytest.raises(FMICallException):
            one.unit.doStep(0.0, 0.01)
        one.set(voltage=1.0)
        assert np.isfinite(one.get())
        with pytest.raises(FMICallException):
            one.set(voltage=float("nan"))
        with pytest.raises(FMICallException):
            one.set(force=1.0)
        with pytest.raises(FMICallException):
            one.unit.doStep(0.0, -0.01)


@pytest.mark.parametrize("fmi", [2, pytest.param(3, marks=pytest.mark.prove)])
def test_where_extrapolation_is_allowed_it_is_none(tmp_path: Path, fmi: int) -> None:
    with instance(written(tmp_path, fmi=fmi, allow_extrapolation=True)) as one:
        one.set(displacement=0.0, velocity=0.0, voltage=3.5)
        one.unit.exitInitializationMode()
        assert np.isfinite(one.get())


@BOTH
def test_there_is_no_python_in_it_and_its_sources_compile_elsewhere(
    compiled: dict[int, Path], tmp_path: Path, fmi: int
) -> None:
    path = compiled[fmi]
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path / "all")
        names = archive.namelist()
    [library] = [name for name in names if name.startswith("binaries/")]
    assert library.startswith("binaries/linux64/" if fmi == 2 else "binaries/x86_64-linux/") or "linux" not in library
    if shutil.which("ldd"):
        needed = subprocess.run(["ldd", tmp_path / "all" / library], capture_output=True, text=True, check=True).stdout
        assert "python" not in needed
    sources = sorted(tmp_path.glob("all/sources/*.c"))
    flags = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-fsyntax-only"]
    subprocess.run(["gcc", *flags, *map(str, sources)], check=True)
    assert ("sources/buildDescription.xml" in names) is (fmi == 3)
    assert path.read_bytes() == written(tmp_path / "again", fmi=fmi).read_bytes()


def test_what_cannot_be_written_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for options, words in (
        ({"fmi": 1}, "fmi = 1 is not a version that is written; choose 2 or 3"),
        ({"drive": "force"}, "drive = 'force' is not known; choose from both, displacement, velocity"),
        ({"single": True}, "single is not an option of the export fmu; its options are fmi, drive"),
    ):
        with pytest.raises(InputError, match=words):
            export(everything(), "fmu", tmp_path / "new", **options)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(InputError, match="an FMU needs a C compiler, and none is installed; install gcc, or"):
        export(everything(), "fmu", tmp_path / "new")
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("fmi", [2, pytest.param(3, marks=pytest.mark.prove)])
def test_the_inverse_finds_the_input_of_a_wanted_force(tmp_path: Path, fmi: int) -> None:
    """What comes out is the input, the force and the reason of Python's, over 1,000 samples; reading twice changes nothing."""
    damper, n = raminelli_2020.damper(), 1000
    path = written(tmp_path, damper, fmi=fmi, inverse=True)
    assert validate_fmu(str(path)) == []
    wanted = 3000.0 * V
    found = damper.inverse().along(T[:n], X[:n], wanted[:n], velocity=V[:n])
    names, rows = ("voltage", "force", "reason", "monotone", "dahl.kw", "wanted_force"), []
    with instance(path) as one:
        for k in range(n):
            if k:
                one.unit.doStep(float(T[k - 1]), float(T[k] - T[k - 1]))
            one.set(displacement=X[k], velocity=V[k], wanted_force=wanted[k])
            if not k:
                one.unit.exitInitializationMode()
            one.get()
            rows.append([one.get(name) for name in names])
    voltage, force, reason, monotone, friction, asked = np.array(rows).T
    close(voltage, found.input)
    close(force, found.force)
    close(friction, damper.laws["dahl.kw"](found.input))
    assert [REASONS[int(k)] for k in reason] == found.reason.tolist()
    assert monotone.tolist() == found.monotone.tolist()
    assert {"met", "below_smallest"} <= set(found.reason)
    np.testing.assert_array_equal(asked, wanted[:n])
