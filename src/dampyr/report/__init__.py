"""Figures and pages for people.

A figure takes plain arrays in SI, shows them in the units people read (mm, N, s, V) and returns a matplotlib
``Figure``. A page is one self-contained HTML file: no network, light and dark, for paper and for a phone.

::

    figure = loops(record.displacement, record.velocity, record.force, {"viscous Dahl": predicted})
    html = page("A damper", [Section("Loops", [FigureBlock(figure, "measured, model")])])
    write_page("out/damper.html", html)
"""

from dampyr.report.blocks import Block, Cell, FigureBlock, Section, Table, Text, Verdict, sentence
from dampyr.report.figure_files import figure_files
from dampyr.report.figures.acceptance import band_used, peak_velocity_band
from dampyr.report.figures.building import building_response
from dampyr.report.figures.calibrated import calibrated
from dampyr.report.figures.controlled import controlled
from dampyr.report.figures.correlation import correlation, strong_pairs
from dampyr.report.figures.envelope import envelope
from dampyr.report.figures.fragility import Fragile, fragility_curves
from dampyr.report.figures.ground_histories import ground_histories
from dampyr.report.figures.ground_motion import ground_motion
from dampyr.report.figures.history import history
from dampyr.report.figures.incremental import incremental_curves
from dampyr.report.figures.laws import Law, parameters_against_input
from dampyr.report.figures.loops import loops
from dampyr.report.figures.memory import memory
from dampyr.report.figures.phase_portrait import phase_portrait
from dampyr.report.figures.planned_drive import planned_drive
from dampyr.report.figures.residual_sizes import residual_sizes
from dampyr.report.figures.residual_velocity import residual_velocity
from dampyr.report.figures.response_spectrum import response_spectrum
from dampyr.report.figures.scores import scores
from dampyr.report.figures.theta import theta
from dampyr.report.page import page, write_page
from dampyr.report.style import save

__all__ = [
    "Block",
    "Cell",
    "Text",
    "Table",
    "FigureBlock",
    "Verdict",
    "Section",
    "page",
    "write_page",
    "save",
    "figure_files",
    "Law",
    "loops",
    "history",
    "parameters_against_input",
    "building_response",
    "controlled",
    "ground_motion",
    "ground_histories",
    "response_spectrum",
    "Fragile",
    "fragility_curves",
    "incremental_curves",
    "envelope",
    "planned_drive",
    "theta",
    "phase_portrait",
    "scores",
    "correlation",
    "strong_pairs",
    "calibrated",
    "peak_velocity_band",
    "band_used",
    "memory",
    "residual_sizes",
    "residual_velocity",
    "sentence",
]
