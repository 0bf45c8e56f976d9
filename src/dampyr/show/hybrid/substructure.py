"""What the computed part of a hybrid test and its run show."""

from __future__ import annotations

import numpy as np

from dampyr.hybrid.substructure import Substructure, SubstructureRun
from dampyr.show.descriptions import Description, describe


@describe.register
def describe_substructure(part: Substructure) -> Description:
    """Where the damper is, the steps, the model and the actuator's lag."""
    model = "none: the force is held" if part.model is None else str(part.model.composition)
    return Description(
        f"Substructure of {part.building.name!r}",
        [
            ("damper", part.building.place_label(part.place)),
            ("steps", f"{part.steps} of {1e3 * part.h:.4g} ms"),
            ("model", model),
            ("lag", f"{1e3 * part.lag:.4g} ms{', followed' if part.adaptive else ''}"),
        ],
    )


@describe.register
def describe_run(run: SubstructureRun) -> Description:
    """How far it is, the peak that was wanted, the lag and the error of energy."""
    return Description(
        f"SubstructureRun of {run.about.building.name!r}",
        [
            ("steps", f"{run.now} of {run.about.steps}"),
            ("peak", f"{1e3 * np.abs(run.target).max():.4g} mm wanted of the specimen"),
            ("lag", f"{1e3 * run.lag.lag:.3g} ms, gain {run.lag.gain:.4g}"),
            ("energy error", f"{100 * run.energy_error:.3g} % of what the ground put in"),
        ],
    )
