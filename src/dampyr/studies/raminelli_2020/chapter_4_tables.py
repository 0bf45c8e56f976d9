"""Tables 4.1 to 4.5: the statistics of the printed rows, and each row again from its own file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dampyr.show.pages.blocks import Block, Text
from dampyr.show.table import Cell, Table, Verdict
from dampyr.studies._compared_value import (
    AlternativeValue,
    ComparedValue,
    ComparisonTolerance,
    Erratum,
    judge,
    overall,
    unchecked,
)
from dampyr.studies._study_run import compared_table
from dampyr.studies.raminelli_2020.campaign_records import PublishedCampaign, PublishedTest
from dampyr.studies.raminelli_2020.published import PARAMETERS, TABLES, TO_SI, UNITS, Published, PublishedRow
from dampyr.studies.raminelli_2020.study_part import StudyPart

Array = NDArray[np.float64]
MOTION = ComparisonTolerance(relative=0.05)
COEFFICIENT = ComparisonTolerance(relative=0.10)
LETTER = {"kx": "kx", "kw": "kw", "rho": "ρ"}
FETCH = "`dampyr datasets fetch labcontrol`"
NO_FILES = f"the campaign's files are not on this machine; get them with {FETCH}"
METHOD = (
    "In the table: the motion, printed and ours over whole cycles; the coefficients, printed, by the modified method (mod.), "
    "and by least squares (fit); the verdict names what differs. The modified method is (4.1)-(4.2), on samples faster than "
    "half the peak speed and past the turning points; least squares is one fit of (2.3)-(2.4) over the whole record. Allowed: "
    f"{100 * MOTION.relative:g} % for the motion, {100 * COEFFICIENT.relative:g} % for the coefficients of the modified method."
)


def table_4_1(published: Published) -> StudyPart:
    """Mean and standard deviation of Table 4.2's rows."""
    judged = []
    for name in PARAMETERS:
        values = np.array([getattr(row, name) for row in published.table("4.2")])
        mean, spread = published.table_4_1[name]
        unit = UNITS[name]
        none = f"the {values.size} printed rows give another value, and leaving out any one of them does not give it either"
        ours = float(values.mean()), float(values.std(ddof=1))
        judged.append(
            judge(
                "Table 4.1", f"mean of {LETTER[name]}", mean, ours[0], unit, candidates=_means(values), otherwise=none
            )
        )
        judged.append(
            judge(
                "Table 4.1",
                f"s.d. of {LETTER[name]}",
                spread,
                ours[1],
                unit,
                candidates=_spreads(values),
                otherwise=none,
            )
        )
    text = Text(
        "The means and standard deviations (n − 1) follow from the rows that Table 4.2 prints; no data are needed."
    )
    return StudyPart("Table 4.1", judged, [text, compared_table(judged)])


def _means(values: Array) -> list[AlternativeValue]:
    """The means of all rows but one."""
    return [
        AlternativeValue(float(np.delete(values, k).mean()), f"the mean of the rows without row {k + 1}")
        for k in range(values.size)
    ]


def _spreads(values: Array) -> list[AlternativeValue]:
    """The deviations without one row, and with one row counted as zero."""
    candidates = []
    for k in range(values.size):
        others = np.delete(values, k)
        candidates.append(AlternativeValue(float(others.std(ddof=1)), f"the deviation of the rows without row {k + 1}"))
        zeroed = float(np.append(others, 0.0).std(ddof=1))
        candidates.append(AlternativeValue(zeroed, f"the deviation with row {k + 1} counted as 0"))
    return candidates


def tables(published: Published, campaign: PublishedCampaign | None) -> list[StudyPart]:
    """Tables 4.2 to 4.5, each row from its own file; without the data, what can be said of the printed rows alone."""
    return [_table_part(published, table, campaign) for table in TABLES]


def _table_part(published: Published, table: str, campaign: PublishedCampaign | None) -> StudyPart:
    rows = published.table(table)
    by_row: list[tuple[PublishedRow, PublishedTest | None, list[ComparedValue]]] = []
    for row in rows:
        test = campaign.test(table, row.row) if campaign else None
        by_row.append((row, test, _compare_row(published, row, test, campaign)))
    judged = [value for _, _, row_values in by_row for value in row_values]
    means = group_means(table, [(row, test) for row, test, _ in by_row if test is not None])
    title = f"Table {table}: {published.printed_voltages[table].text} V"
    errata = _repeated(table, rows)
    text = Text(_introduce(rows, published, table))
    if campaign is None:
        return StudyPart(title, judged, [text, Verdict("cannot be checked", NO_FILES)], errata)
    blocks: list[Block] = [
        text,
        _rows_table(by_row),
        _reasons(by_row),
        compared_table(means, "Means over the rows with a file."),
    ]
    return StudyPart(title, [*judged, *means], blocks, errata)


