"""Text files of another laboratory, and the reading.toml beside them."""

from pathlib import Path

import numpy as np

UNITS = {"time": "s", "displacement": "mm", "force": "N"}


def put(path: Path, header: str = "Time\tDisplacement\tForce", force: float = 50.0, extra: float | None = None) -> Path:
    """A text file of one test."""
    t = 0.01 * np.arange(300)
    rows = np.column_stack(
        [t, 5 * np.sin(6 * t), force * np.cos(6 * t)] + ([t * 0 + extra] if extra is not None else [])
    )
    np.savetxt(path, rows, delimiter="\t", header=header, comments="", fmt="%.6f")
    return path


def four_files(folder: Path) -> Path:
    """A folder of tests whose names hold their inputs."""
    for name in ("run10_0.5A.txt", "run2_0.25A.txt", "run2_0.5A.csv", "quake_1,5A.txt"):
        put(folder / name)
    return folder


def say(folder: Path, text: str) -> None:
    """Write the folder's reading.toml."""
    (folder / "reading.toml").write_text(
        text + '\n[units]\ntime = "s"\ndisplacement = "mm"\nforce = "N"\n', encoding="utf-8"
    )
