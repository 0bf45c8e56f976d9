"""The FMU for model exchange: valid by FMPy, and integrated by CVODE its force is that of dampyr's own steps."""

import shutil
import subprocess
import zipfile
from pathlib import Path
from typing import Any

import fmpy
import fmpy.sundials
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model
from fmpy.fmi3 import FMU3Model
from fmpy.validation import validate_fmu

from dampyr.errors import InputError
from dampyr.export import export
from dampyr.models import Damper, available_parts
from dampyr.models.part import part
from dampyr.studies import raminelli_2020

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is missing: an FMU cannot be compiled")
DT = 1e-3
T = np.arange(1001) * DT
V = np.where(np.abs(np.cos(10.0 * np.pi * T)) < 1e-9, 0.0, 0.1 * np.cos(10.0 * np.pi * T))  # turns round at samples
U = 1.5 + 1.4 * np.sin(5.0 * T)
TOLERANCE = 1e-8
LAGGED = Damper("dahl + lag", dict(raminelli_2020.damper().all_laws) | {"lag.tau": 0.02})
WITH_RATES = [name for name in available_parts() if part(name).rates]


class InputsInTheSolver(fmpy.sundials.CVodeSolver):
    """FMPy's solver, which leaves the inputs as they were at its last step; here they are those of the time asked for."""

    def f(self, t: float, y: Any, ydot: Any, user_data: Any) -> Any:
        self.input.apply(t)
        return super().f(t, y, ydot, user_data)


@pytest.fixture(autouse=True)
def inputs_in_the_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fmpy.sundials, "CVodeSolver", InputsInTheSolver)


def integral(t: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])


def expected(damper: Damper, order: int = 2, u: np.ndarray | None = None, parts: int = 16) -> np.ndarray:
    """The force of dampyr where the velocity is straight between the samples: two refined paths, extrapolated."""

    def refined(m: int) -> np.ndarray:
        t = np.linspace(0.0, T[-1], (T.size - 1) * m + 1)
        v = np.interp(t, T, V)
        follows = {} if u is None else {"voltage": np.interp(t, T, u)}
        return damper.force(t, integral(t, v), velocity=v, **follows)[::m]

    coarse, fine = refined(parts), refined(2 * parts)
    return fine + (fine - coarse) / (2**order - 1)


def simulated(path: Path, tolerance: float = TOLERANCE, **inputs: np.ndarray) -> np.ndarray:
    signals = np.rec.fromarrays([T, *inputs.values()], names=["time", *inputs])
    result = fmpy.simulate_fmu(
        str(path), fmi_type="ModelExchange", relative_tolerance=tolerance, output_interval=DT, stop_time=float(T[-1]),
        input=signals, output=["force"],
    )  # fmt: skip
    at_samples = result[np.isin(np.round(result["time"] / DT, 6), np.arange(T.size))]
    return np.interp(T, at_samples["time"], at_samples["force"])


def constants(names: str) -> Damper:
    values = {f"{name}.{key}": v for name in names.split(" + ") for key, v in part(name).module.EXAMPLE.items()}
    return Damper(names, values, input="none")


def check(found: np.ndarray, force: np.ndarray, tolerance: float = 1e-6) -> None:
    np.testing.assert_allclose(found, force, rtol=0.0, atol=tolerance * np.abs(force).max())


@pytest.mark.parametrize("fmi", [2, pytest.param(3, marks=pytest.mark.prove)])
@pytest.mark.parametrize("drive", ["both", pytest.param("velocity", marks=pytest.mark.prove)])
def test_it_is_valid_and_its_force_is_that_of_dampyr(tmp_path: Path, fmi: int, drive: str) -> None:
    """The published Dahl damper at 1.98 V, to 1e-6 of the largest force at a tolerance of 1e-8."""
    damper = raminelli_2020.damper()
    [path] = export(damper, "fmu", tmp_path, fmi=fmi, drive=drive, model_exchange=True)
    assert validate_fmu(str(path)) == []
    u = np.full(T.size, 1.98)
    motion = {"velocity": V} | ({"displacement": integral(T, V)} if drive == "both" else {})
    check(simulated(path, **motion, voltage=u), expected(damper, u=u))


@pytest.mark.prove
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("name", WITH_RATES)
def test_every_part_that_is_a_differential_equation(tmp_path: Path, fmi: int, name: str) -> None:
    """At constant numbers, beside a spring, to 1e-6; in the narrow pinch of Baber and Noori dampyr's steps of second order are
    refined further."""
    damper, pinches = constants(f"{name} + spring"), name == "bouc_wen_baber_noori"
    [path] = export(damper, "fmu", tmp_path, fmi=fmi, model_exchange=True)
    assert validate_fmu(str(path)) == []
    found = simulated(path, velocity=V, displacement=integral(T, V))
    check(found, expected(damper, parts=64 if pinches else 16))


