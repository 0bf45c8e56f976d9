"""Al Atik and Abrahamson (2010): El Centro matched to EN 1998-1, beside spectra by SciPy and sums of its samples."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.signal import lsim

import dampyr as dp
from dampyr.cli import cli
from dampyr.errors import FileError, InputError
from dampyr.ground_motions import (
    GroundMotion,
    TableSpectrum,
    asce_7,
    el_centro,
    eurocode_8,
    kanai_tajimi,
    matched_to_design,
    read_table_spectrum,
)
from dampyr.ground_motions.spectrum_matching import hat_responses, wavelet

CODE = eurocode_8(ag=2.943, ground="C")


@pytest.fixture(scope="module")
def matched():
    return matched_to_design(el_centro(), CODE, 0.1, 4.0)


def by_lsim(motion, periods, zeta, parts):
    """Pseudo-accelerations by SciPy's first-order hold on steps so fine that the peaks at samples are those between."""
    time = np.arange((motion.n - 1) * parts + 1) * motion.dt / parts
    ground = np.interp(time, motion.time, motion.acceleration)
    peaks = []
    for period in periods:
        w = 2 * np.pi / period
        system = ([[0.0, 1.0], [-(w**2), -2 * zeta * w]], [[0.0], [-1.0]], [[1.0, 0.0]], [[0.0]])
        peaks.append(w**2 * np.abs(lsim(system, ground, time)[1]).max())
    return np.array(peaks)


def test_el_centro_has_the_spectrum_of_the_code_within_five_per_cent(matched):
    """Its own peaks by another program, at periods that are none of those that were matched."""
    periods = np.geomspace(0.1, 4.0, 31) * 1.0007
    periods[-1] = 4.0
    own = by_lsim(matched.motion, periods, 0.05, 6)
    assert np.max(np.abs(own / CODE.at(periods) - 1.0)) < 0.05
    assert np.mean(np.abs(own / CODE.at(periods) - 1.0)) < 0.015
    assert matched.residual < matched.tolerance == 0.05
    assert matched.residual_before > 0.4
    before = by_lsim(matched.scaled, periods, 0.05, 6)
    assert np.max(np.abs(before / CODE.at(periods) - 1.0)) == pytest.approx(matched.residual_before, abs=0.04)
    assert matched.converged
    assert matched.findings == ()


def test_the_ground_ends_at_rest_where_it_began_and_its_quiet_ends_stay_quiet(matched):
    a, h = matched.motion.acceleration, matched.motion.dt
    velocity = np.concatenate([[0.0], np.cumsum(0.5 * h * (a[1:] + a[:-1]))])
    displacement = np.cumsum(h * velocity[:-1] + h**2 / 6 * (2 * a[:-1] + a[1:]))
    assert abs(velocity[-1]) < 1e-12
    assert abs(displacement[-1]) < 1e-11
    added = a - matched.scaled.acceleration
    assert np.abs(added[[0, -1]]).max() < 0.05  # m/s2, what the parabola takes off
    assert np.abs(added).max() > 0.5
    assert matched.arias_ratio == pytest.approx(np.sum(a**2) / np.sum(matched.scaled.acceleration**2))


def test_what_was_done_is_in_its_history_and_shown(matched):
    assert matched.motion.history[-1].startswith(
        "matched to EN 1998-1 type 1, ground C at 5 % damping from 0.1 to 4 s by wavelets"
    )
    assert matched.motion.name == "El Centro 1940 NS, matched"
    shown = matched.as_dict()
    assert shown["residual"] == matched.residual
    assert len(shown["acceleration_m_per_s2"]) == 1560
    assert "PGV" in str(matched)
    frame = matched.to_dataframe()
    assert frame.pseudo_acceleration_m_per_s2.to_numpy() == pytest.approx(matched.after)


def test_steps_that_do_not_suffice_are_told():
    found = matched_to_design(el_centro(), CODE, 0.1, 4.0, iterations=2)
    assert not found.converged
    assert found.iterations <= 2
    assert "and 5 % were wanted; take a record whose spectrum is nearer" in found.findings[0].words
    assert found.residual < found.residual_before


