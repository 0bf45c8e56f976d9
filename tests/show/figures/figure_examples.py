"""Small examples of figures: what is drawn in them is known in closed form."""

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from dampyr.show.figures.acceptance import band_used, peak_velocity_band
from dampyr.show.figures.autocorrelation import memory
from dampyr.show.figures.building import building_response
from dampyr.show.figures.calibration_range import calibrated
from dampyr.show.figures.control_comparison import controlled
from dampyr.show.figures.corner import corner
from dampyr.show.figures.envelope import envelope
from dampyr.show.figures.expected_widths import expected_widths
from dampyr.show.figures.failed_loops import FailedLoop, failed_loops
from dampyr.show.figures.floor_loads import floor_loads
from dampyr.show.figures.fragility import Fragile, fragility_curves
from dampyr.show.figures.ground_histories import ground_histories
from dampyr.show.figures.ground_motion import ground_motion
from dampyr.show.figures.history import history
from dampyr.show.figures.incremental import incremental_curves
from dampyr.show.figures.laws import LawPanel, parameters_against_input
from dampyr.show.figures.loops import loops
from dampyr.show.figures.loops_and_history import loops_and_history
from dampyr.show.figures.loops_by_case import loops_by_case
from dampyr.show.figures.phase_portrait import phase_portrait
from dampyr.show.figures.planned_drive import planned_drive
from dampyr.show.figures.planned_tests import planned_tests
from dampyr.show.figures.published_beside_ours import published_beside_ours
from dampyr.show.figures.residual_sizes import residual_sizes
from dampyr.show.figures.residual_velocity import residual_velocity
from dampyr.show.figures.response_spectrum import response_spectrum
from dampyr.show.figures.scores import scores
from dampyr.show.figures.style import Axis
from dampyr.show.figures.theta import theta

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
    "corner": lambda: corner(
        {"kw": T, "ρ": 1e4 * np.sin(T), "kx": X}, {"kw": KW, "ρ": RHO, "kx": KW}, {"kw": 1.0, "ρ": 0.0, "kx": 0.0}
    ),
    "loads": lambda: floor_loads(T, {"1": 30.0 * np.cos(T), "roof": 80.0 * np.sin(T)}),
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
    "failed": lambda: failed_loops(
        {"a": FailedLoop(V, F, [(0.03, 250.0, 100.0, 200.0)]), "b": FailedLoop(V, 0.5 * F, [])}
    ),
    "by_case": lambda: loops_by_case({"0 V": (X, F), "on_off 0 to 3.2 V, lag 0.01 s": (0.5 * X, 2.0 * F)}),
    "loops_and_history": lambda: loops_and_history(T, X, V, F, 0.9 * F, 2.0, "Dahl"),
    "published": lambda: published_beside_ours(
        {
            "Table 1": [(0.0002, "agrees"), (-0.12, "differs")],
            "(2)": [(0.0, "agrees")],
            "Figure 3": [(900.0, "differs")],
        }
    ),
    "scores": lambda: scores({"0 V": [0.05, 0.1], "1.98 V": [0.12]}, {"published": {"0 V": 0.109}}),
}


def lines(fig: Figure) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Label -> (x, y) of every named line."""
    return {str(line.get_label()): (line.get_xdata(), line.get_ydata()) for ax in fig.axes for line in ax.lines}
