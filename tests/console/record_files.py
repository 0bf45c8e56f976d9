"""Files of records for tests of the console, and how they are sent to it."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any
from urllib.parse import quote

import h5py
import numpy as np
from fastapi.testclient import TestClient
from httpx import Response

from dampyr import records

ROWS = [(k / 100, 8 * np.sin(k / 12), 300 * np.cos(k / 12) + 20) for k in range(600)]
BARE = "".join(f"{t},{x:.5f},{f:.4f}\n" for t, x, f in ROWS)
CSV = f"time [s],displacement [mm],force [N]\n{BARE}"
MEASURED = "labcontrol/ensaio.A.1.mat"
"""A record of the published campaign."""


def upload(client: TestClient, name: str, content: Any = CSV, **said: Any) -> Response:
    """Send a file with what is said of it."""
    kind = {"content-type": "application/octet-stream"}
    return client.put(f"/api/records/uploads/{quote(name, safe='%')}", content=content, params=said, headers=kind)


def listed(client: TestClient) -> list[dict[str, Any]]:
    """The records of the data folder."""
    entries: list[dict[str, Any]] = client.get("/api/records/list", params={"source": "data"}).json()
    return entries


def made(name: str = "a", **more: Any) -> records.Record:
    """The rows of `CSV` as a record."""
    t, x, f = np.array(ROWS).T
    return records.Record(t, 1e-3 * x, f, voltage=1.0, name=name, **more)


def everything(folder: Path) -> list[str]:
    """All files below a folder."""
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def unfolding() -> bytes:
    """An .h5 file of a few kB that unfolds to 24 GB."""
    with tempfile.TemporaryDirectory() as folder, h5py.File(Path(folder, "a.h5"), "w") as file:
        file.attrs.update({"format": "dampyr record", "schema": 1, "complete": np.uint8(1), "name": "a", "role": "fit"})
        file.attrs.update({"test": "a", "try": 1})
        for channel, unit in (("time", "s"), ("displacement", "m"), ("force", "N")):
            dataset = file.create_dataset(
                f"calibrated/{channel}", shape=(10**9,), dtype="f8", chunks=(10**7,), compression="gzip"
            )
            dataset.attrs["unit"] = unit
        file.flush()
        return Path(folder, "a.h5").read_bytes()
