"""A campaign performed: what is recorded, what is kept when it ends early, and how it goes on."""

import contextlib
import errno
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from tests.campaigns.quick_rig import TWO, quick_rig
from tests.endurance import Endurance

from dampyr import campaigns, records
from dampyr.campaigns import RunControl, Stopped, perform, read_journal
from dampyr.campaigns.run_control import Progress
from dampyr.cli import cli
from dampyr.errors import DampyrWarning, FileError, InputError, RigFault
from dampyr.records.files.recording import Recording
from dampyr.records.formats import h5
from dampyr.rig import Rig, RigSettings, load_settings, simulated
from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import InProcess
from dampyr.rig.instruments.ni_daqmx.simulated import InProcessBoard
from dampyr.rig.session import ArmedRig
from dampyr.rig.simulation.faults import FaultSpec


@dataclass
class Performed:
    """A campaign performed on the simulated rig as it is, and what it told meanwhile."""

    campaign: Path
    folder: Path
    reports: list[Progress] = field(default_factory=list)


@pytest.fixture(scope="module")
def performed(tmp_path_factory: pytest.TempPathFactory) -> Performed:
    place = tmp_path_factory.mktemp("performed")
    (place / "two.toml").write_text(TWO, encoding="utf-8")
    done = Performed(place / "two.toml", place / "out")
    perform(done.campaign, simulated(), done.folder, done.reports.append)
    return done


def test_each_test_is_a_file_that_says_everything(performed: Performed) -> None:
    folder = performed.folder
    recorded = records.read_campaign(folder)
    assert [record.name for record in recorded] == ["01-sine-5mm-1Hz-0V", "02-sine-5mm-1Hz-1.5V"]
    first, second = recorded
    assert (first.voltage, second.voltage) == (0.0, 1.5)
    assert first.label is not None
    assert (first.label.peak_to_peak_m, first.label.frequency_hz) == (0.01, 1.0)
    assert np.ptp(first.displacement) == pytest.approx(0.010, rel=0.04)
    assert first.provenance["operator"] == "A. Person"
    assert first.provenance["note"] == "a note"
    assert first.provenance["exit_status"] == "complete"
    assert json.loads(first.provenance["rig"])["actuator"]["free_speed"] == 0.078
    assert json.loads(first.provenance["calibration"])["scale"] == 613.0
    assert json.loads(first.provenance["step"])["amplitude"] == 0.005
    raw = h5.read_raw(folder / "01-sine-5mm-1Hz-0V.h5")
    np.testing.assert_allclose(raw["force"].gain * raw["force"].values + raw["force"].offset, first.force, atol=1e-9)
    x = raw["position"].gain * raw["position"].values + raw["position"].offset
    np.testing.assert_allclose(
        np.interp(first.time - raw["position"].delay, first.time, x), first.displacement, atol=1e-9
    )
    assert "displacement read 0.159 ms earlier" in first.history[0]
    tests, events = read_journal(folder)
    assert [(test.state, test.attempt) for test in tests] == [("complete", 1)] * 2
    assert [event.what for event in events] == [
        "armed", "homed", "checked", "begun", "complete", "begun", "complete", "complete",
    ]  # fmt: skip


def test_the_same_seed_gives_the_same_bits(performed: Performed, tmp_path: Path) -> None:
    both = [records.read_campaign(performed.folder), perform(performed.campaign, simulated(), tmp_path / "again")]
    for one, other in zip(*both, strict=True):
        np.testing.assert_array_equal(one.force, other.force)


def test_progress_is_told_with_every_block(performed: Performed) -> None:
    testing = [report for report in performed.reports if report.phase == "testing"]
    assert {report.done for report in testing} == {0, 1}
    assert testing[-1].fraction == pytest.approx(1.0, abs=0.02)
    assert testing[-1].cycles == pytest.approx(testing[-1].planned_cycles, abs=0.5)
    assert np.all(np.diff([report.time_left for report in testing]) <= 1e-9)
    assert max(abs(report.force) for report in testing) > 100.0
    assert max(report.stroke for report in testing) == pytest.approx(0.010, rel=0.05)


def test_what_the_rig_cannot_do_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    settings = {"step": [{"kind": "sine", "amplitude": "30 mm", "frequency": "1 Hz"}]}
    opened = quick_rig()
    with pytest.raises(InputError, match="lower the amplitude to"):
        perform(campaigns.campaign_of(settings), opened, tmp_path / "out")
    assert not (tmp_path / "out").exists()
    assert opened.board.simulator.time < 0.1  # it was asked who it is, and not read


