"""From when on a record's oddity is a finding: judgements that somebody chose, which a laboratory may choose otherwise.

They are no constants of nature: a bridge damper has strokes that are unlikely elsewhere, and an old recorder jitters more than
1 %. A record holds its own (``record.thresholds``), and `dampyr.records.read` takes them::

    record = dp.records.read("long.csv", thresholds=RecordThresholds(unlikely_stroke=4.0))
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from dampyr.options import Thresholds
from dampyr.units import Quantity


@dataclass(frozen=True)
class RecordThresholds(Thresholds):
    """When what a record shows is a finding. Values may be quantities such as ``"2 m"``; a wrong one is an
    :class:`~dampyr.errors.InputError` with the range that is allowed.

    Examples
    --------
    >>> import dampyr as dp
    >>> dp.records.RecordThresholds(unlikely_stroke="400 mm").unlikely_stroke
    0.4
    """

    # halfway to one missing sample
    gap: Annotated[
        float,
        Quantity("", low=1, open_low=True),
        "Interval between two samples, in median intervals, beyond which it is a gap",
    ] = 1.5
    # beyond it the samples are not even
    jitter: Annotated[
        float,
        Quantity("", low=0),
        "Deviation of the sampling intervals from their median, rms, of it, beyond which they are doubted",
    ] = 0.01
    # with fewer a loop has corners
    samples_per_cycle: Annotated[
        float, Quantity("", low=0), "Samples of a cycle below which a record is coarsely sampled"
    ] = 40
    # dampers of buildings and bridges reach 1 m; 2 mm read as m are there
    unlikely_stroke: Annotated[
        float,
        Quantity("m", low=0, open_low=True),
        "Distance from the least displacement to the greatest beyond which the unit is doubted",
    ] = 2.0
    # smaller ones move no score
    false_sample: Annotated[
        float,
        Quantity("", low=0),
        "Leap of a sample away from its neighbours and back, of the channel's range but for a hundredth at either end, beyond "
        "which it counts as false",
    ] = 0.10
    # a sine's fastest step is 1.6 times its mean
    leap: Annotated[
        float,
        Quantity("", low=1),
        "Step of the displacement, times that which 99 of 100 samples stay below, beyond which the encoder has slipped",
    ] = 5.0
    # the table of the published campaign drifts by up to 0.76 of it
    run_away: Annotated[
        float,
        Quantity("", low=0, open_low=True),
        "Way of the middle of the stroke in one direction in the whole record, of the stroke, beyond which it runs away",
    ] = 1.0
    # there up to 0.051; what an encoder loses that counts so much less one way
    run_away_per_cycle: Annotated[
        float,
        Quantity("", low=0, open_low=True),
        "The same in each cycle, of the stroke; the smaller of the two limits counts",
    ] = 0.08
    # encoders and their last count give half of it on sines
    uncertain_direction: Annotated[
        float,
        Quantity("", low=0, high=1),
        "Part of the samples in which noise turns the direction of motion, beyond which a low-pass is proposed",
    ] = 0.01
    # more than the rounding of a table and the table's own overshoot explain
    label_frequency: Annotated[
        float,
        Quantity("", low=0),
        "Difference of the labelled frequency from the measured one, of that, beyond which the label disagrees",
    ] = 0.05
    label_peak_to_peak: Annotated[
        float,
        Quantity("", low=0),
        "Difference of the labelled peak to peak from the measured one, of that, beyond which the label disagrees",
    ] = 0.05
    # half of what a moving average shows there without leakage
    smoothing_contrast: Annotated[
        float,
        Quantity("", low=0, open_low=True),
        "Depth of the zeros of a moving average in a channel's spectrum, dB, from which on it counts as smoothed",
    ] = 8.0
    # of a hundred windows tried in a thousand channels none comes so far by chance
    smoothing_sigmas: Annotated[
        float,
        Quantity("", low=0, open_low=True),
        "The same depth in standard errors of what noise would give; both are needed",
    ] = 6.0


USUAL = RecordThresholds()
