"""How a fit came out, in one sentence: whether its search converged, and whether its model describes the records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from dampyr.findings import Finding
from dampyr.identification.fit_thresholds import FitThresholds
from dampyr.identification.scoring.score import Score
from dampyr.phrases import rounded

Kind = Literal["good", "fair", "bad"]


@dataclass(frozen=True)
class FitVerdict:
    """``kind`` is "good" only where the search converged and the model describes every record; ``words`` say both."""

    kind: Kind
    words: str

    @property
    def findings(self) -> tuple[Finding, ...]:
        """The verdict as a finding, wrong where it is "bad" and a doubt where it is "fair"; none where it is "good"."""
        if self.kind == "good":
            return ()
        text = self.words[:1].lower() + self.words[1:].removesuffix(".")
        return (Finding("wrong" if self.kind == "bad" else "doubt", text),)


def fit_verdict(
    scores: Mapping[str, Score], converged: bool, reason: str, thresholds: FitThresholds | None = None
) -> FitVerdict:
    """The verdict on a fit, by the mean L1 ratio over the records that it was fitted to, none of which is a misfit in a good
    one; by how its search ended."""
    limits = thresholds or FitThresholds()
    by_record = {name: score.l1 for name, score in scores.items()}
    l1, worst = float(np.mean(list(by_record.values()))), max(by_record, key=lambda name: by_record[name])
    what = "this record" if len(by_record) == 1 else "these records"
    search = "The search converged" if converged else f"The search did not converge ({reason})"
    size = f"{rounded(100 * l1, 2)} % of the force" if np.isfinite(l1) else "without a number"
    if l1 <= limits.good_misfit and by_record[worst] <= limits.misfit:
        kind, model = "good", f"the model describes {what}"
    elif l1 <= limits.misfit:
        kind, model = "fair", f"the model describes {what} roughly"
    else:  # also where it is no number
        kind, model = "bad", f"the model does not describe {what}"
    misfit = f"misfit {size} (L1 ratio)"
    if kind != "good" and len(by_record) > 1 and np.isfinite(l1):
        misfit += f", {rounded(100 * by_record[worst], 2)} % in {worst}"
    return FitVerdict(kind if converged else "bad", f"{search}; {misfit}: {model}.")  # type: ignore[arg-type]
