"""Which motions repeat themselves, and what is told of those that do not; forces written side by side."""

from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import FileError
from dampyr.records import Record, overview
from dampyr.records.checks.label_checks import creates_energy, disagreements
from dampyr.records.files.comparison import write_comparison


def chirp(sign: float = 1.0) -> Record:
    """0.2 to 2 Hz in 10 s, with most of its speed where it is fast."""
    t = 0.005 * np.arange(2001)
    x = 0.01 * np.sin(2 * np.pi * (0.2 * t + 0.09 * t**2))
    return Record(t, x, sign * 800.0 * np.gradient(x, t) + 70.0)


def test_a_sine_repeats_itself(make_sine) -> None:
    seen = overview(make_sine(third=0.1, drift=2e-4))
    assert seen.repeats
    assert seen.dominant_hz == pytest.approx(0.9, abs=0.1)
    assert seen.rms_speed == pytest.approx(0.010 * 2 * np.pi * 0.9 * np.sqrt((1 + 0.09) / 2), rel=0.03)


def test_the_campaign_repeats_itself(published: list[Record]) -> None:
    assert all(overview(record).repeats for record in published)


def test_a_motion_of_many_frequencies_does_not() -> None:
    from tests.stories.laboratory import earthquake

    for seed in (1, 2, 3, 4):
        t, x = earthquake(seed)
        seen = overview(Record(t, x, np.gradient(x, t)))
        assert not seen.repeats
        assert seen.stroke_m == np.ptp(x)
        assert seen.rms_speed == pytest.approx(float(np.sqrt(np.mean(np.gradient(x, t) ** 2))), rel=0.02)


def test_a_sweep_does_not_and_its_work_tells_the_sign() -> None:
    assert not overview(chirp()).repeats
    assert overview(chirp()).work == pytest.approx(
        800.0 * np.trapezoid(np.gradient(chirp().displacement, 0.005) ** 2) * 0.005, rel=0.01
    )
    assert not creates_energy(chirp())
    assert creates_energy(chirp(-1.0))


def test_half_a_cycle_with_an_inverted_force_is_flagged() -> None:
    t = 0.01 * np.arange(100)
    x = 0.01 * np.sin(3.0 * t)
    record = Record(t, x, -500.0 * np.gradient(x, t), name="half")
    assert "half: its loops create energy" in disagreements(record)[0]
    assert disagreements(record.replace(note="turned", force=-record.force)) == []


def test_forces_side_by_side(tmp_path: Path) -> None:
    record = chirp()
    path = write_comparison(record, 0.5 * record.force, tmp_path / "a.csv", offset=3.0)
    table = np.loadtxt(path, delimiter=",", skiprows=3)
    np.testing.assert_allclose(table.T[:3], [record.time, record.displacement, record.force], rtol=1e-8)
    np.testing.assert_allclose(table.T[3], 0.5 * record.force + 3.0, rtol=1e-8)
    assert path.read_text().splitlines()[2] == "time [s],displacement [m],measured force [N],predicted force [N]"
    write_comparison(record, record.force, path)
    np.testing.assert_allclose(np.loadtxt(path, delimiter=",", skiprows=3)[:, 3], record.force, rtol=1e-8)
    assert [each.name for each in tmp_path.iterdir()] == ["a.csv"]


def test_a_file_of_somebody_else_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("mine\n")
    with pytest.raises(FileError, match="was not written by dampyr"):
        write_comparison(chirp(), chirp().force, tmp_path / "a.csv")
    assert (tmp_path / "a.csv").read_text() == "mine\n"
    with pytest.raises(FileError, match="cannot be written"):
        write_comparison(chirp(), chirp().force, tmp_path / "no" / "a.csv")
