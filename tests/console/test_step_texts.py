"""Fields and texts of each kind of step."""

import tomllib

import pytest

pytest.importorskip("fastapi")

from dampyr.console.step_texts import step_kinds, step_text


@pytest.mark.parametrize("kind", [kind for kind in step_kinds() if kind.name != "rest"], ids=lambda kind: kind.name)
def test_every_kind_of_step_has_fields_to_build_it_from(kind):
    required = {field.name for field in kind.fields if field.required}
    assert {line.split(" = ")[0] for line in kind.text.splitlines()[2:]} == required
    assert all(field.value or not field.required for field in kind.fields)
    assert "m" not in {field.unit for field in kind.fields}


@pytest.mark.parametrize("name", [kind.name for kind in step_kinds()])
def test_the_text_of_every_kind_is_a_campaign(name):
    (step,) = tomllib.loads(step_text(name))["step"]
    assert step["kind"] == name


def test_fields_of_one_unit_rise():
    text = tomllib.loads(step_text("sweep"))["step"][0]
    assert (text["start"], text["stop"]) == ("0.5 Hz", "1 Hz")
    (sweep,) = (kind for kind in step_kinds() if kind.name == "sweep")
    amplitude = next(field for field in sweep.fields if field.name == "amplitude")
    assert (amplitude.unit, amplitude.value, amplitude.type, amplitude.several) == ("mm", "4", "number", False)
