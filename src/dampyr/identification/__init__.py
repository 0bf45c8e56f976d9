"""Identification: from records to parameters, their errors, and how well they predict.

`fit` identifies any damper from one record or many, predicts records that it leaves out, and without a model chooses the one
that does so best; its ``findings`` say in words what to look at, and `residuals` analyses what it leaves. `limit_cycle` and
`plastic_region` are the two methods of the dissertation for the viscous Dahl model, which `compare_method` sets beside least
squares. `score` says how well a damper predicts a record, `validate` how well it predicts many, and `accept` whether records
lie within a band about a reference damper. `profile` and `sample_posterior` say how well a number is known where the standard
error is too simple, `identifiability` what the records cannot separate, and `fit_specimens` how the dampers of one type differ.
"""

from dampyr.identification.acceptance_tests.accept import Accepted, accept
from dampyr.identification.acceptance_tests.acceptance import Acceptance, AcceptancePoint, AcceptOptions, Tolerance
from dampyr.identification.fits.diagnostics import Trend
from dampyr.identification.fits.fit import fit
from dampyr.identification.fits.fit_options import FitOptions
from dampyr.identification.fits.residuals import Residuals, Trace, analyse
from dampyr.identification.fits.result import Fit, Nuisance, residuals
from dampyr.identification.limit_cycle_methods.limit_cycle import LimitCycle, limit_cycle
from dampyr.identification.limit_cycle_methods.method_comparison import MethodComparison, MethodResult, compare_method
from dampyr.identification.limit_cycle_methods.plastic_region import PlasticRegion, plastic_region
from dampyr.identification.model_choice.leaderboard import Finalist, Leaderboard
from dampyr.identification.model_choice.screening import Screened, Trial
from dampyr.identification.parameter_uncertainty.identifiability import Identifiability, Inseparable, identifiability
from dampyr.identification.parameter_uncertainty.levels import Levels
from dampyr.identification.parameter_uncertainty.posterior import Posterior, sample_posterior
from dampyr.identification.parameter_uncertainty.profile_likelihood import Profile, profile
from dampyr.identification.parameter_uncertainty.specimens import Specimens, SpecimenSpread, fit_specimens
from dampyr.identification.scoring.prediction_band import Band, Interval, prediction_band
from dampyr.identification.scoring.score import Score, prediction, score
from dampyr.identification.scoring.scoring_window import Window
from dampyr.identification.scoring.validate import ScoreOptions, Validated, validate
from dampyr.identification.scoring.validation import Fold, Validation

__all__ = [
    "AcceptOptions", "Acceptance", "Accepted", "FitOptions", "ScoreOptions", "Validated",
    "accept", "validate",
    "Band", "Interval", "Levels", "prediction_band",
    "Inseparable", "Identifiability", "Posterior", "Profile", "Specimens", "SpecimenSpread",
    "fit_specimens", "identifiability", "profile", "sample_posterior",
    "MethodComparison", "MethodResult", "compare_method",
    "Finalist", "Fit", "Fold", "Leaderboard", "LimitCycle", "Nuisance", "PlasticRegion", "AcceptancePoint", "Residuals",
    "Score", "Screened", "Tolerance", "Trace", "Trend", "Trial", "Validation", "Window",
    "analyse", "fit", "limit_cycle",
    "plastic_region", "prediction", "residuals", "score",
]  # fmt: skip
