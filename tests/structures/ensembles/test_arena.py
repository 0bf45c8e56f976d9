"""An arena against shares counted by hand, the binomial law, and a winner that was planted."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
import xarray
from tests.endurance import Endurance

from dampyr.errors import InputError
from dampyr.structures import EnsembleResult, arena, ensemble, two_storey
from dampyr.structures.ensembles.store import BARE


def result_of(x: np.ndarray, bare: bool = False) -> EnsembleResult:
    """The ensemble with the peak drifts ``x`` (damper, input, motion), each of one building, scale and storey."""
    values = x[None, :, :, :, None, None]
    dims = ("building", "damper", "input", "motion", "scale", "storey")
    names = [f"law {k}" for k in range(x.shape[1])]
    dampers = [BARE if bare and k == 0 else f"damper {k}" for k in range(x.shape[0])]
    return EnsembleResult(
        xarray.Dataset(
            {"drift": (dims, values, {"units": "m"})},
            coords={"input_name": ("input", names), "damper_name": ("damper", dampers)},
            attrs={"accuracy": "fast", "error_estimate": 0.0, "unbounded": 0, "judged": 1, "cases": x.size},
        )
    )


def test_shares_are_counted_and_ties_and_cases_without_bound_with_them() -> None:
    x = np.array([[[1.0, 2.0, 3.0, 4.0], [2.0, 2.0, 1.0, np.nan], [3.0, 9.0, 9.0, np.nan]]])
    found = arena(result_of(x))
    assert found.wins[0, 1] == pytest.approx((1 + 0.5 + 0 + 1) / 4)
    assert found.wins[1, 0] == 1.0 - found.wins[0, 1]
    assert found.wins[1, 2] == pytest.approx((1 + 1 + 1 + 0.5) / 4)
    assert found.best == pytest.approx([(1 + 0.5 + 0 + 1) / 4, (0 + 0.5 + 1) / 4, 0.0])
    assert found.medians[0] == 2.5
    assert found.unit == "m"


def test_the_bare_building_takes_no_part() -> None:
    x = np.ones((2, 2, 5))
    x[0, 1], x[1, 0] = 0.0, 0.5
    found = arena(result_of(x, bare=True))
    assert found.wins[0, 1] == 1.0
    assert found.cases == found.motions == 5


def test_a_band_of_what_always_happened_is_the_binomial_bound() -> None:
    for n, winner in ((4, None), (5, "law 0"), (20, "law 0")):
        found = arena(result_of(np.stack([np.ones((1, n)), 2 * np.ones((1, n))], axis=1)))
        assert found.wins_band[:, 0, 1] == pytest.approx([0.05 ** (1 / n), 1.0])
        assert found.winner == winner
        assert found.needed[0, 1] == (0.0 if winner else 5.0)


def test_motions_are_what_is_independent_and_not_the_dampers_that_they_shake() -> None:
    """A hundred dampers that all follow their motion tell no more than the ten motions: the band is that of ten."""
    rng = np.random.default_rng(1)
    of_motion = rng.choice([0.5, 1.5], size=10, p=[0.7, 0.3])
    x = np.stack([np.tile(of_motion, (100, 1)), np.ones((100, 10))], axis=1)
    low, high = arena(result_of(x)).wins_band[:, 0, 1]
    share = np.mean(of_motion < 1.0)
    assert high - low == pytest.approx(2 * 1.645 * np.sqrt(share * (1 - share) / 10), rel=0.25)


def planted(seed: int, motions: int = 40, dampers: int = 10) -> np.ndarray:
    """Drifts of three laws, of which the first is better in 70 % of the motions' cases; motion and damper matter most."""
    rng = np.random.default_rng(seed)
    common = rng.lognormal(0.0, 0.5, (dampers, 1, 1)) * rng.lognormal(0.0, 0.5, (1, 1, motions))
    of_law = rng.normal(0.0, 0.1, (1, 3, motions)) + rng.normal(0.0, 0.05, (dampers, 3, motions))
    spread = np.sqrt(2 * (0.1**2 + 0.05**2))
    return common * np.exp(
        of_law + spread * 0.5244 * np.array([0.0, 1.0, 1.0])[None, :, None]
    )  # 0.5244: the 70 % quantile


def test_a_planted_winner_is_found() -> None:
    found = arena(result_of(planted(1)))
    assert found.wins[0, 1] == pytest.approx(0.7, abs=0.12)
    low, high = found.wins_band[:, 0, 1]
    assert low < 0.7 < high
    few = arena(result_of(planted(1, motions=6)))
    assert few.winner is None
    assert 6 < few.needed[0, 1] < 1000 or few.needed[0, 1] == 0


