"""The voltage laws (4.3)-(4.5) with the numbers of (4.6)-(4.8): the damper they make, and where they come from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from dampyr.models import Damper, Polynomial
from dampyr.origin import DERIVED
from dampyr.show.figures.laws import LawPanel, parameters_against_input
from dampyr.show.figures.style import Axis
from dampyr.show.pages.blocks import Block, FigureBlock, Text
from dampyr.show.table import Cell, Table
from dampyr.studies._compared_value import ComparedValue, ComparisonTolerance, Erratum, judge
from dampyr.studies._study_run import compared_table
from dampyr.studies.raminelli_2020.published import PARAMETERS, TABLES, TO_SI, UNITS, Published
from dampyr.studies.raminelli_2020.study_part import StudyPart

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
EQUATION = {"kx": "(4.6)", "kw": "(4.7)", "rho": "(4.8)"}
LETTER = {"kx": "kx", "kw": "kw", "rho": "ρ"}
ERRATA = (
    Erratum(
        "section 4.1",
        "“substituted into equation (2.4)”",
        "into (2.3)",
        "(4.1) is (2.3) with w = 1; (2.4) has no force in it",
    ),
    Erratum(
        "(4.1)",
        "F = kx v + kw",
        "F = kx v + kw sgn(v)",
        "w tends to the sign of the velocity by (2.4), to −1 on the way back",
    ),
)
POWERS = ("⁰", "¹", "²", "³")
RECOVERED = ComparisonTolerance(relative=4e-4)


def published_damper(published: Published) -> Damper:
    """(4.6)-(4.8) in SI, on the range of voltages that was applied."""
    voltages = [published.voltage(table) for table in TABLES]
    laws = {
        f"dahl.{name}": Polynomial(
            tuple(TO_SI[name] * float(c) for c in published.cubics[name]), min(voltages), max(voltages)
        )
        for name in PARAMETERS
    }
    strokes, frequencies = [row.displacement for row in published.rows], [row.frequency for row in published.rows]
    return Damper(
        "dahl",
        laws,
        ranges={"frequency": (min(frequencies), max(frequencies))},
        provenance={
            "source": "Raminelli (2020), equations (4.6) to (4.8), dissertation, UTFPR",
            "specimen": "LORD RD-8041-1",
            "calibration": "Tables 4.2 to 4.5; voltages as applied (printed 0, 0.88, 1.98, 3.21 V)",
            "displacement": f"{min(strokes):g} to {max(strokes):g} mm peak to peak as printed, beside a drift "
            "of the mean position",
        },
        origin=DERIVED,
    )


def table_means(published: Published, name: str, rho_0: float | None = None) -> Array:
    """The mean of a parameter over each table's printed rows, (4,), printed units; ``rho_0`` replaces the first of rho."""
    means = np.array([np.mean([getattr(row, name) for row in published.table(table)]) for table in TABLES])
    if name == "rho" and rho_0 is not None:
        means[0] = rho_0
    return means


def through(voltages: Sequence[float], means: Array) -> Array:
    """The coefficients, in rising powers, of the cubic through four means."""
    return np.asarray(np.linalg.solve(np.vander(np.asarray(voltages, dtype=float), increasing=True), means))


def law(published: Published, name: str, voltage: float) -> float:
    """One of the printed cubics at a voltage, printed units."""
    return float(np.polynomial.polynomial.polyval(voltage, [float(c) for c in published.cubics[name]]))


def equations(published: Published) -> StudyPart:
    """(4.6)-(4.8): recovered from the tables, and where they lead."""
    applied = [published.voltage(table) for table in TABLES]
    printed = [float(published.printed_voltages[table]) for table in TABLES]
    rho_0 = float(published.table_4_1["rho"][0])
    judged = recovered(published, applied, rho_0)
    passing = at_printed_voltages(published, applied, printed, rho_0)
    ten_rows = all_ten_rows(published, applied)
    reach = extrapolation(published, applied)
    everything = [*judged, *passing, *ten_rows, *reach]
    blocks: list[Block] = [
        Text(
            "Four coefficients pass through four table means, so the fit leaves no residual to judge it by. The nodes are the "
            f"voltages that were applied, {', '.join(f'{v:g}' for v in applied)} V, and for ρ at 0 V the mean "
            "that Table 4.1 prints."
        ),
        FigureBlock(_figure(published, applied, rho_0), "The cubics (4.6)-(4.8) and the means of Tables 4.2 to 4.5."),
        _nodes(published, applied, printed, rho_0),
        compared_table(
            everything,
            "Coefficients: ours pass through the means at the applied voltages. “Printed voltages”: published "
            "is the cubic there, ours the mean.",
        ),
    ]
    return StudyPart("Equations (4.6) to (4.8)", everything, blocks, ERRATA)


