"""Figures and pages for people.

A figure takes plain arrays in SI, shows them in the units people read (mm, N, s, V) and returns a matplotlib
``Figure``. A page is one self-contained HTML file: no network, light and dark, for paper and for a phone.

::

    figure = loops(record.displacement, record.velocity, record.force, {"viscous Dahl": predicted})
    html = page("A damper", [Section("Loops", [FigureBlock(figure, "measured, model")])])
    write_page("out/damper.html", html)
"""

from importlib import import_module
from typing import Any

from dampyr.figures.acceptance import band_used, peak_velocity_band
from dampyr.figures.autocorrelation import memory
from dampyr.figures.building import building_response
from dampyr.figures.calibration_range import calibrated
from dampyr.figures.control_comparison import controlled
from dampyr.figures.correlation import correlation, strong_pairs
from dampyr.figures.envelope import envelope
from dampyr.figures.fragility import Fragile, fragility_curves
from dampyr.figures.ground_histories import ground_histories
from dampyr.figures.ground_motion import ground_motion
from dampyr.figures.history import history
from dampyr.figures.incremental import incremental_curves
from dampyr.figures.laws import Law, parameters_against_input
from dampyr.figures.loops import loops
from dampyr.figures.phase_portrait import phase_portrait
from dampyr.figures.planned_drive import planned_drive
from dampyr.figures.residual_sizes import residual_sizes
from dampyr.figures.residual_velocity import residual_velocity
from dampyr.figures.response_spectrum import response_spectrum
from dampyr.figures.scores import scores
from dampyr.figures.style import save
from dampyr.figures.theta import theta
from dampyr.report.blocks import Block, Cell, FigureBlock, Section, Table, Text, Verdict
from dampyr.report.how_made import made_by
from dampyr.report.html_page import page, write_page
from dampyr.report.saved_figures import figure_files
from dampyr.representation import sentence

WRITERS = {
    "write_fit_page": "fit_page",
    "write_validate_page": "validate_page",
    "write_acceptance_page": "acceptance_page",
    "write_response_page": "response_page",
    "write_ensemble_page": "ensemble_page",
    "write_motion_page": "motion_page",
    "write_plan_page": "plan_page",
    "write_hybrid_page": "hybrid_page",
}
"""The writers of whole pages and their modules, loaded when they are used: each needs the package whose result it shows."""


def __getattr__(name: str) -> Any:
    if name not in WRITERS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{WRITERS[name]}"), name)


__all__ = [
    *WRITERS,
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
    "made_by",
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
