"""Synthetic records whose truth is known, and the published ones."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from dampyr.records import Record, read_campaign


@pytest.fixture(scope="session")
def published(campaign_folder: Path) -> list[Record]:
    """All records of the published campaign, read once: what is worked out of a record is kept with it."""
    return read_campaign(campaign_folder, role=None)


@pytest.fixture(scope="session")
def published_fits(published: list[Record]) -> list[Record]:
    """Those of them that are for fits."""
    return [record for record in published if record.role == "fit"]


@pytest.fixture
def make_sine() -> Callable[..., Record]:
    """A factory of tests on a quantised sine after a rest; the keywords say what is wrong with it."""

    def make(
        amplitude: float = 0.010,
        frequency: float = 0.9,
        rest: float = 2.0,
        duration: float = 15.0,
        dt: float = 0.01,
        drift: float = 0.0,
        third: float = 0.0,
        quantum: float = 5e-6,
        noise: float = 0.0,
        offset: float = 120.0,
        viscous: float = 3000.0,
        lag: float = 0.0,
        seed: int = 1,
        **fields: object,
    ) -> Record:
        t = dt * np.arange(round(duration / dt) + 1)
        omega = 2 * np.pi * frequency
        phase = np.maximum(t - rest, 0.0) * omega
        x = amplitude * (np.sin(phase) + third * np.sin(3 * phase)) + drift * np.maximum(t - rest, 0.0)
        x = x + noise * np.random.default_rng(seed).standard_normal(len(t))
        late = (t - rest - lag) * omega
        v = amplitude * omega * (np.cos(late) + 3 * third * np.cos(3 * late)) * (late >= 0)
        x = np.round(x / quantum) * quantum if quantum else x
        return Record(time=t, displacement=x, force=offset + viscous * v, **fields)

    return make
