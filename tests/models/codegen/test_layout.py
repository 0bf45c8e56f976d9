"""Where the parameters and states of a composition's parts stand, and the text of a generated function."""

from dampyr.models.codegen.layout import SITE, Function, Layout, call, indexed
from dampyr.models.part import part


def layout_of(*names: str) -> Layout:
    return Layout(tuple(map(part, names)))


def test_parameters_and_states_are_numbered_part_by_part() -> None:
    spring, dahl, modified = layout_of("spring", "dahl", "modified_bouc_wen").slots
    assert spring.value_places() == {"k0": "p[0]"}
    assert dahl.value_places() == {"kx": "p[1]", "kw": "p[2]", "rho": "p[3]"}
    assert dahl.state_places("e{}") == {"w": "e0"}
    assert list(modified.states.values()) == [1, 2]
    assert list(modified.values.values()) == list(range(4, 12))


def test_in_series_the_force_is_the_last_state_and_the_rate_of_the_stretch_the_one_before() -> None:
    side_by_side, stretched = layout_of("dahl", "spring"), layout_of("dahl", "compliance")
    of_velocity = layout_of("dahl", "hysteretic_biviscous", "compliance")
    assert (side_by_side.in_series, side_by_side.n_states, side_by_side.rate_state) == (False, 1, None)
    assert (stretched.in_series, stretched.n_states, stretched.force_state, stretched.rate_state) == (True, 2, 1, None)
    assert (of_velocity.n_states, of_velocity.force_state, of_velocity.rate_state) == (4, 3, 2)
    assert of_velocity.n_parameters == 3 + 4 + 1
    assert of_velocity.width == 8 + 4


def test_a_function_and_those_that_it_calls_have_the_suffix_of_their_site() -> None:
    function = Function("outer", "x", [f"return inner{SITE}x) + 1.0"])
    names: dict[str, object] = {"inner_2": lambda x: 10.0 * x}
    exec(function.python("_2"), names)
    assert names["outer_2"](3.0) == 31.0  # type: ignore[operator]
    assert function.tree().name == "outer"


def test_a_call_has_its_arguments_in_their_places() -> None:
    force = part("dahl").force
    assert force is not None
    text = call(force, {"w": "s[0]", "kx": "p[1]"}, "0.5", suffix="_by_x")
    assert text.startswith("dahl_force_by_x(")
    assert text.endswith(", 0.5)")
    given = text.partition("(")[2].rstrip(")").split(", ")[:-1]
    assert given == [{"w": "s[0]", "kx": "p[1]"}.get(name, name) for name in force.arguments]
    assert indexed((3, 1), "D[{}]") == "D[3], D[1]"
