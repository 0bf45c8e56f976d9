"""A control law that sets the voltage of a hybrid test on the simulated rig: decisions, record, refusals."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.integrate import cumulative_trapezoid
from scipy.signal import lfilter
from tests.hybrid.on_the_rig import HEAVY, settings

from dampyr.campaigns import hybrid_result, perform, planned_hybrid
from dampyr.campaigns.steps import hybrid
from dampyr.campaigns.steps.hybrid import Hybrid, building_of, motion_of
from dampyr.cli import cli
from dampyr.errors import InputError, RigFault
from dampyr.hybrid import Substructure, run_delayed
from dampyr.hybrid.delayed_hybrid import delayed_result
from dampyr.hybrid.hybrid_result import HybridResult
from dampyr.hybrid.substructure import coil_inputs
from dampyr.input_kinds import NO_INPUT
from dampyr.models import Damper
from dampyr.models.part import checked
from dampyr.records import read
from dampyr.records.formats.h5 import read_raw
from dampyr.rig import RigSettings, simulated
from dampyr.show.descriptions import description_of
from dampyr.show.pages.hybrid_page import html
from dampyr.structures.control_laws import law_of
from dampyr.structures.law_form import ControlLaw

ON_OFF = "on_off:period=4ms,high=1.5"
RIG = RigSettings()


def step_of(folder: Path, control: str, **changes: object) -> dict[str, object]:
    return settings(folder, voltage=0.0, control=control, **changes)


def made(folder: Path, control: str) -> Hybrid:
    named = {name: value for name, value in step_of(folder, control).items() if name not in ("kind", "rest_before")}
    return Hybrid(**named)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def tested(tmp_path_factory: pytest.TempPathFactory) -> tuple[Hybrid, Path]:
    """The step of a test under a law of two values, and its record."""
    folder = tmp_path_factory.mktemp("law")
    planned = planned_hybrid(step_of(folder, ON_OFF))
    planned.require()
    with simulated() as rig:
        perform(planned, rig, folder / "out")
    return planned.tests[0].step, folder / "out" / f"{planned.tests[0].name}.h5"


@pytest.fixture(scope="module")
def result(tested: tuple[Hybrid, Path]) -> HybridResult:
    return hybrid_result(tested[1])


def on_off(result: HybridResult) -> np.ndarray:
    """What the law decides on the building of the test, stated anew: high where the floor moves as the damper does."""
    t, q = result.time, result.displacement[0]
    computed = result.computed
    ground = cumulative_trapezoid(computed.ground_acceleration, computed.time, initial=0.0)
    rate = np.gradient(q, t)
    return np.where((rate + np.interp(t, computed.time, ground)) * rate > 0.0, 1.5, 0.0)


def test_it_agrees_with_the_computed_response_and_with_the_virtual_test(
    tested: tuple[Hybrid, Path], result: HybridResult
) -> None:
    """At one voltage the peaks are half a percent off on this rig, by its backlash, its noise and its Uno's clock."""
    step, law = tested[0], tested[0].law(RIG)
    virtual = delayed_result(building_of(step.structure), motion_of(step), step.damper(RIG), 0.005, law)
    np.testing.assert_allclose(result.computed.peak_displacement, virtual.computed.peak_displacement, rtol=1e-9)
    assert np.abs(virtual.differences).max() < 0.002
    assert np.abs(result.differences).max() < 0.015
    assert np.abs(result.peaks / virtual.peaks - 1.0).max() < 0.015
    assert result.inputs is not None
    acting = coil_inputs(result.inputs, law.low, law.lag, result.time[1])
    assert acting[:-1].mean() == pytest.approx(float(result.computed.mean_input[0]), rel=0.03)


def test_it_decides_at_the_right_time(result: HybridResult) -> None:
    """Of decisions that were sent 108 ms before their time as many are those of the law as of a building that is off by noise;
    as early or as late as that, they would be others."""
    assert result.inputs is not None
    wanted, asked = on_off(result), result.inputs
    strong = slice(round(1.0 / result.time[1]), round(3.5 / result.time[1]))

    def agreeing(steps: int) -> float:
        return float(np.mean(np.roll(wanted, steps)[strong] == asked[strong]))

    shares = {steps: agreeing(steps) for steps in range(-54, 55)}
    assert max(shares, key=shares.__getitem__) in range(-3, 4)
    assert shares[1] > 0.9
    assert max(shares[-54], shares[54]) < 0.75
    changes = np.flatnonzero(np.diff(asked))
    assert len(changes) > 20
    assert set((changes + 1) % 2) == {0}  # of steps of 2 ms: the period is 4 ms


