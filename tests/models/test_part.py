"""What a part's file says of it: traits that are read off its formulas, checked numbers, and names."""

import pytest

from dampyr.errors import InputError
from dampyr.models.part import Scale, part, part_name, quantities
from dampyr.models.parts import BoucWen, Dahl, Spring


@pytest.mark.parametrize(
    ("name", "proportional"),
    [
        ("spring", {"k0": "x"}),
        ("dahl", {"kx": "v"}),  # kw multiplies the state, which is no motion
        ("bouc_wen", {"c0": "v", "k0": "x"}),
        ("inertia", {"m": "a"}),
        ("offset", {"f0": "1"}),
        ("bingham", {"c0": "v"}),
        ("delay", {}),
    ],
)
def test_what_the_force_is_proportional_to_is_seen_from_the_formula(name: str, proportional: dict[str, str]) -> None:
    assert part(name).proportional_to == proportional


def test_traits_of_the_states_are_read_off_the_arguments_of_their_formula() -> None:
    path_only, of_velocity, of_rate = part("dahl"), part("hysteretic_biviscous"), part("lugre")
    assert (path_only.path_only, path_only.follows_velocity) == (True, False)
    assert (of_velocity.path_only, of_velocity.follows_velocity) == (False, True)
    assert (of_rate.path_only, of_rate.needs_acceleration) == (False, False)
    assert (part("spring").advance, part("spring").path_only) == (None, True)
    assert part("inertia").needs_acceleration
    assert (part("delay").delay, part("lag").lag, part("delay").force) == ("tau", "tau", None)


def test_behind_what_stretches_the_force_is_the_plain_one_unless_the_file_has_another() -> None:
    assert part("dahl").force_in_series is part("dahl").force
    own = part("sigmoid").force_in_series
    assert own is not None
    assert own.name == "sigmoid_force_in_series"


def test_parameters_are_those_of_the_dataclass_in_its_order() -> None:
    assert list(part("bouc_wen").parameters) == ["c0", "k0", "kw", "rho", "sigma", "n"]
    assert part("bouc_wen").parameters == quantities(BoucWen)
    assert part("dahl").parameters["rho"].unit == "1/m"


def test_a_number_outside_of_its_limits_is_refused_when_a_part_is_made() -> None:
    with pytest.raises(InputError, match=r"Dahl\.rho.* = -1 .*greater than 0"):
        Dahl(kx=1.0, kw=1.0, rho=-1.0)
    assert Spring(k0=3.0).k0 == 3.0


def test_a_part_without_proposals_starts_anywhere() -> None:
    assert part("spring").starts(Scale(0.01, 0.05, 0.005, 100.0)) == [{}]
    assert all(list(start) == ["rho"] for start in part("dahl").starts(Scale(0.01, 0.05, 0.005, 100.0)))


def test_there_is_one_object_for_each_name_and_none_for_others() -> None:
    assert part("dahl") is part("dahl")
    assert part_name(Dahl(kx=1.0, kw=1.0, rho=1.0)) == "dahl"
    with pytest.raises(InputError, match="3 is not a part of a damper"):
        part_name(3)
    with pytest.raises(InputError, match="did you mean 'dahl'"):
        part("dalh")
