"""A record of a specimen, made by its closed form."""

from collections.abc import Mapping

import numpy as np

from dampyr.records import Record
from dampyr.records.record import Label

T = np.arange(0.0, 6.0, 0.005)


def specimen_record(specimen: str, name: str, day: str, size: float = 1.0, **provenance: str) -> Record:
    """A viscous damper of 1000 N s/m times ``size`` at 10 mm and 1 Hz: 62.83 N at peak velocity, 1.974 J a cycle."""
    w, a = 2.0 * np.pi, 0.01
    v = a * w * np.cos(w * T)
    stated: Mapping[str, str] = {"started": f"{day}T10:00:00+00:00", "operator": "A. Person", "rig": '{"name": "lab"}'}
    return Record(
        T, a * np.sin(w * T), 1000.0 * size * v, velocity=v, voltage=1.0, name=name, label=Label(0.02, 1.0),
        specimen=specimen, provenance={**stated, **provenance},
    )  # fmt: skip
