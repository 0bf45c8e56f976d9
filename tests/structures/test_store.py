"""The file of an ensemble: what it shows lies in it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from dampyr.errors import FileError
from dampyr.structures import read_ensemble
from dampyr.structures.ensembles import job_array, store


@pytest.mark.parametrize("read", [read_ensemble, store.progress_of, job_array._opened])
@pytest.mark.parametrize("name", ["done", "drift", "labels"])
def test_what_points_out_of_a_file_is_refused(tmp_path: Path, read: Callable[[Path], Any], name: str) -> None:
    (tmp_path / "secret.bin").write_bytes(np.full(10, 777.25).tobytes())
    path = tmp_path / "part-1-of-2.h5"
    with h5py.File(path, "w") as file:
        file.attrs.update({"format": store.FORMAT, "part": 1, "quantities": ["drift"]})
        if name != "done":
            file["done"] = np.ones(1, bool)
        file.create_dataset(name, (10,), "f8", external=[(str(tmp_path / "secret.bin"), 0, 80)])
    with pytest.raises(FileError, match=f"/{name} has its values in another file"):
        read(path)
