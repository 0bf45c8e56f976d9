"""Figures show what they are given, in the units that people read."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from dampyr import show
from dampyr.errors import InputError
from dampyr.show.figures.acceptance import band_used, peak_velocity_band
from dampyr.show.figures.autocorrelation import memory
from dampyr.show.figures.building import building_response
from dampyr.show.figures.calibration_range import calibrated
from dampyr.show.figures.control_comparison import controlled
from dampyr.show.figures.correlation import correlation, strong_pairs
from dampyr.show.figures.envelope import envelope
from dampyr.show.figures.expected_widths import expected_widths
from dampyr.show.figures.fragility import Fragile, fragility_curves
from dampyr.show.figures.ground_histories import ground_histories
from dampyr.show.figures.ground_motion import ground_motion
from dampyr.show.figures.history import history
from dampyr.show.figures.incremental import incremental_curves
from dampyr.show.figures.laws import LawPanel, parameters_against_input
from dampyr.show.figures.loops import loops
from dampyr.show.figures.phase_portrait import phase_portrait
from dampyr.show.figures.planned_drive import planned_drive
from dampyr.show.figures.planned_tests import planned_tests
from dampyr.show.figures.residual_sizes import residual_sizes
from dampyr.show.figures.residual_velocity import residual_velocity
from dampyr.show.figures.response_spectrum import response_spectrum
from dampyr.show.figures.scores import scores
from dampyr.show.figures.style import ACCELERATION, Axis
from dampyr.show.figures.theta import theta
from dampyr.show.pages.svg import inline_svg

T = np.linspace(0.0, 4.0, 401)
X = 0.012 * np.sin(2 * np.pi * 0.5 * T)
V = np.gradient(X, T)
F = 1000.0 * V + 200.0 * np.sign(V)
KW = Axis("kw", "N")
RHO = Axis("ρ", "1/mm", 1e-3)
LAWS = [
    LawPanel(KW, (T, 100.0 * T), ([0.0, 2.0], [10.0, 190.0]), [5.0, np.inf]),
    LawPanel(RHO, (T, 4e4 - T), others={"published": ([0.0], [42744.8])}),
    LawPanel(KW),
]
POINTS = {"0 V": ([0.5, 1.2], [0.02, 0.008]), "1 V": ([np.nan], [0.01])}
RANGES = {"displacement": (0.0, 0.02), "velocity": (0.0, 0.07), "frequency": (0.5, 1.2)}

GRID = np.linspace(0.1, 9.0, 50)
FRAGILE = {
    "0 V": Fragile(GRID, GRID / 9.0, (GRID / 10.0, GRID / 8.0), ([1.0, 5.0], [0.2, 0.5])),
    "no curve": Fragile(GRID, None, None, ([1.0, 5.0], [0.0, 0.0])),
}
BAND = [[0.04, 100.0, 85.0, 115.0], [0.08, 150.0, 127.5, 172.5]]
PLANNED = {"sine": ([0.5, 1.0], [0.01, 0.008]), "random": ([0.3], [0.02])}
SWEEPS = (
    np.array([[1.0, 2.0, 3.0]] * 3),
    np.array([[0.01, 0.03, 0.02], [0.01, 0.02, 0.03], [0.02, 0.05, np.nan]]),
    [1, 2, 3],
)

MAKERS: dict[str, Callable[[], Figure]] = {
    "loops": lambda: loops(X, V, F, {"Dahl": 0.9 * F}, title="Loops"),
    "loops_without_velocity": lambda: loops(X, None, None, {"Dahl": F, "tanh": 0.8 * F}),
    "history": lambda: history(T, F, 0.9 * F, name="Dahl"),
    "history_measured_only": lambda: history(T, F),
    "laws": lambda: parameters_against_input(LAWS, (0.0, 3.212)),
    "planned_tests": lambda: planned_tests(
        [0.4, 4.0],
        {"0 V": [0.03, 0.002], "3.2 V": [0.02, 0.001]},
        [(0.4, 0.01), (1.0, 0.005)],
        {"sine": [(1.0, 0.005), (1.0, 0.005)], "voltage steps": [(0.4, 0.01)]},
    ),
    "expected_widths": lambda: expected_widths({"round 1": [(0.02, 0.022), (0.01, 0.008)], "round 2": [(0.01, 0.012)]}),
    "one_law": lambda: parameters_against_input(LAWS[:1]),
    "building": lambda: building_response(T, {"no damper": X, "0 V": 0.5 * X}),
    "controlled": lambda: controlled(T, {"0 V": X, "on_off": 0.5 * X}, {"on_off": 1.5 + np.sign(V)}),
    "motion": lambda: ground_motion(T, 3.1266 * np.cos(T)),
    "ground": lambda: ground_histories(T, 3.0 * np.cos(T), V, X),
    "spectrum": lambda: response_spectrum(T[4:], {"2 %": X[4:] + 0.02, "5 %": 0.5 * X[4:] + 0.02}),
    "fragility": lambda: fragility_curves(FRAGILE),
    "incremental": lambda: incremental_curves(*SWEEPS, {"50 %": SWEEPS[1][1], "84 %": [1.0, np.inf, np.inf]}),
    "envelope": lambda: envelope(GRID, {"0 N": 0.01 / GRID, "500 N": 0.008 / GRID}, PLANNED, ([5.0], [0.01])),
    "envelope_of_one_kind": lambda: envelope(GRID, {"0 N": 0.01 / GRID}, {"sine": ([1.0], [0.008])}),
    "planned_drive": lambda: planned_drive(T, X, 1.0 * (T > 2.0)),
    "theta": lambda: theta(X, F, {"x*": (0.0, 0.0)}, (X, F)),
    "phase": lambda: phase_portrait(Axis("x", "1"), Axis("z", "1"), {"z": (X, V)}, {"bound": 0.5}),
    "memory": lambda: memory([(T, np.exp(-T)), (T[:200], np.cos(9 * T[:200]))], 0.31),
    "sizes": lambda: residual_sizes({"0 V": ([0, 0], [0.02, 0.01], [1, np.nan], [0.1, 0.2])}),
    "velocity": lambda: residual_velocity({f"{u} V": {"before": (T, -T, T, 2 * T)} for u in range(3)}),
    "calibrated": lambda: calibrated(POINTS, RANGES),
    "calibrated_without_damper": lambda: calibrated(POINTS),
    "peak_velocity": lambda: peak_velocity_band(
        [BAND, []], {True: ([0.05], [110.0]), False: ([0.06], [90.0]), None: ([0.09], [160.0])}
    ),
    "used": lambda: band_used({"a": {"extension": [0.2, 1.4], "energy": [-1.2]}, "b": {"compression": [0.1]}}),
    "scores": lambda: scores({"0 V": [0.05, 0.1], "1.98 V": [0.12]}, {"published": {"0 V": 0.109}}),
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


def test_control_shows_answers_and_below_them_the_inputs_of_the_laws() -> None:
    top, below = MAKERS["controlled"]().axes
    np.testing.assert_allclose(top.lines[2].get_ydata(), 500.0 * X)
    np.testing.assert_allclose(below.lines[0].get_ydata(), 1.5 + np.sign(V))
    assert below.lines[0].get_color() == top.lines[2].get_color()
    assert [text for text in lines(top.figure) if "mm" in text] == ["0 V: 12 mm", "on_off: 6 mm"]
    assert (top.get_ylabel(), below.get_ylabel()) == ("displacement [mm]", "voltage [V]")


def test_points_outside_a_band_differ_from_those_inside_by_their_shape() -> None:
    fig = MAKERS["peak_velocity"]()
    by_label = {str(line.get_label()): line for line in fig.axes[0].lines}
    assert [(words, by_label[words].get_marker()) for words in ("inside", "outside", "not judged")] == [
        ("inside", "o"), ("outside", "X"), ("not judged", "s"),
    ]  # fmt: skip
    np.testing.assert_allclose(by_label["outside"].get_xydata(), [[60.0, 90.0]])
    np.testing.assert_allclose(by_label["reference"].get_xydata()[1:-1], [[40.0, 100.0], [80.0, 150.0]])
    (fill,) = fig.axes[0].collections
    corners = {tuple(np.round(corner, 3)) for corner in fill.get_paths()[0].vertices}
    assert {(40.0, 85.0), (40.0, 115.0), (80.0, 127.5), (80.0, 172.5)} <= corners
    used = [line for line in MAKERS["used"]().axes[0].lines if line.get_marker() not in ("", "None")]
    assert {str(line.get_label()) for line in used if line.get_markerfacecolor() == "none"} == {
        "extension, outside", "energy, outside",
    }  # fmt: skip


def test_the_residual_is_measured_less_model() -> None:
    residual = MAKERS["history"]().axes[1]
    np.testing.assert_allclose(residual.lines[0].get_ydata(), 0.1 * F)
    low, high = residual.get_ylim()
    assert low <= np.min(0.1 * F)
    assert high >= np.max(0.1 * F)


def test_peaks_of_a_building_are_told() -> None:
    by_label = lines(MAKERS["building"]())
    assert "no damper: 12 mm" in by_label
    assert "0 V: 6 mm" in by_label


def test_the_peak_of_a_motion_is_told_in_g() -> None:
    assert "peak 3.127 m/s² = 0.3188 g at 0 s" in lines(MAKERS["motion"]())


def test_a_ground_motion_is_shown_three_times_in_mm_and_s() -> None:
    acceleration, velocity, displacement = MAKERS["ground"]().axes
    np.testing.assert_allclose(velocity.lines[0].get_ydata(), 1e3 * V)
    np.testing.assert_allclose(displacement.lines[0].get_ydata(), 1e3 * X)
    assert acceleration.get_title(loc="left") == "largest sample 3 m/s² at 0 s"
    assert velocity.get_ylabel() == "velocity [mm/s]"


def test_a_spectrum_tells_its_peak_and_shows_its_periods() -> None:
    fig = MAKERS["spectrum"]()
    assert "2 %: 0.032 m/s² at 0.5 s" in lines(fig)
    assert [label.get_text() for label in fig.axes[0].get_xticklabels()] == ["0.05", "0.1", "0.2", "0.5", "1", "2"]


def test_the_calibrated_box_and_the_greatest_speed_are_in_mm_and_hz() -> None:
    fig = MAKERS["calibrated"]()
    (box,) = fig.axes[0].patches
    assert box.get_bbox().bounds == pytest.approx((0.5, 0.0, 0.7, 20.0))
    by_label = lines(fig)
    np.testing.assert_allclose(by_label["0 V"], [[0.5, 1.2], [20.0, 8.0]])
    f, amplitude = by_label["greatest speed, 70 mm/s"]
    np.testing.assert_allclose(2 * np.pi * f * amplitude, 70.0)


def test_the_mean_memory_is_over_the_records_that_have_the_lag() -> None:
    lag, mean = lines(MAKERS["memory"]())["mean"]
    np.testing.assert_allclose(mean[lag < 1.9], 0.5 * (np.exp(-T) + np.cos(9 * T))[T < 1.9], atol=1e-12)
    np.testing.assert_allclose(mean[lag > 2.0], np.exp(-T[T > 2.0]), atol=1e-12)


MATRIX = np.array([[1.0, -0.95, np.nan], [-0.95, 1.0, 0.4], [np.nan, 0.4, 1.0]])


def test_a_correlation_is_a_cell_below_the_diagonal() -> None:
    fig = correlation(MATRIX, ["a", "b", "c"])
    panel = fig.axes[0]
    cells = {(round(p.get_x() + 0.46), round(p.get_y() + 0.46)): p for p in panel.patches}
    assert set(cells) == {(0, 1), (1, 2)}, "column, row; the unknown one has no colour"
    negative, positive = cells[0, 1], cells[1, 2]
    assert negative.get_facecolor()[0] > negative.get_facecolor()[2]
    assert positive.get_facecolor()[2] > positive.get_facecolor()[0]
    assert negative.get_alpha() > positive.get_alpha()
    assert [text.get_text() for text in panel.texts] == ["−.95", "–", ".40"]
    svg = inline_svg(fig, "correlation", "f1")
    assert set(re.findall(r"(?:fill|stroke): (#\w+)", svg)) <= {"#ffffff"}
    assert "<image" not in svg


@pytest.mark.parametrize("m", [2, 10, 28, pytest.param(60, marks=pytest.mark.prove)])
def test_names_beside_a_correlation_stay_inside_the_figure(m: int) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    fig = correlation(np.full((m, m), -0.95), [f"hyperbolic_tangent.v0 @ 0.{k:04d} V" for k in range(m)])
    FigureCanvasAgg(fig).draw()
    boxes = [label.get_window_extent() for label in fig.axes[0].get_yticklabels()]
    assert min(box.x0 for box in boxes) >= 0.0
    assert max(box.x1 for box in boxes) <= fig.bbox.x1


def test_strong_pairs_come_by_strength_and_unknown_ones_not_at_all() -> None:
    assert strong_pairs(MATRIX, "abc", 0.3) == [("a", "b", -0.95), ("b", "c", 0.4)]
    assert strong_pairs(MATRIX, "abc") == [("a", "b", -0.95)]
    with pytest.raises(InputError, match=r"shape \(3, 3\) for 2 names"):
        correlation(MATRIX, ["a", "b"])


def test_an_axis_scales_from_si() -> None:
    assert RHO.of(42744.8) == pytest.approx(42.7448)
    assert ACCELERATION.label == "acceleration [m/s²]"


def test_a_figure_can_be_a_file(tmp_path: Path) -> None:
    for kind in ("svg", "png", "pdf"):
        assert show.save(MAKERS["theta"](), tmp_path / "deep" / f"theta.{kind}").stat().st_size > 1000


def test_a_fragility_is_in_g_and_per_cent_and_one_without_a_curve_shows_its_points() -> None:
    fig = fragility_curves(FRAGILE)
    x, y = lines(fig)["0 V"]
    np.testing.assert_allclose((x[-1], y[-1]), (9.0 / 9.80665, 100.0))
    x, y = lines(fig)["no curve"]
    np.testing.assert_allclose(x, np.array([1.0, 5.0]) / 9.80665)
    np.testing.assert_array_equal(y, 0.0)
    [band] = fig.axes[0].collections
    assert band.get_paths()[0].get_extents().y1 == pytest.approx(100.0 * 9.0 / 8.0)


def test_an_incremental_curve_is_intensity_over_peak_as_it_is() -> None:
    fig = incremental_curves(*SWEEPS, {"50 %": [0.01, 0.02, np.inf]}, limits={"limit": 0.02}, furthest=0.04)
    [axes] = fig.axes
    np.testing.assert_allclose(axes.lines[0].get_xdata(), [10.0, 30.0, 20.0])
    np.testing.assert_allclose(axes.lines[0].get_ydata(), np.array([1.0, 2.0, 3.0]) / 9.80665)
    np.testing.assert_array_equal(lines(fig)["50 %"][0], [10.0, 20.0, np.nan])
    np.testing.assert_allclose(lines(fig)["limit"][0], 20.0)
    assert axes.get_xlim() == pytest.approx((0.0, 40.0))


def test_an_envelope_is_in_mm_over_hz_and_crosses_out_what_is_refused() -> None:
    fig = envelope(GRID, {"0 N": 0.01 / GRID}, PLANNED, ([5.0], [0.012]))
    [axes] = fig.axes
    lines = axes.get_lines()
    np.testing.assert_allclose(lines[0].get_ydata(), 10.0 / GRID)
    np.testing.assert_allclose(lines[1].get_xydata(), [[0.5, 10.0], [1.0, 8.0]])
    assert (lines[-1].get_marker(), lines[-1].get_ydata()[0]) == ("x", 12.0)
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")


def test_a_planned_drive_shows_the_speed_between_its_set_points() -> None:
    fig = planned_drive(T, X, np.ones_like(T))
    speed = fig.axes[1].get_lines()[0].get_ydata()
    assert np.abs(speed).max() == pytest.approx(12.0 * np.pi, rel=1e-3)
