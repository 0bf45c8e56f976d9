"""EN 1998-1:2004, 3.2.2.2 and tables 3.2 and 3.3; ASCE 7, 11.4: values at corners worked out by hand."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.optimize import minimize_scalar

from dampyr.cli import cli
from dampyr.errors import InputError
from dampyr.ground_motions import asce_7, compare_with_design, el_centro, eurocode_8, scaled_to_design, spectrum
from dampyr.ground_motions.design_spectra import EN_1998_1

TABLES = """
1 A 1.00 0.15 0.40 2.0
1 B 1.20 0.15 0.50 2.0
1 C 1.15 0.20 0.60 2.0
1 D 1.35 0.20 0.80 2.0
1 E 1.40 0.15 0.50 2.0
2 A 1.00 0.05 0.25 1.2
2 B 1.35 0.05 0.25 1.2
2 C 1.50 0.10 0.25 1.2
2 D 1.80 0.10 0.30 1.2
2 E 1.60 0.05 0.25 1.2
"""


@pytest.mark.parametrize("line", TABLES.split("\n")[1:-1])
def test_the_spectra_of_en_1998_at_their_corners_and_between_them(line: str) -> None:
    kind, ground, *numbers = line.split()
    s, first, second, third = map(float, numbers)
    design = eurocode_8(2.0, ground, int(kind))
    periods = [0.0, 0.5 * first, first, second, 0.5 * (second + third), third, 3.0]
    falling = [5.0 * s * second / periods[4], 5.0 * s * second / third, 5.0 * s * second * third / 9.0]
    np.testing.assert_allclose(design.at(periods), [2 * s, 3.5 * s, 5 * s, 5 * s, *falling], rtol=1e-12)
    assert len(EN_1998_1[int(kind)]) == 5


def test_the_damping_of_en_1998() -> None:
    for damping, eta in ((0.05, 1.0), (0.02, np.sqrt(10 / 7)), (0.10, np.sqrt(2 / 3)), (0.4, 0.55)):
        assert eurocode_8(2.0, "B", damping=damping).at(0.3) == pytest.approx(2.5 * eta * 2.0 * 1.2, rel=1e-12)
    assert eurocode_8(2.0, "B", damping=0.4).at(0.0) == pytest.approx(2.4, rel=1e-12)


def test_the_spectrum_of_asce_7_at_its_corners_and_between_them() -> None:
    design = asce_7(9.80665, 0.6 * 9.80665, 8.0)
    periods = [0.0, 0.06, 0.12, 0.6, 1.2, 8.0, 16.0]
    np.testing.assert_allclose(design.at(periods) / 9.80665, [0.4, 0.7, 1.0, 1.0, 0.5, 0.075, 0.01875], rtol=1e-12)


def test_the_factor_is_that_of_least_squares() -> None:
    motion, design = el_centro(), eurocode_8(0.3 * 9.80665, "C", damping=0.02)
    scaled = scaled_to_design(motion, design, 0.2, 2.0)
    periods = np.geomspace(0.2, 2.0, 100)
    own = spectrum(motion, periods, 0.02).pseudo_acceleration
    best = minimize_scalar(lambda f: np.sum((f * own - design.at(periods)) ** 2), options={"xtol": 1e-12}).x
    assert scaled.pga / motion.pga == pytest.approx(best, rel=1e-7)
    said = f"scaled by {best:.6g}, by least squares to EN 1998-1 type 1, ground C at 2 % damping from 0.2 to 2 s"
    assert scaled.history == (said,)
    compared = compare_with_design(scaled, design, periods)
    np.testing.assert_allclose(compared.ratio, best * own / design.at(periods), rtol=1e-6)


@pytest.mark.parametrize(
    ("words", "match"),
    [
        (["--design", "ec8:ag=0.3,ground=C"], "ag = 0.3 has no unit; write it as in ag=0.3g"),
        (["--design", "ec8:ag=0.3g,ground=F"], "ground 'F' has no spectrum in EN 1998-1; choose from A, B, C, D, E"),
        (["--design", "ec8:ag=0.3g,ground=C,type=3"], "type 3 is not one of EN 1998-1; choose 1, or 2"),
        (["--design", "ec8:ag=-0.3g,ground=C"], "it must be finite and greater than 0"),
        (["--design", "ec9:ag=1g"], "'ec9:ag=1g' is not a design spectrum; write it as in asce7:sds=1g"),
        (["--design", "asce7:sds=1g,sd1=0.6g,tl=0.1s"], "sd1/sds = 0.6 s is longer than tl = 0.1 s"),
        (["--design", "ec8:ag=0.3g,ground=C", "--period", "5"], "5 s is outside of the spectrum EN 1998-1 type 1"),
        (["--fit-design", "0.2:2"], "--fit-design needs a design spectrum; give it, such as --design ec8"),
        (
            ["--design", "ec8:ag=1g,ground=C", "--fit-design", "2:1"],
            "from 2 to 1 s are no range; give the shorter one first",
        ),
        (
            ["--design", "ec8:ag=1g,ground=C", "--fit-design", "2"],
            "'2' is not a range of periods; write it as in 0.2:2",
        ),
        (["--design", "ec8:ag=1g,ground=C", "--fit-design", "1:2", "--pga", "1g"], "leave --scale, --pga and --sa out"),
    ],
)
def test_what_is_wrong_is_said(words: list[str], match: str) -> None:
    done = CliRunner().invoke(cli, ["motion", *words])
    assert done.exit_code != 0
    assert match in done.output


def test_the_command_shows_both_spectra_in_text_json_and_on_the_page(tmp_path: Path) -> None:
    words = ["motion", "--design", "ec8:ag=0.3g,ground=c,damping=2%", "--fit-design", "0.2:2", "--period", "0.5"]
    done = CliRunner().invoke(cli, [*words, "--period", "1", "--report", str(tmp_path / "m.html")])
    assert done.exit_code == 0, done.output
    assert "Pseudo-acceleration beside EN 1998-1 type 1, ground C, damping 2 %" in done.output
    assert "EN 1998-1 type 1, ground C" in (tmp_path / "m.html").read_text(encoding="utf-8")
    beside = json.loads(CliRunner().invoke(cli, [*words, "--json"]).output)["design"]
    assert beside["design_acceleration_m_per_s2"] == pytest.approx([2.5 * np.sqrt(10 / 7) * 0.3 * 9.80665 * 1.15])
    with pytest.raises(InputError, match="outside of the spectrum"):
        eurocode_8(1.0, "A").at(4.5)
