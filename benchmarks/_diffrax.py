"""The building of chapter 5 by diffrax: all histories side by side (vmap), compiled by XLA for one core, double precision.

Steps of one length serve diffrax better than its step control here: with histories side by side all of them wait for the one
with the shortest step, and what limits the step is how stiff the damper is at its fastest, not the accuracy asked for.
"""

from __future__ import annotations

import os
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks._suite import Case
from dampyr.structures import state_space, two_storey

Array = NDArray[np.float64]
ONE_CORE = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
LOOK = 0.002  # s between looks at the peaks; at most 0.06 % of a peak is missed at the second mode


def peaks(solver: str, cases: list[Case], m: int) -> Array:
    """(cases, 2): the peaks of the first floor and of the second storey's drift, with m steps to a sample."""
    n = max(len(case.acceleration) for case in cases)
    grounds = np.array([np.pad(case.acceleration, (0, n - len(case.acceleration))) for case in cases])
    dampers = np.array([case.damper for case in cases])
    return np.asarray(compiled(solver, n, cases[0].dt)(cases[0].dt / m, grounds, dampers))


def missing() -> str:
    """Why diffrax cannot run, or nothing."""
    try:
        _modules()
    except ImportError as error:
        return f"missing ({error}); pip install diffrax"
    return ""


@lru_cache(maxsize=1)
def _modules() -> tuple[Any, Any]:
    os.environ.setdefault("XLA_FLAGS", ONE_CORE)  # read when jax starts
    import diffrax
    import jax

    jax.config.update("jax_enable_x64", True)
    jax.config.update("jax_platforms", "cpu")
    return jax, diffrax


@lru_cache(maxsize=8)
def compiled(solver: str, n: int, dt: float) -> Any:
    """(step, (cases, n) ground accelerations, (cases, 3) dampers) -> (cases, 2)."""
    jax, diffrax = _modules()
    jnp, end = jax.numpy, (n - 1) * dt
    looks = jnp.linspace(0.0, end, round(end / LOOK) + 1)
    saved = diffrax.SaveAt(ts=looks, fn=lambda t, y, args: jnp.stack([y[0], y[1] - y[0]]))
    term = diffrax.ODETerm(partial(_rate, jnp, dt, _matrices(jnp)))

    def one(step: Any, ground: Any, damper: Any) -> Any:
        solution = diffrax.diffeqsolve(
            term,
            getattr(diffrax, solver)(),
            0.0,
            end,
            step,
            jnp.zeros(5),
            args=(ground, damper),
            saveat=saved,
            stepsize_controller=diffrax.ConstantStepSize(),
            adjoint=diffrax.ForwardMode(),
            max_steps=None,
            throw=False,
        )
        return jnp.max(jnp.abs(solution.ys), axis=0)

    return jax.jit(jax.vmap(one, in_axes=(None, 0, 0)))


def _matrices(jnp: Any) -> tuple[Any, Any, Any]:
    matrices = state_space(two_storey())
    return jnp.asarray(matrices.A), jnp.asarray(matrices.B[:, 0]), jnp.asarray(matrices.E)


def _rate(jnp: Any, dt: float, matrices: tuple[Any, Any, Any], t: Any, y: Any, args: Any) -> Any:
    (A, B, E), (ground, (kx, kw, rho)) = matrices, args
    at = t / dt
    i = jnp.clip(at.astype(int), 0, ground.shape[0] - 2)
    now = ground[i] + (ground[i + 1] - ground[i]) * (at - i)
    z, w = y[:4], y[4]
    moved = A @ z + B * (kx * z[2] + kw * w) + E * now
    return jnp.append(moved, rho * (z[2] - jnp.abs(z[2]) * w))
