"""A search chooses by some motions and judges on others: what luck it corrects, a planted best, files, and what is refused."""

from concurrent.futures import Executor
from pathlib import Path

import numpy as np
import pytest
import xarray

from dampyr.errors import InputError
from dampyr.ground_motions import kanai_tajimi
from dampyr.models import Damper
from dampyr.structures import (
    EnsembleResult,
    Sensor,
    control_law,
    control_laws_of,
    search_control,
    two_storey,
)
from dampyr.structures.ensembles import control_search

MOTIONS = [kanai_tajimi(3.0, 0.02, seed=(5, k), pga=3.0) for k in range(8)]


def peaks(values: np.ndarray, names: list[str]) -> EnsembleResult:
    """The ensemble with the peak drifts ``values`` (place, input, motion)."""
    dims = ("building", "damper", "input", "motion", "scale", "storey")
    dampers = [f"damper {k}" for k in range(len(values))]
    return EnsembleResult(
        xarray.Dataset(
            {"drift": (dims, values[None, :, :, :, None, None], {"units": "m"})},
            coords={"input_name": ("input", names), "damper_name": ("damper", dampers)},
            attrs={"accuracy": "fast", "error_estimate": 0.0, "unbounded": 0, "judged": 1, "cases": values.size},
        )
    )


def searched(monkeypatch, cubics: Damper, seed: int, worse: float, count: int = 20, motions: int = 40):
    """A search among inputs 0 to 0.1 V that differ by chance alone, but for 0 V, whose drifts are less."""
    rng = np.random.default_rng(seed)
    common, own = rng.lognormal(0.0, 0.5, motions), rng.lognormal(0.0, 0.2, (count, motions))
    own[0] /= worse
    shakes = [kanai_tajimi(2.0, 0.02, seed=k, pga=1.0, rest=0.0) for k in range(motions)]
    which = {id(motion): k for k, motion in enumerate(shakes)}

    def instead(building, some, dampers, voltage, **_):
        columns = [which[id(motion)] for motion in some]
        rows = [round(200 * u) for u in voltage]
        return peaks((common * own)[np.ix_(rows, columns)][None], [f"{u:g} V" for u in voltage])

    monkeypatch.setattr(control_search, "ensemble", instead)
    return search_control(two_storey(), shakes, cubics, [k / 200 for k in range(count)], seed=seed)


def test_the_first_of_many_alike_is_not_called_better_where_it_had_no_choice(monkeypatch, cubics: Damper) -> None:
    """Where it was chosen it leads in every search; on other motions others are told apart as often as by chance."""
    found = [searched(monkeypatch, cubics, seed, worse=1.0) for seed in range(60)]
    assert all(each.ranked[1] / each.ranked[0] > 1.0 for each in found)
    of_ranks = np.array([each.ranked[4] / each.ranked[0] for each in found])
    assert of_ranks.mean() > 1.03
    assert abs(np.mean([np.log(each.ratio[4]) for each in found])) < 0.02
    assert np.mean([each.apart[4] for each in found]) < 0.15  # 5 % in theory
    assert np.mean([each.beaten for each in found]) < 0.3  # four are compared, 5 % each


def test_a_planted_best_is_found_and_told_apart(monkeypatch, cubics: Damper) -> None:
    found = [searched(monkeypatch, cubics, seed, worse=1.3) for seed in range(20)]
    first = [each for each in found if each.best == "0 V, storey 1"]
    assert len(first) >= 18
    assert np.mean([all(each.apart[1:]) for each in first]) > 0.8
    ratios = np.array([each.ratio[1:] for each in first])
    assert ratios.mean() == pytest.approx(1.3, rel=0.05)


