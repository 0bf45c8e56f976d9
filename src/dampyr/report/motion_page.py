"""The page of a ground motion: its intensity measures, histories, response spectra and processing."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from dampyr.figures.ground_histories import ground_histories
from dampyr.figures.response_spectrum import SPECTRAL_DISPLACEMENT, response_spectrum
from dampyr.ground_motions import GroundMotion, Measures, Spectrum, measures, spectrum
from dampyr.report.blocks import Cell, FigureBlock, Section, Table, Text
from dampyr.report.html_page import page, write_page
from dampyr.units import STANDARD_GRAVITY

DAMPINGS = (0.02, 0.05, 0.1)  # ratios: the usual 5 %, one below and one above
TABLE = (0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0)  # s, about evenly spaced in the logarithm


def write_motion_page(
    motion: GroundMotion, path: str | Path, dampings: Sequence[float] = DAMPINGS, periods: Sequence[float] = TABLE
) -> Path:
    """Write the page; ``dampings`` as ratios, ``periods`` [s] those of the table."""
    html = page(
        motion.name,
        [
            Section("Intensity measures", [measures_table(measures(motion))]),
            Section("Over time", [_histories(motion)]),
            Section(
                "Response spectra", [*_spectra(motion, dampings), spectrum_table(spectrum(motion, periods, dampings))]
            ),
            Section(
                "Processing",
                [Text("\n\n".join(motion.history) or "None: the samples are as they were read or generated.")],
            ),
        ],
        subtitle=f"{motion.n} samples every {motion.dt:g} s, {motion.duration:g} s",
        provenance={"source": motion.source or "not known"},
        call=f"dampyr.report.write_motion_page(motion, {Path(path).name!r})",
    )
    return write_page(path, html)


def measures_rows(motion_measures: Measures) -> list[tuple[str, float, str]]:
    """Words, value and unit as people read them."""
    return [
        ("peak acceleration", motion_measures.pga, "m/s²"),
        ("peak acceleration", motion_measures.pga / STANDARD_GRAVITY, "g"),
        ("peak velocity", 1e3 * motion_measures.pgv, "mm/s"),
        ("peak displacement", 1e3 * motion_measures.pgd, "mm"),
        ("Arias intensity", motion_measures.arias, "m/s"),
        ("significant duration, 5 to 95 %", motion_measures.duration_5_95, "s"),
        ("significant duration, 5 to 75 %", motion_measures.duration_5_75, "s"),
        ("cumulative absolute velocity", motion_measures.cumulative_absolute_velocity, "m/s"),
    ]


def measures_table(motion_measures: Measures) -> Table:
    """The measures, one in each row."""
    rows: list[list[Cell]] = [list(row) for row in measures_rows(motion_measures)]
    caption = "Exact for acceleration linear between the samples, g = 9.80665 m/s². Velocity and displacement start from rest."
    return Table(("measure", "value", "unit"), rows, align=("left", "right", "left"), caption=caption)


def spectrum_rows(spectra: Spectrum) -> list[list[float]]:
    """Damping in per cent, period, Sd in mm, pseudo-velocity in mm/s, Sa in m/s² and in g; ``spectra`` has both axes."""
    return [
        [100 * spectra.damping[i], T, 1e3 * spectra.displacement[i, j], 1e3 * spectra.pseudo_velocity[i, j],
         spectra.pseudo_acceleration[i, j], spectra.pseudo_acceleration[i, j] / STANDARD_GRAVITY]
        for i in range(len(spectra.damping))
        for j, T in enumerate(spectra.periods)
    ]  # fmt: skip


SPECTRUM_COLUMNS = (
    "damping",
    "period",
    "displacement",
    "pseudo-velocity",
    "pseudo-acceleration",
    "pseudo-acceleration",
)
SPECTRUM_UNITS = ("%", "s", "mm", "mm/s", "m/s²", "g")


def spectrum_table(spectra: Spectrum) -> Table:
    """The spectrum in numbers."""
    rows: list[list[Cell]] = [list(map(float, row)) for row in spectrum_rows(spectra)]
    caption = "Peaks inside the step, up to the last sample; displacement relative to the ground."
    return Table(SPECTRUM_COLUMNS, rows, SPECTRUM_UNITS, caption=caption, digits=4)


def drift_in_words(motion: GroundMotion) -> str:
    """That the displacement drifts, where it ends far from where it began; else nothing."""
    d = motion.displacement
    if abs(d[-1]) <= 0.25 * np.abs(d).max() or d[-1] == 0:
        return ""
    return (
        f"the displacement ends at {1e3 * d[-1]:.4g} mm: a raw record drifts, and a baseline correction takes that off"
    )


def _histories(motion: GroundMotion) -> FigureBlock:
    figure = ground_histories(motion.time, motion.acceleration, motion.velocity, motion.displacement)
    drift = drift_in_words(motion)
    return FigureBlock(figure, "Acceleration and its exact integrals, from rest" + (f"; {drift}." if drift else "."))


def _spectra(motion: GroundMotion, dampings: Sequence[float]) -> list[FigureBlock]:
    spectra = spectrum(motion, damping=dampings)
    names = [f"{100 * each:g} %" for each in dampings]
    acceleration = response_spectrum(spectra.periods, dict(zip(names, spectra.pseudo_acceleration)))
    displacement = response_spectrum(spectra.periods, dict(zip(names, spectra.displacement)), SPECTRAL_DISPLACEMENT)
    return [
        FigureBlock(acceleration, "Pseudo-acceleration of an oscillator over its period, for each damping."),
        FigureBlock(displacement, "Its displacement relative to the ground."),
    ]
