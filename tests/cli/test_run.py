"""dampyr run: the dry run, and a folder whose journal was lost."""

import hashlib
import json
import os
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path

import h5py
import pytest
from click.testing import CliRunner
from tests.short_campaign import FIRST, SECOND, SHORT

from dampyr import records
from dampyr.campaigns import campaign_of, read_journal
from dampyr.cli import cli
from dampyr.cli.run import FAILED, REFUSED, next_command
from dampyr.records.formats import h5

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
BAD = '[[step]]\nkind = "sine"\namplitude = "20 mm"\nfrequency = ["0.1 Hz", "2 Hz", "3 Hz"]\n'


def run(*arguments):
    return CliRunner().invoke(cli, ["run", *map(str, arguments)])


def test_a_dry_run_prints_every_test():
    done = run(EXAMPLES / "quick_campaign.toml", "--dry-run")
    assert done.exit_code == 0
    assert "quick: 3 tests on shaking table" in done.stdout
    assert "02-sine-8mm-1Hz-1.98V" in done.stdout
    assert done.stderr == ""


def test_a_real_rig_without_a_card_is_told_that_the_force_is_not_known(tmp_path):
    (tmp_path / "rig.toml").write_text('[wires]\nserial = "COM3"\n')
    done = run(EXAMPLES / "quick_campaign.toml", "--dry-run", "--rig", tmp_path / "rig.toml")
    assert "its force is unknown and taken as a conservative envelope" in done.stdout


def test_refusals_stand_in_one_line_each(tmp_path):
    (tmp_path / "bad.toml").write_text(BAD)
    done = run(tmp_path / "bad.toml", "--dry-run")
    assert done.exit_code == 2
    lines = done.stderr.splitlines()
    assert [line.partition(":")[0] for line in lines] == ["dampyr", "dampyr"]
    assert "step 1, sine 20 mm at 2 Hz, 0 V: needs 251.3 mm/s" in lines[0]
    assert "03-sine-20mm-3Hz-0V" in done.stdout


def test_for_machines_in_si(tmp_path):
    (tmp_path / "bad.toml").write_text(BAD)
    output = json.loads(run(tmp_path / "bad.toml", "--dry-run", "--json").stdout)
    assert [test["step"]["amplitude"] for test in output["tests"]] == [0.02] * 3
    assert [bool(test["refusal"]) for test in output["tests"]] == [False, True, True]
    assert len(output["refusals"]) == 2


def test_a_seed_changes_the_order_and_no_name():
    orders = []
    for seed in ("1", "2"):
        output = json.loads(run(EXAMPLES / "every_kind.toml", "--dry-run", "--json", "--seed", seed).stdout)
        orders.append([test["name"] for test in output["tests"]])
    assert orders[0] != orders[1]
    assert sorted(orders[0]) == sorted(orders[1])


def test_a_campaign_that_is_refused_does_not_run(tmp_path):
    (tmp_path / "bad.toml").write_text(BAD)
    done = run(tmp_path / "bad.toml", "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert "needs 251.3 mm/s" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the first test is complete and the second failed."""
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "short.toml").write_text(SHORT)
    done = run(folder / "short.toml", "--out", folder / "out", "--fault", "stalled-motor@18s")
    assert done.exit_code == 3
    assert [test.state for test in read_journal(folder / "out")[0]] == ["complete", "failed"]
    return folder


@pytest.fixture
def lab(recorded: Path, tmp_path: Path) -> Path:
    (tmp_path / "out").mkdir()
    for path in (recorded / "short.toml", *(recorded / "out").iterdir()):
        (tmp_path / path.relative_to(recorded)).write_bytes(path.read_bytes())
    return tmp_path


def sums(folder: Path) -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.glob("*.h5"))}


def lose(how: str, journal: Path) -> None:
    """What may happen to a journal."""
    if how == "deleted":
        journal.unlink()
    elif how == "empty":
        journal.write_bytes(b"")
    else:
        with sqlite3.connect(journal) as base:
            for table in ("tests", "campaign", "events")[: 1 if how == "without tests" else 3]:
                base.execute(f"DELETE FROM {table}")
        base.close()


