"""Instruments of another laboratory: those of docs/how-to/add-an-instrument.md, and folders that are none."""

from __future__ import annotations

import json
import re
import socket
import threading
from dataclasses import replace
from itertools import count
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.campaigns import campaign_of, perform
from dampyr.cli import cli
from dampyr.errors import DampyrWarning, FileError, InputError, RigFault
from dampyr.records import Record, read_campaign
from dampyr.rig import Drive, Rig, RigSettings, load_settings, simulated
from dampyr.rig.diagnosis import diagnose
from dampyr.rig.instruments import catalogue
from dampyr.rig.settings_file import write_settings
from dampyr.rig.simulation.simulator import Simulator

PAGE = (Path(__file__).parents[3] / "docs/how-to/add-an-instrument.md").read_text("utf-8")
FILE = re.compile(r"^```\w+ name=(\S+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBERS = count()
CAMPAIGN = {
    "name": "two",
    "operator": "me",
    "rest_between": "1 s",
    "step": [
        {
            "kind": "sine",
            "amplitude": "8 mm",
            "frequency": "1 Hz",
            "voltage": ["0 V", "1.98 V"],
            "cycles": 2,
        }
    ],
}


@pytest.fixture
def laboratory(tmp_path: Path) -> Path:
    """The folder of a rig.toml with the page's instruments."""
    for name, text in FILE.findall(PAGE):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, "utf-8")
    return tmp_path


