"""Faults of every kind at random moments of campaigns, on rigs that are used for several, judged by the simulator's truth.

The rig always ends at rest with the coil off and says why; nothing is ever unsafe; and no record is complete and without a mark
in which a channel is off by more than three times its stated uncertainty for longer than a cycle of its drive, but for what
no sensor of the rig can tell (`UNSEEN`):

| class | why nothing can tell |
|---|---|
| hot coil | The coil's voltage is stated for 20 degC; copper's resistance grows by 0.39 %/K. The rig estimates the
  coil's warmth from the heat that it puts into the damper; heat from elsewhere is in neither voltage nor motion. A
  thermocouple that is not stuck would tell, or the coil's current; a lower force
  is that of another damper as well as of a warm one. |
| dead coil | A supply that gives nothing, or another voltage than it is commanded, or a broken wire, in a rig that does not
  read the coil's voltage: the record says that it is commanded, not measured. A lower force is that of another damper. |
| constant force | A shunt that is left across the bridge from before the first slow pass of a run until its end: a constant
  force on the cell is what the damper's own gas charge is; only the damper's card says how large that is, to some 90 N here. |
| constant gain | A gain of the load cell's chain that has changed before the first slow pass of a run by less than it may
  differ from that of the run before, in a rig without a shunt across the bridge: so does that of a warmer or a worn damper. |
| passing gain | One that changes and comes back within a test in which the motion does not repeat itself. |
| small gain | One by so little that friction on the slow passes does not tell it, in a rig without a shunt, which does. |
| slow cell | A cell that was slow before the first slow pass of a run by too little for its noise to tell, or whose noise
  lies below the converter's step, in a rig without a shunt, whose step would tell. |
| passing drift | A zero that goes and comes back within a test: it is right on the slow passes before and after, and a
  force that changes by some 20 N in two seconds is what a damper that relaxes, or warms, gives. |
| leap after a turn | A shunt that is switched in, and out again within the same test, each time before the table has gone
  0.3 mm since it turned: there the force of a damper with play in its pins leaps as well. |

Each rig has been run before with its damper when nothing was wrong, as a laboratory has that begins to use it.

The rigs are what their hosts take them for within the stated uncertainties only: each constant strays by its own, of three in
ten rigs as they were bought and of the others as they were calibrated.
"""

from __future__ import annotations

import shutil
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binom
from tests.endurance import Endurance
from tests.rig_truth import errors, stated, true_channels, unsafe

from dampyr import campaigns, records
from dampyr.campaigns import perform, planned_hybrid, read_journal
from dampyr.campaigns.planned_tests import PlannedTest, plan
from dampyr.errors import DampyrWarning, RigFault
from dampyr.records import Record
from dampyr.records.formats import h5
from dampyr.rig import Rig, RigSettings, simulated
from dampyr.rig.calibration import Calibration, calibration_of
from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import InProcess
from dampyr.rig.instruments.ni_daqmx.simulated import InProcessBoard
from dampyr.rig.simulation import plant
from dampyr.rig.simulation.faults import KINDS, FaultSpec
from dampyr.rig.simulation.ground_truth import Truth
from dampyr.rig.simulation.simulator import Simulator

