"""Two fits side by side, and how long a search takes, from jobs that a data folder holds."""

import json
import re

import pytest

pytest.importorskip("fastapi")
from fastapi.testclient import TestClient
from tests.console.conftest import served_here
from tests.console.record_files import made

from dampyr import records
from dampyr.console import app
from dampyr.console.identify_schemas import search_workers
from dampyr.identification.fits.fit_options import BUDGET

LINE = {"x": [-0.01, 0.0, 0.01], "y": [-100.0, 0.0, 100.0]}


def table(columns, rows):
    return {"caption": "", "notes": [], "units": [""] * len(columns), "columns": columns, "rows": rows}


def hold(data, number, model, parameters, misfits, searched=False, seconds=30.0):
    """A fit that is done, as its job has left it."""
    id = f"{number:016x}"
    folder = data / ".console" / "jobs" / id
    folder.mkdir(parents=True)
    request = {"records": [f"data/{name}.h5" for name in misfits], "model": None if searched else model}
    result = {
        "model": model, "notice": "", "card": False, "converged": True, "reason": "converged", "settling": 2.0, "choice": [],
        "verdict": {"kind": "fair", "words": f"{model} has {model[0]}_w and describes these records."},
        "warnings_of_fit": [], "findings": [], "predictions": [], "records": list(misfits),
        "data": {"origin": {"kind": "measured"}}, "held": [{"record": "v", "l1": 0.0725, "problem": ""}],
        "parameters": [table(["parameter", "unit", "0 V"], parameters)],
        "scores": table(["record", "L1"], [*map(list, misfits.items())]) | {"units": ["", "%"]},
    }  # fmt: skip
    over = {"measured": LINE, "model": LINE}
    curves = {name: {"time": over, "displacement": over, "velocity": over, "residual": LINE} for name in misfits}
    job = {"id": id, "kind": "identify", "title": f"{model}, 2 records", "state": "done", "made": 1e9 + number}
    for name, content in (
        ("request", {"kind": "identify", "request": request}), ("result", result), ("curves", curves),
        ("job", job | {"ended": 1e9 + number + seconds}),
    ):  # fmt: skip
        (folder / f"{name}.json").write_text(json.dumps(content))
    return id


def test_two_fits_stand_side_by_side(new_page, data, accessible):
    records.write(made("a"), data / "a.h5")
    first = hold(
        data, 1, "dahl", [["dahl k_x", "N s/mm", "1.42 ± 0.12"], ["dahl ρ", "1/mm", "51 ± 20"]], {"a": 5.25, "b": 6.5}
    )
    second = hold(
        data, 2, "bingham", [["dahl k_x", "N s/mm", "1.55 ± 0.10"], ["f_0", "N", "15 ± 15"]], {"a": 4.25, "c": 9.75}
    )
    with served_here(data) as address:
        look(new_page, address, first, second, accessible)


def look(new_page, address, first, second, accessible):
    page = new_page(f"{address}#/identify?job={first}&with={second}", viewport={"width": 1440, "height": 900})
    parts = page.locator("section", has=page.get_by_role("heading", name="Beside another fit"))
    parts.get_by_role("img", name="Force of a over velocity, measured and by both fits").wait_for()

    def rows(caption):
        lines = parts.get_by_role("table", name=caption).locator("tbody tr").all()
        return [line.locator("td").all_inner_texts() for line in lines]

    assert rows("What each says of itself") == [
        ["dahl", "dahl has dw and describes these records."], ["bingham", "bingham has bw and describes these records."]
    ]  # fmt: skip
    assert rows("Value ± half of the 95 % interval") == [
        ["dahl kx", "0 V", "N s/mm", "1.42 ± 0.12", "1.55 ± 0.10"],
        ["dahl ρ", "0 V", "1/mm", "51 ± 20", "–"],
        ["f0", "0 V", "N", "–", "15 ± 15"],
    ]
    assert rows("Misfit of each record, L1") == [
        ["a", "5.25", "4.25"], ["b", "6.50", "–"], ["v (predicted)", "7.25", "7.25"], ["c", "–", "9.75"]
    ]  # fmt: skip
    assert parts.locator("var sub").all_inner_texts()[:3] == ["w", "w", "x"]
    assert parts.get_by_label("Loops of").locator("option").all_inner_texts() == ["a"]
    for series in ("measured", "dahl", "bingham"):
        parts.locator(".legend").get_by_role("button", name=series, exact=True).wait_for()
    accessible(page)
    parts.get_by_label("Other fit").select_option("")
    parts.get_by_text("Misfit of each record").wait_for(state="detached")
    assert "with=" not in page.url
    page.get_by_label("Source").wait_for()
    assert page.get_by_label("Source").input_value() == "data"
    page.get_by_text(re.compile("Find the best model tries all of the catalogue. Takes up to about")).wait_for()
    page.goto("about:blank")  # it asks for nothing any more


def test_how_long_a_search_takes_is_told_by_the_last_one(data):
    def told():
        with TestClient(app(data), base_url="http://localhost") as client:
            return client.get("/api/identify/choices").json()["search_time"]

    hold(data, 1, "dahl", [], {"a": 5.0})  # a fit of one model says nothing of it
    assert told().startswith(f"Takes up to about {BUDGET * 1.25 / search_workers() / 60:.0f} min here")
    hold(data, 2, "dahl", [], {"a": 5.0, "b": 1.0}, searched=True, seconds=400.0)
    hold(data, 3, "dahl", [], {"a": 5.0}, searched=True, seconds=42.4)
    assert told() == "The last search in this data folder took 42 s, for 1 record."
