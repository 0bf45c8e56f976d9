"""The generated functions of parts side by side, as plain Python, beside differences of the forces that they derive."""

import math

import numpy as np
import pytest

from dampyr.models import compose
from dampyr.models.numerics import bouc_wen_exact

PIECE = (0.001, 0.0016, 0.04, 0.05, 0.013)  # x0, x1 m, v0, v1 m/s, dt s
MODELS = {
    "dahl + spring": [800.0, 50.0, 900.0, 700.0],
    "spring + dahl + hyperbolic_tangent": [700.0, 800.0, 50.0, 900.0, 10.0, 80.0, 0.03, 0.3],
    "bouc_wen + offset": [700.0, 900.0, 60.0, 800.0, 0.8, 1.7, 40.0],
}


def functions_of(model: str) -> dict[str, object]:
    names: dict[str, object] = {name: getattr(math, name) for name in ("exp", "log", "sqrt", "tanh", "copysign")}
    names |= {name: getattr(bouc_wen_exact, name) for name in vars(bouc_wen_exact) if not name.startswith("__")}
    exec(compose(model).source(), names)
    return names


def force_at_end(names: dict[str, object], piece: tuple[float, ...], p: np.ndarray, s: np.ndarray) -> float:
    """The states moved along a piece, and the force at its end."""
    s = s.copy()
    names["advance_site0"](s, *piece, p)  # type: ignore[operator]
    return float(names["force_site0"](s, piece[1], piece[3], 0.0, p))  # type: ignore[operator]


@pytest.mark.parametrize("model", MODELS)
def test_slopes_are_those_of_the_force_at_the_end_of_a_piece(model: str) -> None:
    names, p, s = functions_of(model), np.array(MODELS[model]), np.full(compose(model).n_states, 0.2)
    slopes = names["slopes_site0"](s, *PIECE, p)  # type: ignore[operator]
    for slope, place, step in zip(slopes, (1, 3), (1e-8, 1e-6), strict=True):
        up, down = (tuple(v + sign * step * (k == place) for k, v in enumerate(PIECE)) for sign in (1, -1))
        difference = (force_at_end(names, up, p, s) - force_at_end(names, down, p, s)) / (2 * step)
        assert slope == pytest.approx(difference, rel=1e-6)


@pytest.mark.parametrize("model", MODELS)
def test_tangents_carry_the_derivatives_by_parameters_and_states_along_a_piece(model: str) -> None:
    composition = compose(model)
    names, p, s = functions_of(model), np.array(MODELS[model]), np.full(composition.n_states, 0.2)
    width = p.size + s.size
    D, J, moved = np.zeros((s.size, width)), np.zeros(width), s.copy()
    D[:, p.size :] = np.eye(s.size)
    names["advance_tangents_site0"](moved, D, *PIECE, p)  # type: ignore[operator]
    names["jacobian_site0"](moved, D, PIECE[1], PIECE[3], 0.0, p, J)  # type: ignore[operator]
    for k in range(width):
        step = 1e-6 * (p[k] if k < p.size else 1.0)
        up, down = ((p + sign * step * (np.arange(p.size) == k), s + sign * step * (np.arange(s.size) + p.size == k))
                    for sign in (1, -1))  # fmt: skip
        difference = (force_at_end(names, PIECE, *up) - force_at_end(names, PIECE, *down)) / (2 * step)
        assert J[k] == pytest.approx(difference, rel=1e-5, abs=1e-7)
