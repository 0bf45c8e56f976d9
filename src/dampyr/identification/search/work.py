"""The work of a search: model evaluations times samples times a fixed cost of each part, the same on every machine.

A budget on a clock ends a search earlier where another program keeps the machine busy, and the load chooses the model. So work
is counted, in seconds that it takes one core of the machine on which `COSTS` were measured; nothing is measured as it runs.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dampyr.identification.search.problem import Problem

#: ns of an evaluation of one sample, with its derivatives and their sums of products: measured once (an AMD EPYC core,
#: 2026-11-25, a few records of the labcontrol campaign) and rounded, add-ons as what they add to `dahl`
COSTS = {
    "asymmetric": 45.0, "asymmetric_bouc_wen": 2500.0, "bilinear": 50.0, "bingham": 45.0, "biviscous": 45.0,
    "bouc_wen": 700.0, "bouc_wen_baber_noori": 1500.0, "choi_polynomial": 70.0, "compliance": 180.0, "dahl": 60.0,
    "delay": 30.0, "direction_factor": 40.0, "force_table": 145.0, "free_play": 800.0, "gamota_filisko": 160.0,
    "gas_spring": 30.0, "generalised_maxwell": 105.0, "hardening_bouc_wen": 2000.0, "hyperbolic_tangent": 45.0,
    "hysteretic_biviscous": 60.0, "inertia": 55.0, "lag": 60.0, "lugre": 110.0, "maxwell_slip": 135.0,
    "modified_bouc_wen": 2000.0, "offset": 5.0, "place_friction": 60.0, "power_law": 45.0, "shutting_bleed": 90.0,
    "sigmoid": 65.0, "spring": 10.0, "triple_pendulum": 600.0,
}  # fmt: skip
OTHER = 100.0  # ns, of a part that is not among them
EVALUATION = 1e-3  # s of an evaluation whatever its records: the step that it belongs to
OUT_OF_TIME = "did not converge: its time was used up"
OUT_OF_WORK = "did not converge: its share of the work was used up"


@dataclass
class Work:
    """What a search has ``spent`` of its ``limit``, counted s; ``deadline`` is a value of ``time.perf_counter``, s."""

    limit: float = math.inf
    deadline: float = math.inf
    spent: float = 0.0

    def count(self, problem: Problem) -> None:
        """Count one evaluation of all records."""
        costs = sum(COSTS.get(name, OTHER) for name in problem.composition.names)
        samples = sum(piece.t.size for piece in problem.pieces)
        self.spent += 1e-9 * costs * samples + EVALUATION

    @property
    def stopped(self) -> str:
        """Why no further step begins; empty while one may."""
        if self.spent > self.limit:
            return OUT_OF_WORK
        return OUT_OF_TIME if time.perf_counter() > self.deadline else ""

    def share(self, parts: int) -> Work:
        """One of ``parts`` equal shares of what is left."""
        now = time.perf_counter()
        return Work((self.limit - self.spent) / parts, now + (self.deadline - now) / parts)