def motions_to_tell(share: float) -> int:
    """The motions that tell law 0 from another one with 95 %, by the spread of many planted ones between motions."""
    drifts = planted(999, motions=4000)
    spread = np.std((drifts[:, 0] < drifts[:, 1]).mean(axis=0))
    return math.ceil((2.0 * 1.645 * spread / (share - 0.5)) ** 2)


def test_the_motions_that_are_needed_are_those_of_twice_the_half_band() -> None:
    """Laws 1 and 2 are alike: however many there are, the motions that would tell what is found are said."""
    found = arena(result_of(planted(2, motions=10)))
    half = 0.5 * (found.wins_band[1, 1, 2] - found.wins_band[0, 1, 2])
    assert found.needed[1, 2] == max(np.ceil(10 * (2.0 * half / abs(found.wins[1, 2] - 0.5)) ** 2), 11)
    assert found.needed[1, 2] == found.needed[2, 1]


@pytest.mark.by_hand
def test_bands_hold_the_probability_and_the_winner_is_found(endurance: Endurance) -> None:
    """Of a hundred repeats: two laws are told apart by as many motions as are said to be needed, and a winner by 50."""
    number, needed = endurance.count(100), motions_to_tell(0.7)
    repeats = [arena(result_of(planted(seed, motions=50))) for seed in range(number)]
    held = sum(
        r.wins_band[0, i, j] < p < r.wins_band[1, i, j] for r in repeats for i, j, p in ((0, 1, 0.7), (1, 2, 0.5))
    )
    winners = sum(r.winner == "law 0" for r in repeats)
    wrong = sum(r.winner in ("law 1", "law 2") for r in repeats)
    fewer = [arena(result_of(planted(seed, motions=needed))) for seed in range(1000, 1000 + number)]
    told = sum(r.wins_band[0, 0, j] > 0.5 for r in fewer for j in (1, 2))
    endurance.report(
        f"three laws against one another, one of which wins in 70 % of the cases, 50 motions and 10 dampers; two laws with as "
        f"many motions as are needed, {needed}",
        0,
        f"{number} repeats: bands of 90 % hold the probability in {50 * held / number:.0f} %; the winner is found in "
        f"{winners}, another one in {wrong}; two laws are told apart in {50 * told / number:.0f} %",
    )
    assert held >= 1.7 * number
    assert winners >= 0.95 * number
    assert told >= 1.8 * number - 2  # of 2 number pairs, 95 % to chance
    assert wrong == 0


@pytest.mark.parametrize(
    ("made", "criterion", "message"),
    [
        (lambda: result_of(np.ones((1, 1, 3))), "drift", "there is one input"),
        (lambda: result_of(np.ones((1, 2, 3))), "speed", "criterion = 'speed' is not known; choose from drift"),
        (lambda: result_of(np.ones((1, 2, 3))), "force", "is not in this ensemble; it has drift"),
        (lambda: result_of(np.ones((1, 2, 3)), bare=True), "drift", "no case has a damper"),
        (lambda: SimpleNamespace(), "drift", "arena: result is a SimpleNamespace"),
    ],
)
def test_what_is_wrong_is_said(made, criterion: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        arena(made(), criterion)


def test_one_motion_and_one_damper_have_no_band() -> None:
    found = arena(result_of(np.array([[[1.0], [2.0]]])))
    assert "one motion and one damper" in found.reason
    assert np.isnan(found.wins_band).all()
    assert found.winner is None
    assert any("no band" in finding.words for finding in found.findings)


def test_seeds_are_runs_of_their_own(cubics) -> None:
    from dampyr.ground_motions import kanai_tajimi
    from dampyr.structures import Sensor, control_law

    law = control_law("bang_bang", high=3.2, sensors={"force": Sensor(noise=20.0)}, seed=3)
    motion = kanai_tajimi(2.0, 0.02, seed=1, pga=3.0)
    several = ensemble(two_storey(), motion, cubics, law, seeds=3).dataset
    assert several.sizes["damper"] == 3
    for k in range(3):
        other = control_law("bang_bang", high=3.2, sensors={"force": Sensor(noise=20.0)}, seed=3 + k)
        alone = ensemble(two_storey(), motion, cubics, other).dataset
        np.testing.assert_array_equal(several.drift[0, k, 0, 0, 0], alone.drift[0, 0, 0, 0, 0])
    with pytest.raises(InputError, match="seeds and draws exclude each other"):
        ensemble(two_storey(), motion, cubics, law, seeds=3, draws=3)
