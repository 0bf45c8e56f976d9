"""The picture of each part: its loops, with the numbers that its file has for this (``EXAMPLE``).

A model is drawn on sines of two frequencies and two amplitudes, so that what follows the path, the speed or both is seen; an
add-on beside a friction damper without it; a lag beside one whose input jumps::

    python tools/part_loops.py OUT  # OUT/NAME.svg
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import dampyr as dp
from dampyr.models import available_parts
from dampyr.models.part import Part, part
from dampyr.show.figures.loop_overlay import Loop, loop_overlay

STROKES = (0.005, 0.010)  # m
RATES = (0.5, 2.0)  # Hz
RATE = 1.0  # Hz, of an add-on
PER_CYCLE, CYCLES = 1440, 4  # the last one is drawn
BESIDE = {"dahl.kx": 1000.0, "dahl.kw": 300.0, "dahl.rho": 1500.0}  # what an add-on complements
ON = 2.0  # V: to where the input of a lag jumps


def figure_of(name: str) -> Any:
    """The loops of one part."""
    p = part(name)
    numbers = {f"{name}.{key}": value for key, value in p.module.EXAMPLE.items()}
    if p.lag:
        return loop_overlay({"without": [_switched(None)], "with": [_switched(p)]})
    if p.add_on:
        alone, together = dp.models.Damper("dahl", BESIDE), dp.models.Damper(f"dahl + {name}", BESIDE | numbers)
        return loop_overlay({"without": [_loop(alone, STROKES[1], RATE)], "with": [_loop(together, STROKES[1], RATE)]})
    damper = dp.models.Damper(name, numbers)
    return loop_overlay({f"{rate:g} Hz": [_loop(damper, stroke, rate) for stroke in STROKES] for rate in RATES})


def _loop(damper: Any, stroke: float, rate: float, **inputs: Any) -> Loop:
    phase = 2 * np.pi * np.arange(CYCLES * PER_CYCLE + 1) / PER_CYCLE
    t, x, v = phase / (2 * np.pi * rate), stroke * np.sin(phase), 2 * np.pi * rate * stroke * np.cos(phase)
    last = slice((CYCLES - 1) * PER_CYCLE, None)
    return x[last], v[last], damper.force(t, x, velocity=v, **inputs)[last]


def _switched(lag: Part | None) -> Loop:
    """A loop in which the input is on for a quarter of the cycle after each turn, with the part ``lag`` or at once."""
    laws = BESIDE | {"dahl.kw": dp.models.Polynomial((100.0, 150.0), low=0.0, high=ON)}
    composition = "dahl"
    if lag is not None:
        composition, laws = (
            f"dahl + {lag.name}",
            laws | {f"{lag.name}.{key}": n for key, n in lag.module.EXAMPLE.items()},
        )
    quarter = (4 * np.arange(CYCLES * PER_CYCLE + 1) // PER_CYCLE) % 2
    return _loop(dp.models.Damper(composition, laws), STROKES[1], RATE, voltage=ON * quarter)


def main(arguments: Sequence[str]) -> int:
    """Draw each part that has numbers for it into OUT; 1 where text of one cannot be read."""
    from figure_text import unreadable

    faults = []
    for name in available_parts():
        if hasattr(part(name).module, "EXAMPLE"):
            figure = figure_of(name)
            dp.show.save(figure, Path(arguments[0]) / f"{name}.svg")
            faults += [f"{name}: {fault}" for fault in unreadable(figure)]
    print("\n".join(faults), file=sys.stderr)
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