@pytest.mark.parametrize(
    "how",
    [
        "deleted",
        pytest.param("empty", marks=pytest.mark.prove),
        "without rows",
        pytest.param("without tests", marks=pytest.mark.prove),
    ],
)
def test_a_journal_that_was_lost_is_made_anew_from_the_files(lab: Path, how: str) -> None:
    out, before = lab / "out", sums(lab / "out")
    assert len(before) == 2
    lose(how, out / "journal.sqlite")
    done = run(lab / "short.toml", "--out", out)
    assert done.exit_code == 0, done.output
    assert "was missing or empty and is made anew from the files of 2 of its 2 tests: 1 complete, 1 not" in done.stderr
    tests, events = read_journal(out)
    assert [(test.name, test.state, test.attempt) for test in tests] == [
        (FIRST, "complete", 1),
        (SECOND, "complete", 2),
    ]
    assert [event.detail for event in events if event.what == "rebuilt"]
    after = sums(out)
    assert {name: after[name] for name in before} == before
    assert set(after) - set(before) == {f"{SECOND}.try2.h5"}
    assert len(records.read_campaign(out)) == 2
    lose(how, out / "journal.sqlite")
    done = run(lab / "short.toml", "--in-process", "--out", out)  # an option that has no effect any more
    assert done.exit_code == 0
    assert "2 of 2 tests complete" in done.stdout
    assert sums(out) == after


@pytest.mark.parametrize(
    ("how", "old"),
    [
        ("deleted", False), ("empty", True),
        pytest.param("deleted", True, marks=pytest.mark.prove), pytest.param("empty", False, marks=pytest.mark.prove),
    ],
)  # fmt: skip
def test_another_campaign_with_the_same_names_takes_no_files_over(lab: Path, how: str, old: bool) -> None:
    out = lab / "out"
    if old:  # as before files told of the whole campaign
        for path in out.glob("*.h5"):
            with h5py.File(path, "r+") as file:
                del file["provenance"].attrs["campaign_digest"]
    before = sums(out)
    lose(how, out / "journal.sqlite")
    (lab / "short.toml").write_text(SHORT.replace("cycles = 2", "cycles = 1"))
    done = run(lab / "short.toml", "--out", out)
    assert done.exit_code == 2
    assert f"has no journal of its tests, and its file {FIRST}.h5 is not of the campaign 'short'" in done.stderr
    assert "give another --out, or move the files that are there to another folder" in done.stderr
    assert sums(out) == before
    (lab / "short.toml").write_text(SHORT)  # and its own campaign goes on
    assert run(lab / "short.toml", "--out", out).exit_code == 0
    assert {name: sums(out)[name] for name in before} == before


def test_files_of_other_tests_are_not_taken_for_a_campaign(lab: Path) -> None:
    before = sums(lab / "out")
    (lab / "out/journal.sqlite").unlink()
    (lab / "short.toml").write_text(SHORT.replace("4 mm", "5 mm"))
    done = run(lab / "short.toml", "--out", lab / "out")
    assert done.exit_code == 2
    assert "is not of the campaign 'short'" in done.stderr
    assert sums(lab / "out") == before


def test_a_file_that_cannot_be_read_is_told_before_anything_moves(lab: Path) -> None:
    (lab / "out/journal.sqlite").unlink()
    (lab / "out" / f"{FIRST}.h5").write_bytes(b"")
    done = run(lab / "short.toml", "--out", lab / "out")
    assert done.exit_code == 2
    assert "has no journal of its tests, and a file cannot be read" in done.stderr


def test_a_try_that_the_journal_does_not_know_is_not_written_over(lab: Path) -> None:
    out = lab / "out"
    (out / f"{SECOND}.try2.h5").write_bytes((out / f"{SECOND}.h5").read_bytes())
    before = sums(out)
    assert run(lab / "short.toml", "--out", out).exit_code == 0
    after = sums(out)
    assert {name: after[name] for name in before} == before
    assert set(after) - set(before) == {f"{SECOND}.try3.h5"}
    assert [test.attempt for test in read_journal(out)[0]] == [1, 3]


def test_what_a_killed_host_left_of_a_copy_goes_away(lab: Path) -> None:
    out = lab / "out"
    with sqlite3.connect(out / "journal.sqlite") as base:
        base.execute("UPDATE tests SET state = 'running' WHERE name = ?", (SECOND,))
    base.close()
    (out / f".{SECOND}.h5.abcd1234.part").write_bytes(b"half")
    assert run(lab / "short.toml", "--out", out).exit_code == 0
    assert not list(out.glob(".*"))


