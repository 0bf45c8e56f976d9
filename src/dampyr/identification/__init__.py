"""Identification: from records to parameters, their errors, and how well they predict.

`fit` identifies any damper from one record or many; `limit_cycle` and `plastic_region` are the two methods of the
dissertation for the viscous Dahl model; `score` says how well a damper predicts a record, `cross_validate` how well a model
predicts records that it was not fitted on, `leaderboard` which model does it best; `residuals` analyses what a fit leaves,
and `findings` says it in words; `accept` whether a record lies within a band about a reference damper. `profile` and
`sample_posterior` say how well a number is known where the standard error is too simple, `identifiability` what the records
cannot separate, and `fit_specimens` how the dampers of one type differ.
"""

from dampyr.identification.accept_records import Accepted, AcceptOptions, accept_records
from dampyr.identification.acceptance import Acceptance, Point, Tolerance, accept
from dampyr.identification.data_sheet import contradictions
from dampyr.identification.diagnostics import Trend, findings, trends, warnings_of
from dampyr.identification.fit import Fit, Nuisance, fit
from dampyr.identification.identifiability import Identifiability, Inseparable, identifiability
from dampyr.identification.identify import Identified, IdentifyOptions, identify
from dampyr.identification.leaderboard import Entry, Leaderboard, leaderboard
from dampyr.identification.levels import Levels
from dampyr.identification.limit_cycle import LimitCycle, limit_cycle
from dampyr.identification.plastic_region import PlasticRegion, plastic_region
from dampyr.identification.posterior import Posterior, sample_posterior
from dampyr.identification.prediction_band import Band, Interval, prediction_band
from dampyr.identification.profile_likelihood import Profile, profile
from dampyr.identification.residuals import Residuals, Trace, analyse
from dampyr.identification.result import residuals
from dampyr.identification.score import Score, compare, prediction, score
from dampyr.identification.scoring_window import Window
from dampyr.identification.screening import Screened, Trial
from dampyr.identification.specimens import Specimens, Spread, fit_specimens
from dampyr.identification.validate import Validated, ValidateOptions, validate
from dampyr.identification.validation import Fold, Validation, cross_validate

__all__ = [
    "AcceptOptions", "Acceptance", "Accepted", "IdentifyOptions", "Identified", "ValidateOptions", "Validated",
    "accept_records", "identify", "validate",
    "Band", "Interval", "Levels", "prediction_band",
    "Inseparable", "Identifiability", "Posterior", "Profile", "Specimens", "Spread",
    "fit_specimens", "identifiability", "profile", "sample_posterior",
    "Entry", "Fit", "Fold", "Leaderboard", "LimitCycle", "Nuisance", "PlasticRegion", "Point", "Residuals",
    "Score", "Screened", "Tolerance", "Trace", "Trend", "Trial", "Validation", "Window",
    "accept", "analyse", "compare", "contradictions", "cross_validate", "findings", "fit", "leaderboard", "limit_cycle",
    "plastic_region", "prediction", "residuals", "score", "trends", "warnings_of",
]  # fmt: skip