def _introduce(rows: Sequence[PublishedRow], published: Published, table: str) -> str:
    strokes, frequencies = ([getattr(row, name) for row in rows] for name in ("displacement", "frequency"))
    r = float(np.corrcoef(strokes, frequencies)[0, 1])
    text = (
        f"Printed for {published.printed_voltages[table].text} V; {published.voltage(table):g} V was applied. "
        f"Displacement is peak to peak. Displacement and frequency of the printed rows correlate with {r:.2f}, so their "
        "effects cannot be told apart."
    )
    return f"{text}\n\n{METHOD}" if table == TABLES[0] else f"{text} The rest is as under table {TABLES[0]}."


def _compare_row(
    published: Published, row: PublishedRow, test: PublishedTest | None, campaign: PublishedCampaign | None
) -> list[ComparedValue]:
    where = f"Table {row.table}"
    names = {"displacement": "mm", "frequency": "Hz"} | UNITS
    if test is None:
        missing = "the row has no file in the folder" if campaign else NO_FILES
        return [
            unchecked(where, f"row {row.row}: {LETTER.get(k, k)}", getattr(row, k), unit, missing)
            for k, unit in names.items()
        ]
    return [*_compare_motion(where, row, test, published, campaign), *_compare_coefficients(where, row, test)]


def _compare_motion(
    where: str, row: PublishedRow, test: PublishedTest, published: Published, campaign: PublishedCampaign | None
) -> list[ComparedValue]:
    """Printed against measured displacement and frequency; a printed value that another test has is named."""
    ours = {"displacement": 1e3 * test.measured.peak_to_peak_m, "frequency": test.measured.frequency_hz}
    assert campaign is not None
    judged = []
    for name, unit in (("displacement", "mm"), ("frequency", "Hz")):
        theirs = float(getattr(row, name))
        of_that_label = [
            t.record.name for t in campaign.validation if unit == "Hz" and abs(t.row.label.frequency_hz - theirs) < 1e-9
        ]
        why = next((s for s in test.disagreements if (" Hz" in s) == (unit == "Hz")), "")
        if name == "displacement" and why:
            peak_to_peak = 1e3 * float(np.ptp(test.record.displacement))
            why += f"; over the whole record, which drifts, {peak_to_peak:.4g} mm"
        if of_that_label:
            why += f"; {theirs:g} Hz is the label of {', '.join(of_that_label)}"
        judged.append(judge(where, f"row {row.row}: {name}", theirs, ours[name], unit, MOTION, (), why))
    return judged


def _compare_coefficients(where: str, row: PublishedRow, test: PublishedTest) -> list[ComparedValue]:
    """kx, kw and rho of the modified method against the printed ones."""
    judged = []
    for name in PARAMETERS:
        ours = getattr(test.plastic, name) / TO_SI[name]
        why = _why_rho(row, test) if name == "rho" else _why_force(row, test)
        quantity = f"row {row.row}: {LETTER[name]}"
        judged.append(judge(where, quantity, getattr(row, name), ours, UNITS[name], COEFFICIENT, (), why))
    return judged


def _why_force(row: PublishedRow, test: PublishedTest) -> str:
    """Whether kx and kw only trade against each other: the plastic force at the peak speed."""
    speed = 1e3 * test.measured.peak_speed
    theirs = row.kx * speed + row.kw
    ours = test.plastic.kx / TO_SI["kx"] * speed + test.plastic.kw
    deviation = ours / theirs - 1
    same = abs(deviation) <= COEFFICIENT.relative
    explanation = (
        "kx and kw trade against each other on a near-sine" if same else "the text does not say which samples were used"
    )
    forces = f"the printed pair gives {theirs:.4g} N, ours {ours:.4g} N ({100 * deviation:+.2g} %)"
    return f"{explanation}: at the peak speed of {speed:.3g} mm/s {forces}"


def _why_rho(row: PublishedRow, test: PublishedTest) -> str:
    """Whether the printed rho lies inside the span of the single turning points."""
    slopes = test.slopes / TO_SI["rho"]
    low, high = float(slopes.min()), float(slopes.max())
    inside = low <= row.rho <= high
    return (
        f"at {slopes.size} turning points the two samples next to θ = 0 give a/kw from {low:.3g} to {high:.3g} 1/mm "
        f"(median {float(np.median(slopes)):.3g}); the printed value lies {'inside' if inside else 'outside'} that span"
    )