HEADER = """
name = "short"
rest_between = "0.3 s"
check_amplitude = "{check} mm"
"""
STEPS = {
    "sine": 'amplitude = "{a} mm"\nfrequency = "{f} Hz"\ncycles = {c}\nvoltage = "{u} V"',
    "quasi_static": 'amplitude = "{b} mm"\nspeed = "6 mm/s"\ncycles = 2\nvoltage = "{u} V"',
    "random": 'amplitude = "{b} mm"\nlow = "0.5 Hz"\nhigh = "2 Hz"\nduration = "4 s"\ntaper = "0.5 s"\nvoltage = "{u} V"',
    "sweep": 'amplitude = "{b} mm"\nstart = "0.5 Hz"\nstop = "2 Hz"\nduration = "4 s"\nvoltage = "{u} V"',
    "low_velocity": 'amplitude = "1 mm"\nspeeds = ["2 mm/s", "5 mm/s"]\nvoltage = "{u} V"',
    "friction": 'amplitude = "{b} mm"\nspeed = "8 mm/s"\npause = "0.3 s"\ncycles = 2\nvoltage = "{u} V"',
    "gas_force": 'amplitude = "{b} mm"\nplaces = 3\nspeed = "10 mm/s"\nhold = "0.6 s"',
    "voltage_steps": 'amplitude = "{b} mm"\nfrequency = "1 Hz"\nvoltages = ["0 V", "{u} V", "1 V"]\nhold = "1 s"',
    "random_voltage": 'amplitude = "{b} mm"\nfrequency = "1 Hz"\nhigh = "{u} V"\nhold = "0.25 s"\ncycles = 4',
    "reversals": 'half_period = "0.3 s"\nduty = 0.6\ncount = 6\nvoltage = "{u} V"',
    "warm_up": 'amplitude = "{b} mm"\nfrequency = "1 Hz"\ncycles = 3\nvoltage = "{u} V"',
    "rest": 'duration = "2 s"\nvoltage = "{u} V"',
}
WITHOUT_REST = ("rest",)
WATCHED = 2.0  # s after which the table rests, whatever happened: the watchdog acts after 0.15 s
WRONG = 3.0  # times the stated uncertainty
RUNS = 5  # of a rig
PROFILES = {"full": (1.0,) * 6, "some": (0.5, 0.5, 0.8, 0.75, 0.9, 0.5), "bare": (0.0, 0.0, 1.0, 0.0, 0.0, 0.0)}
"""The chances that end switches, emergency stop, index, thermocouple, readings of the coil and the shunt are wired."""
UNSEEN_SHARE = {"full": 0.01, "some": 0.03, "bare": 0.03}  # of the good records, which no sensor can tell to be wrong
LOOSE = 3.0  # times the true error that a stated uncertainty may be, in the median
PLAY = 3.0e-4  # m: as much as worn pins have
COOLED = 60.0  # degC that a damper has at most, when the next campaign begins
HOMING = 20.0  # s that homing takes on the average
WARM, UNREAD = (
    45.0,
    2.0,
)  # degC of a damper that is run again; K by which its host is wrong about that, a standard deviation
SOFTENING = 0.005  # 1/K of the force of a damper that is run again: that of its slow passes


def a_fault(draw: np.random.Generator, first: float, span: float) -> FaultSpec:
    """A fault of a random kind, size, moment and length."""
    kind = str(draw.choice([name for name in KINDS if name != "late-samples"]))  # which delays the wall clock
    lasts = float(draw.choice([10.0 ** draw.uniform(-2.3, 0.7), np.inf]))
    sign, size = float(draw.choice([-1.0, 1.0])), draw.uniform()
    amount = {
        "lost-bytes": 10.0 ** (-2.0 + 1.7 * size),
        "slipped-encoder": sign * 10.0 ** (-5.0 + 2.7 * size),
        "broken-cell": float(draw.choice([10.0, -10.0, 0.0, 20.0 * size - 10.0])),
        "drifting-cell": sign * 10.0 ** (0.7 + 2.0 * size),
        "hot-specimen": 10.0 + 80.0 * size,
        "cell-clip": 10.0 ** (1.5 + 1.5 * size),
        "cell-gain": 0.8 + 0.4 * size,
        "cell-slow": 10.0 + 20.0 * size,
        "supply-gain": 1.5 * size,
    }.get(kind, KINDS[kind].amount)
    at = first if draw.uniform() < 0.1 else first + draw.uniform(0.0, span)
    return FaultSpec(kind, round(at + 0.001, 4), lasts, amount)


def a_campaign(draw: np.random.Generator) -> str:
    """One or two tests of random kinds."""
    text = HEADER.format(check=draw.choice([0, 1]))
    for _ in range(int(draw.integers(1, 3))):
        kind = str(draw.choice([*STEPS, "sine", "sine"]))
        f = round(float(draw.uniform(0.5, 3.0)), 2)
        numbers = {
            "a": round(float(min(30.0, draw.uniform(1.0, 8.0) / f)), 2),
            "b": round(float(draw.uniform(1.0, 4.0)), 2),
            "f": f,
            "c": int(draw.integers(2, 6)),
            "u": round(float(draw.uniform(0.3, 2.2)), 2),
        }
        rest = "" if kind in WITHOUT_REST else f'rest_before = "{draw.choice([0.1, 0.5])} s"\n'
        text += f'[[step]]\nkind = "{kind}"\n{rest}{STEPS[kind].format(**numbers)}\n'
    return text


