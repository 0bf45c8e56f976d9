"""Reading a million rows of text: the table, a record and a ground motion, against pandas."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks._lines import Line
from benchmarks._timing import race
from dampyr import ground_motions, records
from dampyr.records import ReadOptions
from dampyr.text_table import read_table

ROWS = 1_000_000
TITLE = f"Reading {ROWS:,} rows of text: time, displacement and force; time and acceleration"


def run(data: Path | None) -> list[Line]:
    """`pandas.read_csv` as it comes; then the table, the record (checksums and checks included) and the ground motion."""
    noise = np.random.default_rng(5).standard_normal(ROWS)
    time = 0.001 * np.arange(ROWS)
    with tempfile.TemporaryDirectory() as folder:
        test, commas, motion = (Path(folder) / f"{name}.csv" for name in ("test", "commas", "motion"))
        _write(test, "time [s],displacement [mm],force [N]", np.column_stack([time, noise, 100 * noise]))
        commas.write_text(test.read_text().replace(",", ";").replace(".", ","))
        _write(motion, "time [s],acceleration [m/s^2]", np.column_stack([time, 0.1 * noise]))
        frame, table = pd.read_csv(test), read_table(test, ReadOptions())
        apart = np.max(np.abs(frame.to_numpy() - table.values))
        contenders = {
            "pandas.read_csv": lambda: pd.read_csv(test),
            "dampyr.text_table.read_table": lambda: read_table(test, ReadOptions()),
            "dampyr.records.read": lambda: records.read(test),
            "pandas.read_csv, semicolons and decimal commas": lambda: pd.read_csv(commas, sep=";", decimal=","),
            "dampyr.records.read, semicolons and decimal commas": lambda: records.read(commas),
            "dampyr.ground_motions.read": lambda: ground_motions.read(motion),
        }
        return race(contenders, {"dampyr.text_table.read_table": f"apart from pandas by at most {apart:.0e}"}, rounds=7)


def _write(path: Path, header: str, values: np.ndarray) -> None:
    formats = ["%.3f", "%.6f", "%.4f"][: values.shape[1]]
    np.savetxt(path, values, delimiter=",", header=header, comments="", fmt=formats)
