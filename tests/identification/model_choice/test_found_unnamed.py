"""A search that is told no name finds the part that made its records, also one that is usually tried by name only."""

from collections.abc import Callable

import numpy as np
import pytest
from tests.endurance import Endurance
from tests.identification.model_choice.found_unnamed import (
    ADD_ONS,
    L1,
    NOT_FOUND,
    NOT_SHOWN,
    PARTS,
    numbers_of,
    search_unnamed,
)
from tests.identification.model_choice.test_leaderboard import entry
from tests.models.parts.found_again import damper, six_sines

from dampyr.identification import FitOptions, fit
from dampyr.identification.model_choice import leaderboard as search
from dampyr.identification.model_choice.leaderboard import _select_finalists, simplest
from dampyr.identification.model_choice.parts_by_name import find_called_parts
from dampyr.identification.model_choice.screening import EXACT, Screened, Trial, screening_set
from dampyr.models import available_parts
from dampyr.models.part import part
from dampyr.to_json import plain

OF_WORK = FitOptions(budget=4.0)
COUNT = 20  # random ones


@pytest.mark.by_hand  # a quarter of an hour; what each needed is tested below and with the parts
def test_each_part_is_found_from_six_noise_free_sines(endurance: Endurance) -> None:
    results = []
    for name in [*PARTS, *ADD_ONS]:
        results.append(search_unnamed(name))
        print(results[-1], flush=True)
    missed = [result for result in results if not result.found]
    slowest = max(result.seconds for result in results)
    endurance.report(
        "six noise-free sines of each part, searched without a name: L1 below 0.1 %, numbers within 1 %",
        None,
        f"{len(results) - len(missed)} of {len(results)} found, {slowest:.0f} s of CPU time at most"
        + "".join(f"; {result}" for result in missed),
    )
    assert not missed


def random_table(rng: np.random.Generator) -> dict[str, float]:
    """Rows at random speeds up to 110 mm/s, of the 126 mm/s of the sines; rises of 25 N, a factor of 1.8 (a sigma)."""
    widths = {f"w{k + 1}": float(width) for k, width in enumerate(0.11 * rng.dirichlet(np.full(6, 3.0)))}
    return widths | {f"{side}{k}": float(np.exp(rng.normal(3.2, 0.6))) for side in "ec" for k in range(1, 7)}


def random_bearing(rng: np.random.Generator) -> dict[str, float]:
    """Sliders that begin one after the other and have a stop within the 10 mm of the sines, most of them."""

    def between(low: float, high: float) -> float:
        return float(low * (high / low) ** rng.random())

    lengths = {"l1": between(1e-3, 4e-3), "l2": between(2e-3, 8e-3), "l3": between(2e-3, 8e-3)}
    stops = {"d1": between(1.5e-3, 4e-3), "d2": between(2e-3, 6e-3), "d3": between(2e-3, 6e-3)}
    r2 = between(1.5, 3.0)
    return {"f1": 150.0, "r2": r2, "r3": r2 * between(1.1, 2.0), "uy": 1e-4} | lengths | stops


@pytest.mark.by_hand  # a statistic of many fits
@pytest.mark.parametrize(("name", "draw"), [("force_table", random_table), ("triple_pendulum", random_bearing)])
def test_how_many_random_ones_a_fit_by_name_meets(
    name: str, draw: Callable[[np.random.Generator], dict[str, float]], endurance: Endurance
) -> None:
    met: dict[str, int] = {}
    for starts in (1, None):
        records = [six_sines(damper(name, draw(np.random.default_rng(seed)))) for seed in range(COUNT)]
        fits = [fit(six, name, starts=starts) for six in records]
        count = sum(max(score.l1 for score in one.scores.values()) < L1 for one in fits)
        met[f"{fits[0].starts[0]} start{'s' if starts is None else ''}"] = count
    figures = ", ".join(f"{count} with {starts}" for starts, count in met.items())
    endurance.report(
        f"a fit of {name} to six noise-free sines of a random one: L1 below 0.1 %", 0, f"of {COUNT}: {figures}"
    )
    one, several = met.values()
    assert several >= COUNT // 2 > one


def test_every_part_is_in_the_table_or_says_why_not() -> None:
    assert sorted([*PARTS, *ADD_ONS, *NOT_FOUND, *NOT_SHOWN]) == sorted(available_parts())
    assert all(part(name).add_on for name in (*ADD_ONS, *NOT_FOUND, *NOT_SHOWN))


def test_models_that_describe_the_records_alike_are_told_apart_by_their_numbers() -> None:
    """bouc_wen is modified_bouc_wen with a dashpot in series that is stiff: both end at the rounding of the search."""
    trials = Trial("dahl", 0.5 * EXACT, 1.0), Trial("dahl + compliance", 1e-3 * EXACT, 1.0)
    assert Screened("dahl", trials).best.model == "dahl"
    assert Screened("dahl", (Trial("dahl", 2.0 * EXACT, 1.0), trials[1])).best.model == "dahl + compliance"
    screened = [
        Screened(model, (Trial(model, error, 1.0),))
        for model, error in (("modified_bouc_wen", 1e-8), ("bouc_wen", 2e-5))
    ]
    assert [trial.model for trial in _select_finalists(screened, 2)] == ["bouc_wen", "modified_bouc_wen"]
    entries = entry("modified_bouc_wen", 8, 1e-6, 1e-7), entry("bouc_wen", 6, 2e-5, 1e-6)
    assert simplest(entries) is entries[1]
    assert simplest((entries[0], entry("bouc_wen", 6, 2.0 * EXACT, 1e-6))) is entries[0]


@pytest.mark.prove
@pytest.mark.parametrize("noise", [0.0, 0.03])
@pytest.mark.parametrize("truth", ["hardening_bouc_wen", "asymmetric_bouc_wen", "dahl"])
def test_the_records_call_for_the_part_that_made_them(truth: str, noise: float) -> None:
    """Noise, of the spread of the force, calls for none."""
    names, rng = ["asymmetric_bouc_wen", "hardening_bouc_wen"], np.random.default_rng(1)
    small = [
        record.replace(note="noise", force=record.force + noise * np.std(record.force) * rng.standard_normal(record.n))
        for record in screening_set(six_sines(damper(truth, PARTS[truth])))
    ]
    called, work = find_called_parts(names, "dahl", small, OF_WORK, None, lambda done: None)
    assert [found.name for found in called] == [truth] * (truth in names)
    assert all(found.l1 < 1e-3 + noise < found.without for found in called)
    assert work > 0.0


@pytest.mark.prove
def test_a_part_that_is_called_for_is_chosen_and_says_what_to_mind(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "available_parts", lambda: ["dahl", "hardening_bouc_wen"])
    monkeypatch.setattr(search, "PAIRS", {})
    truth = numbers_of("hardening_bouc_wen")
    result = fit(
        six_sines(damper("hardening_bouc_wen", PARTS["hardening_bouc_wen"])), add_ons=(), progress=lambda *_: None
    )
    board = result.leaderboard
    assert board is not None
    assert [model.base for model in board.screened] == ["dahl", "hardening_bouc_wen"]
    assert board.winner.model == "hardening_bouc_wen"
    assert {key: pytest.approx(value, rel=0.01) for key, value in truth.items()} == result.parameters
    assert any(
        "hardening_bouc_wen was chosen without being named; mind that a hardening" in f.words for f in result.findings
    )
    assert "hardening_bouc_wen was tried too, as at one input it leaves" in str(board.called[0])
    assert "tried besides" in str(board)
    assert plain(board.as_dict())["called"][0]["name"] == "hardening_bouc_wen"