def a_rig(draw: np.random.Generator, profile: str = "some", bought: float = 0.3) -> tuple[RigSettings, Calibration]:
    """What is taken for a rig, wired by its ``profile``, as it was bought, of a share ``bought``, or calibrated."""
    base = RigSettings()
    switches, stop, index, thermocouple, coil, shunt = draw.uniform(size=6) < PROFILES[profile]
    wires = replace(base.wires, end_switches=bool(switches), emergency_stop=bool(stop))
    wires = replace(wires, index=base.wires.index if index else "", temperature="ai1" if thermocouple else "")
    wires = replace(wires, shunt="port0/line0" if shunt else "")
    if coil:
        wires = replace(wires, coil_voltage="ai2", coil_current="ai3")
    rig = replace(base, wires=wires)
    if draw.uniform() < bought:
        return rig, calibration_of(rig)
    cell, supply = rig.load_cell, rig.supply
    return rig, replace(
        calibration_of(rig),
        scale_uncertainty=3e-3 * cell.scale,
        zero_uncertainty=1.0 / cell.scale,
        noise=0.9,
        bandwidth=cell.bandwidth,
        bandwidth_uncertainty=0.03 * cell.bandwidth,
        gain=supply.gain,
        gain_uncertainty=3e-3,
        resistance=supply.resistance,
        resistance_uncertainty=0.01 * supply.resistance,
    )


def true_rig(draw: np.random.Generator, rig: RigSettings) -> RigSettings:
    """What such a rig may really be: each constant strays by its standard uncertainty."""
    cell, supply = rig.load_cell, rig.supply
    stray = np.clip(draw.standard_normal(5), -2.0, 2.0)
    late = max(2e-5, rig.force_delay + stray[2] * cell.delay_uncertainty)
    return replace(
        rig,
        load_cell=replace(
            cell,
            scale=cell.scale * (1.0 + stray[0] * cell.scale_uncertainty),
            zero=cell.zero + stray[1] * cell.zero_uncertainty / cell.scale,
            bandwidth=1.0 / (2.0 * np.pi * late),
            noise=0.4,
        ),
        supply=replace(
            supply,
            gain=supply.gain * (1.0 + stray[3] * supply.gain_uncertainty),
            resistance=supply.resistance * (1.0 + stray[4] * supply.resistance_uncertainty),
        ),
    )


class Board(InProcessBoard):
    """A board that says when its clock began."""

    started = 0.0

    def start(self, rate: float, ahead: np.ndarray) -> None:
        """Start sampling."""
        super().start(rate, ahead)
        self.started = self.simulator.time


def a_host(
    simulator: Simulator, rig: RigSettings, calibration: Calibration, folder: Path, before: Rig | None = None
) -> Rig:
    """A new host; the damper is as warm as the one before it says, and what earlier runs have shown lies in ``folder``."""
    uno, board = Uno(InProcess(simulator.serial)), Board(simulator)
    folder.mkdir(exist_ok=True)
    rig = Rig(
        rig, uno, board, threaded=False, clocked_by_reads=True, clock=lambda: simulator.time, calibration=calibration,
        folder=folder,
    )  # fmt: skip
    if before is not None:
        rig.warmth.temperature = before.warmth.temperature
    return rig


def _hot_coil(trial: Trial) -> bool:
    """Heat from elsewhere in a rig without a thermocouple, or with one that is stuck: only the voltage is wrong, and what that
    one reads.
    """
    hot = any(fault.kind == "hot-specimen" for fault in trial.faults)
    stuck, wires = any(fault.kind == "thermocouple-stuck" for fault in trial.faults), trial.rig.wires
    sensed = (wires.temperature and not stuck) or wires.coil_current
    return hot and not sensed and set(trial.worst) <= {"voltage", "temperature"}


def _dead_coil(trial: Trial) -> bool:
    """A supply or a coil that is dead in a rig that reads neither: the voltage is the commanded one, as the record says."""
    dead = any(fault.kind in ("dead-supply", "open-coil", "supply-stuck", "supply-gain") for fault in trial.faults)
    return dead and not trial.rig.wires.coil_voltage and set(trial.worst) == {"voltage"}


