"""A folder of ground motions as a stranger has it: what each file holds, in one command."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from tests.ground_motions import accelerograph_files as files
from tests.ground_motions.accelerograph_files import shaking

from dampyr.cli import cli
from dampyr.errors import MissingData
from dampyr.ground_motions import read_components, read_folder, rotated_spectrum


def station_of_knet(folder):
    """Three files of one station, as they lie in a folder of K-NET, and two of another."""
    for station, directions in (("AAA001", ("E-W", "N-S", "U-D")), ("BBB002", ("E-W", "U-D"))):
        for k, direction in enumerate(directions):
            counts = np.round(shaking(201, seed=k, peak=1e5))
            gal = 3920 / 6182761 * np.abs(counts - counts.mean()).max()
            path = folder / f"{station}0102030405.{direction.replace('-', '')}"
            files.knet(path, counts, gal, direction, station=station)


def stations_of_esm(folder):
    for k, stream in enumerate(("HNE", "HNN", "HNZ")):
        files.esm(folder / f"XX.ABC..{stream}.D.ASC", shaking(seed=k), stream)


THREE = {"N-S": shaking(seed=1), "E-W": shaking(seed=2), "U-D": shaking(seed=3)}
DEGREES = {"360 Deg": shaking(seed=4), "90 Deg": shaking(), "Up": shaking(seed=5)}
ROUNDED = {"N28W": shaking().round(1), "Up": shaking(seed=2).round(1)}
PEER = "PEER\nNowhere\nACCELERATION IN UNITS OF G\nNPTS= 3, DT= .01 SEC\n.1 .2 .3\n"
FOLDERS = {
    "K-NET": (station_of_knet, 5, 1),
    "ESM": (stations_of_esm, 3, 1),
    "SMC": (lambda folder: [files.smc(folder / f"{k}.smc", shaking(seed=k)) for k in (2, 10)], 2, 0),
    "COSMOS": (lambda folder: files.cosmos(folder / "a.v2c", DEGREES), 3, 1),
    "CSMIP": (lambda folder: files.csmip_v2(folder / "CE1.V2", DEGREES), 3, 1),
    "volume 1": (
        lambda folder: files.volume_1(folder / "a.s0a", {"N08W": (0.02 * np.arange(41), 0.01 * shaking())}), 1, 0,
    ),
    "GeoNet": (lambda folder: files.geonet(folder / "a.V1A", ROUNDED, 1), 2, 0),
    "AFAD": (lambda folder: files.afad(folder / "2001_0001.txt", THREE), 3, 1),
    "PEER": (lambda folder: (folder / "a.AT2").write_text(PEER), 1, 0),
}  # fmt: skip
"""Of each kind what writes it, how many components it holds, and how many pairs of horizontal ones."""


@pytest.mark.parametrize("kind", FOLDERS)
def test_a_strangers_folder_in_one_command_without_an_option(tmp_path, kind):
    write, components, pairs = FOLDERS[kind]
    write(tmp_path)
    result = CliRunner().invoke(cli, ["motion", str(tmp_path), "--json"])
    assert result.exit_code == 0, result.stderr
    answer = json.loads(result.stdout)
    assert len(answer["motions"]) == components
    assert not [entry for entry in answer["motions"] if "problem" in entry]
    assert len(answer["rotated"]) == pairs
    table = read_folder(tmp_path)
    assert [entry["pga_m_s2"] for entry in answer["motions"]] == [motion.pga for motion in table.motions]
    for stated, (first, second) in zip(answer["rotated"], table.horizontal_pairs, strict=True):
        periods = stated["period_s"]
        assert stated["rotd50_m_per_s2"] == pytest.approx(rotated_spectrum(first, second, periods).rotd50.tolist())


def test_the_table_has_every_file_and_says_why_one_is_refused(tmp_path):
    files.afad(tmp_path / "record10.txt", THREE)
    files.esm(tmp_path / "record2.asc", shaking(), peak=120.0)
    (tmp_path / "record3.txt").write_text("0.1\n0.2\n0.1\n")
    (tmp_path / ".hidden").write_text("")
    (tmp_path / "older").mkdir()
    table = read_folder(tmp_path)
    assert [(entry.file, entry.format, entry.component) for entry in table.entries] == [
        ("record2.asc", "esm", "HNE"), ("record3.txt", "columns", ""),
        *(("record10.txt", "afad", name) for name in ("N-S", "E-W", "U-D")),
    ]  # fmt: skip
    assert "the header says 120" in table.entries[0].problem
    assert "no unit is known" in table.entries[1].problem
    shown = CliRunner().invoke(cli, ["motion", str(tmp_path), "--damping", "2%", "--period", "0.5"]).stdout
    assert "record2.asc: HNE: the samples peak at 100 cm/s^2 and the header says 120 cm/s^2" in shown
    assert "record3.txt: No unit is known for the acceleration; declare it, such as --motion-unit g" in shown
    assert "Pseudo-acceleration over all angles, record10 N-S and record10 E-W, damping 2 %" in shown
    # unit and step are for the plain files alone
    stated = read_folder(tmp_path, units="g", dt=0.01)
    assert [entry.file for entry in stated.entries if entry.problem] == ["record2.asc"]


def test_a_file_with_several_components_is_told_of_until_one_is_chosen(tmp_path):
    path = files.afad(tmp_path / "record.txt", THREE)
    run = CliRunner().invoke
    assert "Ground motions in" in run(cli, ["motion", str(path)]).stdout
    assert "record E-W: 41 samples" in run(cli, ["motion", str(path), "--component", "E-W"]).stdout
    assert json.loads(run(cli, ["motion", str(path), "--component", "e-w", "--json"]).stdout)["name"] == "record E-W"
    refused = run(cli, ["motion", str(path), "--pga", "0.3g"])
    assert (refused.exit_code, refused.stdout) == (2, "")
    assert "--pga is of one motion; choose one with --component" in refused.stderr
    simulated = run(cli, ["simulate", "--voltage", "1", "--motion", str(path)])
    assert "holds 3 components (N-S, E-W, U-D); choose one, such as --component 'N-S'\n" in simulated.stderr
    assert list(read_components(path)) == ["N-S", "E-W", "U-D"]


def test_no_folder_and_no_files(tmp_path):
    with pytest.raises(MissingData, match="there is no such file or folder"):
        read_folder(tmp_path / "nothing")
    with pytest.raises(MissingData, match="the folder has no files"):
        read_folder(tmp_path)


def test_the_three_files_of_a_peer_recording_belong_together(tmp_path):
    def write(name, component, samples=41, station="El Centro Array #9"):
        rows = "\n".join(f"{0.1 * np.sin(0.3 * k + samples):.7E}" for k in range(samples))
        head = f"PEER NGA STRONG MOTION DATABASE RECORD\nImperial Valley-02, 5/19/1940, {station}, {component}\n"
        units = "ACCELERATION TIME SERIES IN UNITS OF G\n"
        (tmp_path / name).write_text(f"{head}{units}NPTS= {samples}, DT= .0100 SEC\n{rows}\n")

    write("RSN6_IMPVALL.I_I-ELC180.AT2", "180")
    write("RSN6_IMPVALL.I_I-ELC270.AT2", "270")
    write("RSN6_IMPVALL.I_I-ELC-UP.AT2", "UP")
    write("RSN7_1.AT2", "180", station="another one")
    write("RSN7_2.AT2", "270", 43, station="another one")  # of another length
    table = read_folder(tmp_path)
    assert [entry.component for entry in table.entries] == ["180", "270", "UP", "180", "270"]
    assert [entry.vertical for entry in table.entries] == [False, False, True, False, False]
    [(first, second)] = table.horizontal_pairs
    assert (first.name, second.name) == ("RSN6_IMPVALL.I_I-ELC180", "RSN6_IMPVALL.I_I-ELC270")
    shown = CliRunner().invoke(cli, ["motion", str(tmp_path), "--period", "0.5"]).stdout
    assert "over all angles, RSN6_IMPVALL.I_I-ELC180 and RSN6_IMPVALL.I_I-ELC270" in shown