@pytest.mark.prove
@pytest.mark.parametrize(
    ("motion", "design"),
    [
        (el_centro(), eurocode_8(2.943, "A", 2)),
        (el_centro(), TableSpectrum("site", [0.05, 0.1, 0.5, 2.0, 5.0], [5, 8, 8, 2, 0.5])),
        (kanai_tajimi(15.0, 0.02, seed=3, pga=3.0), asce_7(9.8, 5.9, 8.0)),
    ],
    ids=["El Centro, EN 1998-1 A 2", "El Centro, table", "synthetic, ASCE 7"],
)
def test_other_records_and_codes_are_matched_too(motion, design):
    found = matched_to_design(motion, design, 0.1, 4.0)
    assert found.converged
    periods = np.geomspace(0.11, 3.9, 30)
    assert np.max(np.abs(by_lsim(found.motion, periods, 0.05, 6) / design.at(periods) - 1.0)) < 0.05
    assert abs(found.motion.displacement[-1]) < 1e-10


def test_a_sample_of_the_ground_moves_an_oscillator_as_scipy_has_it():
    h, omega, zeta = 0.01, 9.0, 0.05
    ground = np.zeros(400)
    ground[1] = 1.0
    system = ([[0.0, 1.0], [-(omega**2), -2 * zeta * omega]], [[0.0], [-1.0]], [[1.0, 0.0]], [[0.0]])
    expected = lsim(system, ground, np.arange(400) * h)[1]
    ours = hat_responses(np.array([omega]), zeta, h, 400)[0]
    np.testing.assert_allclose(ours[:399], expected[1:], atol=1e-12)


@pytest.mark.parametrize("zeta", [0.02, 0.05, 0.2])
def test_an_oscillator_answers_most_to_its_wavelet_at_the_peak(zeta):
    h, omega, peak = 0.005, 2 * np.pi, 8.0
    t = np.arange(4000) * h
    system = ([[0.0, 1.0], [-(omega**2), -2 * zeta * omega]], [[0.0], [-1.0]], [[1.0, 0.0]], [[0.0]])
    response = lsim(system, wavelet(t, peak, omega, zeta), t)[1]
    near = np.abs(t - peak) < 0.4
    at = t[near][np.argmax(np.abs(response[near]))]
    assert at == pytest.approx(peak, abs=0.12)  # an eighth of the period
    assert np.abs(np.trapezoid(wavelet(t, peak, omega, zeta), t)) < 1e-5  # m/s: it leaves no velocity


@pytest.mark.parametrize(
    ("choices", "words"),
    [
        ({"low": 4.0, "high": 0.1}, "from 4 to 0.1 s are no range"),
        ({"low": 0.05}, r"0.05 s, is less than 4 samples of El Centro 1940 NS \(0.02 s each\); give 0.08 s or more"),
        ({"design": TableSpectrum("t", [0.1, 90.0], [1.0, 1.0]), "high": 60.0}, "60 s, is longer than El Centro"),
        ({"tolerance": 5.0}, "tolerance = 5.0 is not allowed; it must be from 0.001 to 0.5"),
        ({"iterations": 0}, "iterations = 0 is not allowed; it must be a whole number from 1 to 1000"),
        ({"high": 5.0}, "s is outside of the spectrum EN 1998-1 type 1, ground C, from 0 to 4 s"),
        ({"design": eurocode_8(1.0, "A", damping=0.6)}, "is 0.6; wavelets are for 0.5 at most"),
        ({"motion": GroundMotion(np.zeros(1000), 0.02)}, "is 0 throughout and cannot be scaled"),
    ],
)
def test_what_makes_no_sense_is_refused(choices, words):
    usual = {"motion": el_centro(), "design": CODE, "low": 0.1, "high": 4.0}
    with pytest.raises(InputError, match=words):
        matched_to_design(**(usual | choices))