def _constant_force(trial: Trial) -> bool:
    """A force on the cell from before the first pass of a run until its end."""
    constant = any(fault.kind == "shunted-cell" and np.isinf(fault.duration) for fault in trial.faults)
    return constant and set(trial.worst) == {"force"}


def _passing_drift(trial: Trial) -> bool:
    """A drift that has come and gone between the slow passes before a test and after it."""
    passing = any(fault.kind == "drifting-cell" and np.isfinite(fault.duration) for fault in trial.faults)
    return passing and set(trial.worst) == {"force"}


def _gain(trial: Trial, passing: bool) -> bool:
    """A gain of the load cell's chain; ``passing``: one that comes back within a test, which a shunt does not show either."""
    gains = [fault for fault in trial.faults if fault.kind == "cell-gain"]
    passes = any(np.isfinite(fault.duration) for fault in gains)
    return bool(gains) and set(trial.worst) == {"force"} and (passes if passing else not trial.rig.wires.shunt)


def _slow_cell(trial: Trial) -> bool:
    """A cell that is slow in a rig without a shunt; the force is late, and nothing else is wrong."""
    slow = any(fault.kind == "cell-slow" for fault in trial.faults)
    return slow and not trial.rig.wires.shunt and set(trial.worst) == {"force"}


UNSEEN: dict[str, Callable[[Trial], bool]] = {
    "hot coil": _hot_coil,
    "dead coil": _dead_coil,
    "constant force": _constant_force,
    "passing drift": _passing_drift,
    "passing gain": lambda trial: _gain(trial, passing=True),
    "constant or small gain": lambda trial: _gain(trial, passing=False),
    "slow cell": _slow_cell,
    "leap after a turn": lambda trial: trial.after_turns,
}
"""What no sensor of the rig can tell, see above."""


def classes_of(trial: Trial) -> list[str]:
    """The classes of what no sensor tells in a trial; none where a channel is wrong for no such reason."""
    each = [
        [name for name, holds in UNSEEN.items() if holds(replace(trial, worst={channel: worst}))]
        for channel, worst in trial.worst.items()
    ]
    return list(dict.fromkeys(names[0] for names in each)) if all(each) else []


@dataclass
class Trial:
    """A campaign with faults, what became of it, and how its records differ from the truth."""

    number: int
    faults: list[FaultSpec]
    rig: RigSettings
    ended: str = ""
    reason: str = ""
    unsafe: list[str] = field(default_factory=list)
    profile: str = "some"
    good: int = 0
    marked: int = 0
    bad: int = 0
    """Records that are good and wrong, but for those that say themselves that what is wrong in them was not measured."""
    told: int = 0
    """Those: only their voltage is wrong, and it is commanded, not measured."""
    wrong: list[str] = field(default_factory=list)
    worst: dict[str, float] = field(default_factory=dict)
    steps: list[str] = field(default_factory=list)
    after_turns: bool = False
    """Whether its only fault is a shunt that is switched in and out just after turns of the table."""

    def __str__(self) -> str:
        words = f"{self.number} {'+'.join(map(str, self.faults))}: {self.ended} {self.unsafe} {self.wrong}"
        return (
            f"{words} {self.steps} thermocouple={bool(self.rig.wires.temperature)} index={bool(self.rig.wires.index)}"
        )


def perform_before(rig: Rig, folder: Path) -> None:
    """An earlier run with the rig and its damper, as every laboratory has; nothing is wrong in it."""
    (folder / "before.toml").write_text(BEFORE, "utf-8")
    perform(plan(campaigns.read(folder / "before.toml"), rig.settings), rig, folder / "before")
    shutil.rmtree(folder / "before")


def has_just_turned(truth: Truth, at: float) -> bool:
    """Whether the table, that moves, has gone less than `PLAY` since it last turned, by the truth."""
    before = (truth.time > at - 2.0) & (truth.time <= at)
    x = truth.position[before]
    far = np.flatnonzero(np.abs(x - x[-1]) >= PLAY) if x.size else np.zeros(0, int)
    if not far.size:
        return False
    way = x[far[-1] :]
    return bool(np.ptp(way) > abs(way[-1] - way[0]) + 1e-5)


