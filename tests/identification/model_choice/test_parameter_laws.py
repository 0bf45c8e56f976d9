"""Which parameters follow the input is found on the records: those of which one value does not predict as well."""

import pytest
from tests.identification.synthetic import sine
from tests.identification.tangent_campaign import NAME, campaign

from dampyr.identification import FitOptions, fit
from dampyr.identification.model_choice import screening
from dampyr.identification.model_choice.leaderboard import leaderboard
from dampyr.identification.model_choice.parameter_laws import list_shapes, may_follow_input, with_constant
from dampyr.identification.model_choice.screening import Screened, Trial, TrialModel, screen_all, simplify
from dampyr.models import Constant, Damper, Interpolation
from dampyr.records import Record
from dampyr.show.identification.leaderboard import choice_in_words

VOLTS = (0.0, 1.0, 2.0)


def springs(k0: tuple[float, float, float], rho: tuple[float, float, float] = (2500.0,) * 3) -> list[Record]:
    """Noise-free sines at three voltages of Dahl's model beside a spring."""
    laws = {"dahl.kx": (900.0, 1400.0, 1900.0), "dahl.kw": (70.0, 200.0, 300.0), "dahl.rho": rho, "spring.k0": k0}
    damper = Damper("dahl + spring", {name: Interpolation(VOLTS, values) for name, values in laws.items()})
    return [
        sine(damper, u, f"{u:g}V-{k}", 0.006 + 0.004 * k, 1.2 - 0.3 * k, seconds=4.0) for u in VOLTS for k in range(2)
    ]


def screened_with_spring(records: list[Record], laws: str | None = None) -> Screened:
    [found], _ = screen_all(["dahl"], records, FitOptions(add_ons=("spring",), laws=laws), None, lambda done: None)
    return found


def test_an_add_on_has_one_value_where_that_predicts_as_well() -> None:
    found = screened_with_spring(springs((5000.0, 5000.0, 5000.0)))
    assert found.best.trial_model == TrialModel("dahl + spring", ("spring.k0",))
    assert found.best.error < 0.2 * found.bare.error
    assert [trial.constant for trial in found.trials] == [(), ("spring.k0",), ()]  # freed too, and no better


def test_an_add_on_follows_the_input_where_that_lowers_the_error() -> None:
    found = screened_with_spring(springs((2000.0, 5000.0, 9000.0)))
    assert found.best.trial_model == TrialModel("dahl + spring")
    assert found.best.error < 0.5 * next(trial.error for trial in found.trials if trial.constant)


def test_laws_that_are_asked_for_are_those_that_are_tried() -> None:
    records = springs((5000.0, 5000.0, 5000.0))
    assert all(not trial.constant for trial in screened_with_spring(records, "interpolation").trials)
    assert may_follow_input(FitOptions(), records)
    assert not may_follow_input(FitOptions(laws="polynomial:1"), records)
    assert not may_follow_input(FitOptions(), [r for r in records if r.voltage == 1.0])


@pytest.mark.parametrize(("rho", "constant"), [((2500.0, 2500.0, 2500.0), ("dahl.rho",)), ((2500.0, 900.0, 400.0), ())])
def test_what_shapes_the_force_has_one_value_where_that_predicts_as_well(
    rho: tuple[float, float, float], constant: tuple[str, ...]
) -> None:
    records = springs((0.0, 0.0, 0.0), rho)
    best, trials = simplify(TrialModel("dahl").try_on(records, FitOptions()), records, FitOptions())
    assert best.constant == constant
    assert [trial.constant for trial in trials] == [("dahl.rho",)]  # kx and kw are what the force is proportional to


def test_one_value_stays_only_where_the_error_rises_by_half_a_percent_of_it_at_most(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    errors = {(): 0.1, ("compliance.s",): 0.1004, ("compliance.s", f"{NAME}.v0"): 0.1006}

    def trial(model: str, small: list[Record], options: FitOptions) -> Trial:
        return Trial(model, errors[tuple(options.laws or ())], 0.0)

    monkeypatch.setattr(screening, "trial", trial)
    monkeypatch.setattr(screening, "list_shapes", lambda model: ["compliance.s", f"{NAME}.v0"])
    best, trials = simplify(Trial(f"{NAME} + compliance", 0.1, 0.0), [], FitOptions())
    assert best.constant == ("compliance.s",)
    assert len(trials) == 2


@pytest.mark.parametrize(
    ("model", "names"),
    [
        ("dahl + spring", ["spring.k0", "dahl.rho"]),
        ("dahl + hyperbolic_tangent + delay", ["delay.tau", "hyperbolic_tangent.v0", "dahl.rho"]),  # its s is held at 0
        ("bouc_wen + spring", ["bouc_wen.n", "bouc_wen.sigma", "bouc_wen.rho"]),  # of two springs the sum alone is seen
        (
            "shutting_bleed + place_friction",
            ["shutting_bleed.vy", "shutting_bleed.fy", "shutting_bleed.c"],
        ),  # by its part
        ("dahl + lag", ["dahl.rho"]),  # the lag of the input does not depend on it
    ],
)
def test_the_parameters_that_need_not_follow_the_input(model: str, names: list[str]) -> None:
    assert list_shapes(model) == names


def test_the_fewest_add_ons_and_laws_are_chosen_among_trials_that_are_worth_the_same() -> None:
    trials = (
        Trial("dahl", 0.2, 1.0),
        Trial("dahl + spring", 0.1, 1.0, constant=("spring.k0",)),
        Trial("dahl + spring", 0.0985, 1.0),
        Trial("dahl + spring + delay", 0.0983, 1.0, constant=("spring.k0", "delay.tau")),
    )
    assert Screened("dahl", trials).best is trials[1]
    assert Screened("dahl", (*trials, Trial("dahl + spring + compliance", 0.09, 1.0))).best.error == 0.09


def test_the_options_name_what_is_constant() -> None:
    assert with_constant(FitOptions(), ()).laws is None
    assert with_constant(FitOptions(), ("spring.k0",)).laws == {"spring.k0": "constant"}


@pytest.mark.prove
def test_the_card_of_a_search_holds_one_value_and_the_ranking_says_so() -> None:
    """The compliance and the tangent's speed of this campaign do not depend on the voltage."""
    found = fit(campaign(), models=(NAME,), add_ons=("compliance",), budget=None, progress=lambda what, done: None)
    board = found.leaderboard
    assert board is not None
    names = ("compliance.s", f"{NAME}.v0")
    assert set(names) <= set(board.winner.constant)
    assert all(isinstance(found.damper.laws[name], Constant) for name in names)
    assert not isinstance(found.damper.laws[f"{NAME}.ft"], Constant)
    assert found.damper.laws["compliance.s"](1.0) == pytest.approx(3e-6, rel=0.02)
    entry = board.as_dict()["entries"][0]
    assert set(names) <= set(entry["constant"])
    assert any("the same at all inputs" in words and "compliance.s" in words for words in choice_in_words(board))
    again = leaderboard(
        campaign(), FitOptions(models=(NAME,), add_ons=("compliance",), laws="interpolation", budget=None)
    )
    assert again.winner.constant == ()
    assert again.winner.parameters == board.winner.parameters + 2 * len(board.winner.constant)
