"""Synthetic ground motions have the density of Kanai (1957), Tajimi (1960), Clough and Penzien (1975), and come to rest."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from dampyr.errors import InputError
from dampyr.ground_motions import FIRM, MEDIUM, SOFT, RisePlateauDecay, ShinozukaSato, Soil, kanai_tajimi, stationary
from dampyr.ground_motions.intensity_measures import pgd, pgv

S0 = 0.01


@pytest.mark.parametrize("soil", [FIRM, SOFT])
def test_the_mean_density_of_many_motions_is_the_formula(soil: Soil) -> None:
    """300 motions in the stationary window, averaged over bands: 5 standard errors of a periodogram's mean."""
    dt, many, start, length = 0.02, 300, 1500, 2048
    window = np.hanning(length)
    power = np.zeros(length // 2 + 1)
    for k in range(many):
        motion = kanai_tajimi(75.0, dt, (7, k), intensity=S0, soil=soil, envelope=stationary, rest=0.0)
        piece = motion.acceleration[start : start + length]
        power += np.abs(np.fft.rfft(piece * window)) ** 2 * dt / (2 * np.pi * np.sum(window**2)) / many
    omega = 2 * np.pi * np.fft.rfftfreq(length, dt)
    for low, high in ((2.0, 6.0), (6.0, 12.0), (12.0, 20.0), (20.0, 50.0), (50.0, 100.0), (100.0, 150.0)):
        band = (omega >= low) & (omega < high)
        estimate, expected = power[band].mean(), soil.density(omega[band], S0).mean()
        assert estimate == pytest.approx(expected, rel=5 / math.sqrt(many * band.sum() / 2) + 0.01)


def test_the_variance_is_the_area_and_does_not_change_in_the_window() -> None:
    many, dt = 400, 0.01
    motions = np.array(
        [kanai_tajimi(40.0, dt, (3, k), intensity=S0, envelope=stationary, rest=0.0).acceleration for k in range(many)]
    )
    area = 2 * quad(lambda w: float(FIRM.density(w, S0)), 0.0, math.pi / dt, limit=500)[0]
    first, second = (np.var(motions[:, part]) for part in (slice(1500, 2500), slice(2900, 3900)))
    assert first == pytest.approx(area, rel=0.03)
    assert second == pytest.approx(area, rel=0.03)


def test_a_seed_is_a_motion_bit_for_bit() -> None:
    one, same, other = (kanai_tajimi(20.0, 0.01, seed, pga=3.0) for seed in (5, 5, 6))
    np.testing.assert_array_equal(one.acceleration, same.acceleration)
    assert np.abs(one.acceleration - other.acceleration).max() > 1.0
    twin = kanai_tajimi(20.0, 0.01, (5, 1), pga=3.0)
    assert np.abs(one.acceleration - twin.acceleration).max() > 1.0
    assert "PCG64 seed 5" in one.source
    assert one.name == "Kanai-Tajimi 5"
    noise = np.random.Generator(np.random.PCG64(5)).standard_normal(3)
    assert noise[0] == pytest.approx(-0.80193143, abs=1e-8), "the stream that seeds stand for"


@pytest.mark.parametrize("soil", [FIRM, MEDIUM, SOFT])
@pytest.mark.parametrize("envelope", [RisePlateauDecay(), ShinozukaSato(0.2, 0.6), stationary])
def test_the_ground_comes_to_rest_where_it_began(soil: Soil, envelope: object) -> None:
    for seed in range(5):
        motion = kanai_tajimi(20.0, 0.01, seed, pga=3.0, soil=soil, envelope=envelope)
        assert abs(motion.velocity[-1]) < 1e-3 * pgv(motion)
        assert abs(motion.displacement[-1]) < 2e-3 * pgd(motion)
        assert np.abs(motion.acceleration[-50:]).max() < 1e-4 * motion.pga, "nothing rings at the Nyquist frequency"
        assert motion.pga == pytest.approx(3.0, rel=1e-14)


def test_what_is_asked_for_is_what_lasts() -> None:
    assert kanai_tajimi(20.0, 0.01, 1, pga=3.0, rest=0.0).duration == pytest.approx(20.0)
    assert kanai_tajimi(20.0, 0.01, 1, pga=3.0, rest=30.0).duration == pytest.approx(50.0)
    usual = kanai_tajimi(20.0, 0.01, 1, pga=3.0)
    assert usual.duration == pytest.approx(20.0 + math.log(1e4) / (0.6 * 1.5), abs=0.02)
    cut = kanai_tajimi(20.0, 0.01, 1, intensity=S0, rest=0.0)
    np.testing.assert_array_equal(cut.acceleration, kanai_tajimi(20.0, 0.01, 1, intensity=S0).acceleration[: cut.n])


def test_a_stronger_noise_is_a_stronger_motion() -> None:
    one, four = (kanai_tajimi(20.0, 0.01, 1, intensity=s).acceleration for s in (S0, 4 * S0))
    np.testing.assert_allclose(four, 2 * one, rtol=1e-12, atol=1e-14)


def test_the_envelope_shapes_the_mean_strength() -> None:
    motions = np.array([kanai_tajimi(20.0, 0.02, (9, k), intensity=S0, soil=FIRM).acceleration for k in range(400)])
    strength = np.sqrt(np.mean(motions**2, axis=0))
    plateau = strength[250:500].mean()
    at = np.arange(150, 1001, 50)
    expected = RisePlateauDecay()((at - 16) * 0.02 - 0.1, 20.0)  # the lead, and the filters' memory
    np.testing.assert_allclose(strength[at] / plateau, expected, atol=0.12)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"intensity": 0.01}, "give exactly one of the two"),
        ({"pga": None}, "intensity = None and pga = None"),
        ({"pga": -1.0}, r"pga = -1.0 m/s2 is not allowed"),
        ({"pga": None, "intensity": 0.0}, "intensity = 0.0 m2/s3 is not allowed"),
        ({"duration": -5.0}, "duration = -5 s is not allowed; it must be greater than 0"),
        ({"duration": 0.05}, "less than 100 steps of 0.01 s"),
        ({"dt": 0.0}, "dt = 0 s is not allowed"),
        ({"rest": -1.0}, "rest = -1 s"),
        ({"seed": -3}, "seed = -3 is not allowed; give a whole number, at least 0"),
        ({"seed": 1.5}, "seed = 1.5 is not allowed"),
    ],
)
def test_what_makes_no_sense_is_refused(change: dict[str, object], words: str) -> None:
    given: dict[str, object] = {"duration": 20.0, "dt": 0.01, "seed": 1, "pga": 3.0} | change
    with pytest.raises(InputError, match=words):
        kanai_tajimi(**given)
