r"""The input of a wanted force: the damper's own model, run backwards in the controller.

A law that asks for a force (``ASKS = "force"``, see `dampyr.structures.law_form`) decides in N. At its sample k, with the
measured stroke x and rate v, the model goes on over the past period under the command that was given, and

.. math:: u_k = \arg\min_{low \le u \le high} |F(u) - f_k|

with F the force that the model gives a period T later if the rate stays as it is, at the stroke x + T v, the command held and
the coil following it (`dampyr.models.inverse`). Where no input gives the wanted force, the nearest is taken, and what kept it
from being met is counted by its reason.

The model is that of the damper's card, of a drawn damper the drawn one; it has no other knowledge of the damper than the stroke
and the rate that are measured. The static force, which buildings leave out, is left out here too.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dampyr.models.inverse import BEYOND, REASONS, Inverse, InverseInput, nodes
from dampyr.structures.control_laws import lag_of
from dampyr.structures.controller import asks_force

Array = NDArray[np.float64]


def model_of(damper: Any) -> Any:
    """The damper as a building has it, without its static force."""
    static = [p.name for p in damper.composition.parts if p.static]
    return damper.without(*static) if static else damper


class FollowedInverse:
    """The inverse in plain Python, sample by sample of a law."""

    def __init__(self, law: Any, damper: Any) -> None:
        self.law, self.damper, self.lag = law, model_of(damper), lag_of(law, damper)
        self.inverse: Inverse | None = None
        self.command = law.low

    def find(self, stroke: float, rate: float, wanted: float) -> InverseInput:
        """The input from this sample on, for the measured stroke [m] and rate [m/s] and the wanted force [N]."""
        period = self.law.period
        if self.inverse is None:
            self.inverse = Inverse(self.damper, stroke, rate, self.law.low, self.law.high)
            self.inverse.lag = self.lag
        else:
            self.inverse.advance(stroke, rate, period, self.command)
        found = self.inverse.find(stroke + period * rate, rate, wanted, period)
        self.command = found.input
        return found


class WantedForces(NamedTuple):
    """The models of all sites for the kernel of `respond`; a site whose law decides on its input has ``asks`` 0."""

    asks: Any  # (N,)
    at: Any  # (N, 2): where stroke and rate stand among the law's arguments
    kind: Any  # (N,) which of the bound dampers
    bounds: Any  # (N, 2) V or A
    period: Any  # (N,) s
    left: Any  # (N,) the share of the coil's gap to its command that is left after a period
    nodes: Any  # (N, the most of a site), the last beyond every bound
    begun: Any  # (N,) 0 before the first sample; this and the following are written by the kernel
    past: Any  # (N, 3): stroke, rate and acting input at the latest sample
    states: Any  # (N, S)
    work: Any  # (N, S)
    params: Any  # (N, P)
    found: Any  # (4,): input, force, reason and whether the force is monotone
    tally: Any  # (N, reasons): how many decisions each reason had


def inverse_of(law: Any, damper: Any) -> FollowedInverse | None:
    """The inverse that a law needs; None of one that decides on its input."""
    return FollowedInverse(law, damper) if asks_force(law) else None


def wanted_forces(sites: Any, kinds: Any, controllers: Any) -> WantedForces | None:
    """The models of the sites whose laws ask for a force, at the start; None where none does."""
    asking = [controller is not None and asks_force(controller.law) for controller in controllers]
    if not any(asking):
        return None
    count, width = len(sites), max(len(site.values) for site in sites)
    depth = max([1, *(site.composition.n_states for site in sites)])
    at = [
        nodes(site.damper, site.law.low, site.law.high) if a else np.zeros(0)
        for site, a in zip(sites, asking, strict=True)
    ]
    models = WantedForces(
        asks=np.array(asking, dtype=np.int64),
        at=np.zeros((count, 2), dtype=np.int64),
        kind=np.array(kinds, dtype=np.int64),
        bounds=np.zeros((count, 2)),
        period=np.zeros(count),
        left=np.zeros(count),
        nodes=np.full((count, max(map(len, at))), BEYOND),
        begun=np.zeros(count, dtype=np.int64),
        past=np.zeros((count, 3)),
        states=np.zeros((count, depth)),
        work=np.zeros((count, depth)),
        params=np.zeros((count, width)),
        found=np.zeros(4),
        tally=np.zeros((count, len(REASONS))),
    )
    for d, (site, controller) in enumerate(zip(sites, controllers, strict=True)):
        if asking[d]:
            models.at[d] = controller.formulas.stroke_and_rate
            models.bounds[d] = site.law.low, site.law.high
            models.period[d] = site.law.period
            lag = lag_of(site.law, site.damper)
            models.left[d] = np.exp(-site.law.period / lag) if lag > 0.0 else 0.0
            models.nodes[d, : len(at[d])] = at[d]
            models.past[d, 2] = site.law.low
            models.states[d, : site.composition.n_states] = site.composition.path0
    return models


def reasons_of(models: WantedForces | None, count: int) -> tuple[dict[str, float], ...]:
    """Of each site the share of its decisions by reason, those that occurred; {} where its law asks for no force."""
    if models is None:
        return ({},) * count
    shares = models.tally / np.maximum(models.tally.sum(axis=1, keepdims=True), 1.0)
    return tuple(
        {name: float(share) for name, share in zip(REASONS, row, strict=True) if share > 0.0} for row in shares
    )