def test_a_fault_ends_the_test_and_the_next_run_goes_on_with_it(two: Path, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with pytest.raises(RigFault, match="is the motor blocked"):
        perform(two, quick_rig("stalled-motor@30s"), folder)
    tests, _ = read_journal(folder)
    assert [test.state for test in tests] == ["complete", "failed"]
    record = records.read(folder / "02-sine-5mm-1Hz-1.5V.h5")
    assert (record.provenance["exit_status"], record.provenance["ring"]) == ("failed", "firmware")
    assert "is the motor blocked" in record.provenance["reason"]
    assert len(records.read_campaign(folder)) == 1
    perform(two, quick_rig(), folder)
    assert [test.attempt for test in read_journal(folder)[0]] == [1, 2]
    assert (folder / "02-sine-5mm-1Hz-1.5V.try2.h5").is_file()
    assert len(records.read_campaign(folder)) == 2
    again = quick_rig()
    perform(two, again, folder)  # nothing is left
    assert again.board.simulator.time < 0.1


def test_another_campaign_in_the_folder_is_refused(performed: Performed, two: Path) -> None:
    two.write_text(TWO.replace("5 mm", "6 mm"), encoding="utf-8")
    with pytest.raises(InputError, match="holds the campaign 'two', and this one differs"):
        perform(two, simulated(), performed.folder)


def pressing(control: RunControl, button: str, at: int) -> object:
    count = 0

    def show(progress: Progress) -> None:
        nonlocal count
        count += progress.phase == "testing"
        if count == at:
            getattr(control, button)()

    return show


def test_stop_ends_in_order(two: Path, tmp_path: Path) -> None:
    control = RunControl()
    opened = simulated()
    with pytest.raises(Stopped, match="run it again to go on"):
        perform(two, opened, tmp_path / "out", pressing(control, "stop", 30), control)
    record = records.read(tmp_path / "out/01-sine-5mm-1Hz-0V.h5")
    assert record.provenance["exit_status"] == "stopped"
    assert 30 * 0.04 >= record.time[-1] - record.time[0] > 20 * 0.04
    assert not opened.board.simulator.twin.enabled


def test_abort_acts_at_once(two: Path, tmp_path: Path) -> None:
    control = RunControl()
    with pytest.raises((RigFault, Stopped)):
        perform(two, simulated(), tmp_path / "out", pressing(control, "abort", 30), control)
    assert read_journal(tmp_path / "out")[0][0].state == "stopped"


def test_pause_waits_between_tests(two: Path, tmp_path: Path) -> None:
    control, paused = RunControl(), 0

    def show(progress: Progress) -> None:
        nonlocal paused
        if progress.phase == "testing" and progress.done == 0:
            control.pause()
        paused += progress.phase == "paused"
        if paused == 5:
            control.resume()

    perform(two, quick_rig(), tmp_path / "out", show, control)
    assert paused >= 5
    assert [e.what for e in read_journal(tmp_path / "out")[1]].count("resumed") == 1


def test_a_full_disk_ends_the_test_cleanly(two: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened, append, count = simulated(), Recording.append, 0

    def full(self: Recording, values: object) -> int:
        nonlocal count
        count += 1
        if count == 20:
            with self._translate_errors("cannot be written"):
                raise OSError(28, "No space left on device")
        return append(self, values)

    monkeypatch.setattr(Recording, "append", full)
    with pytest.raises(FileError, match="the disk is full; make room, and run the campaign again"):
        perform(two, opened, tmp_path / "out")
    simulator = opened.board.simulator
    assert not simulator.twin.enabled
    assert simulator.truth.voltage[-1] == 0.0
    record = records.read(tmp_path / "out/01-sine-5mm-1Hz-0V.h5")
    assert record.provenance["complete"] == "no"
    assert record.n == pytest.approx(19 * 40, abs=40)
    assert "disk is full" in read_journal(tmp_path / "out")[0][0].reason


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EFBIG])
def test_room_is_reserved_before_anything_moves(
    two: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    def refused(*_: object) -> None:
        raise OSError(number, os.strerror(number))

    opened = quick_rig()
    monkeypatch.setattr(os, "posix_fallocate", refused)
    with pytest.raises(FileError, match=r"01-sine-5mm-1Hz-0V cannot be recorded: .*: \d+ bytes are needed"):
        perform(two, opened, tmp_path / "out")
    assert opened.board.simulator.time < 0.1  # it was asked who it is, and not read


def test_a_test_that_never_began_leaves_no_file(two: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    go = ArmedRig.go

    def stuck(self: ArmedRig, displacement: float) -> None:
        if next((tmp_path / "out").glob("*.h5"), None):  # its room is reserved before the table moves
            raise RigFault("the table stands", "check")
        go(self, displacement)

    monkeypatch.setattr(ArmedRig, "go", stuck)
    with pytest.raises(RigFault, match="the table stands"):
        perform(two, quick_rig(), tmp_path / "out")
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"journal.sqlite"}


CROWDED = textwrap.dedent("""
    import os, resource, subprocess, sys
    from pathlib import Path
    from dampyr.campaigns import record_test
    from dampyr.cli import cli
    from dampyr.records import read
    from dampyr.records.formats import h5
    from dampyr.records.files.recording import Recording
    from dampyr.rig import simulated

    way, reserved, campaign, folder = sys.argv[1:5]
    append, out, log = Recording.append, Path(folder) / "out", Path(campaign).parent / "log.txt"

    def told(self, values):
        rows = append(self, values)
        with log.open("a") as file:
            file.write(f"{self.path.name} {rows}\\n")
        return rows

    Recording.append = told
    if reserved == "no":  # as where a file system takes a write anew that was reserved before, or others use up the room
        record_test.check_disk_space = lambda *_: None
        os.posix_fallocate = lambda *_: None
    simulated().board.simulator.run_unattended(0.01)  # compiled once, for every host that is forked
    print("ready", flush=True)
    for line in sys.stdin:
        host = os.fork()
        if not host:
            for k, name in enumerate(("stdout", "stderr"), 1):
                os.dup2(os.open(Path(campaign).parent / name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), k)
            if way == "limit":
                resource.setrlimit(resource.RLIMIT_FSIZE, (int(line) * 1024,) * 2)
            try:
                cli.main(["run", campaign, "--out", str(out)])
            except SystemExit as ended:
                os._exit(ended.code)
        print(os.waitstatus_to_exitcode(os.waitpid(host, 0)[1]), flush=True)
""")


@contextlib.contextmanager
def small_disk(folder: Path, kilobytes: int) -> Iterator[None]:
    command = ["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", str(folder)]
    if os.geteuid() or subprocess.run(command, check=False, capture_output=True).returncode:
        pytest.skip("only root may mount a small disk")
    try:
        yield
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def crowded(hosts: subprocess.Popen, tmp_path: Path, kilobytes: int) -> tuple[int, str]:
    """How a campaign ended on so much room, and what it said; its files are checked."""
    assert hosts.stdin is not None
    assert hosts.stdout is not None
    (tmp_path / "log.txt").write_text("")
    hosts.stdin.write(f"{kilobytes}\n")
    hosts.stdin.flush()
    code = int(hosts.stdout.readline())
    assert code in (0, 2, 4), (kilobytes, code)  # complete, refused before anything moved, or failed
    said = (tmp_path / "stderr").read_text().strip().splitlines()
    assert not any(line.startswith("Traceback") for line in said), (kilobytes, said)
    out = tmp_path / "disk" / "out"
    for path in out.glob("*.h5"):
        assert h5.state(path).test
    acknowledged: dict[str, int] = {}
    for name, rows in (line.split() for line in (tmp_path / "log.txt").read_text().splitlines()):
        acknowledged[name] = int(rows)
    check_saved(out, {name: rows for name, rows in acknowledged.items() if rows >= 8})
    assert not list(out.glob(".*"))
    return code, said[-1] if said else ""


def check_free_space(way: str, reserved: str, tmp_path: Path, sizes: Iterable[int]) -> dict[int, str]:
    """Campaigns on disks or with files of so many kB: each ends in order and says why."""
    campaign, disk, outcomes = tmp_path / "two.toml", tmp_path / "disk", {}
    campaign.write_text(TWO.replace("cycles = 2", "cycles = 1"), encoding="utf-8")
    disk.mkdir()
    command = [sys.executable, "-c", CROWDED, way, reserved, str(campaign), str(disk)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as hosts:
        assert hosts.stdout is not None
        assert hosts.stdout.readline() == "ready\n"
        for size in sizes:
            with small_disk(disk, size) if way == "disk" else contextlib.nullcontext():
                code, said = crowded(hosts, tmp_path, size)
                shutil.rmtree(disk / "out", ignore_errors=True)
            assert code == 0 or said.startswith("dampyr: "), (size, said)
            outcomes[size] = said if code else "complete"
        assert hosts.stdin is not None
        hosts.stdin.close()
    return outcomes


@pytest.mark.prove
def test_on_every_disk_that_is_too_small_a_campaign_ends_in_order(tmp_path: Path) -> None:
    outcomes = check_free_space("disk", "yes", tmp_path, [300, 340, 420, 500, 620, 740, 1200])
    assert outcomes[1200] == "complete"
    assert re.search(r"the disk is full: \d+ bytes are needed, .* and \d+ are free; make room", outcomes[340])


@pytest.mark.prove
def test_a_file_that_may_not_become_so_long_ends_a_campaign_in_order(tmp_path: Path) -> None:
    outcomes = check_free_space("limit", "yes", tmp_path, [120, 300, 400])
    assert outcomes[400] == "complete"
    assert "a file may not become as long here" in outcomes[120]


@pytest.mark.prove
@pytest.mark.parametrize("way", ["disk", "limit"])
@pytest.mark.parametrize(  # with room reserved, the two tests above are like it
    "reserved", [pytest.param("yes", marks=pytest.mark.by_hand), "no"]
)
def test_wherever_room_runs_out_a_campaign_ends_in_order(way: str, reserved: str, tmp_path: Path) -> None:
    """Without reserving, as where a file system promises what it does not hold, it runs out in the middle of every write."""
    sizes = range(100, 1300, 200) if way == "disk" else range(20, 420, 80)  # five limits of a file's length
    outcomes = check_free_space(way, reserved, tmp_path, sizes)
    assert len({words.split(": ")[-1] for words in outcomes.values()}) > 1


def test_a_cell_wired_backwards_is_seen_before_the_first_test(two: Path, tmp_path: Path) -> None:
    opened = quick_rig()
    assert opened.calibration is not None
    opened.calibration = replace(opened.calibration, scale=-613.0)
    with pytest.raises(RigFault, match="is the force's sign inverted"):
        perform(two, opened, tmp_path / "out")
    assert [test.state for test in read_journal(tmp_path / "out")[0]] == ["planned", "planned"]


HOST = textwrap.dedent("""
    import sys
    from dampyr.campaigns import perform
    from dampyr.records.files.recording import Recording
    from dampyr.rig import RigSettings
    from tests.rig.wires.process import over_wires

    campaign, folder, box = sys.argv[1:4]
    append = Recording.append

    def told(self, values):
        rows = append(self, values)
        sys.stdout.write(f"{self.path.name} {rows}\\n")
        sys.stdout.flush()
        return rows

    Recording.append = told
    with over_wires(black_box=box) as rig:
        sys.stdout.write("ready\\n")
        sys.stdout.flush()
        perform(campaign, rig, folder)
    sys.stdout.write("complete\\n")
    sys.stdout.flush()
""")


def killed(campaign: Path, folder: Path, after: float, rows: int = 0) -> tuple[dict[str, int], bool, Path]:
    """Run a campaign in a process of its own and kill it ``after`` s, and ``rows`` of a test: the rows that it
    acknowledged, whether it had ended, and the black box of its rig."""
    box = folder.parent / f"box-{time.monotonic_ns()}.jsonl"
    command = [sys.executable, "-c", HOST, str(campaign), str(folder), str(box)]
    path = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=path) as host:
        assert host.stdout is not None
        assert host.stdout.readline() == "ready\n"
        said = []
        while rows and not (said and int(said[-1][1]) >= rows):
            said.append(host.stdout.readline().split())
        try:
            host.wait(after)
        except subprocess.TimeoutExpired:
            os.kill(host.pid, signal.SIGKILL)
        said += [line.split() for line in host.stdout.read().split("\n")[:-1]]
    return {line[0]: int(line[1]) for line in said if len(line) == 2}, ["complete"] in said, box


def at_rest(box: Path) -> list[dict[str, object]]:
    """The black box, once the rig whose host was killed has come to rest."""
    for _ in range(200):
        events = [json.loads(line) for line in box.read_text("utf-8").splitlines()]
        if events and events[-1]["event"] == "ends":
            return events
        time.sleep(0.05)
    raise AssertionError(f"the rig did not come to rest: {events[-5:]}")


def check_saved(folder: Path, acknowledged: dict[str, int]) -> None:
    for name, rows in acknowledged.items():
        assert records.read(folder / name).n >= rows, name


def check_rest(box: Path) -> None:
    """From the moment the host was gone: coil dead and table at rest within 300 ms."""
    events = at_rest(box)
    gone = next(e["time"] for e in events if e["event"] == "serial closed")
    after = [e for e in events if e["time"] >= gone]
    moving = any(e["event"] == "enable high" for e in events)
    if moving:
        low = [e["time"] for e in events if e["event"] == "enable low"]
        rests = [e["time"] for e in events if e["event"] == "at rest"]
        assert low[-1] <= gone + 0.300, (gone, after)
        assert not rests or rests[-1] <= gone + 0.300, (gone, after)


@pytest.mark.prove
def test_a_killed_host_leaves_a_rig_at_rest_and_its_samples(two: Path, tmp_path: Path) -> None:
    acknowledged, ended, box = killed(two, tmp_path / "out", 0.0, rows=600)
    assert not ended
    check_saved(tmp_path / "out", acknowledged)
    check_rest(box)
    perform(two, simulated(), tmp_path / "out")
    assert [test.state for test in read_journal(tmp_path / "out")[0]] == ["complete"] * 2
    assert any("interrupted" in event.detail for event in read_journal(tmp_path / "out")[1])


FORKING = textwrap.dedent("""
    import os, signal, sys, time
    from dampyr.campaigns import perform
    from dampyr.records.files.recording import Recording
    from dampyr.rig import simulated

    append = Recording.append

    def told(self, values):
        rows = append(self, values)
        os.write(1, f"{self.path.name} {rows}\\n".encode())
        return rows

    Recording.append = told
    simulated().board.simulator.run_unattended(0.01)  # compiled once, for every host that is forked
    print("ready", flush=True)
    for line in sys.stdin:
        campaign, folder, after = line.rstrip().split("|")
        host = os.fork()
        if not host:
            perform(campaign, simulated(), folder)
            os.write(1, b"complete\\n")
            os._exit(0)
        until = time.monotonic() + float(after)
        while time.monotonic() < until and os.waitpid(host, os.WNOHANG) == (0, 0):
            time.sleep(0.0005)
        try:
            os.kill(host, signal.SIGKILL)
            os.waitpid(host, 0)
        except (ProcessLookupError, ChildProcessError):
            pass
        print("over", flush=True)
""")


@pytest.mark.prove
@pytest.mark.endure
def test_kills_in_campaigns(two: Path, tmp_path: Path, endurance: Endurance) -> None:
    """Hosts killed at random moments, over and over, until each campaign is complete: nothing acknowledged is lost."""
    seed, wanted = 20201124, endurance.count(400, part=80)
    draw, kills, number, rows = np.random.default_rng(seed), 0, 0, 0
    command = [sys.executable, "-c", FORKING]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as hosts:
        assert hosts.stdin is not None
        assert hosts.stdout is not None
        assert hosts.stdout.readline() == "ready\n"
        while kills < wanted:
            number += 1
            folder, acknowledged, ended, max_delay = tmp_path / str(number) / "out", {}, False, 0.3
            folder.parent.mkdir()
            while not ended:
                max_delay *= 1.1  # so that a slow machine comes to the end of a campaign too
                hosts.stdin.write(f"{two}|{folder}|{draw.uniform(0.0, max_delay)}\n")
                hosts.stdin.flush()
                said = [line.split() for line in iter(hosts.stdout.readline, "over\n")]
                acknowledged |= {line[0]: int(line[1]) for line in said if len(line) == 2}
                ended = ["complete"] in said
                kills += not ended
                check_saved(folder, acknowledged)
            assert len(records.read_campaign(folder)) == 2
            assert [test.state for test in read_journal(folder)[0]] == ["complete"] * 2
            assert not list(folder.glob(".*"))  # of a copy that was under way
            rows += sum(acknowledged.values())
        hosts.stdin.close()
    assert number > wanted / 40  # campaigns went on to their end between the kills
    endurance.report(
        "the host is killed while it performs a campaign, until the campaign is complete",
        seed,
        f"{kills} kills in {number} campaigns; of {rows} acknowledged samples none is lost",
    )


@pytest.mark.endure
@pytest.mark.by_hand  # one kill over the wires, above, and many without wires are the proofs that are always run
def test_kills_over_the_wires(two: Path, tmp_path: Path, endurance: Endurance) -> None:
    """The rig is a process of its own and comes to rest within 300 ms whenever its host is killed."""
    seed, wanted = 20201125, 100 if endurance.full else 2
    draw, kills, number = np.random.default_rng(seed), 0, 0
    while kills < wanted:
        number += 1
        folder, saved, ended, max_delay = tmp_path / str(number) / "out", {}, False, 1.0
        folder.parent.mkdir()
        while not ended:
            max_delay *= 1.2 if endurance.full else 2.0
            acknowledged, ended, box = killed(two, folder, float(draw.uniform(0.0, max_delay)))
            saved |= acknowledged
            kills += not ended
            check_saved(folder, saved)
            check_rest(box)
        assert len(records.read_campaign(folder)) == 2
    endurance.report(
        "the host is killed while its rig, a process of its own, moves",
        seed,
        f"{kills} kills in {number} campaigns; each time at rest with the coil off within 300 ms",
    )


@pytest.mark.parametrize("new", [pytest.param(False, marks=pytest.mark.prove), True])
def test_counts_that_were_lost_since_the_last_campaign_are_seen_before_the_next(
    two: Path, tmp_path: Path, new: bool
) -> None:
    first = quick_rig()
    simulator = first.board.simulator
    perform(two, first, tmp_path / "a")
    simulator.faults = (FaultSpec("slipped-encoder", simulator.time, amount=-0.0017),)
    simulator.run_unattended(0.1)
    board = InProcessBoard(simulator)
    second = Rig(first.settings, Uno(InProcess(simulator.serial)), board, threaded=False) if new else first
    with pytest.warns(DampyrWarning, match="index was not where homing had put it.*homed again"):
        perform(two, second, tmp_path / "b")
    assert "index moved" in [event.what for event in read_journal(tmp_path / "b")[1]]
    with second.armed() as table:
        assert table.position == pytest.approx(simulator.truth.position[-1], abs=1.1e-5)


def test_the_settings_are_those_of_the_rig_file(two: Path, tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text('[board]\nrate = "500 Hz"\n', encoding="utf-8")
    with simulated(tmp_path / "rig.toml") as opened:
        assert opened.settings.board.rate == 500.0
        perform(two, opened, tmp_path / "out")
    assert records.read_campaign(tmp_path / "out")[0].dt == pytest.approx(0.002)
    assert RigSettings().board.rate == 1000.0


def test_a_name_that_is_none_is_refused_before_anything_moves(two: Path, tmp_path: Path) -> None:
    two.write_text('specimen = "  "\n' + TWO, encoding="utf-8")
    with pytest.raises(FileError, match=r"two\.toml: specimen = '  ' is not a name; give one line of text"):
        campaigns.read(two)
    (tmp_path / "rig.toml").write_text('[specimen]\nname = "a\\nb"\n', encoding="utf-8")
    with pytest.raises(FileError, match=r"rig\.toml: .*name = 'a\\nb' is not a name"):
        load_settings(tmp_path / "rig.toml")


def test_what_was_scaled_is_in_the_record_the_journal_and_what_run_prints(tmp_path: Path) -> None:
    text = """
        name = "fitted"
        rest_between = "0.2 s"
        check_amplitude = 0
        [[step]]
        kind = "sweep"
        amplitude = "8 mm"
        start = "1 Hz"
        stop = "3 Hz"
        duration = "2 s"
        rest_before = "0.2 s"
        fit_limits = true
        [[step]]
        kind = "earthquake"
        motion = "motion.csv"
        rest_before = "0 s"
    """
    t = np.arange(0.0, 2.0, 0.02)  # 2 m/s^2 at 2 Hz: 160 mm/s, twice what the table can do
    shaken = 2.0 * np.sin(0.5 * np.pi * t) ** 2 * np.sin(4 * np.pi * t)
    rows = "".join(f"{at:.2f},{value:.6f}\n" for at, value in zip(t, shaken, strict=True))
    (tmp_path / "motion.csv").write_text(f"time [s],acceleration [m/s^2]\n{rows}")
    (tmp_path / "fitted.toml").write_text(text)
    done = CliRunner().invoke(
        cli,
        ["run", str(tmp_path / "fitted.toml"), "--out", str(tmp_path / "out")],
        env={"COLUMNS": "400"},
    )
    assert done.exit_code == 0
    fitted = campaigns.plan(tmp_path / "fitted.toml").tests
    flat = " ".join(done.stdout.split())
    for test in fitted:
        assert f"{test.name}: {test.fitted}" in flat
        assert h5.provenance(tmp_path / "out" / f"{test.name}.h5")["fitted"] == test.fitted
    assert [event.detail for event in read_journal(tmp_path / "out")[1] if event.what == "fitted"] == [
        test.fitted for test in fitted
    ]
    assert fitted[1].fitted.startswith("scaled to 0.")