@pytest.mark.prove
@pytest.mark.parametrize("fmi", [2, 3])
def test_an_input_that_varies_and_a_coil_that_follows_it(tmp_path: Path, fmi: int) -> None:
    """The steps of dampyr take the input at their ends, so that they are of first order in it; extrapolated, to 1e-6."""
    motion = {"velocity": V, "displacement": integral(T, V), "voltage": U}
    for damper, name in ((raminelli_2020.damper(), "prompt"), (LAGGED, "lagged")):
        [path] = export(damper, "fmu", tmp_path, name=name, fmi=fmi, model_exchange=True)
        assert validate_fmu(str(path)) == []
        # a coil begins at the command of the first sample in dampyr, and where the master sets it here
        start = {} if name == "prompt" else {"start_values": {"acting_voltage": U[0]}}
        signals = np.rec.fromarrays([T, *motion.values()], names=["time", *motion])
        result = fmpy.simulate_fmu(
            str(path), fmi_type="ModelExchange", relative_tolerance=TOLERANCE, output_interval=DT, stop_time=1.0,
            input=signals, output=["force", "dahl.kw"], **start,
        )  # fmt: skip
        force = np.interp(T, result["time"], result["force"])
        check(force, expected(damper, order=1, u=U, parts=64), 2e-6)
        if name == "prompt":
            kw = np.interp(T, result["time"], result["dahl.kw"])
            np.testing.assert_allclose(kw, damper.laws["dahl.kw"](U), rtol=1e-6)


def test_where_the_states_begin_is_the_masters_choice(tmp_path: Path) -> None:
    """A damper that has slipped forwards before: w = 1 from the start, so that its friction is there at once."""
    damper = constants("dahl")
    [path] = export(damper, "fmu", tmp_path, model_exchange=True)
    signals = np.rec.fromarrays([T, np.full(T.size, 0.1), 0.1 * T], names=["time", "velocity", "displacement"])
    result = fmpy.simulate_fmu(
        str(path), fmi_type="ModelExchange", output_interval=DT, stop_time=1.0, input=signals, output=["force"],
        start_values={"dahl.w": 1.0},
    )  # fmt: skip
    np.testing.assert_allclose(result["force"], 0.1 * 1000.0 + 300.0, rtol=1e-9)


def model(path: Path, fmi: int) -> tuple[Any, dict[str, int]]:
    about = fmpy.read_model_description(str(path))
    kind = FMU2Model if fmi == 2 else FMU3Model
    one = kind(guid=about.guid, unzipDirectory=fmpy.extract(str(path)), modelIdentifier="damper", instanceName="one")
    one.instantiate()
    if fmi == 2:
        one.setupExperiment(startTime=0.0)
    one.enterInitializationMode()
    return one, {each.name: each.valueReference for each in about.modelVariables}


@pytest.mark.parametrize("fmi", [2, pytest.param(3, marks=pytest.mark.prove)])
def test_out_of_range_is_an_error_and_a_stored_state_comes_back(tmp_path: Path, fmi: int) -> None:
    [path] = export(raminelli_2020.damper(), "fmu", tmp_path, fmi=fmi, model_exchange=True)
    one, references = model(path, fmi)
    write, read = (one.setReal, one.getReal) if fmi == 2 else (one.setFloat64, one.getFloat64)
    keep, restore = (
        (one.getFMUstate, one.setFMUstate) if fmi == 2 else (one.getFMUState, one.setFMUState)
    )  # the same in both
    try:
        write([references[key] for key in ("velocity", "voltage", "dahl.w")], [0.1, 1.0, 0.5])
        one.exitInitializationMode()
        [force, w, rate, sign] = [
            read([references[key]])[0] for key in ("force", "dahl.w", "der(dahl.w)", "switch[1]")
        ] if fmi == 3 else [*(read([references[key]])[0] for key in ("force", "dahl.w", "der(dahl.w)")), 0.1]  # fmt: skip
        kx, kw, rho = raminelli_2020.damper().values(1.0)
        assert (force, w, rate, sign) == pytest.approx((kx * 0.1 + kw * 0.5, 0.5, rho * 0.05, 0.1), rel=1e-12)
        state = keep()
        write([references["voltage"]], [9.0])
        with pytest.raises(FMICallException):
            read([references["force"]])
        restore(state)
        assert read([references["force"]])[0] == force
        with pytest.raises(FMICallException):
            write([references["force"]], [1.0])
        with pytest.raises(FMICallException):
            write([references["velocity"]], [float("nan")])
    finally:
        one.freeInstance()


def test_its_sources_compile_without_a_warning_and_say_what_they_are(tmp_path: Path) -> None:
    damper = constants("modified_bouc_wen + generalised_maxwell")
    for fmi in (2, 3):
        [path] = export(damper, "fmu", tmp_path / str(fmi), fmi=fmi, model_exchange=True)
        with zipfile.ZipFile(path) as archive:
            archive.extractall(tmp_path / str(fmi))
            text = archive.read("modelDescription.xml").decode()
        assert "<ModelExchange " in text
        assert "<CoSimulation " not in text
        flags = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-fsyntax-only"]
        subprocess.run(["gcc", *flags, *map(str, (tmp_path / str(fmi)).glob("sources/*.c"))], check=True)


def test_what_has_no_model_exchange_is_said(tmp_path: Path) -> None:
    dahl = raminelli_2020.damper()
    for damper, options, words in (
        (dahl, {"drive": "displacement"}, "has no velocity, which model exchange needs at every time; choose both or"),
        (dahl, {"inverse": True}, "the inverse is found step by step, and has no model exchange"),
        (dahl, {"control": raminelli_2020}, "a control law is found step by step"),
        (
            constants("bilinear"),
            {},
            "bilinear is no differential equation for a solver: it has states that are held at st",
        ),
        (
            constants("dahl + delay"),
            {},
            "delay is no differential equation for a solver: it needs the force of a time ago",
        ),
        (constants("dahl + compliance"), {}, "compliance is no differential equation .* root of an equation"),
    ):
        with pytest.raises(InputError, match=words):
            export(damper, "fmu", tmp_path / "new", model_exchange=True, **options)
    assert not (tmp_path / "new").exists()
