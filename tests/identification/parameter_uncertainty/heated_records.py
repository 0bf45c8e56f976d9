"""Records of a damper that weakens as it dissipates energy."""

import math

import numpy as np

from dampyr.records import Record

RATE, TIME_CONSTANT = -1.5e-3, 30.0  # 1/J and s: the median of the simulated records below ends 10 % weaker


def heated(record: Record, rate: float = RATE, time_constant: float = TIME_CONSTANT) -> Record:
    """The record with its dynamic force times exp(rate H), dH/dt = force times velocity - H/time_constant, sample by sample."""
    mean = float(np.mean(record.force))
    assert record.velocity is not None
    energy, dt, levels = 0.0, record.dt, [1.0]
    for force, velocity in zip((record.force - mean).tolist()[:-1], record.velocity.tolist()[:-1], strict=True):
        energy += dt * (levels[-1] * force * velocity - energy / time_constant)
        levels.append(math.exp(rate * energy))
    return record.replace(note="heated up", force=mean + np.array(levels) * (record.force - mean))
