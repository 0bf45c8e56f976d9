"""One block of histories of an engine, without what an ensemble does around it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from dampyr.ground_motions import GroundMotion
from dampyr.models import Damper
from dampyr.structures.batch.engine import Engine, engine
from dampyr.structures.building import Building
from dampyr.structures.sites import connections, make_sites


@dataclass(frozen=True)
class Block:
    """Histories under one motion at scales from 0.5 to 1.5, the damper in storey 1."""

    engine: Engine
    run: Callable[[], Any]
    steps: int  # of all histories together


def block(
    building: Building,
    motion: GroundMotion,
    damper: Damper,
    voltage: float,
    m: int,
    quantities: tuple[str, ...] = ("displacement", "drift"),
    precision: int = 64,
) -> Block:
    """A block with m steps to a sample."""
    sites = make_sites(building, {1: damper}, voltage, None, False)
    rows = connections(building, sites)
    made = engine(building, rows, tuple(site.composition for site in sites), motion.dt, m, quantities, precision)
    width = made.text.block_width
    grounds, scales = [motion.acceleration] * width, np.linspace(0.5, 1.5, width)
    values = [np.tile(site.values, (width, 1)) for site in sites]
    rest = np.zeros((width, len(sites)))
    steps = width * m * (len(motion.acceleration) - 1)
    return Block(made, lambda: made.run(grounds, values, rest, scales=scales), steps)