def cycle(test: PlannedTest) -> float:
    """s of a cycle of a drive, 1 s where it has none."""
    frequency = getattr(test.step, "frequency", None)
    return 1.0 / frequency if isinstance(frequency, float) else 1.0


def steady(record: Record) -> np.ndarray:
    """The samples that are not beside a step of the voltage, whose moment is known to a sample."""
    steps = np.flatnonzero(np.diff(np.broadcast_to(record.voltage, record.time.shape)))
    away = np.ones(record.n, bool)
    for near in range(-1, 3):
        away[np.clip(steps + near, 0, record.n - 1)] = False
    return away


def judge(
    trial: Trial, tests: dict[str, PlannedTest], folder: Path, simulator: Simulator, started: float, rig: RigSettings
) -> list[tuple[str, float, float]]:
    """The records that are complete and without a mark: which channels are wrong, and the errors of those that are not."""
    ratios, truth, resistance = [], simulator.truth, simulator.settings.supply.resistance
    for name, test in tests.items():
        path = folder / f"{name}.h5"
        if not path.is_file() or not h5.state(path).complete:
            continue
        record = records.read(path)
        if record.marks:
            trial.marked += 1
            continue
        trial.good += 1
        before = len(trial.wrong)
        uncertainty = stated(record)
        for channel, error in errors(record, true_channels(record, truth, started, rig, resistance)).items():
            off = np.abs(error) > WRONG * uncertainty[channel]
            seconds = float(np.count_nonzero(off)) * record.dt
            if seconds > cycle(test):
                worst = float(np.abs(error).max() / uncertainty[channel])
                trial.worst[channel] = max(worst, trial.worst.get(channel, 0.0))
                trial.wrong.append(f"{name}: {channel} {worst:.3g} times, {seconds:.3g} s of {record.duration:.3g} s")
            else:
                rms = float(np.sqrt(np.mean(error[steady(record)] ** 2)))
                ratios.append((channel, uncertainty[channel], rms))
        wrong = trial.wrong[before:]
        unread = "commanded, not measured" in record.provenance["voltage"]
        told = bool(wrong) and unread and all(f"{name}: voltage " in words for words in wrong)
        trial.told, trial.bad = trial.told + told, trial.bad + (bool(wrong) and not told)
    return ratios


def run_trial(
    k: int, draw: np.random.Generator, rig: Rig, path: Path, out: Path
) -> tuple[Trial, list[tuple[str, float, float]]]:
    """A campaign with one or two faults."""
    simulator = rig.board.simulator
    path.write_text(a_campaign(draw), "utf-8")
    campaign_plan = plan(campaigns.read(path), rig.settings)
    campaign_plan.require()
    first = simulator.time
    span = 1.15 * (sum(test.duration for test in campaign_plan.tests) + 3.0 * len(campaign_plan.tests))
    span += 0.0 if simulator.twin.registers[8] else HOMING
    faults = [a_fault(draw, first, span) for _ in range(int(draw.integers(1, 3)))]
    simulator.faults = tuple(faults)
    trial = Trial(k, faults, rig.settings, steps=[test.kind for test in campaign_plan.tests])
    beats: list[float] = []
    beat = type(simulator)._on_heartbeat.__get__(simulator)

    def hear() -> None:
        beats.append(simulator.time)
        beat()

    simulator.twin.on_heartbeat = hear
    try:
        perform(campaign_plan, rig, out)
        trial.ended = "complete"
    except RigFault as problem:
        trial.ended, trial.reason = problem.ring or "no answer", str(problem)
    simulator.run_unattended(WATCHED)
    assert not simulator.twin.enabled, trial
    assert simulator.command == 0.0, trial
    assert not np.isnan(simulator.at_rest_since), trial
    assert not np.isnan(simulator.coil_dead_since), trial
    edges = [edge for fault in faults for edge in (fault.at, fault.until)]
    trial.after_turns = all(fault.kind == "shunted-cell" for fault in faults) and all(
        np.isfinite(edge) and has_just_turned(simulator.truth, edge) for edge in edges
    )
    trial.unsafe = unsafe(simulator.truth, first, simulator.settings, beats)
    ratios = judge(
        trial, {test.name: test for test in campaign_plan.tests}, out, simulator, rig.board.started, rig.settings
    )
    if (out / "journal.sqlite").is_file():
        tests, _ = read_journal(out)
        assert all(test.reason for test in tests if test.state == "failed"), trial
    return trial, ratios