def test_a_file_with_few_samples_is_listed_as_such(lab: Path) -> None:
    path = lab / "out" / f"{SECOND}.h5"
    with h5py.File(path, "r+") as file:
        for name in ("time", "displacement", "force"):
            values = file[f"calibrated/{name}"][:5]
            del file[f"calibrated/{name}"]
            file[f"calibrated/{name}"] = values
        del file.attrs["sha256"]
    for paths in ((path,), (path, lab / "out" / f"{FIRST}.h5")):
        done = CliRunner().invoke(cli, ["records", *map(str, paths)])
        assert done.exit_code == 0, done.output
        assert f"{SECOND}.h5: holds 5 samples of a test that did not come to its end (the Uno stopped" in done.stdout
        assert (FIRST in done.stdout) == (len(paths) == 2)
    done = CliRunner().invoke(cli, ["records", "--json", str(path)])
    assert len(json.loads(done.stdout)["too_short"]) == 1


def test_a_test_is_recorded_again_by_its_name(lab: Path) -> None:
    out = lab / "out"
    assert run(lab / "short.toml", "--out", out).exit_code == 0
    (out / f"{FIRST}.h5").unlink()
    done = run(lab / "short.toml", "--out", out)
    assert done.exit_code == REFUSED  # nothing has moved
    assert f"{FIRST} (gone); run the same command with --again {FIRST} to record them again" in done.stderr
    assert "1 of 2 tests complete" in done.stdout
    assert f"next: run the same command with --again {FIRST}" in " ".join(done.stdout.split())
    listed = json.loads(run(lab / "short.toml", "--out", out, "--json").stdout)
    assert [test["state"] for test in listed["tests"]] == ["gone", "complete"]
    done = run(lab / "short.toml", "--out", out, "--again", FIRST)
    assert done.exit_code == 0
    assert h5.state(out / f"{FIRST}.try2.h5").complete
    assert "again" not in run(lab / "short.toml", "--out", out).stderr


@pytest.mark.prove
@pytest.mark.parametrize("end", ["2>&1 | head -1", "2>/dev/full", "<&- >&- 2>&-"])
def test_a_campaign_goes_on_whatever_becomes_of_its_streams(tmp_path: Path, end: str) -> None:
    (tmp_path / "short.toml").write_text(SHORT)
    command = f"({sys.executable} -m dampyr run short.toml --out out; echo $? > code) {end}"
    done = subprocess.run(["sh", "-c", command], cwd=tmp_path, check=False, capture_output=True, text=True)
    assert "Traceback" not in done.stderr
    assert (tmp_path / "code").read_text().strip() == "0"
    assert [test.state for test in read_journal(tmp_path / "out")[0]] == ["complete"] * 2
    for path in (tmp_path / "out").glob("*.h5"):
        assert records.read(path).n > 1000


# how a run ends, for scripts


def ended(tmp_path: Path, *more: str, text: str = SHORT) -> tuple[int, str]:
    (tmp_path / "short.toml").write_text(text)
    done = run(tmp_path / "short.toml", "--out", tmp_path / "out", *more)
    return done.exit_code, done.stderr


def test_exit_code_complete(tmp_path: Path) -> None:
    assert ended(tmp_path)[0] == 0


@pytest.mark.parametrize(("fault", "code", "words"), [
    ("unplugged-serial@0s", 2, "does not answer HELLO"),
    ("stalled-motor@4s", 3, "the motor"),
    ("broken-cell@5s", 3, "the interlock stopped the rig"),
    ("board-timeout@5s", 4, "the simulated board gives an error"),
])  # fmt: skip
def test_exit_codes_of_a_rig_that_fails(tmp_path: Path, fault: str, code: int, words: str) -> None:
    exit_code, stderr = ended(tmp_path, "--fault", fault)
    assert exit_code == code
    assert words in stderr


