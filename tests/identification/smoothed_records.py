"""Records whose force went through a moving average, declared so."""

import numpy as np
from tests.identification.search.test_normal_equations import LAWS, VOLTS
from tests.identification.synthetic import sine

from dampyr.models import Damper
from dampyr.records import Declaration, Record, with_smoothing

SAMPLES = 21  # of 200 a second: about a tenth of the period


def smoothed(record: Record, samples: int = SAMPLES, trailing: bool = False, motion: bool = False) -> Record:
    """The record with its force averaged, window by window, and declared so."""
    before, after = (samples - 1, 0) if trailing else (samples // 2, (samples - 1) // 2)

    def mean(values: np.ndarray) -> np.ndarray:
        return np.array([values[max(i - before, 0) : i + after + 1].mean() for i in range(values.size)])

    channels = ("displacement", "velocity", "force") if motion else ("force",)
    made = record.replace(note="", **{c: mean(getattr(record, c)) for c in channels})
    return with_smoothing(made, Declaration(samples=samples, trailing=trailing, channels=channels, undo=False))


def records(noise: float = 0.0, count: int = 2) -> list[Record]:
    damper = Damper("dahl", LAWS)
    return [
        sine(damper, u, f"{u:g}-{k}", 0.004 + 0.003 * k, 1.0 - 0.2 * k, noise, seed=k)
        for u in VOLTS
        for k in range(count)
    ]
