"""The form of a job's options in a browser: a control for each option, and what is entered is what is asked for."""

import pytest

pytest.importorskip("fastapi")

from tests.identification.synthetic import sine

from dampyr import records
from dampyr.identification import FitOptions
from dampyr.options import options_of
from dampyr.studies import raminelli_2020

ENTERED = {
    "laws": ("polynomial:1; dahl.rho = constant", {"*": "polynomial:1", "dahl.rho": "constant"}),
    "fixed": ("dahl.kx = 900,5", {"dahl.kx": 900.5}),
    "tied": ("spring.k0 = bouc_wen.k0", {"spring.k0": "bouc_wen.k0"}),
    "bandwidth": ("20", 20.0),
    "loss": ("huber", "huber"),
    "settling": ("500 ms", "500 ms"),
    "session_prior": ("5", 0.05),
    "starts": ("4", 4),
    "models": ("dahl; bingham", ["dahl", "bingham"]),
    "nested": (True, True),
    "predict": (["record", "input"], ["record", "input"]),
    "nuisances": (["offset", "gain"], ["offset", "gain"]),
}


def label_of(option):
    words = option.name.replace("_", " ").capitalize()
    return f"{words}, {option.shown_in}" if option.shown_in else words


def test_every_option_of_a_fit_has_a_control_and_what_is_entered_is_asked_for(address, new_page, data, accessible):
    records.write(sine(raminelli_2020.damper(), 1.98, "r0"), data / "r0.h5")
    page = new_page(f"{address}#/identify", refused=400)
    for opened in ("Fit options", "Search", "Choice of a model"):
        page.get_by_text(opened, exact=True).click()
    page.get_by_label("Source").select_option("data")
    page.get_by_label("Choose r0").check()
    form = page.locator("details", has=page.get_by_text("Fit options", exact=True)).first  # not that of scoring a card
    for option in options_of(FitOptions):
        label = label_of(option)
        several = option.several and option.choices
        control = form.get_by_role("group", name=label) if several else form.get_by_label(label, exact=True)
        assert control.count() == 1, option.name
        assert form.get_by_text(option.words, exact=True).count() == 1, option.name
        if option.name not in ENTERED:
            continue
        typed, _ = ENTERED[option.name]
        if several:
            for choice in option.choices:
                control.get_by_label(choice, exact=True).set_checked(choice in typed)
        elif option.kind is bool:
            control.set_checked(typed)
        elif option.choices:
            control.select_option(typed)
        else:
            control.fill(typed)
    accessible(page)
    with page.expect_request("**/api/identify/jobs") as sent:
        page.get_by_role("button", name="Find the best model").click()
    page.get_by_text("fixed and tied parameters need a model").wait_for()
    request = sent.value.post_data_json
    assert request == {
        "records": ["data/r0.h5"], "model": None, **{name: value for name, (_, value) in ENTERED.items()},
    }  # fmt: skip
