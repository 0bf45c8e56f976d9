"""The two published errors, 14.81 % and 21.71 %, by every reading that the text allows; and one joint model beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from dampyr.identification import score
from dampyr.identification.scoring.score import compare, prediction
from dampyr.models import Constant, Damper
from dampyr.records import Record, with_velocity
from dampyr.records.conditioning.velocity import default_bandwidth
from dampyr.show.figures.scores import scores
from dampyr.show.pages.blocks import Block, FigureBlock, Text
from dampyr.show.table import Cell, Table
from dampyr.studies._compared_value import ComparedValue, ComparisonTolerance, judge, unchecked
from dampyr.studies._study_run import compared_table
from dampyr.studies.raminelli_2020.campaign_records import PublishedCampaign, PublishedTest
from dampyr.studies.raminelli_2020.chapter_4_tables import NO_FILES
from dampyr.studies.raminelli_2020.cubics import published_damper
from dampyr.studies.raminelli_2020.published import PARAMETERS, TABLES, TO_SI, Published, PublishedRow
from dampyr.studies.raminelli_2020.study_part import StudyPart

Array = NDArray[np.float64]
Readings = Mapping[str, Array]  # of the coefficients or files -> (records, definitions), %
HALF_A_POINT = ComparisonTolerance(absolute=0.5)
TITLE = "The published errors, and what a joint model gives"
DEFINITIONS = (
    "L1 (3.1), offset removed, from 2 s after the motion starts",
    "L1 (3.1), offset removed, whole record",
    "L1 (3.1), offset left in, whole record",
    "pointwise mean, from 2 s after the motion starts, samples above 1 % of the peak force",
    "pointwise mean, from 2 s after the motion starts, every sample",
    "pointwise mean, whole record, every sample",
    "pointwise mean, offset left in, whole record, every sample",
)


def percent(damper: Damper, record: Record) -> Array:
    """The errors of one record under one damper by `DEFINITIONS`, (definitions,), %."""
    model = prediction(damper, record)
    settled = compare(record, model, centre="midrange")
    entire = compare(record, model, window=(float(record.time[0]), float(record.time[-1])), centre="midrange")
    window = settled.window.slice
    ratios = (
        settled.l1,
        entire.l1,
        float(np.sum(np.abs(model - record.force)) / np.sum(np.abs(record.force))),
        settled.pointwise,
        _pointwise(record.force[window], model[window]),
        _pointwise(record.force, model),
        _relative(record.force, model - record.force),
    )
    return 100.0 * np.array(ratios)


def _pointwise(measured: Array, model: Array) -> float:
    """The mean of |error| / |force|, the error less its mean, the force from the middle of its range."""
    error = model - measured
    return _relative(measured - 0.5 * (measured.max() + measured.min()), error - error.mean())


def _relative(force: Array, error: Array) -> float:
    nonzero = force != 0.0
    return float(np.mean(np.abs(error[nonzero] / force[nonzero])))


def errors(published: Published, campaign: PublishedCampaign | None) -> StudyPart:
    """Both errors; without the data nothing can be said."""
    if campaign is None or not campaign.tests:
        unchecked_values = [
            unchecked("14.81 %", "mean error at 0 V, section 4.2", published.error_at_0, "%", NO_FILES),
            unchecked("21.71 %", "error of (4.6)-(4.8), section 4.4", published.error_validation, "%", NO_FILES),
        ]
        return StudyPart(TITLE, unchecked_values, [compared_table(unchecked_values)])
    text = Text(
        "The text names the L1 ratio (3.1) for both. “Pointwise mean” is the mean of |error| / |force| over "
        "the samples; it hangs "
        "on those where the force passes through zero, so it says little about a model. Several readings are "
        "given, and a printed "
        "value that one of them meets is not thereby explained."
    )
    at_0, block_0 = error_at_0(published, campaign)
    at_validation, block_validation = error_of_validation(published, campaign)
    judged = [*at_0, *at_validation]
    blocks = [text, *block_0, *block_validation, compared_table(judged, digits=4), *joint_model(published, campaign)]
    return StudyPart(TITLE, judged, blocks)


def constant_damper(values: Mapping[str, float], voltage: float) -> Damper:
    """A viscous Dahl damper of printed coefficients, at one voltage."""
    return Damper("dahl", {f"dahl.{k}": Constant(TO_SI[k] * float(v), voltage, voltage) for k, v in values.items()})


def row_damper(row: PublishedRow) -> Damper:
    """The damper of one printed row."""
    return constant_damper({name: getattr(row, name) for name in PARAMETERS}, row.voltage)


def error_at_0(published: Published, campaign: PublishedCampaign) -> tuple[list[ComparedValue], list[Block]]:
    """14.81 %: the mean coefficients of Table 4.1, and each row's own, on the files of Table 4.2."""
    pairs = [(row, test) for row in published.table("4.2") if (test := campaign.test("4.2", row.row)) is not None]
    if not pairs:
        missing = "no file of Table 4.2 is in the folder"
        return [unchecked("14.81 %", "mean error at 0 V", published.error_at_0, "%", missing)], []
    mean = constant_damper({name: published.table_4_1[name][0] for name in PARAMETERS}, pairs[0][0].voltage)
    readings = {
        "coefficients of Table 4.1": np.array([percent(mean, test.record) for _, test in pairs]),
        "each row's own": np.array([percent(row_damper(row), test.record) for row, test in pairs]),
    }
    single = readings["coefficients of Table 4.1"][:, 0]
    value = judge(
        "14.81 %",
        f"mean of L1 (3.1) over the {len(pairs)} files at 0 V, coefficients of Table 4.1",
        published.error_at_0,
        float(single.mean()),
        "%",
        HALF_A_POINT,
        otherwise="the text names neither the runs nor how the offset was treated; "
        + describe_near(published.error_at_0, readings)
        + _describe_three_runs(single),
    )
    caption = f"The error at 0 V, mean over {len(pairs)} files; printed: {published.error_at_0.text} %."
    return [value], [_readings_table(readings, caption)]