def rig_file(folder: Path, **wires: str) -> Path:
    """A rig.toml that names instruments."""
    path = folder / f"rig{next(NUMBERS)}.toml"
    path.write_text("[wires]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in wires.items()), "utf-8")
    return path


def records_of(rig: Rig, out: Path) -> list[Record]:
    """The records of a campaign on a rig."""
    with rig:
        return list(perform(campaign_of(CAMPAIGN), rig, out))


def agree(ours: list[Record], theirs: list[Record], skip: float = 0.0) -> None:
    """Two campaigns agree within the noise of a sample, from ``skip`` s after a record's start on."""
    assert len(ours) == len(theirs) == 2
    for own, other in zip(ours, theirs, strict=True):
        assert own.time.size == other.time.size
        late = own.time - own.time[0] >= skip
        assert np.sqrt(np.mean((own.force - other.force)[late] ** 2)) < 3.0  # N: noise and wander of 0.9 N, twice
        assert np.abs(own.displacement - other.displacement).max() < 2e-5
        assert own.voltage == other.voltage


@pytest.fixture(scope="module")
def usual(tmp_path_factory: pytest.TempPathFactory) -> list[Record]:
    """The records of the NI board."""
    return records_of(simulated(), tmp_path_factory.mktemp("usual") / "out")


def test_the_page_shows_files_that_are_there(laboratory: Path) -> None:
    rig = load_settings(laboratory / "rig.toml")
    assert (rig.wires.acquisition, rig.wires.supply) == ("./our_board", "./bench_supply")
    assert load_settings(write_settings(rig, laboratory / "written.toml")) == rig
    with simulated(laboratory / "rig.toml") as opened:
        assert "OUR-BOARD 7, supply simulated BENCH 30V" in opened.identity
        assert "up to 90 ms late" in opened.identity


def test_an_acquisition_of_ones_own_gives_the_record_of_the_usual_one(laboratory: Path, usual: list[Record]) -> None:
    path = rig_file(laboratory, acquisition="./our_board")
    ours = records_of(simulated(path), laboratory / "out")
    agree(ours, usual)
    for own, other in zip(ours, usual, strict=True):  # the same calls: to the last bit
        np.testing.assert_array_equal(own.force, other.force)


def test_the_driver_of_ones_own_over_its_wire(laboratory: Path) -> None:
    """The page's driver speaks to its simulated end over TCP, and gives what it gives without a wire."""
    rig = replace(RigSettings(), wires=replace(RigSettings().wires, acquisition=str(laboratory / "our_board")))
    end, driver = (catalogue.part(rig, "acquisition", name) for name in ("simulated", "driver"))
    simulators = [Simulator(RigSettings(), 1) for _ in range(2)]
    listener = socket.create_server(("127.0.0.1", 0))

    def serve() -> None:
        client, _ = listener.accept()
        with client, client.makefile("rw", encoding="utf-8") as lines:
            for line in lines:
                request = json.loads(line)
                try:
                    reply = end.answer(simulators[0], request.pop("do"), **request)
                except InputError as problem:
                    reply = {"error": str(problem)}
                lines.write(json.dumps(reply) + "\n")
                lines.flush()

    threading.Thread(target=serve, daemon=True).start()
    address = f"127.0.0.1:{listener.getsockname()[1]}"
    there = driver.connect(replace(rig, wires=replace(rig.wires, acquisition_address=address)))
    here = end.in_process(simulators[1])
    with pytest.raises(RigFault, match=r"our board gives an error: .*no sampled task runs"):
        there.read(10)
    seen = []
    for board in (there, here):
        board.start(1000.0, [1.0] * 100)
        board.queue([2.0] * 50)
        seen.append(board.read(40))
        board.write(0.5)
        assert board.identity() == "simulated OUR-BOARD 7"
        assert board.index_counts().size == 0
        board.stop()
    for ours, theirs in zip(*seen, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    assert simulators[0].command == simulators[1].command == pytest.approx(0.5, abs=1e-3)
    there.close()
    listener.close()


def test_the_supply_of_ones_own_without_a_wire_says_what_it_is(laboratory: Path) -> None:
    with simulated(laboratory / "rig.toml") as rig:
        volts, counts = rig.listen(0.2)
        assert (volts.shape, counts.shape) == ((1, 200), (200,))
        assert rig.identity.startswith("simulated OUR-BOARD 7, supply simulated BENCH 30V (no sample clock")


def test_dampyr_run_takes_it(laboratory: Path) -> None:
    path = rig_file(laboratory, acquisition="./our_board")
    (laboratory / "one.toml").write_text(
        'name = "one"\noperator = "me"\n[[step]]\nkind = "sine"\namplitude = "5 mm"\nfrequency = "1 Hz"\ncycles = 2\n'
        'voltage = "0 V"\n'
    )
    command = [
        "run",
        str(laboratory / "one.toml"),
        "--rig",
        str(path),
        "--out",
        str(laboratory / "out"),
    ]
    result = CliRunner().invoke(cli, command, catch_exceptions=False)
    assert result.exit_code == 0, result.stderr
    [record] = read_campaign(laboratory / "out")
    assert record.provenance["board"].startswith("simulated OUR-BOARD 7")


def test_a_supply_without_a_clock_holds_constant_voltages(laboratory: Path, usual: list[Record]) -> None:
    path = rig_file(laboratory, supply="./bench_supply")
    ours = records_of(simulated(path), laboratory / "out")
    agree(ours, usual, skip=0.3)
    assert "(no sample clock: its voltage comes up to 90 ms late)" in ours[0].provenance["board"]


def test_a_step_of_its_voltage_is_told_with_its_latency(laboratory: Path) -> None:
    drive = Drive(0.01, np.zeros(100), np.r_[np.zeros(50), np.full(50, 2.0)])
    with simulated(rig_file(laboratory, supply="./bench_supply")) as rig:
        simulator: Simulator = rig.board.acquisition.simulator  # type: ignore[attr-defined]
        with rig.armed() as table:
            table.home(here=True)
            with pytest.warns(DampyrWarning, match="steps of its voltage come up to 90 ms late"):
                blocks = list(table.play(drive))
            begin = simulator.time - table.loop.next / rig.settings.board.rate
    samples = [block for block, _ in blocks]
    time, voltage = (np.concatenate([getattr(block, name) for block in samples]) for name in ("time", "voltage"))
    commanded = time[np.flatnonzero(voltage > 1.9)[0]]
    truth = simulator.truth
    late = truth.time[np.flatnonzero(truth.voltage > 1.9)[0]] - begin - commanded
    assert 0.02 < late <= rig.command_delay == pytest.approx(0.09)
    with simulated() as rig:
        assert rig.command_delay == 0.0


def test_a_cut_is_not_followed_by_what_was_queued(laboratory: Path) -> None:
    with simulated(rig_file(laboratory, supply="./bench_supply")) as rig:
        board, simulator = rig.board, rig.board.acquisition.simulator  # type: ignore[attr-defined]
        board.start(1000.0, np.r_[np.full(100, 2.0), np.full(300, 3.0)])
        board.read(80)
        assert simulator.command == pytest.approx(2.0, abs=1e-3)
        board.write(0.0)
        for _ in range(5):
            board.read(50)
        assert simulator.command == pytest.approx(0.0, abs=1e-3)
        board.stop()
        board.start(1000.0, np.full(100, 1.0))
        board.read(80)
        assert simulator.command == pytest.approx(1.0, abs=1e-3)


DRIVE = """
from dampyr.rig.instruments.arduino_uno.driver import Uno
from dampyr.rig.instruments.arduino_uno.wire import InProcess, open_wire

class OurDrive(Uno):
    jogs = 0

    def jog(self, speed, time_ms):
        self.jogs += 1
        super().jog(speed, time_ms)

def connect(rig):
    return OurDrive(open_wire(rig.wires.serial, rig.wires.baud))

def in_process(simulator):
    return OurDrive(InProcess(simulator.serial))
"""


def test_a_drive_of_ones_own(tmp_path: Path) -> None:
    (tmp_path / "our_drive").mkdir()
    (tmp_path / "our_drive" / "driver.py").write_text(DRIVE)
    (tmp_path / "our_drive" / "simulated.py").write_text("from .driver import in_process\n")
    with simulated(rig_file(tmp_path, drive="./our_drive")) as rig:
        assert "drive's firmware" in rig.identity
        with rig.armed() as table:
            table.home()
            table.jog(0.001)
            assert rig.uno.jogs == 1  # type: ignore[attr-defined]
            table.go(0.002)
            assert table.position == pytest.approx(0.002, abs=5e-4)


@pytest.mark.prove  # in real time
def test_the_process_that_reads_opens_own_instruments(laboratory: Path) -> None:
    with simulated(laboratory / "rig.toml", real_time=True) as rig:
        volts, counts = rig.listen(0.2)
        assert volts.shape == (1, 200)
        assert "OUR-BOARD 7" in rig.identity
        with rig.armed() as table:
            table.home(here=True)
            assert rig.command_delay == pytest.approx(0.09)
        assert counts.shape == (200,)


def test_the_catalogue() -> None:
    assert catalogue.available("acquisition") == ["ni-daqmx"]
    assert catalogue.available("drive") == ["arduino-uno"]
    assert catalogue.available("supply") == ["analogue-output"]


@pytest.mark.parametrize(
    ("wires", "words"),
    [
        ({"acquisition": "ni-daqm"}, r"wires.acquisition = 'ni-daqm' is not known; did you mean 'ni-daqmx'\?"),
        ({"drive": "ni-daqmx"}, "wires.drive = 'ni-daqmx' is not known; .*arduino-uno.* or give the path of a folder"),
        ({"supply": "analog-output"}, "did you mean 'analogue-output'"),
        ({"acquisition": "./nowhere"}, "nowhere: wires.acquisition names this folder, and there is none"),
        (
            {"acquisition": "./empty"},
            "empty: has no .*py; wires.acquisition names a folder with driver.py and simulated.py",
        ),
        ({"acquisition": "./broken"}, "cannot be imported: SyntaxError"),
        ({"acquisition": "./nothing"}, r"nothing: .*py has no "),
        (
            {"acquisition": "./poor"},
            r"poor: its driver has no index_counts\(\) and no queue\(\), which is needed of an acq",
        ),
        ({"supply": "./poor"}, "no latency, which is needed of a supply"),
    ],
)
def test_an_instrument_that_is_none_is_a_sentence(tmp_path: Path, wires: dict[str, str], words: str) -> None:
    for name, text in (("broken", "def"), ("nothing", "")):
        for file in ("driver.py", "simulated.py"):
            (tmp_path / name).mkdir(exist_ok=True)
            (tmp_path / name / file).write_text(text)
    (tmp_path / "empty").mkdir()
    (tmp_path / "poor").mkdir()
    methods = "start = read = write = stop = close = identity = lambda self, *given: None"
    (tmp_path / "poor" / "driver.py").write_text(
        f"class Poor:\n    {methods}\n\ndef connect(rig):\n    return Poor()\n"
    )
    (tmp_path / "poor" / "simulated.py").write_text(
        "from .driver import Poor\n\ndef in_process(simulator):\n    return Poor()\n"
    )
    path = rig_file(tmp_path, **wires)
    with pytest.raises(InputError, match=words):
        simulated(path)
    [(role, name)] = wires.items()
    findings = {each.what: each for each in diagnose(path)}
    assert findings[role].observed == name
    assert re.search(words, str(findings["connection"].repair))


@pytest.mark.prove  # a process is started, which imports dampyr
def test_in_real_time_it_is_the_same_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"wires.acquisition = 'ni-daqm' is not known"):
        simulated(rig_file(tmp_path, acquisition="ni-daqm"), real_time=True)


def test_a_simulated_end_without_its_function_says_what_is_missing(laboratory: Path) -> None:
    path = laboratory / "our_board" / "simulated.py"
    path.write_text(path.read_text().replace("def in_process(", "def in_this_process("))
    with pytest.raises(FileError, match=r"simulated.py has no in_process\(\)"):
        simulated(rig_file(laboratory, acquisition="./our_board"))


def test_what_was_opened_is_closed_where_another_fails(tmp_path: Path) -> None:
    from dampyr.rig.instruments.connection import assembled

    closed: list[str] = []

    class Closing:
        def close(self) -> None:
            closed.append("closed")

    with pytest.raises(FileError, match=r"no hello\(\)"):
        assembled(RigSettings(), {"drive": Closing, "acquisition": Closing})
    assert closed == ["closed"]


def test_doctor_lists_the_instruments(laboratory: Path) -> None:
    findings = {each.what: each for each in diagnose(laboratory / "rig.toml")}
    assert findings["acquisition"].observed == "./our_board"
    assert findings["drive"].observed == "arduino-uno"
    assert findings["supply"].observed == "./bench_supply"
    assert "OUR-BOARD 7" in findings["board"].observed
    usual = {each.what: each for each in diagnose(None)}
    assert usual["supply"].observed == "an output of the acquisition"


def test_a_relative_folder_lies_beside_the_rigs_file(laboratory: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir("/")
    rig = load_settings(laboratory / "rig.toml")
    absolute = catalogue.with_absolute_folders(rig, laboratory)
    assert absolute.wires.acquisition == str(laboratory / "our_board")
    assert absolute.wires.drive == "arduino-uno"
    assert replace(absolute, wires=rig.wires) == rig
