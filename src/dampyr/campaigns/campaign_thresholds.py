"""Thresholds of a campaign: where what a test shows of itself becomes a mark of its record, or ends the campaign.

They are judgements and not constants of nature: a campaign on another rig, or with another damper, may be run with others.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from dampyr.options import Thresholds
from dampyr.units import Quantity

Newtons = Quantity("N", low=0.0)
Share = Quantity("", low=0.0)


@dataclass(frozen=True)
class CampaignThresholds(Thresholds):
    """What is allowed before a test is marked, spoiled, or not begun; the values of `perform` unless others are given.

    Raises :class:`~dampyr.errors.InputError` for a value of the wrong kind or unit, or outside of its range.

    Examples
    --------
    >>> import dampyr as dp
    >>> dp.campaigns.CampaignThresholds(sudden_force="40 N").sudden_force
    40.0
    """

    stroke_error: Annotated[
        float,
        Quantity("", low=0.0, open_low=True, high=1.0),
        "Share of the slow stroke before the first test by which it may differ from the commanded one: a wrong scale of the "
        "encoder differs by more; beyond, no test begins",
    ] = 0.2
    flat_steps: Annotated[
        float,
        Quantity("", low=0.0, open_low=True),
        "Steps of the converter that a force may stray and still counts as standing: the noise of a live cell is several",
    ] = 2.0
    leap: Annotated[
        float,
        Quantity("", low=0.0, open_low=True),
        "Size of a leap into a standing force, in steps of the converter and in usual changes between samples, beyond which "
        "the test is spoiled: no damper's force leaps so far",
    ] = 20.0
    reversal: Annotated[
        float,
        Quantity("m", low=0.0, open_low=True),
        "Way on either side of a reversal over which the force of any damper changes; one that stands over it spoils the test",
    ] = 5.0e-4
    rest_drift: Annotated[
        float,
        Newtons,
        "Change of the force from the rest before the motion to that after it, beyond which it is marked",
    ] = 10.0
    rest_drift_share: Annotated[
        float,
        Share,
        "What the same may be more, as a share of half of the force's range: in a rest after a motion hysteresis holds a part",
    ] = 0.5
    cycle_drift: Annotated[
        float,
        Newtons,
        "Drift of the mean force of the cycles in the test, beyond which it is marked; in a good test it strays by 4 N",
    ] = 10.0
    cycle_drift_share: Annotated[float, Share, "What the same may be more, as a share of half of the force's range"] = (
        0.03
    )
    cycles: Annotated[
        int, Quantity("", low=2), "Number of inner cycles from which the drift of their mean is judged"
    ] = 4
    pass_shift: Annotated[
        float,
        Newtons,
        "Shift of the force's zero between slow passes over the same place, beyond which it is marked: they agree to 1 N",
    ] = 6.0
    pass_shift_share: Annotated[float, Share, "What the same may be more, as a share of the force, peak to peak"] = (
        0.005
    )
    shift_per_kelvin: Annotated[
        float,
        Quantity("N/K", low=0.0),
        "What the same may be more for each kelvin of warming: a gas charge under 300 N gains a 293rd of its force a kelvin",
    ] = 1.0
    pass_expected: Annotated[
        float,
        Newtons,
        "Difference of the force on the run's first slow pass from what the damper's card promises, beyond which it is marked: "
        "a gas charge and a mounting differ by less",
    ] = 50.0
    pass_expected_share: Annotated[float, Share, "What the same may be more, as a share of what the card promises"] = (
        0.3
    )
    pass_height: Annotated[
        float,
        Quantity("", low=0.0),
        "Standard uncertainties of the load cell by which the height of the hysteresis may differ between slow passes over the "
        "same place, beyond which it is marked: the height is that of the damper, and the gain of the cell's chain its scale",
    ] = 2.1
    pass_height_share: Annotated[
        float, Share, "What the same may be more, as a share of the height: the passes' speeds differ a little"
    ] = 0.01
    height_per_kelvin: Annotated[
        float,
        Quantity("1/K", low=0.0),
        "What the same may be more for each kelvin of warming, as a share of the height: a fluid thins as it warms",
    ] = 0.01
    run_height_share: Annotated[
        float,
        Share,
        "Share of the height by which the first slow pass of a run may differ from those of the runs before it with the same "
        "specimen, beside the load cell's errors (pass_height) and warming (height_per_kelvin), beyond which it is marked: a "
        "room is some kelvin warmer that nothing reads, and a damper has rested",
    ] = 0.03
    shunt_share: Annotated[
        float,
        Share,
        "Share of the shunt's step at the begin of the run by which a later one may differ beside the load cell's own errors, "
        "beyond which it is marked: the resistor and the bridge are the same",
    ] = 0.003
    shunt_expected: Annotated[
        float,
        Quantity("", low=0.0),
        "Standard uncertainties, of the shunt and of the load cell's scale, by which the step may differ from what the "
        "settings promise, beyond which it is marked",
    ] = 3.0
    quiet_share: Annotated[
        float,
        Share,
        "Share of the load cell's noise on the run's first slow pass that is left in a test, below which it is marked: an "
        "amplifier that grows slow lets less of it through",
    ] = 0.5
    cycle_height: Annotated[
        float,
        Share,
        "Share of the usual height of a test's cycles, their energy over their path, by which two neighbours may differ, "
        "beyond which it is marked: a damper warms or settles over many cycles",
    ] = 0.02
    coil_voltage_share: Annotated[
        float, Share, "Share of the largest command by which the coil's voltage may differ, beyond which it is marked"
    ] = 0.05
    coil_voltage: Annotated[float, Quantity("V", low=0.0), "What the same may be more, whatever the command is"] = 0.02
    spoiling_share: Annotated[
        float,
        Quantity("", low=0.0, high=1.0),
        "Share of the commanded voltage or current that the coil may lack, beyond which the test is spoiled: it was not at its "
        "voltage",
    ] = 0.2
    coil_warmth: Annotated[
        float,
        Quantity("K", low=0.0),
        "Kelvin by which the coil may be warmer than the damper as estimated, beyond which it is marked: it is inside, where "
        "the heat arises",
    ] = 15.0
    sudden_force: Annotated[
        float,
        Quantity("N", low=0.0, open_low=True),
        "Change of the force from one sample to the next while nothing moves the damper, beyond which it is marked",
    ] = 25.0
    sudden_rate: Annotated[
        float,
        Quantity("N/s", low=0.0),
        "The same as a rate, where samples are further apart than a millisecond",
    ] = 2.5e4
    created_force: Annotated[
        float,
        Newtons,
        "Energy that the damper gives in a cycle or in the test over its path, beyond which the test is spoiled: a damper that "
        "is looser than this gives nothing to identify",
    ] = 5.0


USUAL = CampaignThresholds()
"""The values that hold unless others are given."""
