"""Velocity and force only: the displacement is integrated, and what became of its drift is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import DampyrWarning, FileError
from dampyr.records import Record, read

OMEGA = 2.0 * np.pi * 0.8


def written(path: Path, t: np.ndarray, v: np.ndarray, head: str = "t [s],v [mm/s],f [N]") -> Path:
    rows = "\n".join(f"{a:.17g},{b:.17g},{c:.17g}" for a, b, c in zip(t, v, np.nan_to_num(3.0 * v), strict=True))
    path.write_text(f"{head}\n{rows}\n", encoding="utf-8")
    return path


def from_velocity(path: Path, **said: object) -> Record:
    with pytest.warns(DampyrWarning, match="displacement integrated from the velocity"):
        return read(path, **said)  # type: ignore[arg-type]


@pytest.mark.parametrize("zero", [0.0, 0.3, -1.5])
def test_a_zero_error_of_the_velocity_is_taken_away_and_told(tmp_path: Path, zero: float) -> None:
    """A sine with an error of ``zero`` mm/s that would carry it 1.5 strokes away in 20 s."""
    t = 0.002 * np.arange(10_000)
    record = from_velocity(written(tmp_path / "a.csv", t, 10.0 * OMEGA * np.cos(OMEGA * t) + zero))
    # the cycles begin at samples, so that the drift is judged to a thousandth of the stroke and a few um/s
    np.testing.assert_allclose(record.displacement, 0.010 * np.sin(OMEGA * t), atol=2e-5)
    np.testing.assert_allclose(record.velocity, 0.010 * OMEGA * np.cos(OMEGA * t), atol=5e-6)
    if zero:
        assert f"drift of {zero:.3g} mm/s, {20 * zero:.3g} mm in all, removed" in record.provenance["displacement"]
    assert record.provenance["displacement"].startswith("integrated from the velocity; drift of")
    assert any(
        note.startswith("displacement integrated from the velocity; drift of")
        for note in [one.words for one in record.findings]
    )
    assert record.history[1:2] == ("displacement integrated from the velocity by trapezoids, 0 at the first sample",)
    assert record.history[2].endswith("removed from it and from the velocity")


def test_without_repeating_cycles_nothing_is_taken_away(tmp_path: Path) -> None:
    t = np.concatenate([np.linspace(0.0, 1.0, 400), np.linspace(1.003, 4.0, 500)])  # uneven
    x = 5.0 * t**2 * np.exp(-t)  # mm
    record = from_velocity(written(tmp_path / "a.csv", t, 5.0 * (2.0 * t - t**2) * np.exp(-t)))
    np.testing.assert_allclose(record.displacement, 1e-3 * x, atol=1e-7)
    ends = f"no repeating cycle to judge its drift by, nothing removed: it ends {x[-1]:.3g} mm from its start"
    assert record.provenance["displacement"] == f"integrated from the velocity; {ends}"
    assert ends in record.history


def test_a_displacement_that_is_left_out_is_integrated_anew(tmp_path: Path) -> None:
    t = 0.01 * np.arange(500)
    path = tmp_path / "a.csv"
    rows = "\n".join(f"{a},{b},7,{b}" for a, b in zip(t, np.cos(6.0 * t), strict=True))
    path.write_text(f"t [s],v [mm/s],x [mm],f [N]\n{rows}", encoding="utf-8")
    assert np.ptp(read(path).displacement) == 0.0
    assert np.ptp(from_velocity(path, columns={"displacement": "-"}).displacement) == pytest.approx(
        1e-3 / 3.0, rel=1e-2
    )


def test_a_fault_of_the_velocity_is_named_as_one(tmp_path: Path) -> None:
    t = 0.01 * np.arange(50)
    v = np.cos(t)
    v[7] = np.nan
    with pytest.raises(FileError, match=r"a\.csv: velocity\[7\] = nan m/s is not finite"):
        read(written(tmp_path / "a.csv", t, v))
