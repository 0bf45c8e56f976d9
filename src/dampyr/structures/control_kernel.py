"""What the kernel under control laws needs of them: their gains, their clocks, and the laws of the parameters as tables."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.models.laws import polynomial_table
from dampyr.structures.connection import describe_place
from dampyr.structures.control_law import lag_of, settings
from dampyr.structures.sites import Site
from dampyr.structures.workspace import Control

Array = NDArray[np.float64]


def control(sites: tuple[Site, ...], kinds: list[int], gains: Array, step: float) -> Control:
    """The laws of the sites for steps of ``step`` seconds; ``kinds`` and ``gains`` (N, 2n + 1) as the kernel knows them."""
    count, tables = len(sites), [polynomial_table(site.damper, static=False) for site in sites]
    max_settings = max(1, *(len(settings(site.law)) for site in sites if site.law))
    depth = [max(c.shape[axis] for _, c in tables) for axis in range(3)]
    controllers = Control(
        kind=np.array(kinds),
        gains=gains,
        settings=np.zeros((count, max_settings)),
        every=np.zeros(count, dtype=np.int64),
        decay=np.zeros((count, 4)),
        command=np.zeros(count),
        level=np.zeros(count),
        reached=np.tile([math.inf, -math.inf], (count, 1)),
        knots=np.full((count, *depth[:2]), math.inf),
        coefficients=np.zeros((count, *depth)),
    )
    for d, site in enumerate(sites):
        controllers.level[d] = controllers.command[d] = site.law.low if site.law else site.input_value
        if site.law:
            _fill(controllers, d, site, step)
            knots, coefficients = tables[d]
            controllers.knots[d, : knots.shape[0], : knots.shape[1]] = knots
            controllers.coefficients[d][tuple(map(slice, coefficients.shape))] = coefficients
    return controllers


def _fill(controllers: Control, d: int, site: Site, step: float) -> None:
    """The clock, the settings and the coil of one law."""
    lag, numbers = lag_of(site.law, site.damper), settings(site.law)
    controllers.every[d] = round(site.law.period / step)
    controllers.settings[d, : len(numbers)] = numbers
    if lag > 0:
        controllers.decay[d] = np.exp(-np.arange(1, 5) * 0.25 * step / lag)


def check_reached(sites: tuple[Site, ...], controllers: Control) -> None:
    """Raise InputError where a law asked for an input outside its own bounds."""
    for site, (low, high) in zip(sites, controllers.reached, strict=True):
        if site.law is None or low > high:
            continue
        slack = 1e-9 * max(abs(site.law.low), abs(site.law.high), 1.0)
        if not site.law.low - slack <= low <= high <= site.law.high + slack:
            raise InputError(
                f"the law {describe_place(site.place)} asked for {low if low < site.law.low else high:g}; it must "
                f"stay between its low = {site.law.low:g} and high = {site.law.high:g}"
            )
