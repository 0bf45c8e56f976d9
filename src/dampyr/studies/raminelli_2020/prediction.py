"""The two published errors, 14.81 % and 21.71 %, by every definition the text allows; and one joint model beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.identification import compare, prediction, score
from dampyr.models import Damper
from dampyr.records import Record, default_bandwidth, with_velocity
from dampyr.report import Cell, FigureBlock, Table, Text, Verdict, scores
from dampyr.studies.raminelli_2020.campaign import Campaign, Test
from dampyr.studies.raminelli_2020.cubics import published_damper
from dampyr.studies.raminelli_2020.finding import Finding, Tolerance, judge, unchecked
from dampyr.studies.raminelli_2020.part import Part, findings_table
from dampyr.studies.raminelli_2020.published import PARAMETERS, TABLES, TO_SI, Published, Row
from dampyr.studies.raminelli_2020.tables import FETCH

Array = NDArray[np.float64]
POINT = Tolerance(absolute=0.5)
TITLE = "The published errors, and what a joint model gives"
DEFINITIONS = (
    "L1 (3.1), offset removed, from 2 s after the motion starts",
    "L1 (3.1), offset removed, whole record",
    "L1 (3.1), offset left in both places, whole record",
    "pointwise mean of |error| / |force|, recorded velocity",
    "pointwise mean of |error| / |force|, smoothed velocity",
    "pointwise mean of |error| / |force|, offset left in, recorded velocity",
)


@dataclass(frozen=True)
class Errors:
    """The errors of one record under one damper, in %, by `DEFINITIONS`."""

    percent: tuple[float, ...]

    @classmethod
    def of(cls, damper: Damper, record: Record) -> Errors:
        """All definitions."""
        force = prediction(damper, record)
        late, whole = compare(record, force), compare(record, force, window=(float(record.time[0]), float(record.time[-1])))
        smooth = with_velocity(record, default_bandwidth(record))
        return cls(
            tuple(
                100.0 * value
                for value in (
                    late.l1,
                    whole.l1,
                    float(np.sum(np.abs(force - record.force)) / np.sum(np.abs(record.force))),
                    late.pointwise,
                    score(damper, smooth).pointwise,
                    _raw_pointwise(record.force, force),
                )
            )
        )


def _raw_pointwise(measured: Array, model: Array) -> float:
    seen = np.abs(measured) > 0.01 * np.abs(measured).max()
    return float(np.mean(np.abs(model - measured)[seen] / np.abs(measured)[seen]))


def errors(published: Published, campaign: Campaign | None) -> Part:
    """Both errors; without the data nothing can be said."""
    if campaign is None or not campaign.tests:
        missing = f"the campaign's files are not on this machine; get them with {FETCH}"
        found = [
            unchecked("14.81 %", "mean error at 0 V, section 4.2", published.error_at_0, "%", missing),
            unchecked("21.71 %", "error of (4.6)-(4.8), section 4.4", published.error_validation, "%", missing),
        ]
        return Part(TITLE, found, [findings_table(found)])
    at_0, block_0 = error_at_0(published, campaign)
    at_validation, block_validation = error_of_validation(published, campaign)
    findings = [*at_0, *at_validation]
    return Part(TITLE, findings, [block_0, block_validation, findings_table(findings, digits=4), *joint_model(published, campaign)])


def constant_damper(values: Mapping[str, float], voltage: float) -> Damper:
    """A viscous Dahl damper of printed coefficients, at one voltage."""
    from dampyr.models import Constant

    return Damper("dahl", {f"dahl.{k}": Constant(TO_SI[k] * float(v), voltage, voltage) for k, v in values.items()})


def row_damper(row: Row) -> Damper:
    """The damper of one printed row."""
    return constant_damper({name: getattr(row, name) for name in PARAMETERS}, row.voltage)


def error_at_0(published: Published, campaign: Campaign) -> tuple[list[Finding], Table]:
    """14.81 %: the mean coefficients of Table 4.1, and each row's own, on the files of Table 4.2."""
    pairs = [(row, test) for row in published.table("4.2") if (test := campaign.test("4.2", row.row)) is not None]
    if not pairs:
        lost = unchecked("14.81 %", "mean error at 0 V", published.error_at_0, "%", "no file of Table 4.2 is in the folder")
        return [lost], _definitions({}, "")
    mean = constant_damper({name: published.table_4_1[name][0] for name in PARAMETERS}, pairs[0][0].voltage)
    with_means = np.array([Errors.of(mean, test.record).percent for _, test in pairs])
    with_rows = np.array([Errors.of(row_damper(row), test.record).percent for row, test in pairs])
    columns = {"coefficients of Table 4.1": with_means, "each row's own": with_rows}
    named = [float(column.mean()) for block in columns.values() for column in block.T]
    finding = judge(
        "14.81 %",
        f"mean of L1 (3.1) over the {len(pairs)} files at 0 V, coefficients of Table 4.1",
        published.error_at_0,
        float(with_means[:, 0].mean()),
        "%",
        POINT,
        otherwise=_why(float(published.error_at_0), named, with_means[:, 0], len(pairs)),
    )
    return [finding], _definitions(columns, f"The error at 0 V, mean over {len(pairs)} files; printed: {published.error_at_0.text} %.")


