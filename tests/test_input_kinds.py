from dampyr.input_kinds import (
    ALL_RECORDS,
    NO_INPUT,
    at_input,
    group_name,
    input_arguments,
    input_text,
    unit_of,
)


def test_an_input_has_its_unit_and_no_input_has_no_words():
    assert input_text(1.98, "V") == "1.98 V"
    assert input_text(0.0, NO_INPUT) == ""
    assert f"repeat one test{at_input(0.5, 'A')}, in every session" == "repeat one test at 0.5 A, in every session"
    assert f"repeat one test{at_input(0.0, NO_INPUT)}, in every session" == "repeat one test, in every session"
    assert (group_name(0.0, "V"), group_name(0.0, NO_INPUT)) == ("0 V", ALL_RECORDS)
    assert [unit_of(kind) for kind in ("V", "A", NO_INPUT, None)] == ["V", "A", "", ""]


def test_a_damper_is_given_the_input_that_it_has():
    assert input_arguments("V", 1.0) == {"voltage": 1.0}
    assert input_arguments("A", 1.0) == {"current": 1.0}
    assert input_arguments(NO_INPUT, 0.0) == {}
