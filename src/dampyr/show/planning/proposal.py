"""What a proposal of tests and its tests show."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from dampyr.findings import as_dicts
from dampyr.phrases import counted, sentence
from dampyr.planning.proposal import Proposal, ProposedTest, half_in_percent
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures.planned_tests import planned_tests
from dampyr.show.table import Cell, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@describe.register
def describe_proposed_test(test: ProposedTest) -> Description:
    """Its duration, and which intervals would be wider without it."""
    rows = [("duration", f"{test.candidate.duration:.4g} s"), ("for" if test.reason else "wider without it", test.why)]
    return Description(f"ProposedTest {test.candidate.words!r}", rows)


@describe.register
def describe_proposal(proposal: Proposal) -> Description:
    """Goal, tests, model and expected intervals; candidates and chosen tests against the limits of the rig."""
    minutes = proposal.duration / 60
    rows = [
        ("goal", proposal.goal),
        (
            "tests",
            f"{len(proposal.tests)} of {len(proposal.envelope.candidates)} candidates, {minutes:.3g} min without rests",
        ),
        ("model", proposal.model),
        *[
            (label, f"{half_in_percent(proposal.before.get(label))} -> {half_in_percent(half)}")
            for label, half in proposal.after.items()
            if np.isfinite(half)
        ],
    ]
    if proposal.peak_after is not None:
        rows.append(("peak", f"{half_in_percent(proposal.peak_before)} -> {half_in_percent(proposal.peak_after)}"))
    reached = ["With these tests the targets are expected to be met."] if proposal.reached else []
    return Description(
        f"Proposal of {counted(len(proposal.tests), 'test')}",
        [*rows, *(("note", note) for note in proposal.notes)],
        verdict=[*map(sentence, proposal.notes), *reached],
        tables=[lambda: proposed_tests(proposal), lambda: interval_table(proposal)],
        figure=lambda: envelope_figure(proposal),
        data=lambda: _numbers(proposal),
        frame=lambda: _columns(proposal),
    )


def envelope_figure(proposal: Proposal) -> Figure:
    """Amplitude against frequency: the limits of a sine at each voltage, the candidates and what was chosen."""
    candidates = [(c.frequency, c.amplitude) for c in proposal.envelope.candidates]
    chosen: dict[str, list[tuple[float, float]]] = {}
    for test in proposal.tests:
        chosen.setdefault(test.candidate.kind.replace("_", " "), []).append(
            (test.candidate.frequency, test.candidate.amplitude)
        )
    has_input = all(candidate.has_input for candidate in proposal.envelope.candidates)
    limits = {
        f"{u:.4g} V" if has_input else "largest sine": amplitudes for u, amplitudes in proposal.envelope.limits.items()
    }
    return planned_tests(proposal.envelope.frequencies, limits, candidates, chosen)


def proposed_tests(proposal: Proposal) -> Table:
    """The tests, and what each is good for."""
    rows: list[list[Cell]] = [
        [k, test.candidate.words, test.candidate.duration, test.why] for k, test in enumerate(proposal.tests, start=1)
    ]
    return Table(
        ("", "test", "time", "why: the intervals that would be wider without it"),
        rows,
        ("", "", "s", ""),
        caption=f"{counted(len(rows), 'test')} for {proposal.goal}, of {len(proposal.envelope.candidates)} that "
        f"{proposal.rig.name} can do; {proposal.duration / 60:.1f} min without rests.",
        digits=4,
    )


def interval_table(proposal: Proposal) -> Table:
    """Half widths of the intervals now and as expected after the tests, one row a coefficient, and the peak's."""
    rows: list[list[Cell]] = [
        [label, half_width(proposal.before.get(label)), half_width(half)] for label, half in proposal.after.items()
    ]
    if proposal.peak_after is not None:
        rows.append([proposal.goal, half_width(proposal.peak_before), half_width(proposal.peak_after)])
    return Table(
        ("coefficient", "now", "expected"),
        rows,
        caption=f"95 % intervals over the values, model {proposal.model}.",
    )


def half_width(half: float | None) -> str | None:
    """A half width over its value in words; None where there is no interval."""
    if half is None or not 0.0 <= half < math.inf:
        return None
    return f"± {100 * half:.0f} %" if half >= 1.0 else f"± {100 * half:.2g} %"


def _columns(proposal: Proposal) -> DataFrameColumns:
    """The tests: what each does, its duration and what it is good for."""
    tests = proposal.tests
    columns = {
        "test": [test.candidate.words for test in tests],
        "time [s]": [test.candidate.duration for test in tests],
        "without it wider": [test.why for test in tests],
    }
    return DataFrameColumns(columns)


def _numbers(proposal: Proposal) -> dict[str, Any]:
    """Tests and intervals by name, for `dampyr.to_json`, SI units."""
    return {
        "damper_origin": proposal.origin.as_dict(),
        "findings": as_dicts(proposal.findings),
        "goal": proposal.goal,
        "model": proposal.model,
        "rig": proposal.rig.name,
        "tests": [
            {
                "kind": test.candidate.kind,
                "words": test.candidate.words,
                "step": test.candidate.table,
                "duration_s": test.candidate.duration,
                "frequency_Hz": test.candidate.frequency,
                "amplitude_m": test.candidate.amplitude,
                "wider_without": dict(test.improves),
                "reason": test.reason,
            }
            for test in proposal.tests
        ],
        "candidates": len(proposal.envelope.candidates),
        "duration_s": proposal.duration,
        "values": dict(proposal.values),
        "half_width_before": dict(proposal.before),
        "half_width_after": dict(proposal.after),
        "peak": proposal.peak,
        "peak_half_width_before": proposal.peak_before,
        "peak_half_width_after": proposal.peak_after,
        "reached": proposal.reached,
        "notes": proposal.notes,
    }
