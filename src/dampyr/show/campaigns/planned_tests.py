"""What the plan of a campaign and its tests show."""

from __future__ import annotations

from dampyr.campaigns.planned_tests import Plan, PlannedTest
from dampyr.phrases import counted
from dampyr.show.descriptions import Description, Frame, describe
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
    forces = [each.peak_force for each in plan.tests if each.peak_force is not None]
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
        f"Plan of {plan.campaign.header.name!r}", rows, tables=[lambda: _table(plan)], frame=lambda: _columns(plan)
    )


def _table(plan: Plan) -> Table:
    """The tests with what they ask of the rig."""
    rows: list[list[Cell]] = [
        [t.name, t.words, t.duration, 1e3 * t.peak_position, 1e3 * t.peak_speed, t.peak_voltage, t.peak_force,
         t.refusal]
        for t in plan.tests
    ]  # fmt: skip
    heads = ("test", "what it does", "time", "position", "speed", "voltage", "force", "refused")
    return Table(heads, rows, ("", "", "s", "mm", "mm/s", "V", "N", ""))


def _columns(plan: Plan) -> Frame:
    """The tests in SI units: what each asks of the rig, and why it is refused."""
    names = {
        "kind": "kind", "words": "words", "duration": "duration_s", "peak_position": "peak_position_m",
        "peak_speed": "peak_speed_m_per_s", "peak_voltage": "peak_voltage_V", "peak_force": "peak_force_N",
        "energy": "energy_J", "refusal": "refusal",
    }  # fmt: skip
    columns = {head: [getattr(each, name) for each in plan.tests] for name, head in names.items()}
    return Frame(columns, [each.name for each in plan.tests], "test")