def describe_near(printed: float, readings: Readings) -> str:
    """Which of the readings come within half a point of the printed value, and over what they range."""
    means = {(name, k): float(block[:, k].mean()) for name, block in readings.items() for k in range(len(DEFINITIONS))}
    low, high = min(means.values()), max(means.values())
    hits = [
        f"“{DEFINITIONS[k]}” with {name} ({v:.4g} %)"
        for (name, k), v in means.items()
        if HALF_A_POINT.allows(printed, v)
    ]
    near_ones = f"{len(hits)} within half a point of the printed value" + (": " + ", ".join(hits) if hits else "")
    return f"{len(means)} readings run from {low:.1f} to {high:.0f} %, {near_ones}"


def _describe_three_runs(single: Array) -> str:
    """What a mean over three runs could be, as laboratories often repeat thrice."""
    if single.size < 3:
        return ""
    ordered = np.sort(single)
    return f". Any three of the files average to {ordered[:3].mean():.3g} to {ordered[-3:].mean():.3g} % by L1"


def error_of_validation(published: Published, campaign: PublishedCampaign) -> tuple[list[ComparedValue], list[Block]]:
    """21.71 %: the cubics on the validation run and on the files of Table 4.3."""
    damper, printed = published_damper(published), published.error_validation
    runs = {"the validation run": [test.record for test in campaign.validation]}
    runs["the validation run, velocity smoothed"] = [
        with_velocity(record, default_bandwidth(record)) for record in runs["the validation run"]
    ]
    runs["the files of Table 4.3"] = [test.record for test in campaign.table("4.3")]
    readings = {name: np.array([percent(damper, r) for r in listed]) for name, listed in runs.items() if listed}
    names = ", ".join(test.record.name for test in campaign.validation) or "none"
    missing = f"the text does not say which runs, and the folder holds {names} only; the other validation runs would be needed"
    judged = [unchecked("21.71 %", "mean error over the validation runs", printed, "%", missing)]
    for name, block in readings.items():
        if "smoothed" in name:
            continue
        ours = float(block[:, 0].mean())
        why = describe_near(printed, readings)
        judged.append(
            judge("21.71 %", f"L1 (3.1) of the cubics, {name}", printed, ours, "%", HALF_A_POINT, otherwise=why)
        )
    caption = f"The error of (4.6)-(4.8); printed: {printed.text} %."
    return judged, [_readings_table(readings, caption)] if readings else []


def _readings_table(readings: Readings, caption: str) -> Table:
    rows: list[list[Cell]] = [
        [title, *(float(block[:, k].mean()) for block in readings.values())] for k, title in enumerate(DEFINITIONS)
    ]
    return Table(["reading", *readings], rows, ["", *["%"] * len(readings)], caption=caption, digits=4)


def joint_model(published: Published, campaign: PublishedCampaign) -> list[Block]:
    """L1 by table: least squares per record, the cubics, and one model for all voltages."""
    joint, cubics = campaign.joint, published_damper(published)
    if joint is None or joint.damper is None:
        return [
            Text("No joint model: " + (joint.reason if joint else "the folder holds records at one voltage only") + ".")
        ]
    groups = {f"{published.voltage(t):g} V": campaign.table(t) for t in TABLES if campaign.table(t)}
    groups |= {"validation run": campaign.validation} if campaign.validation else {}
    single = {name: [l1 for test in tests if (l1 := _l1_alone(test)) is not None] for name, tests in groups.items()}
    by_cubics = {name: [score(cubics, t.record, centre="midrange").l1 for t in tests] for name, tests in groups.items()}
    by_joint = {
        name: [score(joint.damper, t.record, centre="midrange").l1 for t in tests] for name, tests in groups.items()
    }
    rows: list[list[Cell]] = [
        [name, len(tests), *(_mean_percent(column[name]) for column in (single, by_cubics, by_joint))]
        for name, tests in groups.items()
    ]
    heads = ("records", "files", "Dahl, each record alone", "published cubics", "one joint model")
    caption = "Mean L1 (3.1), offset removed, from 2 s after the motion starts."
    references = {"published cubics": {name: float(np.mean(values)) for name, values in by_cubics.items()}}
    ended = "converged" if joint.converged else f"not converged: {joint.reason}"
    return [
        Text(
            "One model for all voltages, fitted to all records of the tables together: Dahl, a rounded "
            "friction force, a spring and "
            f"a delay; ρ and the delay are one number each, the others follow the voltage ({ended}). The "
            "validation run was not "
            "fitted; the other rows say how well a model describes what it was fitted to."
        ),
        Table(heads, rows, ("", "", "%", "%", "%"), caption=caption, digits=3),
        FigureBlock(
            scores(by_joint, references), "L1 of the joint model by record; the diamonds are the published cubics."
        ),
    ]


def _mean_percent(values: Sequence[float]) -> float | None:
    return 100 * float(np.mean(values)) if values else None


def _l1_alone(test: PublishedTest) -> float | None:
    fit = test.least_squares
    return None if fit is None or fit.damper is None else score(fit.damper, test.record, centre="midrange").l1
