"""Instruments of docs/how-to/add-an-instrument.md, and a short campaign with them."""

from __future__ import annotations

import json
import re
from itertools import count
from pathlib import Path

import numpy as np

from dampyr.campaigns import campaign_of, perform
from dampyr.records import Record
from dampyr.rig import Rig

PAGE = (Path(__file__).parents[3] / "docs/how-to/add-an-instrument.md").read_text("utf-8")
FILE = re.compile(r"^```\w+ name=(\S+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBERS = count()
CAMPAIGN = {
    "name": "two",
    "operator": "me",
    "rest_between": "1 s",
    "step": [
        {
            "kind": "sine",
            "amplitude": "8 mm",
            "frequency": "1 Hz",
            "voltage": ["0 V", "1.98 V"],
            "cycles": 2,
        }
    ],
}


def rig_file(folder: Path, **wires: str) -> Path:
    """A rig.toml that names instruments."""
    path = folder / f"rig{next(NUMBERS)}.toml"
    path.write_text("[wires]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in wires.items()), "utf-8")
    return path


def records_of(rig: Rig, out: Path) -> list[Record]:
    """The records of a campaign on a rig."""
    with rig:
        return list(perform(campaign_of(CAMPAIGN), rig, out))


def agree(ours: list[Record], theirs: list[Record], skip: float = 0.0) -> None:
    """Two campaigns agree within the noise of a sample, from ``skip`` s after a record's start on."""
    assert len(ours) == len(theirs) == 2
    for own, other in zip(ours, theirs, strict=True):
        assert own.time.size == other.time.size
        late = own.time - own.time[0] >= skip
        assert np.sqrt(np.mean((own.force - other.force)[late] ** 2)) < 3.0  # N: noise and wander of 0.9 N, twice
        assert np.abs(own.displacement - other.displacement).max() < 2e-5
        assert own.voltage == other.voltage
