"""How a fit came out, in one sentence: whether its search converged, and whether its model describes the records."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from dampyr.identification.result import Fit

# of the force (L1): bands of acceptance are 10 to 15 % wide, so that a model beyond 10 % is not that damper, and one within
# half of it leaves them to the specimens
DESCRIBES, MISSES = 0.05, 0.10

Kind = Literal["good", "fair", "bad"]


@dataclass(frozen=True)
class FitVerdict:
    """``kind`` is "good" only where the search converged and the model describes the records; ``words`` say both."""

    kind: Kind
    words: str


def fit_verdict(fit: Fit) -> FitVerdict:
    """The verdict on a fit, by the mean L1 ratio over the records that it was fitted to."""
    l1 = float(np.mean([one.l1 for one in fit.scores.values()]))
    what = "this record" if len(fit.scores) == 1 else "these records"
    search = "The search converged" if fit.converged else f"The search did not converge ({fit.reason})"
    size = f"{100 * l1:.2g} % of the force" if np.isfinite(l1) else "without a number"
    misfit = f"misfit {size} (L1 ratio)"
    if l1 <= DESCRIBES:
        kind, model = "good", f"the model describes {what}"
    elif l1 <= MISSES:
        kind, model = "fair", f"the model describes {what} roughly"
    else:  # also where it is no number
        kind, model = "bad", f"the model does not describe {what}"
    return FitVerdict(kind if fit.converged else "bad", f"{search}; {misfit}: {model}.")  # type: ignore[arg-type]
