"""Judgements on a fit: from which value on something is worth a sentence, and which sentence it is.

They change no number of a fit, only what its findings and its verdict say. Numerical tolerances, and the numbers of records and
cycles that an estimate of a variance needs, are no judgements and stay where they are used.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from dampyr.errors import InputError
from dampyr.options import Thresholds
from dampyr.units import Quantity

SHARE = Quantity("", low=0, high=1)
POSITIVE = Quantity("", low=0, open_low=True)
RATIO = Quantity("", low=1)
COUNT = Quantity("", low=1)


@dataclass(frozen=True)
class FitThresholds(Thresholds):
    """Thresholds of the findings of a fit: ``fit(records, "dahl", thresholds=FitThresholds(misfit=0.2))``.

    Examples
    --------
    >>> import dampyr as dp
    >>> dp.identification.FitThresholds(misfit=0.2).misfit
    0.2
    """

    # Bands of acceptance are 10 to 15 % wide: a model beyond 10 % is not that damper, and one within half of it leaves them to
    # the specimens.
    good_misfit: Annotated[float, SHARE, "Mean L1 ratio up to which a model describes its records"] = 0.05
    misfit: Annotated[
        float,
        SHARE,
        "Mean L1 ratio beyond which a model does not describe its records; no record of a good fit is beyond it",
    ] = 0.10
    # half again what a model may miss: its numbers describe little then, and a cause is worth some seconds
    unexplained: Annotated[
        float, SHARE, "Mean L1 ratio beyond which effects are tried that the model or the records may lack"
    ] = 0.15
    # a record of twice the length is then off by as much as a model may miss
    level_drift: Annotated[
        float, SHARE, "Change of the level with the energy of the median record beyond which it is a doubt"
    ] = 0.05
    correlated: Annotated[
        float,
        RATIO,
        "Correlation time of a residual, in sampling intervals, beyond which it is misfit; white noise has 1",
    ] = 5.0
    # three quarters of the residual's variance are then more than noise
    beyond_noise: Annotated[float, RATIO, "Size of a residual over that of its noise beyond which it is misfit"] = 2.0
    chance: Annotated[
        float,
        SHARE,
        "Probability below which a trend of the residual is not due to chance, over all trends that are tried",
    ] = 0.05
    # a perfect rank correlation of four comes by chance once in twelve
    trend_records: Annotated[int, COUNT, "Number of records from which on a trend is looked for"] = 5
    # half of the variance of their ranks is shared
    confounded: Annotated[
        float, SHARE, "Rank correlation of frequency and stroke from which on the two cannot be told apart"
    ] = 0.7
    alike: Annotated[
        float, RATIO, "Ratio of the residual's size in the two directions up to which it is alike in both"
    ] = 1.1
    shifted: Annotated[
        float,
        POSITIVE,
        "Difference of the residual's means in the two directions, over its size, that is a doubt beyond",
    ] = 0.5
    uneven: Annotated[
        float,
        SHARE,
        "Share of the residual's variance that is the same in both directions up to which it is no concern",
    ] = 0.1
    uneven_by_chance: Annotated[
        float, RATIO, "The same share over what chance would give, beyond which it is a doubt"
    ] = 2.5
    # however long the memory of the residual
    uneven_surely: Annotated[float, SHARE, "The same share beyond which it is a doubt whatever chance would give"] = (
        0.75
    )
    independent: Annotated[
        float, SHARE, "Effective samples over all samples from which on successive residuals are nearly independent"
    ] = 0.7
    repeated: Annotated[
        float,
        SHARE,
        "Share of the residual's variance that comes again in each cycle from which on it is the model's shape",
    ] = 0.2
    resolved_steps: Annotated[
        int, COUNT, "Number of values of the displacement below which its resolution hides the loop"
    ] = 25
    sliding: Annotated[
        float,
        POSITIVE,
        "Peak-to-peak stroke times rho below which friction does not come near its limit: the motion is pre-sliding",
    ] = 1.0
    few_cycles: Annotated[int, COUNT, "Number of cycles below which errors by cycles are called rough"] = 10
    # each interval is then 1.7 times as wide as if the other number were known
    trading: Annotated[
        float, SHARE, "Correlation of two numbers from which on they trade against each other (identifiability)"
    ] = 0.8
    # what is outside for less decides no peak and little energy
    outside_time: Annotated[
        float,
        SHARE,
        "Share of a motion's time outside of the fitted strokes and speeds beyond which it is extrapolated",
    ] = 0.1
    # records differ by as much from one another
    outside_margin: Annotated[
        float, SHARE, "Stroke or speed over the smallest that was fitted below which it is outside of the fitted ones"
    ] = 0.8

    def check(self) -> None:
        """Refuse a good misfit that is beyond the bad one."""
        if self.good_misfit > self.misfit:
            raise InputError(
                f"good_misfit = {self.good_misfit:g} is above misfit = {self.misfit:g}; lower good_misfit, or raise misfit"
            )