def group_means(table: str, pairs: Sequence[tuple[PublishedRow, PublishedTest]]) -> list[ComparedValue]:
    """The means over the rows that have a file: printed, modified, with least squares in the reason."""
    judged = []
    for name in PARAMETERS:
        if not pairs:
            break
        theirs = float(np.mean([getattr(row, name) for row, _ in pairs]))
        ours = float(np.mean([getattr(test.plastic, name) for _, test in pairs])) / TO_SI[name]
        alone = [t.least_squares.parameters[f"dahl.{name}"] / TO_SI[name] for _, t in pairs if t.least_squares]
        spans = [float(np.median(t.slopes)) / TO_SI[name] for _, t in pairs]
        why = f"least squares over whole records gives {float(np.mean(alone)):.4g}"
        if name == "rho":
            why += f", two samples around θ = 0 (median over turning points) {float(np.mean(spans)):.4g}"
        quantity = f"mean of {LETTER[name]} over {len(pairs)} rows"
        judged.append(judge(f"Table {table}", quantity, theirs, ours, UNITS[name], COEFFICIENT, (), why))
    return judged


def _rows_table(by_row: Sequence[tuple[PublishedRow, PublishedTest | None, list[ComparedValue]]]) -> Table:
    """The motion and the coefficients of each row: printed, and ours."""
    rows: list[list[Cell]] = []
    for row, test, row_values in by_row:
        measured = (1e3 * test.measured.peak_to_peak_m, test.measured.frequency_hz) if test else (None, None)
        cells: list[Cell] = [row.row, test.record.name if test else None]
        cells += [row.displacement, measured[0], row.frequency, measured[1]]
        for name in PARAMETERS:
            alone = test.least_squares if test else None
            cells += [
                getattr(row, name),
                getattr(test.plastic, name) / TO_SI[name] if test else None,
                alone.parameters[f"dahl.{name}"] / TO_SI[name] if alone else None,
            ]
        rows.append([*cells, _verdict(row_values)])
    columns, units = ["row", "file"], ["", ""]
    for k, (name, unit) in enumerate((("displ.", "mm"), ("freq.", "Hz"))):
        columns += [f"{name} printed", "ours" + " " * k]
        units += [unit, unit]
    for k, name in enumerate(PARAMETERS):
        columns += [f"{LETTER[name]} printed", "mod." + " " * k, "fit" + " " * k]
        units += [UNITS[name]] * 3
    return Table([*columns, "verdict"], rows, [*units, ""], caption="The rows: printed, and ours.", digits=4)


def _verdict(judged: Sequence[ComparedValue]) -> Verdict:
    """One verdict for a row, naming what differs; `_reasons` says why where it is farthest off."""
    kind = overall(judged)
    if kind == "cannot be checked":
        return Verdict(kind, "no file")
    return Verdict(kind, ", ".join(_number(f) for f in judged if f.verdict == "differs"))


def _number(value: ComparedValue) -> str:
    return value.quantity.partition(": ")[2]


def _reasons(by_row: Sequence[tuple[PublishedRow, PublishedTest | None, list[ComparedValue]]]) -> Table:
    """What differs, a line for each number: in which rows, by how much, and the reason of the row that is farthest off."""
    differing: dict[str, list[tuple[int, ComparedValue]]] = {}
    for row, _, row_values in by_row:
        for value in row_values:
            if value.verdict == "differs":
                differing.setdefault(_number(value), []).append((row.row, value))
    rows: list[list[Cell]] = []
    for name, values in differing.items():
        off = [float(value.ours) / float(value.published) - 1.0 for _, value in values]  # type: ignore[arg-type]
        farthest, value = values[int(np.argmax(np.abs(off)))]
        numbers = ", ".join(str(row) for row, _ in values)
        span = f"{100 * min(off):+.2g} to {100 * max(off):+.2g} %" if len(off) > 1 else f"{100 * off[0]:+.2g} %"
        rows.append([name, numbers, span, f"row {farthest}: {value.reason}"])
    return Table(
        ("number", "rows", "off by", "the row that is farthest off, and why"),
        rows,
        caption="What differs; reproduce.json has the reason of each row.",
    )


def _repeated(table: str, rows: Sequence[PublishedRow]) -> list[Erratum]:
    """Values that stand more than once in a column where no two measurements would give the same four digits."""
    twice = {value: n for value, n in Counter(row.rho for row in rows).items() if n > 1}
    return [
        Erratum(
            f"Table {table}",
            f"ρ = {value:g} in rows {' and '.join(str(r.row) for r in rows if r.rho == value)}",
            "not known",
            "two tests with different kx and kw do not give the same six digits; one of them was probably copied",
        )
        for value in twice
    ]
