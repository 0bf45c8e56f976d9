"""The description of an FMU: its variables, units and starts, read back as XML."""

from xml.etree import ElementTree

import pytest
from tests.export.every_law import everything

from dampyr.export.fmi_text import UNITS, model_description, variables
from dampyr.models import Damper

SI = {  # in kg, m, s, A
    "m": (0, 1, 0, 0), "m/s": (0, 1, -1, 0), "N": (1, 1, -2, 0), "V": (1, 2, -3, -1),
    "A": (0, 0, 0, 1), "V/s": (1, 2, -4, -1), "A/s": (0, 0, -1, 1), "s": (0, 0, 1, 0),
    "kg": (1, 0, 0, 0), "1/m": (0, -1, 0, 0), "1/s": (0, 0, -1, 0), "N/m": (1, 0, -2, 0), "N s/m": (1, 0, -1, 0),
    "m/s^2": (0, 1, -2, 0), "m/N": (-1, 0, 2, 0), "N s/m^3": (1, -2, -1, 0),
}  # fmt: skip


def test_units_are_those_of_si() -> None:
    for unit, text in UNITS.items():
        exponents = ElementTree.fromstring(f"<BaseUnit {text}/>").attrib
        assert tuple(int(exponents.get(base, 0)) for base in ("kg", "m", "s", "A")) == SI[unit], unit


@pytest.mark.parametrize(
    ("drive", "inputs"),
    [("both", ["displacement", "velocity", "voltage"]), ("displacement", ["displacement", "voltage"])],
)
def test_variables_are_inputs_then_the_force_then_the_parameters(drive: str, inputs: list[str]) -> None:
    listed = variables(everything(), drive)
    assert [variable.name for variable in listed] == [
        "displacement", "velocity", "voltage", "force", *everything().all_laws,
    ]  # fmt: skip
    assert [variable.name for variable in listed if variable.causality == "input"] == inputs
    assert [variable.name for variable in listed if variable.causality == "output"] == ["force"]
    units = {variable.name: variable.unit for variable in listed}
    assert (units["bouc_wen.rho"], units["delay.tau"], units["voltage"]) == ("1/m", "s", "V")


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_description_says_what_is_where(fmi: int) -> None:
    laws = {"dahl.kx": 900.0, "dahl.kw": 150.0, "dahl.rho": 9000.0}
    damper = Damper("dahl", laws, input="A")
    root = ElementTree.fromstring(model_description(damper, "mr", fmi, "both", "the-token", "1.2.3"))
    assert root.attrib["fmiVersion"].startswith(str(fmi))
    assert root.attrib["modelName"] == "mr"
    assert "dahl" in root.attrib["description"]
    assert "the-token" in root.attrib.values()
    found = [each for each in root.find("ModelVariables") if "valueReference" in each.attrib]  # type: ignore[union-attr]
    by_name = {each.attrib["name"]: each for each in found if each.attrib["name"] != "time"}
    assert list(by_name)[:4] == ["displacement", "velocity", "current", "force"]
    for k, name in enumerate(by_name):
        assert by_name[name].attrib["valueReference"] == str(k)
    described = {unit.attrib["name"] for unit in root.iter("Unit")}
    assert {"m", "m/s", "A", "N", "N s/m", "1/m"} <= described
