"""What the plan of a campaign and its tests show."""

from __future__ import annotations

from typing import Any

from dampyr.campaigns.planned_tests import Plan, PlannedTest
from dampyr.phrases import counted, sentence
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.rig.drive import describe_drive
from dampyr.show.table import Cell, Table


@describe.register
def describe_planned_test(test: PlannedTest) -> Description:
    """What it does, its duration, peaks and force, notes and refusal; the set points that the rig is to follow."""
    force = "not known" if test.peak_force is None else f"{test.peak_force:.4g} N"
    rows = [
        ("does", test.words),
        ("duration", f"{test.duration:.4g} s"),
        (
            "peaks",
            f"{1e3 * test.peak_position:.4g} mm, {1e3 * test.peak_speed:.4g} mm/s, {test.peak_voltage:.4g} V",
        ),
        ("force", force + ("" if test.energy is None else f" expected, {test.energy:.4g} J")),
    ]
    rows += [("note", note) for note in test.notes[:3]]
    if test.refusal:
        rows.append(("refused", test.refusal))
    return Description(f"PlannedTest {test.name!r}", rows, figure=describe_drive(test.drive).figure)


@describe.register
def describe_plan(plan: Plan) -> Description:
    """Rig, duration, expected force, damper and what is refused; the tests in a table."""
    forces = [test.peak_force for test in plan.tests if test.peak_force is not None]
    rows = [
        ("rig", plan.rig.name),
        ("tests", f"{len(plan.tests)}, {plan.duration:.4g} s with the rests and slow ways between them"),
        ("force", f"up to {max(forces):.4g} N expected" if forces else "not known"),
        (
            "damper",
            "not known: a conservative envelope stands for it" if plan.damper is None else str(plan.damper.composition),
        ),
        ("refused", f"{counted(len(plan.refusals), 'refusal')}: {plan.refusals[0]}" if plan.refusals else "nothing"),
    ]
    return Description(
        f"Plan of {plan.campaign.header.name!r}",
        rows,
        verdict=plan_notes(plan),
        tables=[lambda: plan_table(plan)],
        data=lambda: _numbers(plan),
        frame=lambda: _columns(plan),
    )


def plan_table(plan: Plan) -> Table:
    """What each test asks of the rig, in the order in which they run, and which are refused (the plan's refusals say why)."""
    refused = any(test.refusal for test in plan.tests)
    rows: list[list[Cell]] = [
        [test.name, test.words, test.duration, 1e3 * test.peak_speed, 1e3 * test.peak_position, test.peak_force,
         test.peak_voltage, *["yes" if test.refusal else ""] * refused]
        for test in plan.tests
    ]  # fmt: skip
    minutes = f"{plan.duration / 60:.1f} min" if plan.duration >= 60 else f"{plan.duration:.0f} s"
    return Table(
        ("test", "what", "duration", "peak speed", "position", "force", "coil", *["refused"] * refused),
        rows,
        ("", "", "s", "mm/s", "mm", "N", "V", *[""] * refused),
        caption=f"{plan.campaign.header.name}: {len(plan.tests)} tests on {plan.rig.name}, {minutes}.",
        digits=4,
    )


def plan_notes(plan: Plan) -> list[str]:
    """What the expected force rests on, and what the plan says of single tests, in sentences."""
    of_tests = dict.fromkeys(f"{test.name}: {note}" for test in plan.tests for note in test.notes)
    return [sentence(note) for note in (*plan.notes, *of_tests)]


def _numbers(plan: Plan) -> dict[str, Any]:
    """What each test asks of the rig for JSON, SI units."""
    return {
        "campaign": plan.campaign.header,
        "rig": plan.rig.name,
        "duration_s": plan.duration,
        "tests": [
            {
                "name": test.name, "kind": test.kind, "step": test.step, "duration_s": test.duration,
                "peak_speed_m_s": test.peak_speed, "peak_position_m": test.peak_position,
                "peak_force_N": test.peak_force, "peak_voltage_V": test.peak_voltage,
                "energy_J": test.energy,
                "notes": test.notes, "refusal": test.refusal,
            }
            for test in plan.tests
        ],
        "notes": plan.notes,
        "refusals": plan.refusals,
    }  # fmt: skip


def _columns(plan: Plan) -> DataFrameColumns:
    """The tests in SI units: what each asks of the rig, and why it is refused."""
    names = {
        "kind": "kind", "words": "words", "duration": "duration_s", "peak_position": "peak_position_m",
        "peak_speed": "peak_speed_m_per_s", "peak_voltage": "peak_voltage_V", "peak_force": "peak_force_N",
        "energy": "energy_J", "refusal": "refusal",
    }  # fmt: skip
    columns = {head: [getattr(test, name) for test in plan.tests] for name, head in names.items()}
    return DataFrameColumns(columns, [test.name for test in plan.tests], "test")
