"""NTC 2018 section 11.9.3: at least five full cycles at the design displacement."""

import pytest

from dampyr import campaigns
from dampyr.errors import FileError, InputError

TABLE = {"kind": "ntc_2018_quasi_static", "design_displacement": "8 mm"}


def test_five_full_cycles_at_the_design_displacement_at_every_voltage():
    tests = campaigns.campaign_of({"protocol": TABLE | {"voltages": ["0 V", "1.98 V"]}}).tests
    assert [(t.kind, t.step.amplitude, t.step.cycles, t.step.voltage) for t in tests] == [
        ("quasi_static", 0.008, 6, 0.0),
        ("quasi_static", 0.008, 6, 1.98),
    ]


def test_four_cycles_are_refused():
    with pytest.raises(InputError, match=r"cycles = 4 is not allowed; NTC 2018 11\.9\.3 asks for at least 5"):
        campaigns.campaign_of({"protocol": TABLE | {"cycles": 4}})


@pytest.mark.parametrize(
    ("document", "sentence"),
    [
        ({"protocol": {"kind": "shock"}}, "'shock' is not among the kinds of protocol"),
        ({"protocol": {"design_displacement": 1}}, "protocol.kind is missing"),
        ({"protocol": TABLE, "step": [{"kind": "rest", "duration": 1}]}, r"\[protocol\] or \[\[step\]\], not both"),
        ({"protocol": TABLE, "order": "random"}, "not allowed with a protocol"),
        ({"protocol": "ntc"}, "must be a table"),
        ({"protocol": TABLE | {"design": 1}}, "protocol.design is not known"),
    ],
)
def test_a_mistake_in_the_protocol_is_told_with_its_place(document, sentence):
    with pytest.raises(InputError, match=sentence):
        campaigns.campaign_of(document)


def test_a_protocol_is_read_from_a_file(tmp_path):
    path = tmp_path / "ntc.toml"
    path.write_text('[protocol]\nkind = "ntc_2018_quasi_static"\ndesign_displacement = "8 mm"\n')
    assert [test.name for test in campaigns.read(path).tests] == ["01-quasi_static-8mm-2mmps-0V"]
    path.write_text('[protocol]\nkind = "ntc_2018_quasi_static"\ndesign_displacement = "8 V"\n')
    with pytest.raises(FileError, match=r"protocol\.design_displacement"):
        campaigns.read(path)
