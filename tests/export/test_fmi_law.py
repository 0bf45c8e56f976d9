"""A control law as an FMU: valid by FMPy, and it decides on samples as Python does."""

import shutil
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from dampyr.errors import InputError
from dampyr.export import c_law, export
from dampyr.structures import available_control_laws, control_law, two_storey
from dampyr.structures.controller import ControllerRun, design_controller
from dampyr.structures.wanted_force import inverse_of
from dampyr.studies import raminelli_2020

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is missing: an FMU cannot be compiled")
QUICK = ("clipped_optimal_lqg", "inverse_tracking", "modulated_friction")  # every other one is a proof
PERIOD = 0.005


class Law:
    """The FMU of a law, in the same words for both versions of the standard."""

    def __init__(self, path: Path) -> None:
        about = fmpy.read_model_description(str(path))
        self.second = about.fmiVersion.startswith("2")
        listed = [each for each in about.modelVariables if each.causality in ("input", "output")]
        self.inputs = [each.valueReference for each in listed if each.causality == "input"]
        self.outputs = [each.valueReference for each in listed if each.causality == "output"]
        kind = FMU2Slave if self.second else FMU3Slave
        self.unit = kind(
            guid=about.guid, unzipDirectory=fmpy.extract(str(path)), modelIdentifier="damper_law", instanceName="one"
        )
        self.unit.instantiate()
        if self.second:
            self.unit.setupExperiment(startTime=0.0)
        self.unit.enterInitializationMode()
        self.unit.exitInitializationMode()

    def set(self, y: np.ndarray) -> None:
        (self.unit.setReal if self.second else self.unit.setFloat64)(self.inputs, [float(value) for value in y])

    def get(self) -> list[float]:
        return list((self.unit.getReal if self.second else self.unit.getFloat64)(self.outputs))


def controller_of(law):
    return design_controller(law, two_storey(), two_storey().connection(1)[None], 0, summed=False)


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.prove] * (name not in QUICK))
        for name in available_control_laws()
        if not name.startswith("passive")
    ],
)
def test_it_decides_as_in_python_in_steps_of_a_fifth_of_its_period(tmp_path: Path, name: str, fmi: int) -> None:
    damper, law = raminelli_2020.damper(), control_law(name, high=3.0, lag=0.01)
    _, path = export(damper, "fmu", tmp_path, control=law, fmi=fmi)
    assert validate_fmu(str(path)) == []
    controller = controller_of(law)
    y, expected = c_law._samples(controller, damper)
    one, allowed = Law(path), 3.0 * (c_law.AGREE_AT_A_TURN if controller.formulas.asks_force else c_law.AGREE)["double"]
    for k in range(60):
        for part in range(5):
            one.set(y[k] if part == 0 else 100.0 * y[k])  # what is set between samples is not looked at
            assert one.get()[0] == one.get()[0] == pytest.approx(expected[k], abs=allowed)
            one.unit.doStep(PERIOD * (k + 0.2 * part), 0.2 * PERIOD)
    one.unit.freeInstance()


def test_why_a_wanted_force_is_not_met_is_an_output(tmp_path: Path) -> None:
    damper, law = raminelli_2020.damper(), control_law("inverse_tracking", high=3.0)
    _, path = export(damper, "fmu", tmp_path, control=law)
    controller = controller_of(law)
    run, one = ControllerRun(controller, inverse=inverse_of(law, damper)), Law(path)
    y, reasons = c_law._samples(controller, damper)[0], []
    for k in range(100):
        one.set(y[k])
        run.decide_on(y[k])
        reasons.append(
            (["met", "wrong_sign", "above_largest", "below_smallest", "jump"][int(one.get()[1])], run.reason)
        )
        one.unit.doStep(PERIOD * k, PERIOD)
    one.unit.freeInstance()
    assert all(ours == expected for ours, expected in reasons)
    assert {"met", "wrong_sign"} <= {reason for reason, _ in reasons}


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_step_over_a_sample_is_refused(tmp_path: Path, fmi: int) -> None:
    _, path = export(raminelli_2020.damper(), "fmu", tmp_path, control=control_law("fuzzy", high=3.0), fmi=fmi)
    one = Law(path)
    one.set(np.array([0.1, 0.1]))
    one.unit.doStep(0.0, 0.004)
    with pytest.raises(FMICallException):
        one.unit.doStep(0.004, 0.002)
    one.unit.freeInstance()


def test_a_law_that_measures_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="passive_on 0 to 3 measures nothing"):
        export(raminelli_2020.damper(), "fmu", tmp_path, control=control_law("passive_on", high=3.0))
