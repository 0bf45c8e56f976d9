"""A damper of each composition."""

from __future__ import annotations

from dampyr.models import Damper
from dampyr.models.codegen.composition import compose

HELD = {
    "dahl.kx": 1400.0, "dahl.kw": 227.0, "dahl.rho": 18800.0, "delay.tau": 0.007, "compliance.s": 5e-7, "inertia.m": 3.0,
    "hyperbolic_tangent.c": 1500.0, "hyperbolic_tangent.ft": 200.0, "hyperbolic_tangent.v0": 0.0032, "spring.k0": 900.0,
    "hyperbolic_tangent.s": 0.13, "bouc_wen.c0": 1400.0, "bouc_wen.k0": 500.0, "bouc_wen.kw": 227.0, "bouc_wen.rho": 18800.0,
    "bouc_wen.sigma": 0.8, "bouc_wen.n": 1.5, "free_play.g": 4e-4, "free_play.fc": 20.0,
    "hysteretic_biviscous.c": 1400.0, "hysteretic_biviscous.fy": 200.0, "hysteretic_biviscous.vy": 0.004,
    "hysteretic_biviscous.vh": 0.003, "sigmoid.ft": 200.0, "sigmoid.c": 1500.0, "sigmoid.vk": 0.004, "sigmoid.vh": 0.003,
}  # fmt: skip


def of(name: str) -> Damper:
    return Damper(name, {key: HELD[key] for key in compose(name).parameters})