def _why(printed: float, named: Sequence[float], single: Array, n: int) -> str:
    low, high = min(named), max(named)
    text = (
        f"the text names neither the runs nor how the offset was treated. Over {len(named)} readings of the definition and coefficients the "
        f"mean over all {n} files runs from {low:.3g} to {high:.3g} %, and the printed value lies {'inside' if low <= printed <= high else 'outside'}"
    )
    near = [value for value in named if POINT.allows(printed, value)]
    text += f"; {len(near)} of them come within {POINT.absolute:g} points" if near else "; none comes within half a point"
    if single.size >= 3:
        worst = float(np.sort(single)[-3:].mean())
        text += f". A mean over three files only could reach {worst:.3g} %: which runs were averaged is not in this folder"
    return text


def error_of_validation(published: Published, campaign: Campaign) -> tuple[list[Finding], Table]:
    """21.71 %: the cubics on the validation run and on the files of Table 4.3."""
    damper, printed = published_damper(published), published.error_validation
    columns: dict[str, Array] = {}
    for name, tests in (("the validation run", campaign.validation), ("files of Table 4.3", campaign.table("4.3"))):
        if tests:
            columns[name] = np.array([Errors.of(damper, test.record).percent for test in tests])
    runs = ", ".join(test.record.name for test in campaign.validation) or "none"
    findings = [
        unchecked(
            "21.71 %",
            "mean error over the validation runs",
            printed,
            "%",
            f"the text does not say which runs; validation runs in this folder: {runs}. The other runs would be needed",
        )
    ]
    for name, block in columns.items():
        pointwise = block[:, 3:5].mean(axis=0)
        low, high = float(pointwise.min()), float(pointwise.max())
        near = POINT.allows(float(printed), low) or POINT.allows(float(printed), high) or low <= printed <= high
        why = (
            f"by L1 it is another number; the pointwise mean relative error is {low:.3g} to {high:.3g} % with the velocity smoothed or as recorded, "
            f"which {'takes in' if near else 'does not take in'} the printed value"
            + (": the printed error was probably a pointwise mean, not (3.1)" if near else "")
        )
        quantity = f"L1 (3.1) of the cubics, {name}"
        findings.append(judge("21.71 %", quantity, printed, float(block[:, 0].mean()), "%", POINT, otherwise=why))
    return findings, _definitions(columns, f"The error of (4.6)-(4.8) at 0.8712 V; printed: {printed.text} %.")


def _definitions(columns: Mapping[str, Array], caption: str) -> Table:
    rows: list[list[Cell]] = [
        [words, *(float(block[:, k].mean()) for block in columns.values())] for k, words in enumerate(DEFINITIONS)
    ]
    return Table(["definition", *columns], rows, ["", *["%"] * len(columns)], caption=caption, digits=3)


def joint_model(published: Published, campaign: Campaign) -> list[FigureBlock | Table | Text | Verdict]:
    """L1 by table: least squares per record, the cubics, and one model for all voltages."""
    joint, cubics = campaign.joint, published_damper(published)
    if joint is None or joint.damper is None:
        return [Text("No joint model: " + (joint.reason if joint else "the folder holds records at one voltage only") + ".")]
    groups = {f"{published.voltage(t):g} V": campaign.table(t) for t in TABLES if campaign.table(t)}
    groups |= {"validation run": campaign.validation} if campaign.validation else {}
    single = {name: [l1 for test in tests if (l1 := _own(test)) is not None] for name, tests in groups.items()}
    by_cubics = {name: [score(cubics, t.record).l1 for t in tests] for name, tests in groups.items()}
    by_joint = {name: [score(joint.damper, t.record).l1 for t in tests] for name, tests in groups.items()}
    columns = (single, by_cubics, by_joint)
    rows: list[list[Cell]] = [
        [name, len(tests), *(100 * float(np.mean(c[name])) if c[name] else None for c in columns)] for name, tests in groups.items()
    ]
    heads = ("records", "files", "Dahl, each record alone", "published cubics", "one joint model")
    references = {"published cubics": {name: float(np.mean(values)) for name, values in by_cubics.items()}}
    converged = "converged" if joint.converged else f"not converged: {joint.reason}"
    return [
        Text(
            "One model for all voltages, fitted to all records of the tables together: Dahl, a rounded friction force, a spring and a delay, every "
            f"parameter a law of the voltage ({converged}). The validation run was not fitted; the other rows say how well a model describes what "
            "it was fitted to."
        ),
        Table(heads, rows, ("", "", "%", "%", "%"), caption="Mean L1 (3.1), offset removed, from 2 s after the motion starts.", digits=3),
        FigureBlock(scores(by_joint, references), "L1 of the joint model by record; the diamonds are the published cubics."),
    ]


def _own(test: Test) -> float | None:
    fit = test.least_squares
    return None if fit is None or fit.damper is None else score(fit.damper, test.record).l1
