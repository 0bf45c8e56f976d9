"""Lines for a browser: few points, every peak preserved."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import BaseModel, Field

from dampyr.show.figures.style import thin

POINTS = 1600  # of a line: about the columns of a wide screen
ZOOMED = 4000  # of a record's histories, which are zoomed into


class Line(BaseModel):
    """A line, SI; the points between its extremes are thinned."""

    x: list[float] = Field(description="(n,)")
    y: list[float] = Field(description="(n,)")


def line(x: ArrayLike, y: ArrayLike, points: int = POINTS) -> Line:
    """At most ``points`` points of a line."""
    few_x, few_y = thin(x, y, points)
    return Line(x=_short(few_x), y=_short(few_y))


def measured_and_modelled(
    t: ArrayLike, x: ArrayLike, v: ArrayLike, measured: NDArray[np.float64], model: NDArray[np.float64]
) -> dict[str, Any]:
    """The force of a record over time, displacement and velocity, measured and modelled, and the residual over time."""

    def both(over: ArrayLike) -> dict[str, Any]:
        return {"measured": line(over, measured).model_dump(), "model": line(over, model).model_dump()}

    return {
        "time": both(t),
        "displacement": both(x),
        "velocity": both(v),
        "residual": line(t, measured - model).model_dump(),
    }


def _short(values: NDArray[np.float64]) -> list[float]:
    """Six digits: more than a screen shows, and half the bytes."""
    return [float(f"{value:.6g}") for value in values]