def recovered(published: Published, applied: Sequence[float], rho_0: float) -> list[ComparedValue]:
    """Each printed coefficient against the one through the means at the applied voltages."""
    judged = []
    for name in PARAMETERS:
        ours = through(applied, table_means(published, name, rho_0))
        for power, (theirs, value) in enumerate(zip(published.cubics[name], ours, strict=True)):
            quantity = f"{LETTER[name]}: coefficient of v{POWERS[power]}"
            judged.append(judge(EQUATION[name], quantity, theirs, float(value), _per_volt(name, power), RECOVERED))
    return judged


def _per_volt(name: str, power: int) -> str:
    return UNITS[name] + ("", "/V", "/V²", "/V³")[power]


def at_printed_voltages(
    published: Published, applied: Sequence[float], printed: Sequence[float], rho_0: float
) -> list[ComparedValue]:
    """The cubic at the voltage that the table prints, against that table's mean."""
    judged = []
    for name in PARAMETERS:
        means = table_means(published, name, rho_0)
        for table, true, as_printed, mean in zip(TABLES, applied, printed, means, strict=True):
            at_true = law(published, name, true)
            deviation = 100 * abs(at_true / mean - 1)
            otherwise = f"at the applied {true:g} V the cubic gives {at_true:.6g}, {deviation:.1g} % from the mean"
            quantity = f"{LETTER[name]} at the printed {as_printed:g} V, against Table {table}"
            judged.append(
                judge(
                    "Printed voltages",
                    quantity,
                    law(published, name, as_printed),
                    float(mean),
                    UNITS[name],
                    RECOVERED,
                    (),
                    otherwise,
                )
            )
    return judged


def all_ten_rows(published: Published, applied: Sequence[float]) -> list[ComparedValue]:
    """(4.8) with the mean of all ten rows of Table 4.2 in place of the printed one."""
    means = table_means(published, "rho")
    ours, theirs = through(applied, means), np.array([float(c) for c in published.cubics["rho"]])
    worst = int(np.argmax(np.abs(ours / theirs - 1)))
    rho_0 = float(published.table_4_1["rho"][0])
    why = f"the printed mean {rho_0:g} of Table 4.1 is not that of its ten rows, {means[0]:.6g}"
    quantity = f"ρ: coefficient of v{POWERS[worst]} with the mean of all ten rows at 0 V (the one that misses most)"
    return [
        judge(
            "(4.8) from all ten rows",
            quantity,
            published.cubics["rho"][worst],
            float(ours[worst]),
            _per_volt("rho", worst),
            RECOVERED,
            (),
            why,
        )
    ]


def extrapolation(published: Published, applied: Sequence[float]) -> list[ComparedValue]:
    """How far the cubics reach: the highest voltage used against the highest one tested."""
    roots = np.polynomial.Polynomial([float(c) for c in published.cubics["rho"]]).roots()
    real = [float(np.real(r)) for r in roots if abs(np.imag(r)) < 1e-9 and float(np.real(r)) > 0]
    used = float(published.highest_voltage)
    end = "ρ(v) has no root above 0 V"
    if real:
        end = f"ρ(v) has its root at {min(real):.4g} V, above which the Dahl state is unstable"
    rho = law(published, "rho", used)
    why = f"chapter 5 uses the cubics at {used:g} V, outside of their range; ρ({used:g} V) = {rho:.4g} 1/mm, and {end}"
    quantity = "the highest voltage (published: used in case 3; ours: tested)"
    return [
        judge(
            "Range of (4.6) to (4.8)",
            quantity,
            published.highest_voltage,
            max(applied),
            "V",
            ComparisonTolerance(relative=0.01),
            (),
            why,
        )
    ]


def _figure(published: Published, applied: Sequence[float], rho_0: float) -> Figure:
    over = np.linspace(0.0, float(published.highest_voltage), 300)
    laws = [
        LawPanel(
            Axis(LETTER[name], UNITS[name]),
            curve=(over, [law(published, name, v) for v in over]),
            points=(applied, table_means(published, name, rho_0)),
            error=[float(np.std([getattr(r, name) for r in published.table(t)], ddof=1)) for t in TABLES],
        )
        for name in PARAMETERS
    ]
    return parameters_against_input(laws, calibrated=(min(applied), max(applied)))


def _nodes(published: Published, applied: Sequence[float], printed: Sequence[float], rho_0: float) -> Table:
    rows: list[list[Cell]] = []
    for name in PARAMETERS:
        means = table_means(published, name, rho_0)
        spread = [float(np.std([getattr(r, name) for r in published.table(t)], ddof=1)) for t in TABLES]
        for k, table in enumerate(TABLES):
            at = (law(published, name, applied[k]), law(published, name, printed[k]))
            rows.append(
                [LETTER[name], UNITS[name], table, float(means[k]), spread[k], applied[k], at[0], printed[k], at[1]]
            )
    columns = ("parameter", "unit", "table", "mean", "s.d.", "applied V", "cubic there", "printed V", "cubic there ")
    caption = (
        "Means and deviations (n − 1) of the printed rows, and the cubics at the applied and at the printed voltages."
    )
    return Table(columns, rows, caption=caption)
