"""What intensity measures show."""

from __future__ import annotations

from dampyr.ground_motions.intensity_measures import Measures
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.table import Cell, Table
from dampyr.units import STANDARD_GRAVITY


@describe.register
def describe_measures(measures: Measures) -> Description:
    """The peaks, the Arias intensity, the durations and the cumulative absolute velocity, in words and as a table."""
    durations = (measures.duration_5_95, measures.duration_5_75)
    return Description(
        "Measures",
        [
            ("PGA", f"{measures.pga:.4g} m/s² ({measures.pga / STANDARD_GRAVITY:.3g} g)"),
            ("PGV", f"{1e3 * measures.pgv:.4g} mm/s"),
            ("PGD", f"{1e3 * measures.pgd:.4g} mm"),
            ("Arias", f"{measures.arias:.4g} m/s"),
            ("duration", f"{durations[0]:.4g} s from 5 to 95 %, {durations[1]:.4g} s from 5 to 75 % of Arias"),
            ("CAV", f"{measures.cumulative_absolute_velocity:.4g} m/s, cumulative absolute velocity"),
        ],
        tables=[lambda: measures_table(measures)],
        frame=lambda: _columns(measures),
    )


def measures_table(measures: Measures) -> Table:
    """The measures, one in each row, as people read them."""
    rows: list[list[Cell]] = [
        ["peak acceleration", measures.pga, "m/s²"],
        ["peak acceleration", measures.pga / STANDARD_GRAVITY, "g"],
        ["peak velocity", 1e3 * measures.pgv, "mm/s"],
        ["peak displacement", 1e3 * measures.pgd, "mm"],
        ["Arias intensity", measures.arias, "m/s"],
        ["significant duration, 5 to 95 %", measures.duration_5_95, "s"],
        ["significant duration, 5 to 75 %", measures.duration_5_75, "s"],
        ["cumulative absolute velocity", measures.cumulative_absolute_velocity, "m/s"],
    ]
    return Table(
        ("measure", "value", "unit"),
        rows,
        align=("left", "right", "left"),
        caption="Intensity measures.",
        notes=(
            "Exact for acceleration linear between the samples, g = 9.80665 m/s². Velocity and displacement start from rest.",
        ),
    )


def _columns(measures: Measures) -> DataFrameColumns:
    """The measures in SI units, in one row."""
    values = {
        "pga_m_per_s2": measures.pga,
        "pgv_m_per_s": measures.pgv,
        "pgd_m": measures.pgd,
        "arias_m_per_s": measures.arias,
        "duration_5_95_s": measures.duration_5_95,
        "duration_5_75_s": measures.duration_5_75,
        "cumulative_absolute_velocity_m_per_s": measures.cumulative_absolute_velocity,
    }
    return DataFrameColumns({name: [value] for name, value in values.items()})