@pytest.mark.usefixtures("terminal_signals")
@pytest.mark.parametrize(("how", "code"), [
    ("stop", 130), (signal.SIGTERM, 143), (OSError(28, "full"), 4),
    pytest.param("abort", 130, marks=pytest.mark.prove), pytest.param(signal.SIGINT, 130, marks=pytest.mark.prove),
    pytest.param(signal.SIGHUP, 129, marks=pytest.mark.prove),
])  # fmt: skip
def test_exit_codes_of_a_run_that_is_ended(
    tmp_path: Path, how: str | int | OSError, code: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    from dampyr.campaigns import RunControl
    from dampyr.campaigns.monitor import Watch

    blocks, check = 0, RunControl.check

    def take(self: Watch, samples: object) -> None:
        nonlocal blocks
        blocks += 1
        if blocks == 5 and isinstance(how, OSError):
            raise how
        if blocks == 5 and isinstance(how, int):
            os.kill(os.getpid(), how)

    def pressed(self: RunControl) -> None:
        if blocks == 5 and isinstance(how, str):
            getattr(self, how)()
        check(self)

    monkeypatch.setattr(Watch, "take", take)
    monkeypatch.setattr(RunControl, "check", pressed)
    exit_code, stderr = ended(tmp_path)
    assert exit_code == code, stderr
    (test, _) = read_journal(tmp_path / "out")[0]
    assert test.state in ("stopped", "failed")
    if code > 130 or code == 129:
        assert f"ended by signal {code - 128}; the rig is at rest" in stderr


# an encoder that both layers read, and that loses counts


@pytest.mark.parametrize(
    "fault",
    [
        "stuck-encoder@4.9s for 120ms",
        pytest.param("stuck-encoder@9.1s for 60ms", marks=pytest.mark.prove),
        pytest.param("slipped-encoder=0.1mm@8s", marks=pytest.mark.prove),
    ],
)
def test_lost_counts_end_no_campaign_complete(tmp_path: Path, fault: str) -> None:
    done = run(EXAMPLES / "quick_campaign.toml", "--out", tmp_path / "out", "--fault", fault)
    assert done.exit_code == 3, done.output
    assert "nothing moved" in done.stderr or "index" in done.stderr
    for test in read_journal(tmp_path / "out")[0]:
        if test.state != "complete":
            continue
        # what is complete was complete before, and its strokes are those that were planned
        record = records.read(tmp_path / "out" / f"{test.name}.h5")
        assert abs(record.displacement).max() < 0.0085


def test_a_check_that_is_left_out_is_told_in_the_plan_the_run_and_the_record(tmp_path: Path) -> None:
    words = "whether the load cell's sign is right and the encoder's scale is"
    (tmp_path / "short.toml").write_text(SHORT.replace('"0 V", "0.8712 V"', '"0 V"'))
    assert words in run(tmp_path / "short.toml", "--dry-run").stdout.replace("\n", " ")
    done = run(tmp_path / "short.toml", "--out", tmp_path / "out")
    assert (done.exit_code, words in done.stderr) == (0, True)
    (record,) = records.read_campaign(tmp_path / "out")
    assert words in record.provenance["preliminary_check"]
    (tmp_path / "short.toml").write_text(
        SHORT.replace('"0 V", "0.8712 V"', '"0 V"').replace("check_amplitude = 0.0", "check_amplitude = 0.001")
    )
    done = run(tmp_path / "short.toml", "--out", tmp_path / "checked")
    assert (done.exit_code, words in done.stderr) == (0, False)
    (record,) = records.read_campaign(tmp_path / "checked")
    assert record.provenance["preliminary_check"] == "passed"


@pytest.mark.parametrize("wired", [False, True])
def test_a_run_says_where_the_coil_s_voltage_is_commanded_and_not_measured(tmp_path: Path, wired: bool) -> None:
    """A supply that dies ends nothing where nothing reads it."""
    (tmp_path / "rig.toml").write_text(
        '[wires]\ncoil_voltage = "ai2"\ncoil_current = "ai3"\n' if wired else "", "utf-8"
    )
    (tmp_path / "one.toml").write_text(
        'check_amplitude = "0 mm"\n[[step]]\nkind = "sine"\namplitude = "5 mm"\nfrequency = "2 Hz"\nvoltage = "1 V"\n'
        'cycles = 2\nrest_before = "0.2 s"\n',
        "utf-8",
    )
    words = ["run", str(tmp_path / "one.toml"), "--rig", str(tmp_path / "rig.toml"), "--out", str(tmp_path / "out")]
    ran = CliRunner().invoke(cli, [*words, *([] if wired else ["--fault", "dead-supply@0.5s"])])
    assert ran.exit_code == 0, ran.output
    said = " ".join(ran.output.split())
    assert ("the coil's voltage in all records is commanded, not measured" in said) == (not wired)
    (record,) = records.read_campaign(tmp_path / "out")
    assert ("it is commanded, not measured" in record.provenance["voltage"]) == (not wired)


def test_several_specimens_are_run_in_turn_each_after_it_was_mounted(tmp_path, monkeypatch):
    """The second was not mounted: the first stays complete, and the same command goes on with the second."""
    performed = []

    def perform(plan, rig, out, again, as_json, how):
        performed.append((plan.campaign.header.specimen, out.name))
        return 0

    monkeypatch.setattr("dampyr.cli.run._perform", perform)
    words = ["run", str(EXAMPLES / "quick_campaign.toml"), "--out", str(tmp_path), "--specimens", "SN 1,SN2"]
    first = CliRunner().invoke(cli, words, input="\n")
    assert first.exit_code == 130
    assert "Mount SN2" in first.stderr
    assert "SN2 was not mounted" in first.stderr
    assert performed == [("SN 1", "SN_1")]
    done = {"SN_1": "complete"}
    monkeypatch.setattr(
        "dampyr.campaigns.run_folders.folder_state", lambda plan, folder: (done.get(folder.name, "new"), "")
    )
    second = CliRunner().invoke(cli, words, input="\n")
    assert second.exit_code == 0
    assert "Mount SN 1" not in second.stderr
    assert performed == [("SN 1", "SN_1"), ("SN2", "SN2")]


@pytest.mark.parametrize("names", ["SN1,SN1", "SN1,,SN2", "a/b,a_b", ".."])
def test_specimens_without_folders_of_their_own_are_refused(names, tmp_path):
    refused = run(EXAMPLES / "quick_campaign.toml", "--out", tmp_path / "out", "--specimens", names)
    assert refused.exit_code == 2
    assert "specimens = " in refused.stderr
    assert not (tmp_path / "out").exists()


def test_a_specimen_that_fails_ends_the_queue(tmp_path, monkeypatch):
    monkeypatch.setattr("dampyr.cli.run._perform", lambda *_: 3)
    words = ["run", str(EXAMPLES / "quick_campaign.toml"), "--out", str(tmp_path), "--specimens", "SN1,SN2"]
    ended = CliRunner().invoke(cli, words, input="\n\n")
    assert ended.exit_code == 3
    assert "Mount SN2" not in ended.stderr


@pytest.mark.prove
def test_a_protocol_that_has_come_to_its_end_says_so_and_proposes_its_figures(tmp_path):
    (tmp_path / "rig.toml").write_text("[specimen]\nsoftening = 0.01\n")
    (tmp_path / "endurance.toml").write_text(
        'rest_between = "0.2 s"\ncheck_amplitude = "0 mm"\n[protocol]\nkind = "endurance"\namplitude = "5 mm"\n'
        'frequency = "1 Hz"\nvoltage = "1 V"\ncycles = 12\nblock_cycles = 4\nstop_decay = "10 %"\n'
    )
    words = (tmp_path / "endurance.toml", "--rig", tmp_path / "rig.toml", "--out", tmp_path / "out")
    done = run(*words, "--fault", "hot-specimen=25@22s")
    assert done.exit_code == FAILED, done.output
    assert "the protocol ends here: the force has decayed by" in done.stderr
    assert f"next: dampyr protocol {tmp_path / 'out'}" in done.stdout
    again = run(*words)
    assert again.exit_code == FAILED
    judged = CliRunner().invoke(cli, ["protocol", str(tmp_path / "out")])
    assert judged.exit_code == 1
    assert "decay <= 10 %" in judged.output


def test_what_follows_a_campaign_is_what_it_was_run_for(tmp_path):
    speeds = {"kind": "peak_velocity", "stroke": "20 mm", "speeds": ["50 mm/s"]}
    slow = {"kind": "ntc_2018_quasi_static", "design_displacement": "5 mm"}
    for document, words in (
        ({"step": [{"kind": "sine", "amplitude": "5 mm", "frequency": "1 Hz"}]}, "identify lab"),
        ({"protocol": speeds}, "protocol lab"),
        ({"protocol": slow}, "judge lab --criteria NAME"),
    ):
        assert next_command(campaign_of(document), Path("lab")) == f"dampyr {words}"
