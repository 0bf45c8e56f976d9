"""From records to parameters: how well they are known, and how well they predict.

`fit` identifies any damper from one record or many; `limit_cycle` and `plastic_region` are the two methods of the
dissertation for the viscous Dahl model; `score` says how well a damper predicts a record.
"""

from dampyr.identification.fit import Fit, Nuisance, fit
from dampyr.identification.limit_cycle import LimitCycle, limit_cycle
from dampyr.identification.plastic_region import PlasticRegion, plastic_region
from dampyr.identification.score import Score, Window, compare, prediction, score

__all__ = [
    "Fit", "LimitCycle", "Nuisance", "PlasticRegion", "Score", "Window",
    "compare", "fit", "limit_cycle", "plastic_region", "prediction", "score",
]  # fmt: skip
