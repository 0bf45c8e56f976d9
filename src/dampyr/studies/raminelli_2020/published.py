"""The numbers that the dissertation prints, each with the place where it stands, in the printed units."""
# ruff: noqa: RUF009

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

from dampyr.phrases import listing
from dampyr.records.files.campaign_folder import campaign_rows
from dampyr.show.descriptions import Description, describe
from dampyr.shown import Shown
from dampyr.studies._compared_value import PrintedNumber

PARAMETERS = ("kx", "kw", "rho")
UNITS = {"kx": "N s/mm", "kw": "N", "rho": "1/mm"}
# N s/mm and 1/mm to SI
TO_SI = {"kx": 1e3, "kw": 1.0, "rho": 1e3}
TABLES = ("4.2", "4.3", "4.4", "4.5")


def _numbers(text: str) -> tuple[PrintedNumber, ...]:
    return tuple(PrintedNumber(word) for word in text.split())


@dataclass(frozen=True)
class Example:
    """Section 2.4 (cm, N, s): the parameters of Step 1, and what Steps 2 to 5 print."""

    kx: PrintedNumber = PrintedNumber("0.045")
    kw: PrintedNumber = PrintedNumber("6.32")
    rho: PrintedNumber = PrintedNumber("705.32")
    amplitude: PrintedNumber = PrintedNumber("0.8")
    frequency: PrintedNumber = PrintedNumber("0.2")
    force_0: PrintedNumber = PrintedNumber("-6.3199")
    force_T: PrintedNumber = PrintedNumber("6.3200")
    velocity_0: PrintedNumber = PrintedNumber("7.8957e-5")
    velocity_T: PrintedNumber = PrintedNumber("2.3687e-4")
    kx_identified: PrintedNumber = PrintedNumber("0.045")
    x_star: PrintedNumber = PrintedNumber("-0.8")
    a: PrintedNumber = PrintedNumber("4466.3")
    x_star1: PrintedNumber = PrintedNumber("-0.2092")
    rho_identified: PrintedNumber = PrintedNumber("706.687")
    kw_identified: PrintedNumber = PrintedNumber("6.32")


@dataclass(frozen=True)
class BoucWenLetters:
    """The caption of Fig. 2.2, in the letters of (2.2)."""

    alpha: PrintedNumber = PrintedNumber("0.1")
    beta: PrintedNumber = PrintedNumber("0.1")
    gamma: PrintedNumber = PrintedNumber("2")
    A: PrintedNumber = PrintedNumber("1")
    n: PrintedNumber = PrintedNumber("1.3")


@dataclass(frozen=True)
class PublishedRow:
    """A row of Tables 4.2 to 4.5 (mm, Hz, N s/mm, N, 1/mm); ``voltage`` is the one that was applied, in V."""

    table: str
    row: int
    voltage: float
    displacement: float
    frequency: float
    kx: float
    kw: float
    rho: float


def _rows() -> tuple[PublishedRow, ...]:
    """The rows as the table of the campaign has them, which comes with dampyr."""
    rows = []
    for row in campaign_rows():
        if row.row is not None:
            values = [row.published[name] / TO_SI[name] for name in PARAMETERS]
            motion = (round(1e3 * row.label.peak_to_peak_m, 9), row.label.frequency_hz)
            rows.append(PublishedRow(row.table, row.row, row.voltage, *motion, *values))
    return tuple(rows)


@dataclass(frozen=True, repr=False)
class Published(Shown):
    """Everything that is compared."""

    example: Example = Example()
    bouc_wen: BoucWenLetters = BoucWenLetters()
    rows: tuple[PublishedRow, ...] = field(default_factory=_rows)
    printed_voltages: Mapping[str, PrintedNumber] = field(
        default_factory=lambda: dict(zip(TABLES, _numbers("0 0.88 1.98 3.21")))
    )
    table_4_1: Mapping[str, tuple[PrintedNumber, ...]] = field(
        default_factory=lambda: {
            "kx": _numbers("0.8020 0.1023"),
            "kw": _numbers("50.2368 6.7375"),
            "rho": _numbers("42.7448 17.9213"),
        }
    )
    cubics: Mapping[str, tuple[PrintedNumber, ...]] = field(
        default_factory=lambda: {  # (4.6) to (4.8), in rising powers of the voltage
            "kx": _numbers("0.802 0.4931 0.0342 0.0855"),
            "kw": _numbers("50.237 201.92 -24.866 3.6157"),
            "rho": _numbers("42.745 -39.038 17.881 -2.8368"),
        }
    )
    error_at_0: PrintedNumber = PrintedNumber("14.81")
    error_validation: PrintedNumber = PrintedNumber("21.71")
    fig_4_3_voltage: PrintedNumber = PrintedNumber("0.88")
    fig_4_3_frequency: PrintedNumber = PrintedNumber("0.8474")
    fig_4_3_displacement: PrintedNumber = PrintedNumber("23.5")
    fig_4_3_rate: PrintedNumber = PrintedNumber("0.01")
    peaks: tuple[PrintedNumber, ...] = field(default_factory=lambda: _numbers("223.1413 216.8413 201.5243"))
    reductions: tuple[PrintedNumber, ...] = field(default_factory=lambda: _numbers("7.01 13.66"))
    highest_voltage: PrintedNumber = PrintedNumber("3.6")
    actuator_speed: PrintedNumber = PrintedNumber("16.8")

    def table(self, table: str) -> list[PublishedRow]:
        """The rows of one table."""
        return [row for row in self.rows if row.table == table]

    def voltage(self, table: str) -> float:
        """The voltage that was applied in the tests of one table, V."""
        return self.table(table)[0].voltage


@describe.register
def describe_published(published: Published) -> Description:
    """How many tests of which table, and what else is compared."""
    tables = Counter(row.table for row in published.rows)
    return Description(
        "Published, Raminelli (2020)",
        [
            ("tests", ", ".join(f"{count} in table {name}" for name, count in sorted(tables.items()))),
            ("table 4.1", ", ".join(published.table_4_1)),
            ("cubics", ", ".join(published.cubics) + " over the voltage, (4.6) to (4.8)"),
            ("peaks", f"{listing([peak.text for peak in published.peaks])} mm, of chapter 5"),
            ("errors", f"{published.error_at_0.text} % at 0 V, {published.error_validation.text} % of the validation"),
        ],
    )


PUBLISHED = Published()
"""The numbers as printed."""
