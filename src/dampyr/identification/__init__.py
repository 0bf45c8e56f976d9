"""Identification: from records to parameters, their errors, and how well they predict.

`fit` identifies any damper from one record or many, predicts records that it leaves out, and without a model chooses the one
that does so best; its ``findings`` say in words what to look at, and `residuals` analyses what it leaves. `limit_cycle` and
`plastic_region` are the two methods of the dissertation for the viscous Dahl model, which `compare_method` sets beside least
squares. `score` says how well a damper predicts a record, `validate` how well it predicts many, and `accept` whether records
lie within a band about a reference damper. `profile` and `sample_posterior` say how well a number is known where the standard
error is too simple, `identifiability` what the records cannot separate, and `fit_specimens` how the dampers of one type differ.
`track_level` follows one damper while it runs, and flags a change.
"""

from dampyr.identification.acceptance_tests.accept import accept
from dampyr.identification.acceptance_tests.acceptance import AcceptOptions, Tolerance
from dampyr.identification.fit_thresholds import FitThresholds
from dampyr.identification.fits.fit import fit
from dampyr.identification.fits.fit_options import FitOptions
from dampyr.identification.fits.residuals import analyse
from dampyr.identification.fits.result import Fit, residuals
from dampyr.identification.level_tracking import track_level
from dampyr.identification.limit_cycle_methods.limit_cycle import limit_cycle
from dampyr.identification.limit_cycle_methods.method_comparison import compare_method
from dampyr.identification.limit_cycle_methods.plastic_region import plastic_region
from dampyr.identification.model_choice.leaderboard import Leaderboard
from dampyr.identification.parameter_uncertainty.identifiability import identifiability
from dampyr.identification.parameter_uncertainty.posterior import sample_posterior
from dampyr.identification.parameter_uncertainty.profile_likelihood import profile
from dampyr.identification.parameter_uncertainty.specimens import fit_specimens
from dampyr.identification.scoring.prediction_band import prediction_band
from dampyr.identification.scoring.score import Score, score
from dampyr.identification.scoring.validate import ScoreOptions, validate

__all__ = [
    "fit", "score", "validate", "accept", "prediction_band", "identifiability", "profile", "sample_posterior",
    "fit_specimens", "track_level", "compare_method", "limit_cycle", "plastic_region", "residuals", "analyse", "Fit",
    "Leaderboard", "Score", "FitOptions", "ScoreOptions", "AcceptOptions", "Tolerance", "FitThresholds",
]  # fmt: skip