def test_a_table_is_straight_over_logarithms_and_over_numbers_from_zero():
    table = TableSpectrum("t", [0.0, 0.1, 0.4, 4.0], [2.0, 4.0, 4.0, 0.4])
    assert table.at([0.0, 0.05, 0.2, 1.0, 4.0]) == pytest.approx([2.0, 3.0, 4.0, 1.6, 0.4])
    assert table.at(0.4) == pytest.approx(4.0)
    with pytest.raises(InputError, match=r"4\.5 s is outside of the spectrum t, from 0 to 4 s"):
        table.at(4.5)
    for periods, accelerations, words in (
        ([0.1], [1.0], "of two numbers or more"),
        ([0.2, 0.1], [1.0, 1.0], "rise; sort them"),
        ([0.1, 0.2], [1.0, 0.0], "the least is 0"),
    ):
        with pytest.raises(InputError, match=words):
            TableSpectrum("t", periods, accelerations)
    with pytest.raises(InputError, match="damping = 5 is not allowed"):
        TableSpectrum("t", [0.1, 0.2], [1.0, 1.0], damping=5)


def test_a_table_is_read_from_a_file_with_its_unit(tmp_path: Path):
    path = tmp_path / "target.csv"
    path.write_text("site 12\nperiod [s]; Sa [g]\n0,1\n0.1; 0.5\n1e0; 0.25\n", encoding="utf-8")
    table = read_table_spectrum(path, damping=0.02)
    assert table.at([0.1, 1.0]) == pytest.approx(9.80665 * np.array([0.5, 0.25]))
    assert (table.name, table.damping) == ("target.csv", 0.02)
    path.write_text("0.1 0.5\n1.0 0.25\n", encoding="utf-8")
    assert read_table_spectrum(path, "m/s^2").at(0.1) == pytest.approx(0.5)
    with pytest.raises(InputError, match="the unit of the acceleration is not stated; give it, such as unit=g"):
        read_table_spectrum(path)
    path.write_text("nothing\n", encoding="utf-8")
    with pytest.raises(FileError, match="no two lines of a period and an acceleration"):
        read_table_spectrum(path)
    with pytest.raises(FileError, match="cannot be read as text"):
        read_table_spectrum(tmp_path / "none.csv")


def test_the_command_matches_saves_and_shows_it(tmp_path: Path):
    table, saved, page = tmp_path / "target.csv", tmp_path / "m.csv", tmp_path / "m.html"
    table.write_text("T [s], Sa [g]\n0.1,0.6\n0.5,0.6\n2,0.15\n", encoding="utf-8")
    words = ["motion", "--design", f"table:{table}", "--match", "0.2:1", "--period", "0.5"]
    done = CliRunner().invoke(cli, [*words, "--save", str(saved), "--report", str(page)])
    assert done.exit_code == 0, done.output
    assert "only scaled" in done.output
    assert "Matched to target.csv at 5 % damping from 0.2 to 1 s" in done.output
    assert "Matched spectrum" in page.read_text(encoding="utf-8")
    told = json.loads(CliRunner().invoke(cli, [*words, "--json"]).output)
    assert told["matched"]["converged"] is True
    motion = dp.ground_motions.read(saved)
    np.testing.assert_allclose(motion.acceleration, told["matched"]["acceleration_m_per_s2"], rtol=1e-12)
    assert motion.dt == pytest.approx(0.02, rel=1e-9)
    own = by_lsim(motion, [0.25, 0.5, 0.9], 0.05, 10)
    assert np.max(np.abs(own / read_table_spectrum(table).at([0.25, 0.5, 0.9]) - 1.0)) < 0.05


@pytest.mark.parametrize(
    ("words", "match"),
    [
        (["--match", "0.1:4"], "--match needs a design spectrum; give it, such as --design ec8"),
        (["--design", "ec8:ag=1g,ground=C", "--match", "4"], "'4' is not a range of periods; write it as in 0.1:4"),
        (
            ["--design", "ec8:ag=1g,ground=C", "--match", "0.1:4", "--pga", "1g"],
            "leave --scale, --pga, --sa and --fit-design out",
        ),
        (["--design", "table:"], "'table:' is not a table of a spectrum; write it as in table:FILE.csv,unit=g"),
    ],
)
def test_what_is_wrong_on_the_command_line_is_said(words, match):
    done = CliRunner().invoke(cli, ["motion", *words])
    assert done.exit_code == 2
    assert match in done.output