BEFORE = HEADER.format(check=1) + f'[[step]]\nkind = "sine"\n{STEPS["sine"].format(a=2, f=1, c=2, u=0)}\n'
"""A campaign of before, when nothing was wrong."""


def run_trials(
    count: int, seed: int, folder: Path, first: int = 0
) -> tuple[list[Trial], dict[str, list[tuple[float, float]]]]:
    """Campaigns with faults on rigs that are used for `RUNS` of them."""
    trials: list[Trial] = []
    ratios = defaultdict(list)
    for k in range(first, count):
        draw = np.random.default_rng([seed, k])
        if k % RUNS == 0:
            profile = list(PROFILES)[k // RUNS % len(PROFILES)]
            believed, calibration = a_rig(draw, profile)
            true = true_rig(draw, calibration.corrected(believed))
            kept = folder / f"rig{k}"
            perform_before(a_host(Simulator(true, k), believed, calibration, kept), folder)
            simulator = Simulator(true, k, position=float(draw.uniform(-0.0369, 0.0369)))
            rig = a_host(simulator, believed, calibration, kept)
        elif draw.uniform() < 0.5:
            rig = a_host(simulator, believed, calibration, kept, rig)
        trial, more = run_trial(k, draw, rig, folder / "short.toml", folder / str(k))
        trial.profile = profile
        trials.append(trial)
        for channel, uncertainty, rms in more:
            ratios[channel].append((uncertainty, rms))
        simulator.truth_log.chunks.clear()  # half an hour of it is long to look through
        simulator.truth_log.count = 0
        shutil.rmtree(folder / str(k), ignore_errors=True)
        rig.warmth.temperature = min(rig.warmth.temperature, COOLED)  # an hour later
        simulator.plant[plant.Y_TEMPERATURE] = rig.warmth.temperature
    return trials, ratios


@pytest.mark.prove
@pytest.mark.endure
@pytest.mark.filterwarnings("ignore:the encoder's index was not where homing had put it")
@pytest.mark.filterwarnings("ignore:the Uno had stopped by itself")  # a host that comes after a fault
@pytest.mark.filterwarnings("ignore:the Uno was left in state")
@pytest.mark.filterwarnings("ignore:.*with the same specimen")  # its records have the mark
def test_whatever_goes_wrong_is_safe_and_no_wrong_record_is_good(tmp_path: Path, endurance: Endurance) -> None:
    seed, count = 20201126, endurance.count(2000)
    trials, ratios = run_trials(count, seed, tmp_path)
    ended = Counter(trial.ended for trial in trials)
    assert [str(trial) for trial in trials if trial.unsafe] == []
    assert all(trial.reason for trial in trials if trial.ended != "complete")
    classes = [classes_of(trial) for trial in trials if trial.wrong]
    assert all(classes), [str(trial) for trial in trials if trial.wrong and not classes_of(trial)]
    unseen = Counter(each[0] for each in classes)
    shares = []
    for profile, share in UNSEEN_SHARE.items():
        of_it = [trial for trial in trials if trial.profile == profile]
        records_good, bad, told = (sum(getattr(each, name) for each in of_it) for name in ("good", "bad", "told"))
        # Of a part, so many by chance in one of a hundred at most.
        most = share * records_good if endurance.full else binom.ppf(0.99, records_good, share)
        shares.append(f"{bad} of {records_good} ({profile}), and {told} that say that their voltage is not measured")
        assert bad <= most, (profile, shares, unseen)
    medians = {
        channel: float(np.median([uncertainty for uncertainty, _ in each]) / np.median([rms for _, rms in each]))
        for channel, each in sorted(ratios.items())
    }
    del medians["temperature"]  # a simulated thermocouple is exact, and the uncertainty is that of a real one
    assert max(medians.values()) <= LOOSE, medians
    good, marked = sum(trial.good for trial in trials), sum(trial.marked for trial in trials)
    assert ended["complete"] > 0.05 * count
    assert ended["interlock"] > 0.05 * count
    assert ended["firmware"] > 0.05 * count
    assert good > 0.2 * count
    stated_over_true = ", ".join(f"{channel} {ratio:.2g}" for channel, ratio in medians.items())
    figures = (
        f"{count} campaigns: {', '.join(f'{how} {number}' for how, number in ended.most_common())}; each time at rest with the "
        f"coil off, none unsafe; {good} records good, {marked} marked; wrong and good, which no sensor can tell: "
        f"{', '.join(shares)}: "
        f"{', '.join(f'{name} {number}' for name, number in unseen.items()) or 'none'}; median of stated uncertainty over true "
        f"rms error: {stated_over_true}"
    )
    print(figures)
    endurance.report("one or two faults of the rig at random moments of campaigns, five on each rig", seed, figures)


@pytest.mark.prove
@pytest.mark.endure
def test_no_healthy_run_is_marked(tmp_path: Path, endurance: Endurance) -> None:
    """Campaigns without a fault on rigs that are what they were calibrated to be, and hybrid tests of other voltages.

    The former on a damper that softens, and is warmer than in the run before, by some kelvin more or less than its host takes
    it for.
    """
    seed, count, marked, good, compared = 20201127, endurance.count(500), [], 0, 0
    for k in range(count):
        draw = np.random.default_rng([seed, k])
        out, path = tmp_path / str(k), tmp_path / "short.toml"
        if k % 10 == 9:
            step = {"kind": "hybrid", "voltage": round(float(draw.uniform(0.0, 2.0)), 3)}
            made = perform(planned_hybrid(step | {"duration": float(draw.choice([5.0, 10.0]))}), simulated(seed=k), out)
        else:
            believed, calibration = a_rig(draw, list(PROFILES)[k % len(PROFILES)], bought=0.0)
            true = true_rig(draw, calibration.corrected(believed))
            true = replace(true, specimen=replace(true.specimen, softening=SOFTENING))
            path.write_text(a_campaign(draw), "utf-8")
            kept = tmp_path / f"rig{k}"
            perform_before(a_host(Simulator(true, 10**6 + k), believed, calibration, kept), tmp_path)
            simulator = Simulator(true, k)
            rig = a_host(simulator, believed, calibration, kept)
            rig.warmth.temperature = float(draw.uniform(20.0, WARM))
            simulator.plant[plant.Y_TEMPERATURE] = rig.warmth.temperature + float(draw.normal(0.0, UNREAD))
            made = perform(plan(campaigns.read(path), believed), rig, out)
            compared += sum("compared with the runs until" in record.provenance["cell_gain"] for record in made)
        read = [records.read(one) for one in sorted(made.folder.glob("*.h5"))]
        good += len(read)
        marked += [f"{k} {record.name}: {record.marks}" for record in read if record.marks]
        shutil.rmtree(out)
    assert marked == []
    figures = f"{count} runs, {good} records, {compared} of them compared with a run before, none marked"
    endurance.report("runs without a fault, one in ten of them hybrid, on calibrated rigs", seed, figures)


SHORT = """
name = "short"
rest_between = "0.1 s"
check_amplitude = "{check} mm"
[[step]]
kind = "sine"
amplitude = "5 mm"
frequency = "2 Hz"
voltage = ["0 V", "1.5 V"]
cycles = 1
rest_before = "0.1 s"
"""


@pytest.mark.parametrize(("start", "check"), [(5.0, 1), (5.2, 0)])
def test_a_motor_that_stands_on_the_way_to_a_test_ends_the_campaign_as_a_fault(
    tmp_path: Path, start: float, check: int
) -> None:
    (tmp_path / "short.toml").write_text(SHORT.format(check=check), "utf-8")
    rig = simulated(faults=[FaultSpec("stalled-motor", start, np.inf)])
    with pytest.raises(RigFault, match=r"look at the motor|is the motor blocked"):
        perform(tmp_path / "short.toml", rig, tmp_path / "out")


@pytest.mark.parametrize(("first", "count"), [(0, 5), pytest.param(5, 10, marks=pytest.mark.prove)])
def test_campaigns_with_faults_are_safe_and_their_records_right(tmp_path: Path, first: int, count: int) -> None:
    """A few of those above, for every run of the tests; another rig in the proofs."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        trials, _ = run_trials(count, 1, tmp_path, first)
    for trial in trials:
        assert not trial.unsafe, trial
        assert not trial.wrong or classes_of(trial), trial
