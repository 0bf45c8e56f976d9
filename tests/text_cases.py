"""What people bring on the first day, made again: tests of a Dahl damper and ground motions in the dialects of the field.

The damper has kx = 1.2 N s/mm, kw = 200 N and rho = 2 /mm, and moves by 10 mm at 1 Hz: in the steady state its loop encloses
pi kx w A^2 + 4 kw (A - tanh(rho A)/rho), 9.969 J. The ground motion has 1203 samples of 0.01 s and peaks at 0.35043 g.
"""

from __future__ import annotations

import math

import numpy as np

A, KX, KW, RHO, W = 10.0, 1.2, 200.0, 2.0, 2 * math.pi  # mm, N s/mm, N, 1/mm, rad/s
ENERGY = 1e-3 * (math.pi * KX * W * A**2 + 4 * KW * (A - math.tanh(RHO * A) / RHO))  # J
PGA = 0.35043  # g
DT, SAMPLES = 0.01, 1203


def damper(cycles: int = 6, times: np.ndarray | None = None) -> np.ndarray:
    """Time in s, displacement in mm, velocity in mm/s and force in N ``(n, 4)``, 200 samples a cycle or at ``times``."""
    t = 0.005 * np.arange(200 * cycles) if times is None else times
    x, v = A * np.sin(W * t), A * W * np.cos(W * t)
    way = np.where(v >= 0, x + A, A - x)  # since the last reversal, along which w goes from -w1 to w1
    w = np.sign(v) * (1.0 - (1.0 + math.tanh(RHO * A)) * np.exp(-RHO * way))
    w[v == 0] = np.sign(x[v == 0]) * math.tanh(RHO * A)
    return np.column_stack([t, x, v, KX * v + KW * w])


def table(columns: list[str], rows: np.ndarray, formats: list[str], delimiter: str = ",") -> str:
    """Lines of names, and of numbers."""
    lines = [delimiter.join(form.format(value) for form, value in zip(formats, row, strict=True)) for row in rows]
    return "\n".join([*columns, *lines]) + "\n"


def european(text: str) -> str:
    """Points as commas, and commas as points."""
    return text.translate(str.maketrans(".,", ",."))


def ground() -> np.ndarray:
    """A ground motion (n,) in g, of 5 decimals."""
    t = DT * np.arange(SAMPLES)
    a = (
        np.sin(7.0 * t) * np.exp(-0.5 * ((t - 4.0) / 1.5) ** 2)
        + 0.3 * np.sin(23.0 * t) * np.exp(-0.2 * t)
        + 0.01 * np.sin(t)
    )
    return np.round(PGA * a / np.max(np.abs(a)), 5)


def in_rows(values: list[str], per_line: int, end: str = "\n") -> str:
    """Values in lines of so many, the last one short."""
    return "".join("".join(values[k : k + per_line]) + end for k in range(0, len(values), per_line))
