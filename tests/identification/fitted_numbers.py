"""The numbers of Dahl's model and of its fit, and records with gains of their own."""

import numpy as np
from tests.identification.synthetic import sine

from dampyr.models import Damper
from dampyr.records import Record

NUMBERS = np.array([900.0, 70.0, 2500.0])


def values(fit_result) -> np.ndarray:
    return np.array(list(fit_result.parameters.values()))


def gained(gains: list[float], viscosities: list[float]) -> list[Record]:
    records = []
    for k, (gain, warmth) in enumerate(zip(gains, viscosities, strict=True)):
        laws = {"dahl.kx": 900.0 * warmth, "dahl.kw": 70.0, "dahl.rho": 2500.0}
        record = sine(
            Damper("dahl", laws), 0.0, f"r{k}", 0.006 + 0.001 * k, 1.2 - 0.1 * k, noise=0.5, seed=k, offset=0.0
        )
        records.append(record.replace(note="its own gain", force=gain * record.force + 100.0 + k))
    return records
