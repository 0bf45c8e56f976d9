"""The reference of a run: compared live, and a report at its end."""

import os
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from tests.console.bench_runs import Phase, Until, records_of, start
from tests.endurance import REPOSITORY
from tests.rig_time import HANG, RealTime
from tests.short_campaign import FIRST, SECOND

from dampyr.campaigns.journal import Journal
from dampyr.campaigns.run_control import Progress
from dampyr.console import run_reference
from dampyr.console.bench_session import Bench
from dampyr.console.pages.campaigns import EXAMPLE
from dampyr.console.run_reference import RunReference
from dampyr.console.run_report import ACCEPTANCE, CYCLES, PROTOCOL, RunReport, report_of
from dampyr.errors import InputError
from dampyr.identification import accept
from dampyr.records import Record, read_campaign
from dampyr.rig.interlock import Samples


@pytest.mark.prove
def test_cycles_are_compared_with_a_reference_and_a_report_is_written(armed: Bench, until: Until, phase: Phase) -> None:
    start(armed, "one")
    phase(armed, "campaign")
    phase(armed, "idle")
    start(armed, "two", reference="one")
    until(lambda: (comparison := armed.state().comparison) is not None and comparison.passed > 0, 60.0)
    assert armed.runs.reference is not None
    assert armed.runs.reference.loop is not None
    assert np.ptp(armed.runs.reference.loop.x) == pytest.approx(8.0, rel=0.05)
    phase(armed, "idle")
    comparison = armed.state().comparison
    assert comparison is not None
    assert comparison.failed == 0
    accepted = accept(read_campaign(records_of(armed, "two")), read_campaign(records_of(armed, "one")))
    [judged] = [result for result in accepted.results if result.record == SECOND]
    assert comparison.test == SECOND
    for cycle in comparison.cycles:
        extension, compression, energy = [p.deviation for p in judged.points if p.cycle == cycle.number]
        assert cycle.energy == pytest.approx(energy, abs=1e-3)
        assert cycle.extension == pytest.approx(extension, abs=0.03)  # its zero is the mean over three cycles
        assert cycle.extension + cycle.compression == pytest.approx(extension + compression, abs=1e-3)
    # by the wall clock: a simulated rig that is read as fast as it can be would leave the report's process nothing
    RealTime().until(lambda: (run := armed.state().run) is not None and run.report_state != "writing", HANG)
    run = armed.state().run
    assert run is not None
    assert (run.report, run.report_state) == (ACCEPTANCE, "")
    assert "<html" in (records_of(armed, "two") / ACCEPTANCE).read_text()


def shown(name: str, samples: object = None, phase: str = "testing") -> Progress:
    return Progress(0, 1, name, phase, samples=samples)  # type: ignore[arg-type]


def sine_samples(force: float) -> tuple[Record, list[Samples]]:
    """Four cycles of 10 mm between rests, as a record and in two blocks as they come from a rig; a force in phase with the
    velocity."""
    time = np.arange(0.0, 8.0, 2e-3)
    grow = np.clip(time - 1.0, 0.0, 1.0) * np.clip(7.0 - time, 0.0, 1.0)
    x = 0.01 * grow * np.sin(2.0 * np.pi * time)
    values = force * np.tanh(np.gradient(x, time) / 1e-2)
    none, volts = np.zeros((1, 2000)), np.zeros(2000)
    blocks = [
        Samples(
            k, time[k : k + 2000], x[k : k + 2000], values[k : k + 2000], None, none, none[0].astype(int), volts, None
        )  # type: ignore[arg-type]
        for k in (0, 2000)
    ]
    return Record(time, x, values, voltage=0.0, name=FIRST), blocks


def test_cycles_are_counted_once_the_reference_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A force that is a fifth stronger passes within 25 % and fails within 15 %, and what came before the reference was read is
    judged too; a further try of the test begins anew."""
    record, _ = sine_samples(500.0)
    monkeypatch.setattr(run_reference, "read_campaign", lambda folder, role: [record])
    _, stronger = sine_samples(600.0)
    for tolerance, passes in ((0.25, True), (0.15, False)):
        reference = RunReference(tmp_path, tolerance)
        reference.take(shown(FIRST))
        assert reference.comparison.test == ""  # nothing has come yet
        reference.take(shown(FIRST, stronger[0]))
        RealTime().until(lambda ref=reference: ref.loop is not None)
        assert np.ptp(reference.loop.x) == pytest.approx(20.0, rel=0.02)
        reference.take(shown(FIRST, stronger[1]))
        comparison = reference.comparison
        assert comparison.passed + comparison.failed > 2
        assert comparison.cycles[0].number == 2
        assert (comparison.failed == 0) is passes
        assert (comparison.passed == 0) is not passes
        assert reference.comparison.reason == ""
        reference.take(shown(FIRST, phase="rest"))
        assert reference.comparison == comparison
        reference.take(shown(FIRST, stronger[0]))
        assert reference.comparison.passed + reference.comparison.failed < comparison.passed + comparison.failed


def test_a_test_that_the_reference_lacks_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    record, samples = sine_samples(500.0)
    monkeypatch.setattr(run_reference, "read_campaign", lambda folder, role: [record])
    reference = RunReference(tmp_path, 0.15)
    reference.take(shown(FIRST, phase="homing"))
    RealTime().until(lambda: reference._run is not None)
    reference.take(shown(SECOND, samples[0]))
    assert f"no complete test '{SECOND}'" in reference.comparison.reason
    assert (reference.loop, reference.comparison.passed, reference.comparison.failed) == (None, 0, 0)


def test_a_reference_that_cannot_be_read_is_told(tmp_path: Path) -> None:
    reference = RunReference(tmp_path, 0.15)
    _, samples = sine_samples(500.0)
    reference.take(shown(SECOND, samples[0]))
    RealTime().until(lambda: reference.comparison.reason != "its reference is being read")
    assert "the folder has no records" in reference.comparison.reason
    assert (reference.loop, reference.comparison.passed, reference.comparison.failed) == (None, 0, 0)


def test_a_report_is_written_when_it_is_asked_for_and_again_after_newer_records(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = []

    def write(report: RunReport) -> str:
        if report.path.name == PROTOCOL:
            return "no report: it has no figures of its own"
        written.append(report.words)
        report.path.write_text("<html>")
        return ""

    monkeypatch.setattr(RunReport, "write", write)
    with closing(Journal(tmp_path)) as journal:
        journal.set_metadata({"source": "[protocol]\nkind = 'stiffness'\n"})
    record = tmp_path / "one.h5"
    record.touch()
    os.utime(record, (1e9, 1e9))
    for _ in range(2):
        assert report_of(tmp_path).name == CYCLES  # where a protocol has no figures of its own
    assert written == [("cycles", str(tmp_path))]
    os.utime(record, (4e9, 4e9))  # a test was repeated
    report_of(tmp_path)
    assert len(written) == 2
    monkeypatch.setattr(RunReport, "write", lambda report: "no report: there is no record")
    with pytest.raises(InputError, match="there is no record"):
        report_of(tmp_path)


def test_the_example_of_the_console_is_that_of_the_examples() -> None:
    assert EXAMPLE.read_text("utf-8") == (REPOSITORY / "examples" / "quick_campaign.toml").read_text("utf-8")
