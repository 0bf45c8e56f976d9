"""What a virtual hybrid test shows."""

from __future__ import annotations

from dampyr.hybrid.virtual_test import VirtualRun
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.figures.building import building_response


@describe.register
def describe_run(run: VirtualRun) -> Description:
    """The loop's stability, and the criteria or where the run diverged."""
    rows = [("loop", run.stability.reason), ("samples", f"{len(run.time)}, {run.time[-1]:.4g} s")]
    if run.diverged:
        rows.append(("diverged", f"at {run.time[-1]:.4g} s"))
    else:
        true, measured = run.criteria(), run.criteria(measured=True)
        rows.append(("J1", f"{true.J1:.3g} ms"))
        rows += [(f"J{k + 1}", f"{true[k]:.3g} % (as measured {measured[k]:.3g} %)") for k in range(1, 5)]
        rows += [(f"J{k + 1}", f"{true[k]:.3g} %") for k in range(5, 9)]
    rows.append(("at the greatest force", f"{run.at_limit} samples"))
    cases = {"whole, computed": run.reference[-1, : len(run.time)], "hybrid test": run.floors[-1]}
    return Description(
        f"VirtualRun of {run.setup.structure.name!r}",
        rows,
        figure=lambda: building_response(run.time, cases, title=f"floor {len(run.floors)}"),
        frame=lambda: _histories(run),
    )


def _histories(run: VirtualRun) -> DataFrameColumns:
    """The histories, one row a sample."""
    return DataFrameColumns(
        {
            "time_s": run.time,
            "target_m": run.target,
            "displacement_m": run.displacement,
            "measured_m": run.measured,
            "command_m": run.command,
            "force_N": run.force,
        }
    )
