"""Laws by name: what is taken, what is refused, what they are called."""

import re
from dataclasses import dataclass

import pytest

from dampyr.errors import InputError
from dampyr.models import Damper
from dampyr.structures import available_control_laws, control_law, two_storey
from dampyr.structures.control.on_off import OnOff
from dampyr.structures.control_laws import describe_law, is_control_law, law_of, parts, spelled
from dampyr.structures.controller import design_controller
from dampyr.structures.law_form import ControlLaw


def test_a_law_is_a_file():
    assert {"on_off", "skyhook", "clipped_optimal", "lyapunov", "bang_bang"} <= set(available_control_laws())
    assert control_law("on_off", high=3) == OnOff(0.0, 3.0)
    assert is_control_law(OnOff(0.0, 1.0))
    assert not any(map(is_control_law, (OnOff, 1.0, None, "on_off", [OnOff(0.0, 1.0)])))


@pytest.mark.parametrize(
    ("name", "settings", "message"),
    [
        ("on_of", {"high": 1.0}, "is not among the control laws; did you mean 'on_off'"),
        ("on_off", {}, "on_off needs high"),
        (
            "on_off",
            {"high": 1.0, "gain": 2.0},
            "'gain' is not a setting of on_off; it has low, high, period, lag, sensors, seed",
        ),
        ("on_off", {"high": "much"}, "high = 'much' of on_off is not a number"),
        ("lyapunov", {"high": 1.0, "weights": 3.0}, "weights = 3.0 of lyapunov is not numbers"),
        ("on_off", {"low": 2.0, "high": 1.0}, "low = 2 of on_off is above high = 1"),
        ("on_off", {"high": 1.0, "period": 0.0}, "period = 0 s is not allowed"),
        ("on_off", {"high": float("nan")}, "high = nan"),
        ("on_off", {"high": 1.0, "lag": -1.0}, "lag = -1 s is not allowed"),
    ],
)
def test_what_is_wrong_is_said(name, settings, message):
    with pytest.raises(InputError, match=message):
        control_law(name, **settings)


def test_a_law_imports_from_modules_that_stay():
    """Its source, imports included, is in the digest by which an ensemble's file is taken up: another place ends old files."""
    stay = {
        "errors", "units", "models.part", "structures.building", "structures.propagator", "structures.control._optimal",
        "structures.law_form",
    }  # fmt: skip
    used = {
        name
        for law in available_control_laws()
        for name in re.findall(r"^from dampyr\.([\w.]+) import", spelled(control_law(law, high=3.0)), re.MULTILINE)
    }
    assert used <= stay


def test_a_label_tells_what_is_not_usual():
    assert describe_law(control_law("on_off", high=3.212), "V") == "on_off 0 to 3.212 V"
    law = control_law("clipped_optimal", low=0.1, high=2.0, period=0.01, lag=0.02, effort=0.3, weights=(1, 2))
    assert describe_law(law, "A") == "clipped_optimal 0.1 to 2 A, period 0.01 s, lag 0.02 s, effort 0.3, weights (1 2)"


def test_the_digest_knows_every_setting_exactly():
    base = {"high": 3.0}
    others = [{"high": 3.0 + 1e-15}, {"low": 0.1}, {"period": 0.01}, {"lag": 0.001}, {"ratio": 0.9}]
    texts = {spelled(control_law("skyhook", **base | other)) for other in [{}, *others]}
    assert len(texts) == 6
    assert spelled(OnOff(0, 3)) == spelled(OnOff(0.0, 3.0))
    assert spelled(control_law("bang_bang", **base)) != spelled(control_law("on_off", **base))


@pytest.mark.parametrize(
    ("periods", "dt", "expected"),
    [
        ([0.005], 0.02, 4),
        ([0.02], 0.02, 1),
        ([0.06], 0.02, 1),
        ([0.003], 0.02, 20),
        ([0.005, 0.004], 0.02, 20),
        ([], 0.02, 1),
    ],
)
def test_laws_decide_at_the_ends_of_steps(periods, dt, expected):
    steps = parts([OnOff(0.0, 1.0, period) for period in periods], dt)
    assert steps == expected
    for period in periods:
        assert period / (dt / steps) == pytest.approx(round(period / (dt / steps)), abs=1e-9)


@pytest.mark.parametrize(
    ("periods", "message"),
    [
        ([0.0061234], r"does not fit the motion's 0.02 s; .* such as 0.005 s"),
        ([0.02 / 19, 0.02 / 23], "meet only in 437 parts"),
    ],
)
def test_periods_that_fit_no_step_are_refused(periods, message):
    with pytest.raises(InputError, match=message):
        parts([OnOff(0.0, 1.0, period) for period in periods], 0.02)


MEASURES = ("rate", "state")


@dataclass(frozen=True)
class Curious(ControlLaw):
    pass


def decide(temperature, low):
    return low


def test_a_law_that_asks_for_what_is_not_sensed_is_refused():
    assert is_control_law(Curious(0.0, 1.0))
    building = two_storey()
    with pytest.raises(InputError, match="asks for 'temperature'; it may use rate, low, high, period, lag"):
        design_controller(Curious(0.0, 1.0), building, building.connection(1)[None], 0)


def test_a_law_is_a_text_over_the_range_of_its_damper(cubics: Damper) -> None:
    assert law_of("on_off:lag=10ms", cubics) == control_law(
        "on_off", low=cubics.range[0], high=cubics.range[1], lag=0.01
    )
