"""Black boxes beside a leaderboard: what they see that no model does, and with what a residual goes."""

import sys
from pathlib import Path

import numpy as np
import pytest

import dampyr as dp
from dampyr.errors import InputError
from dampyr.identification.fits.fit_options import FitOptions
from dampyr.identification.model_choice import yardstick
from dampyr.identification.model_choice.leaderboard import leaderboard
from dampyr.identification.model_choice.yardstick import (
    Yardstick,
    describe_what_is_left,
    find_carriers,
    train_yardsticks,
)
from dampyr.models import Damper
from dampyr.phrases import sentence
from dampyr.records import Record, with_velocity
from dampyr.show.descriptions import description_of
from dampyr.show.identification.leaderboard import finalists

REASON = "the extra yardstick is not installed: pip install dampyr[yardstick]"
PLACE = {"place_friction.g": 30.0, "place_friction.y0": 0.003, "place_friction.ell": 0.02, "place_friction.vf": 1e-3}


def sines(model: str, further: dict[str, float], count: int = 8) -> list[Record]:
    """Sines of a viscous damper with friction, each of its own stroke and frequency, with noise of 1 %."""
    numbers = {"hyperbolic_tangent.c": 900.0, "hyperbolic_tangent.ft": 40.0, "hyperbolic_tangent.v0": 0.01}
    damper = Damper(tuple(model.split(" + ")), numbers | {"hyperbolic_tangent.s": 0.0} | further)
    rng, records = np.random.default_rng(5), []
    for k in range(count):
        t = np.arange(0.0, 6.0, 0.01)
        x = rng.uniform(0.006, 0.02) * np.sin(2.0 * np.pi * rng.uniform(0.4, 1.5) * t)
        force = damper.force(t, x, voltage=0.0)
        noise = rng.normal(0.0, 0.01 * np.std(force), t.size)
        records.append(Record(t, x, force + noise, voltage=0.0, velocity=np.gradient(x, t), name=f"sine_{k}"))
    return records


def shorten(monkeypatch: pytest.MonkeyPatch) -> None:
    """Black boxes that are trained briefly, on few samples."""
    for name, value in {"EPOCHS": 60, "SAMPLES": 300, "SCALE_SAMPLES": 100, "PROCESS_SAMPLES": 600}.items():
        monkeypatch.setattr(yardstick, name, value)


def test_black_boxes_predict_a_damper_of_the_velocity_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("sklearn", reason=REASON)
    shorten(monkeypatch)
    seen: list[float] = []
    boxes = train_yardsticks(sines("hyperbolic_tangent", {}, 10), 2, 0, 1.0, seen.append)
    assert [box.name for box in boxes] == ["a network of two layers", "a Gaussian process"]
    assert all(box.l1 < 0.2 and box.error == box.l1 for box in boxes)  # half of the records predict the other half
    assert all(np.isnan(box.unseen_input) and box.numbers > 500 for box in boxes)
    assert seen[-1] == 1.0


@pytest.mark.usefixtures("no_trials")
def test_the_residual_of_a_model_without_the_place_goes_with_the_place() -> None:
    pytest.importorskip("sklearn", reason=REASON)
    records = sines("hyperbolic_tangent + place_friction", PLACE)
    lacking = find_carriers(dp.identification.fit(records, "hyperbolic_tangent"), 0)
    assert next(iter(lacking)) == "the place in the motion"
    assert lacking["the place in the motion"] > 0.2
    whole = find_carriers(dp.identification.fit(records, "hyperbolic_tangent + place_friction"), 0)
    assert whole == {}  # noise goes with nothing


def test_what_is_left_is_said_in_one_sentence() -> None:
    boxes = (Yardstick("a network", 0.05, 0.040, 0.08, 3217, 1.0), Yardstick("a process", 0.06, 0.045, 0.09, 2000, 1.0))
    text = describe_what_is_left(0.055, boxes, {"the place in the motion": 0.31})
    assert text == (
        "of records that were left out the model misses 5.5 % (L1) and a network 4 %: 1.5 points are structure that no part "
        "has; the residual goes most with the place in the motion (31 %)"
    )
    assert "the black box sees nothing more; the residual goes with no feature" in describe_what_is_left(
        0.03, boxes, {}
    )


def test_without_scikit_learn_the_search_does_not_begin(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sklearn", None)
    with pytest.raises(InputError, match=r'pip install "dampyr\[yardstick\]", or leave it out'):
        leaderboard(sines("hyperbolic_tangent", {}, 5), FitOptions(models=("dahl",), yardstick=True))


@pytest.mark.prove
def test_the_black_boxes_are_the_last_rows_of_the_leaderboard(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("sklearn", reason=REASON)
    shorten(monkeypatch)
    records = sines("hyperbolic_tangent + place_friction", PLACE, 6)
    board = leaderboard(
        records, FitOptions(models=("hyperbolic_tangent",), add_ons=(), finalists=1, yardstick=True, bandwidth=15.0)
    )
    table = finalists(board)
    assert [row[1] for row in table.rows][-2:] == [
        "black box: a network of two layers",
        "black box: a Gaussian process",
    ]
    assert sentence(board.what_is_left) in description_of(board).verdict


@pytest.mark.by_hand  # of scikit-learn's training of minutes; what the model reaches is a proof
def test_no_black_box_predicts_the_campaign_better(campaign_folder: Path) -> None:
    pytest.importorskip("sklearn", reason=REASON)
    records = [with_velocity(record, 18.2) for record in dp.records.read_campaign(campaign_folder)]
    network, process = train_yardsticks(records, 5, 0, 1.0, lambda done: None)
    best = min(network.l1, process.l1)
    assert 0.038 < best < 0.046  # the model: 0.036 (test_campaign.py)
    assert min(network.unseen_input, process.unseen_input) > 0.12  # the model: 0.069
