"""Figures show what they are given, in the units that people read."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from dampyr import report
from dampyr.report.style import ACCELERATION, Axis
from dampyr.report.svg import inline_svg

T = np.linspace(0.0, 4.0, 401)
X = 0.012 * np.sin(2 * np.pi * 0.5 * T)
V = np.gradient(X, T)
F = 1000.0 * V + 200.0 * np.sign(V)
KW = Axis("kw", "N")
RHO = Axis("ρ", "1/mm", 1e-3)
LAWS = [
    report.Law(KW, (T, 100.0 * T), ([0.0, 2.0], [10.0, 190.0]), [5.0, np.inf]),
    report.Law(RHO, (T, 4e4 - T), others={"published": ([0.0], [42744.8])}),
    report.Law(KW),
]

MAKERS: dict[str, Callable[[], Figure]] = {
    "loops": lambda: report.loops(X, V, F, {"Dahl": 0.9 * F}, title="Loops"),
    "loops_without_velocity": lambda: report.loops(X, None, None, {"Dahl": F, "tanh": 0.8 * F}),
    "history": lambda: report.history(T, F, 0.9 * F, name="Dahl"),
    "history_measured_only": lambda: report.history(T, F),
    "laws": lambda: report.parameters_against_input(LAWS, (0.0, 3.212)),
    "one_law": lambda: report.parameters_against_input(LAWS[:1]),
    "building": lambda: report.building_response(T, {"no damper": X, "0 V": 0.5 * X}),
    "motion": lambda: report.ground_motion(T, 3.1266 * np.cos(T)),
    "theta": lambda: report.theta(X, F, {"x*": (0.0, 0.0)}, (X, F)),
    "phase": lambda: report.phase_portrait(Axis("x", "1"), Axis("z", "1"), {"z": (X, V)}, {"bound": 0.5}),
    "scores": lambda: report.scores({"0 V": [0.05, 0.1], "1.98 V": [0.12]}, {"published": {"0 V": 0.109}}),
}


def lines(fig: Figure) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Label -> (x, y) of every named line."""
    return {str(line.get_label()): (line.get_xdata(), line.get_ydata()) for ax in fig.axes for line in ax.lines}


@pytest.mark.parametrize("name", MAKERS)
def test_a_figure_draws_and_has_a_unit_on_every_axis(name: str) -> None:
    fig = MAKERS[name]()
    assert inline_svg(fig, name, "f1").startswith("<svg")
    shown = [ax for ax in fig.axes if ax.axison]
    assert shown
    for ax in shown:
        if ax.get_xlabel():
            assert ax.get_xlabel().endswith("]")
        if name != "scores" and ax.get_ylabel():
            assert ax.get_ylabel().endswith("]")
    assert any(ax.get_xlabel() for ax in shown)


@pytest.mark.parametrize("name", MAKERS)
def test_a_figure_follows_the_page(name: str) -> None:
    """Only variables for colours: a fixed one would vanish on a dark page."""
    svg = inline_svg(MAKERS[name](), name, "f1")
    fixed = set(re.findall(r"(?:fill|stroke): (#\w+)", svg))
    assert fixed <= {"#ffffff"}
    assert "<text" in svg
    assert "<image" not in svg


def test_loops_are_in_mm_and_mm_per_s() -> None:
    fig = MAKERS["loops"]()
    left, right = fig.axes
    np.testing.assert_allclose(left.lines[0].get_xdata(), 1e3 * X)
    np.testing.assert_allclose(right.lines[0].get_xdata(), 1e3 * V)
    np.testing.assert_allclose(left.lines[1].get_ydata(), 0.9 * F)
    assert left.get_xlabel() == "displacement [mm]"
    assert right.get_xlabel() == "velocity [mm/s]"
    assert left.get_ylabel() == "force [N]"


def test_the_residual_is_measured_less_model() -> None:
    residual = MAKERS["history"]().axes[1]
    np.testing.assert_allclose(residual.lines[0].get_ydata(), 0.1 * F)
    low, high = residual.get_ylim()
    assert low <= np.min(0.1 * F)
    assert high >= np.max(0.1 * F)


def test_peaks_of_a_building_are_told() -> None:
    known = lines(MAKERS["building"]())
    assert "no damper: 12 mm" in known
    assert "0 V: 6 mm" in known


def test_the_peak_of_a_motion_is_told_in_g() -> None:
    assert "peak 3.127 m/s² = 0.3188 g at 0 s" in lines(MAKERS["motion"]())


def test_an_axis_scales_from_si() -> None:
    assert RHO.of(42744.8) == pytest.approx(42.7448)
    assert ACCELERATION.label == "acceleration [m/s²]"


def test_a_figure_can_be_a_file(tmp_path: Path) -> None:
    for kind in ("svg", "png", "pdf"):
        assert report.save(MAKERS["theta"](), tmp_path / "deep" / f"theta.{kind}").stat().st_size > 1000