def test_the_numbers_are_those_of_the_ensembles(cubics: Damper) -> None:
    inputs = [0.0, 1.0, control_law("bang_bang", high=3.0, lag=0.01)]
    found = search_control(two_storey(), MOTIONS, cubics, inputs, [1, (0, 2)], [0.5, 1.0], "acceleration", finalists=3)
    assert {*found.chosen_by, *found.judged_on} == {motion.name for motion in MOTIONS}
    assert len(found.chosen_by) == len(found.judged_on) == 4
    assert set(found.names) == {
        f"{name}, {place}" for name in ("0 V", "1 V", "bang_bang 0 to 3 V, lag 0.01 s") for place in ("storey 1", "0-2")
    }
    here = found.choosing.dataset.acceleration.max("floor")
    means = np.exp(np.log(here).mean(("building", "motion", "scale"))).values.ravel()
    np.testing.assert_allclose(found.ranked, np.sort(means), rtol=1e-12)
    assert len(found.judged) == 3
    np.testing.assert_allclose(found.ratio, found.judged / found.judged[0], rtol=1e-12)
    assert found.ratio_band[:, 0] == pytest.approx([1.0, 1.0])
    assert found.arena.names == found.names[:3]
    assert found.arena.cases == 8


class Refusing(Executor):
    """Runs nothing."""

    def submit(self, *_, **__):
        raise AssertionError("what was computed is computed again")


def test_it_goes_on_from_its_files(cubics: Damper, tmp_path: Path) -> None:
    arguments = (two_storey(), MOTIONS, cubics, [0.0, 1.0, 2.0])
    whole = search_control(*arguments)
    first = search_control(*arguments, out=tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["choosing.h5", "judging_3.h5"]
    again = search_control(*arguments, out=tmp_path, executor=Refusing())
    (tmp_path / "judging_3.h5").unlink()
    with pytest.raises(AssertionError, match="computed again"):
        search_control(*arguments, out=tmp_path, executor=Refusing())
    rest = search_control(*arguments, out=tmp_path)
    for other in (first, again, rest):
        assert other.names == whole.names
        assert np.array_equal(other.ratio_band, whole.ratio_band)


def test_noise_that_had_a_say_does_not_judge(cubics: Damper) -> None:
    laws = control_laws_of("bang_bang", high=3.0, lag=[0.01, 0.02], sensors={"force": Sensor(noise=3.0)})
    found = search_control(two_storey(), MOTIONS[:4], cubics, laws)
    assert "seed" not in str(found.choosing.dataset.input_name.values)
    assert all("seed" in str(name) for name in found.arena.result.dataset.input_name.values)
    assert "seed" not in found.best


def test_laws_of_every_combination() -> None:
    laws = control_laws_of(
        "clipped_optimal", high=3.0, effort=[0.1, 0.2], lag=[0.0, 0.01], weights=(1.0, 2.0, 3.0, 4.0)
    )
    assert [(law.effort, law.lag) for law in laws] == [(0.1, 0.0), (0.1, 0.01), (0.2, 0.0), (0.2, 0.01)]
    with pytest.raises(InputError, match="effort = \\[\\] of clipped_optimal has no value to choose from"):
        control_laws_of("clipped_optimal", high=3.0, effort=[])


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"motions": MOTIONS[:3]}, "a search needs 4 motions or more, .*; 3 given"),
        ({"voltage": [1.0]}, "there is one candidate"),
        ({"places": []}, "places is empty"),
        ({"criterion": "beauty"}, "criterion = 'beauty' is not known; choose from drift"),
        ({"finalists": 1}, "finalists = 1 is not allowed"),
        ({"current": [1.0, 2.0]}, "voltage and current are both given"),
        ({"voltage": [1.0, 9.0]}, "outside the calibrated range"),
    ],
)
def test_what_is_wrong_is_said(cubics: Damper, changed: dict, message: str) -> None:
    given = {"building": two_storey(), "motions": MOTIONS, "damper": cubics, "voltage": [0.0, 1.0]} | changed
    with pytest.raises(InputError, match=message):
        search_control(**given)
