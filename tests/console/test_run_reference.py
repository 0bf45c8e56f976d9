"""The reference of a run: compared live, and a report at its end."""

from pathlib import Path

import numpy as np
import pytest
from tests.console.bench_runs import Phase, Until, records_of, start
from tests.rig_time import HANG, RealTime
from tests.short_campaign import FIRST, SECOND

from dampyr.campaigns.run_control import Progress
from dampyr.console import run_reference
from dampyr.console.bench_reference import of_record
from dampyr.console.bench_session import Bench
from dampyr.console.run_reference import REPORT, RunReference
from dampyr.records import Record
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
    # by the wall clock: a simulated rig that is read as fast as it can be would leave the report's process nothing
    RealTime().until(lambda: (run := armed.state().run) is not None and run.report_state != "writing", HANG)
    run = armed.state().run
    assert run is not None
    assert (run.report, run.report_state) == (REPORT, "")
    assert "<html" in (records_of(armed, "two") / REPORT).read_text()


def shown(name: str, samples: object = None) -> Progress:
    return Progress(0, 1, name, "testing", samples=samples)  # type: ignore[arg-type]


def sine_samples(force: float) -> tuple[Record, Samples]:
    """Four cycles of 10 mm between rests, as a record and as they come from a rig; a force in phase with the velocity."""
    time = np.arange(0.0, 6.0, 2e-3)
    grow = np.clip(time, 0.0, 1.0) * np.clip(6.0 - time, 0.0, 1.0)
    x = 0.01 * grow * np.sin(2.0 * np.pi * time)
    values = force * np.tanh(np.gradient(x, time) / 1e-2)
    none = np.zeros((1, len(time)))
    samples = Samples(0, time, x, values, None, none, none[0].astype(int), none[0], None)  # type: ignore[arg-type]
    return Record(time, x, values, voltage=0.0, name=FIRST), samples


def test_cycles_are_counted_once_the_reference_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A force that is a fifth stronger passes within 25 % and fails within 15 %; what comes before the file is read is left."""
    record, _ = sine_samples(500.0)
    monkeypatch.setattr(run_reference, "reference_test", lambda folder, test: of_record(record, test))
    _, stronger = sine_samples(600.0)
    for tolerance, passes in ((0.25, True), (0.15, False)):
        reference = RunReference(tmp_path, tolerance)
        reference.take(shown(FIRST))
        assert reference.comparison.test == ""  # nothing has come yet
        reference.take(shown(FIRST, stronger))
        RealTime().until(lambda ref=reference: ref.loop is not None)
        assert np.ptp(reference.loop.x) == pytest.approx(20.0, rel=0.02)
        reference.take(shown(FIRST, stronger))
        comparison = reference.comparison
        assert comparison.passed + comparison.failed > 2
        assert (comparison.failed == 0) is passes
        assert (comparison.passed == 0) is not passes
        assert reference.comparison.reason == ""


def test_a_test_that_the_reference_lacks_is_told(tmp_path: Path) -> None:
    reference = RunReference(tmp_path, 0.15)
    _, samples = sine_samples(500.0)
    reference.take(shown(SECOND, samples))
    RealTime().until(lambda: reference.comparison.reason != "its reference is being read")
    assert "journal" in reference.comparison.reason
    assert (reference.loop, reference.comparison.passed, reference.comparison.failed) == (None, 0, 0)