def test_the_record_says_which_law_ran_and_what_it_asked_for(tested: tuple[Hybrid, Path], result: HybridResult) -> None:
    record, raw = read(tested[1]), read_raw(tested[1])
    assert record.provenance["law"] == result.law == "on_off 0 to 1.5 V, period 0.004 s, lag 0.01 s"
    asked = raw["asked_voltage"]
    assert (asked.unit, asked.gain, len(asked.values)) == ("V", 1.0, record.n)
    assert set(np.unique(asked.values)) == {0.0, 1.5}
    np.testing.assert_array_equal(asked.values, record.voltage)
    assert result.voltage == pytest.approx(np.mean(result.inputs[:-1]))  # type: ignore[index]
    assert np.all(asked.values[:1000] == 0.0)  # the sine before the test, and the way back after it
    assert np.all(asked.values[-1000:] == 0.0)


def test_a_voltage_that_is_read_back_does_not_take_the_place_of_what_was_asked_for(tmp_path: Path) -> None:
    rig_settings = replace(RIG, wires=replace(RIG.wires, coil_voltage="ai2"))
    step = replace(made(tmp_path, ON_OFF), duration=2.0)
    with simulated(rig_settings) as rig, rig.armed() as table:
        table.home()
        table.go(0.0)
        blocks = [samples for samples, _ in table.play(step.drive(rig.settings))]
    asked, read_back = (np.concatenate([getattr(b, name) for b in blocks]) for name in ("asked", "voltage"))
    assert set(np.unique(asked)) == {0.0, 1.5}
    assert np.abs(asked - read_back).max() > 0.0
    assert np.median(np.abs(asked - read_back)) < 0.01


def test_the_page_and_the_text_show_the_law(result: HybridResult) -> None:
    rows = dict(description_of(result).rows)
    assert rows["damper"].startswith("on_off 0 to 1.5 V")
    assert rows["input"].startswith("0 to 1.5 V, ")
    page = html(result)
    assert "As the law asked for it in the test" in page
    assert result.law in page
    np.testing.assert_array_equal(result.to_dataframe()["input_V"], result.inputs)


def test_an_actuator_that_is_computed_shows_what_the_prediction_costs(tmp_path: Path) -> None:
    """A model that is the specimen, an actuator that is late by what it is taken for: decisions are 108 ms ahead, and right."""
    step = made(tmp_path, "skyhook:period=4ms,high=1.5")
    part = replace(step.substructure(RIG), lag=0.02, adaptive=False)
    assert part.law_lead == pytest.approx(0.108)
    run = run_delayed(part, step.damper(RIG), 0.02, 0.0)
    assert run.over
    peaks = np.abs(run.z[:, :2]).max(axis=0)
    np.testing.assert_allclose(peaks, step.computed(RIG).peak_displacement, rtol=0.003)


def test_the_coil_follows_as_a_filter_of_first_order() -> None:
    """The level at the ends of steps is a filter of first order, exactly; the middles are half a step further."""
    commands = np.random.default_rng(1).choice([0.0, 1.5], 500)
    share = np.exp(-0.002 / 0.01)
    ends = np.concatenate([[0.3], lfilter([1.0 - share], [1.0, -share], commands, zi=[share * 0.3])[0]])
    half = np.exp(-0.001 / 0.01)
    np.testing.assert_allclose(coil_inputs(commands, 0.3, 0.01, 0.002), commands + (ends[:-1] - commands) * half)
    np.testing.assert_array_equal(coil_inputs(commands, 0.3, 0.0, 0.002), commands)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"control": "on_off"},
            "period = 0.005 s of the control law is not a whole number of the test's steps of 0.002 s",
        ),
        ({"control": "on_off:period=4ms,high=9"}, r"outside|calibrated"),
        ({"control": "on-off:period=4ms"}, "on_off"),
        ({"control": ON_OFF, "voltage": 1.0}, "voltage and control both set"),
        ({"control": "on_off:period=4ms,low=-1"}, r"outside|calibrated|negative"),
    ],
)
def test_what_is_wrong_is_said_before_anything_moves(tmp_path: Path, changes: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        planned_hybrid(settings(tmp_path, **({"voltage": 0.0} | changes)))


def test_a_law_beyond_the_supply_is_refused_by_the_plan(tmp_path: Path) -> None:
    """Before it is known what the law would ask for: by its bounds."""
    low_limit = replace(RIG, limits=replace(RIG.limits, voltage=1.2))
    path = tmp_path / "rig.toml"
    path.write_text("[limits]\nvoltage = 1.2\n")
    planned = planned_hybrid(step_of(tmp_path, ON_OFF), path)
    assert "needs 1.5 V at the coil, the limit is 1.2 V; give the law another high or low" in planned.refusals[0]
    assert low_limit.limits.voltage == 1.2
    assert planned.tests[0].peak_voltage == 1.5


def test_a_rig_that_cannot_offer_a_law_says_so(tmp_path: Path) -> None:
    without_clock = replace(RIG, wires=replace(RIG.wires, supply="./bench_supply"))
    with pytest.raises(
        InputError, match="has no sample clock, so a law's voltage would come at times that are not known"
    ):
        Hybrid(control=ON_OFF).law(without_clock)
    oil = replace(Damper(("spring",), {"spring.k0": 2e3}), input=NO_INPUT).save(tmp_path / "oil.toml")
    with pytest.raises(InputError, match="the damper's model has no input, which a control law would set"):
        Hybrid(control=ON_OFF, model=str(oil)).law(RIG)
    with pytest.raises(InputError, match="give a model"):
        Substructure(
            building_of("two_storey"), 1, np.zeros(9), 0.002, law=law_of("on_off:period=4ms", Hybrid().damper(RIG))
        )


def test_the_lag_is_that_of_the_rigs_coil_unless_it_is_given() -> None:
    assert Hybrid(control=ON_OFF).law(RIG).lag == pytest.approx(0.01)
    assert Hybrid(control=ON_OFF, clock=2.0).law(RIG).lag == pytest.approx(0.005)
    assert Hybrid(control=f"{ON_OFF},lag=20ms").law(RIG).lag == pytest.approx(0.02)


@checked
@dataclass(frozen=True)
class Beyond(ControlLaw):
    """It asks for more than its greatest input."""


def decide(high: float) -> float:
    return 1.5 * high


@pytest.mark.prove
def test_a_law_that_asks_beyond_its_bounds_moves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hybrid, "law_of", lambda text, damper: Beyond(0.0, 1.0, 0.004))
    with pytest.raises(InputError, match=r"asked for 1\.5; it must stay between its low = 0 and high = 1"):
        planned_hybrid(step_of(tmp_path, "beyond"))


