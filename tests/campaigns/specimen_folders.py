"""Folders of campaigns as the rig leaves them, with records of a force that is computed: for what judges them."""

import json
from collections.abc import Callable, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from dampyr import campaigns, records
from dampyr.campaigns import Journal
from dampyr.campaigns.differences import contents_of
from dampyr.campaigns.journal import JournalEntry
from dampyr.rig import RigSettings

RATE = 500.0
Law = Callable[[Any, Any], Any]
"""The force N of a path: of its displacement m and velocity m/s."""

LADDER = {
    "name": "ladder",
    "operator": "me",
    "protocol": {
        "kind": "rising_amplitude",
        "ladder": "modified ATC-24 as coded",
        "largest_amplitude": "8 mm",
        "frequency": "1 Hz",
    },
}
QUASI_STATIC = {
    "name": "ntc",
    "operator": "me",
    "protocol": {"kind": "ntc_2018_quasi_static", "design_displacement": "4 mm", "speed": "10 mm/s"},
}


def power_law(exponent: float, coefficient: float = 500.0) -> Law:
    """C sgn(v) |v|^a."""
    return lambda x, v: coefficient * np.sign(v) * np.abs(v) ** exponent


def dahl(kw: float, rho: float) -> Law:
    """Dahl without a viscous part, from rest at w = 0, exact along each straight piece of path."""

    def force(x: Any, v: Any) -> Any:
        w = np.zeros(len(x))
        for k in range(1, len(x)):
            way = x[k] - x[k - 1]
            s = np.sign(way)
            w[k] = s + (w[k - 1] - s) * np.exp(-rho * abs(way)) if way else w[k - 1]
        return kw * w

    return force


def specimen_folder(
    folder: Path,
    document: Mapping[str, Any],
    law: Law,
    specimen: str = "SN 1",
    states: Mapping[int, str] = {},
    factors: Mapping[int, float] = {},
    lasting: Mapping[int, float] = {},
) -> Path:
    """A campaign's folder; by the number of a test its ``states`` other than complete, ``factors`` on its force, and for which
    part of its duration it is ``lasting``."""
    folder.mkdir(exist_ok=True)
    campaign = campaigns.campaign_of(document)
    entries = []
    for number, test in enumerate(campaign.tests, 1):
        state: Any = states.get(number, "complete")
        if state != "planned":
            entries.append(JournalEntry(test.name, state, 1, "by the operator" if state == "stopped" else ""))
        if state != "complete":
            continue
        drive = test.step.drive(RigSettings())
        t = np.arange(0.0, drive.duration * lasting.get(number, 1.0), 1.0 / RATE)
        x = np.interp(t, drive.time, drive.displacement)
        force = factors.get(number, 1.0) * law(x, np.gradient(x, t))
        provenance = test.step.steady_cycles.as_provenance(7.0)
        record = records.Record(
            7.0 + t, x, force, voltage=test.step.voltage, name=test.name, specimen=specimen, provenance=provenance
        )
        records.write(record, folder / f"{test.name}.h5")
    with closing(Journal(folder)) as journal:
        names = [test.name for test in campaign.tests]
        journal.plan(campaign.digest, names, {"name": "a test", "contents": contents_of(campaign)}, entries)
    return folder


def with_other_contents(folder: Path, tests: list[Any]) -> None:
    """Another campaign in its journal."""
    with closing(Journal(folder)) as journal:
        journal.set_metadata({"contents": json.dumps(tests)})
