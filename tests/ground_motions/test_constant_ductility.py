"""Chopra (2017), chapter 7: oscillators that yield, beside closed forms and a plain central difference with return mapping."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, el_centro, inelastic_spectrum, spectrum, trimmed

EARLY = GroundMotion(el_centro().acceleration[:400], 0.02, "the first 8 s of El Centro")


def ductilities(motion, periods, strengths, zeta, alpha, parts):
    """max |u| / u_y of oscillators (p,) by central differences, the spring mapped back to its yield surface each step."""
    omega2 = (2 * np.pi / np.asarray(periods)) ** 2
    uy, dt = np.asarray(strengths) / omega2, motion.dt / parts
    time = np.arange((motion.n - 1) * parts + 1) * dt
    ground = np.interp(time, motion.time, motion.acceleration)
    damped = zeta * np.sqrt(omega2) / dt
    u, s, peak = np.zeros_like(uy), np.zeros_like(uy), np.zeros_like(uy)
    before = np.full_like(uy, -0.5 * dt**2 * ground[0])
    for g in ground:
        force = alpha * omega2 * u + (1 - alpha) * omega2 * s
        after = ((2 * u - before) / dt**2 + damped * before - g - force) / (1 / dt**2 + damped)
        s = np.clip(s + after - u, -uy, uy)
        before, u = u, after
        peak = np.maximum(peak, np.abs(u))
    return peak / uy


@pytest.mark.parametrize("hardening", [0.0, 0.1])
@pytest.mark.parametrize("mu", [1.5, 4.0, 10.0])
def test_a_load_that_stays_needs_the_strength_of_the_closed_form(mu, hardening):
    """Its work is what the spring takes up to the first turn: A_y = a mu / (1/2 + (mu - 1) + alpha (mu - 1)^2 / 2)."""
    a = 3.0
    found = inelastic_spectrum(GroundMotion(np.full(401, a), 0.01), mu, [0.4, 1.0], damping=0.0, hardening=hardening)
    expected = a * mu / (0.5 + (mu - 1) + 0.5 * hardening * (mu - 1) ** 2)
    assert found.strength[0] == pytest.approx([expected, expected], rel=1e-7)


def test_at_a_ductility_of_one_it_is_the_elastic_spectrum():
    periods = [0.1, 0.5, 1.0, 3.0]
    found = inelastic_spectrum(el_centro(), [1.0, 2.0], periods, 0.02)
    elastic = spectrum(el_centro(), periods, 0.02)
    assert found.strength[0] == pytest.approx(elastic.pseudo_acceleration, rel=1e-12)
    assert found.displacement[0] == pytest.approx(elastic.displacement, rel=1e-12)
    assert found.reduction[0] == pytest.approx(np.ones(4))
    nearly = inelastic_spectrum(el_centro(), 1.0001, periods, 0.02)
    assert nearly.strength[0] == pytest.approx(elastic.pseudo_acceleration, rel=2e-3)


@pytest.mark.parametrize("hardening", [0.0, 0.05])
def test_the_ductility_is_that_of_a_plain_integration(hardening):
    periods, mu = np.array([0.2, 0.5, 1.0, 2.0]), [1.5, 2.0, 4.0]
    found = inelastic_spectrum(EARLY, mu, periods, 0.05, hardening)
    ours = ductilities(EARLY, np.tile(periods, 3), found.strength.ravel(), 0.05, hardening, 100)
    assert ours.reshape(3, 4) == pytest.approx(np.repeat(np.array(mu)[:, None], 4, axis=1), rel=1e-3)
    yielding = found.strength / (2 * np.pi / periods) ** 2
    assert found.displacement == pytest.approx(yielding * np.array(mu)[:, None], rel=1e-6)


def test_no_stronger_oscillator_has_the_ductility():
    """Between the strength found and the elastic one the plain integration stays below it."""
    found = inelastic_spectrum(EARLY, 3.0, [0.3, 0.7])
    for k, period in enumerate(found.periods):
        stronger = np.geomspace(1.01 * found.strength[0, k], found.elastic[k], 40)
        assert ductilities(EARLY, np.full(40, period), stronger, 0.05, 0.0, 40).max() < 3.0


def test_where_weaker_ones_have_it_too_it_is_said():
    periods = np.geomspace(0.3, 3.0, 25)
    found = inelastic_spectrum(el_centro(), [2.0, 4.0, 8.0], periods)
    assert found.several.any()
    assert "weaker oscillators have the same ductility; the strongest is taken" in found.findings[0].words
    d, p = np.argwhere(found.several)[0]
    weaker = found.strength[d, p] * 0.99 ** np.arange(1, 160)
    over = ductilities(el_centro(), np.full(159, periods[p]), weaker, 0.05, 0.0, 20)
    wanted = found.ductility[d]
    signs = np.sign(over - wanted)
    assert np.sum(signs[1:] != signs[:-1]) >= 2  # above it, below it again, and above


def test_what_cannot_be_reached_is_told():
    """An undamped oscillator in resonance swings a hundred times as far as a weak one, which yields before it does."""
    time = 0.02 * np.arange(2001)
    found = inelastic_spectrum(GroundMotion(np.cos(2 * np.pi * time), 0.02), 50.0, 1.0, damping=0.0)
    assert np.isnan(found.strength).all()
    assert "has the ductility; leave out the shortest periods or lower the ductility" in found.findings[0].words
    assert found.as_dict()["strength_m_per_s2"]


def test_it_shows_itself_and_draws():
    found = inelastic_spectrum(trimmed(el_centro(), 0.05, 0.5), [2.0, 4.0], [0.5, 1.0], hardening=0.03)
    assert "bilinear, 3 % hardening" in str(found)
    assert found.to_dataframe().shape == (4, 6)
    with pytest.raises(InputError, match="'force' is not a quantity of an inelastic spectrum; choose from strength"):
        found.plot("force")
    with pytest.raises(InputError, match="a figure needs two periods or more"):
        inelastic_spectrum(EARLY, 2.0, 0.5).plot()


@pytest.mark.parametrize(
    ("choices", "words"),
    [
        ({"ductility": 0.5}, r"ductility = \[0.5\] is not allowed; give numbers from 1 to 50"),
        ({"ductility": [2.0, np.nan]}, "give numbers from 1 to 50"),
        ({"periods": [0.0, 1.0]}, "they must be finite and greater than 0, in s"),
        ({"damping": 5.0}, "damping = 5 is not allowed; it must be from 0 to less than 1"),
        ({"hardening": 3.0}, r"hardening = 3 is not allowed; .* \(0.03 for 3 %\)"),
        ({"motion": GroundMotion(np.zeros(9), 0.02)}, "is 0 throughout, so that no oscillator yields"),
    ],
)
def test_what_makes_no_sense_is_refused(choices, words):
    usual = {"motion": EARLY, "ductility": 2.0, "periods": [0.5]}
    with pytest.raises(InputError, match=words):
        inelastic_spectrum(**(usual | choices))


def test_the_command_tells_strengths(tmp_path):
    words = ["motion", "--ductility", "4", "--period", "0.5", "--period", "1", "--damping", "2%", "--hardening", "3%"]
    done = CliRunner().invoke(cli, [*words, "--json"])
    assert done.exit_code == 0, done.output
    told = json.loads(done.output)["inelastic"]
    expected = inelastic_spectrum(el_centro(), 4.0, [0.5, 1.0], 0.02, 0.03)
    assert told["strength_m_per_s2"] == expected.strength.tolist()
    assert "Spectrum of constant ductility" in CliRunner().invoke(cli, words).output
    for wrong, match in (
        (["--hardening", "3%"], "--hardening belongs to --ductility"),
        (["--ductility", "2", "--damping", "2%", "--damping", "5%"], "--ductility is for one --damping"),
    ):
        refused = CliRunner().invoke(cli, ["motion", *wrong])
        assert refused.exit_code == 2
        assert match in refused.output
