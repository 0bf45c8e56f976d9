"""``dampyr motion``, and how ``dampyr simulate`` scales a ground motion."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from tests.show.pages.test_html_page import Reader

from dampyr.cli import cli
from dampyr.cli._motion import acceleration, ratio, spectral
from dampyr.errors import InputError
from dampyr.ground_motions import corrected, el_centro, measures, spectrum
from dampyr.ground_motions.intensity_measures import sa

G = 9.80665


def run(*args: str | Path) -> Result:
    return CliRunner().invoke(cli, list(map(str, args)))


def run_json(*args: str | Path) -> dict[str, Any]:
    result = run(*args, "--json")
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A drifting record in cm/s2, one column."""
    path = tmp_path / "quake.txt"
    t = np.arange(3000) * 0.01
    np.savetxt(path, 100.0 * np.sin(6 * t) * np.exp(-0.1 * t) + 1.0)
    return path


def test_machines_get_what_the_room_computes() -> None:
    output = run_json("motion", "--damping", "2%", "--damping", "0.05", "--period", "0.5", "--period", "2")
    expected = measures(el_centro())
    assert output["pga_m_s2"] == expected.pga
    assert output["arias_m_s"] == expected.arias
    assert output["duration_5_75_s"] == expected.duration_5_75
    np.testing.assert_array_equal(
        output["spectrum"]["displacement_m"], spectrum(el_centro(), [0.5, 2.0], [0.02, 0.05]).displacement
    )
    assert (output["samples"], output["dt_s"], output["history"]) == (1560, 0.02, [])


def test_a_table_of_a_motion_is_declared(tmp_path: Path) -> None:
    path = tmp_path / "quake.csv"
    rows = "".join(f"{10 * k},{(37 * k) % 100 - 50},{k}\n" for k in range(400))
    path.write_text(f"Clock,Channel 3,Other\n{rows}")
    declared = ("--column", "time=Clock", "--column", "acceleration=Channel 3", "--unit", "time=ms")
    assert "no unit is known for the acceleration" in run("motion", path, *declared).stderr
    output = run_json("motion", path, *declared, "--motion-unit", "gal")
    assert (output["samples"], output["dt_s"], output["pga_m_s2"]) == (400, 0.01, pytest.approx(0.5))
    factor = run_json("motion", path, *declared, "--factor", "acceleration=0.002 g", "--header", "1")
    assert factor["pga_m_s2"] == pytest.approx(0.1 * G)
    assert factor["history"] == ["acceleration is 0.002 g times 'Channel 3' in the file, as declared"]
    simulated = run_json("simulate", "--motion", path, *declared, "--motion-unit", "gal", "--without-damper")
    assert list(simulated) == ["no damper"]
    assert "--unit belongs to a file that is given with --motion" in run("motion", *declared).stderr


def test_people_get_tables_in_their_units(file: Path) -> None:
    shown = run("motion").stdout
    assert "El Centro 1940 NS: 1560 samples every 0.02 s, 31.18 s" in shown
    row = next(line.split() for line in shown.splitlines() if line.split()[:2] == ["5", "0.5"])
    assert row == ["5", "0.5", "57.05", "717", "9.01", "0.9187"]
    drifting = run("motion", file, "--motion-unit", "cm/s^2", "--dt", "0.01").stdout
    assert "a raw record drifts" in drifting
    assert "(dampyr motion --baseline)" in drifting
    assert "drifts" not in run("motion", file, "--motion-unit", "cm/s^2", "--dt", "0.01", "--baseline").stdout


def test_a_file_its_baseline_and_its_scale(file: Path) -> None:
    plain = ("motion", file, "--motion-unit", "cm/s^2", "--dt", "0.01")
    raw, straight = run_json(*plain), run_json(*plain, "--baseline", "--pga", "0.3g")
    assert raw["name"] == "quake"
    assert straight["pga_m_s2"] == pytest.approx(0.3 * G, rel=1e-12)
    assert straight["pgd_m"] < 0.2 * raw["pgd_m"]
    assert [note.split()[0] for note in straight["history"]] == ["baseline", "scaled"]


def test_simulate_scales_the_same_way() -> None:
    case = ("simulate", "--voltage", "1.98")
    bare = {key: run_json(*case, *more)["no damper"]["peak_displacement_m"][0] for key, more in {
        "none": (), "scale": ("--scale", "2"), "pga": ("--pga", "0.5g"), "sa": ("--sa", "0.5g@0.48s@3%"),
    }.items()}  # fmt: skip
    assert bare["scale"] == pytest.approx(2 * bare["none"], rel=1e-9)
    assert bare["pga"] == pytest.approx(0.5 * G / el_centro().pga * bare["none"], rel=1e-9)
    assert bare["sa"] == pytest.approx(0.5 * G / sa(el_centro(), 0.48, 0.03) * bare["none"], rel=1e-9)


def test_a_page_shows_histories_and_spectra(tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    assert run("motion", "--baseline", "--damping", "3%", "--period", "0.48", "--report", path).exit_code == 0
    reader = Reader(path.read_text(encoding="utf-8"))
    assert [tag for tag, _ in reader.tags].count("svg") == 3
    texts = " ".join(text for _, text in reader.texts)
    for words in ("El Centro 1940 NS", "Arias intensity", "displacement [mm]", "pseudo-acceleration [m/s²]", "3 %: "):
        assert words in texts
    assert "Baseline of degree 2" in texts or "baseline of degree 2" in texts
    assert f"{sa(corrected(el_centro()), 0.48, 0.03):.4g}" in texts


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--pga", "3"), "'3' has no unit; write it as in 3g or '3 m/s^2'"),
        (("--pga", "0.3g", "--scale", "2"), "--scale and --pga contradict each other; give one of them"),
        (("--pga", "-1g"), "must be greater than 0"),
        (("--sa", "3g"), "write it as in 0.5g@0.48s or 0.5g@0.48s@5%"),
        (("--sa", "3g@0.5mm"), "does not measure"),
        (("--damping", "5"), "a damping of 5 is not allowed; it must be from 0 to less than 1, as in 5% or 0.05"),
        (("--damping", "five"), "'five' is not a damping"),
        (("--period", "-1"), "periods: -1 s is not allowed"),
        (("--dt", "0.01"), "belong to a file that is given with --motion"),
        (("nothing.at2",), "no such file"),
    ],
)
def test_what_is_wrong_is_one_line(arguments: tuple[str, ...], words: str) -> None:
    result = run("motion", *arguments)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert words in result.stderr


def test_quantities_as_they_are_typed() -> None:
    assert acceleration("0.3g") == acceleration(" 0.3 g") == pytest.approx(0.3 * G, rel=1e-14)
    assert acceleration("300Gal") == pytest.approx(3.0, rel=1e-14)
    assert spectral("0.5g@480ms") == (pytest.approx(0.5 * G), pytest.approx(0.48), 0.05)
    assert spectral("5 m/s^2@0.48@2%") == (5.0, 0.48, 0.02)
    assert ratio("2%") == ratio("0.02") == 0.02
    with pytest.raises(InputError, match="has no unit"):
        spectral("0.5@0.48s")