def off_and_at_rest(rig) -> None:
    simulator = rig.board.simulator
    simulator.run_unattended(0.5)
    assert simulator.command == 0.0
    assert not np.isnan(simulator.at_rest_since)
    assert not np.isnan(simulator.coil_dead_since)


@pytest.mark.parametrize("how", ["beyond", "abort", "trip"])
def test_what_ends_the_test_sets_the_coil_to_0_v(how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A law that asks beyond its bounds while the table moves, an abort, the interlock: the voltage was 1.5 V until then."""
    step = made(tmp_path, "passive_on:period=4ms,high=1.5")
    stated = {
        "beyond": r"stopped after \d\.\d\d s.*asked for 2; it must stay",
        "abort": "aborted",
        "trip": "the interlock",
    }
    with simulated() as rig:
        drive = step.drive(rig.settings)
        with pytest.raises(RigFault, match=stated[how]) as fault, rig.armed() as table:  # noqa: PT012
            table.home()
            table.go(0.0)
            for samples, _ in table.play(drive):
                if samples.voltage[-1] != 1.5:
                    continue
                assert rig.board.simulator.command > 1.4
                if how == "abort":
                    table.abort()
                elif how == "trip":
                    monkeypatch.setattr(table.loop.interlock, "judge", partial(tripped, "the interlock"))
                else:
                    run = table.loop.player.run
                    monkeypatch.setattr(run._law.run, "decide", lambda known: 2.0)
        assert fault.value.ring == {"beyond": "check", "abort": "operator", "trip": "interlock"}[how]
        off_and_at_rest(rig)


def tripped(why: str, *_: object) -> None:
    raise RigFault(why, "interlock")


def test_the_command_plans_and_runs_a_law(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "heavy.toml").write_text(HEAVY)
    words = ["hybrid", "--structure", "heavy.toml", "--duration", "2", "--scale", "0.15", "--control", ON_OFF]
    planned = CliRunner().invoke(cli, [*words, "--dry-run", "--json"])
    assert planned.exit_code == 0, planned.output
    assert ON_OFF in json.loads(planned.stdout)["test"]
    done = CliRunner().invoke(cli, [*words, "--out", "out", "--json", "--report", "page.html"])
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["law"].startswith("on_off 0 to 1.5 V")
    assert "As the law asked for it in the test" in (tmp_path / "page.html").read_text()
    for more, message in (
        (["--voltage", "1"], "voltage and control both set"),
        (["--control", "on_off"], "is not a whole number of the test's steps of 0.002 s; give period=0.004"),
    ):
        refused = CliRunner().invoke(cli, [*words, *more, "--dry-run"])
        assert (refused.exit_code, message in refused.stderr) == (2, True), refused.stderr


@pytest.mark.prove
@pytest.mark.parametrize("ppm", [5000.0, -5000.0])
def test_it_keeps_up_on_the_slowest_line_whatever_the_unos_clock(ppm: float, tmp_path: Path) -> None:
    """Each request takes 16 ms: neither a set point nor a voltage comes too late."""
    slow = replace(RIG, uno=replace(RIG.uno, clock_ppm=ppm, shortest_latency=0.016, longest_latency=0.016))
    planned = planned_hybrid(step_of(tmp_path, ON_OFF))
    with simulated(slow) as rig:
        perform(replace(planned, rig=rig.settings), rig, tmp_path / "out")
    result = hybrid_result(tmp_path / "out" / f"{planned.tests[0].name}.h5")
    assert np.abs(result.differences).max() < 0.02
    assert set(np.unique(result.inputs)) == {0.0, 1.5}  # type: ignore[arg-type]
