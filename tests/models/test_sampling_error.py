"""What samples that step over a speed of the model cost: the warning states the error that they make."""

import re

import numpy as np
import pytest
from tests.identification.synthetic import sine
from tests.models.parts.stribeck_friction import damper, motion

from dampyr.errors import DampyrWarning
from dampyr.identification import fit, score

STIFF = {"sigma1": 0.0, "sigma2": 50.0, "rho": 2e4, "e": 9.0}


@pytest.mark.parametrize("vs", [1e-2, 3e-3, 1e-3])
def test_samples_that_step_over_vs_are_told_with_the_error_that_they_make(vs: float) -> None:
    """200 samples a second, as a campaign has: the figures in the warning are those of 51,200, within a factor of 1.2."""
    t, fine = np.linspace(0.0, 1.5, 301), np.linspace(0.0, 1.5, 300 * 256 + 1)
    stiff = damper(**STIFF, vs=vs)
    (x, v), (fine_x, fine_v) = motion(t), motion(fine)
    exact = stiff.force(fine, fine_x, voltage=0.0, velocity=fine_v)[::256]
    with pytest.warns(DampyrWarning, match=f"crosses {1e3 * vs:.3g} mm/s within a sample at 200 samples") as caught:
        force = stiff.force(t, x, voltage=0.0, velocity=v)
    mean, worst = (float(text) / 100 for text in re.findall(r"by (\S+) % of its", str(caught[0].message)))
    gap = np.abs(force - exact)
    assert mean == pytest.approx(np.mean(gap) / np.mean(np.abs(exact - np.median(exact))), rel=0.2)
    assert worst == pytest.approx(gap.max() / np.abs(exact).max(), rel=0.2)
    assert (worst > 0.48) is (vs == 1e-3)


def test_samples_that_follow_vs_are_not_warned_of(recwarn: pytest.WarningsRecorder) -> None:
    t = np.linspace(0.0, 1.5, 3001)
    x, v = motion(t)
    damper(**STIFF).force(t, x, voltage=0.0, velocity=v)
    assert not recwarn.list


@pytest.mark.prove
def test_fits_and_scores_tell_of_it_too() -> None:
    stiff = damper(**STIFF, vs=1e-3)
    with pytest.warns(DampyrWarning, match="within a sample"):
        coarse = sine(stiff, 0.0)
    with pytest.warns(DampyrWarning, match="within a sample"):
        score(stiff, coarse)
    with pytest.warns(DampyrWarning, match=r"test: .* within a sample"):
        result = fit(coarse, "lugre", fixed={"lugre.vs": 1e-3, "lugre.rho": 2e4, "lugre.sigma1": 0.0})
    assert any("within a sample" in note for note in map(str, result.findings))
