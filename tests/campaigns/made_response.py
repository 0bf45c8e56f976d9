"""A record as the protocol `response_time` leaves it, made in closed form."""

import json
from pathlib import Path

import numpy as np

from dampyr import campaigns, records
from dampyr.campaigns.protocol_result import protocol_text
from dampyr.records import Record

TABLE = {"kind": "response_time", "amplitude": 0.012, "speeds": [0.03], "high_voltages": [1.0]}


def write_response(folder: Path, tau: float, table: dict = TABLE, names: slice = slice(None)) -> Path:
    """A folder with a record for each test of the protocol: strokes of 24 mm at 30 mm/s, an extension with a rise of the
    voltage, a compression with a fall, to which the force of 200 to 500 N answers with the time constant ``tau``."""
    folder.mkdir(parents=True, exist_ok=True)
    campaign = campaigns.campaign_of({"protocol": table})
    t, turn = np.arange(0.0, 1.6, 1e-3), 0.8
    on = (t >= 0.3 - 1e-9) & (t < 1.1 - 1e-9)
    grown = np.where(
        t < 1.1, 1 - np.exp(-np.clip(t - 0.3, 0.0, None) / tau), np.exp(-np.clip(t - 1.1, 0.0, None) / tau)
    )
    for test in campaign.tests[names]:
        provenance = {
            "protocol": protocol_text(campaign.protocol_kind, campaign.protocol),
            "step": json.dumps({name: getattr(test.step, name) for name in ("speed", "low", "high")}),
        }
        x = 0.03 * np.where(t < turn, t, 2 * turn - t)
        force = (200.0 + 300.0 * grown) * np.where(t < turn, 1.0, -1.0)
        record = Record(t, x, force, voltage=1.0 * on, name=test.name, provenance=provenance, role="validation")
        records.write(record, folder / f"{test.name}.h5")
    return folder
