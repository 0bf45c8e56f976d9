"""Figures of cycles on the Records page: what its endpoint tells, and its page."""

import numpy as np
import pytest

pytest.importorskip("fastapi")

from dampyr import records

ONE, OTHER = "labcontrol/ensaio.A.3.mat", "labcontrol/ensaio.A.4.mat"


def test_the_endpoint_tells_what_the_function_finds(client, campaign_folder):
    got = client.get("/api/records/cycle-figures", params={"key": [ONE, OTHER], "unit_system": "in-lb"}).json()
    own = records.cycles([records.read(campaign_folder / key.split("/")[1]) for key in (ONE, OTHER)])
    tables = {table["name"]: table for table in got["tables"]}
    every = tables["cycles"]
    energy = every["columns"].index("energy")
    assert every["units"][energy] == "in lbf"
    assert len(every["rows"]) == len(own.cycles) > 10
    told = [row[energy] * 0.1129848 for row in every["rows"]]  # J in a pound-force times an inch
    assert told == pytest.approx([cycle.energy for cycle in own.cycles], rel=1e-5)
    assert {row[0] for row in every["rows"]} == {"ensaio.A.3", "ensaio.A.4"}
    page = client.get("/api/records/cycle-figures/page", params={"key": ONE, "device": "viscous"})
    assert page.headers["content-disposition"] == 'attachment; filename="cycles.html"'
    assert "dampyr cycles labcontrol/ensaio.A.3.mat --device viscous" in page.text


def test_a_passive_device_has_its_own_figures(client, data):
    t = np.arange(0.0, 6.0, 0.002)
    x = 0.01 * np.sin(2 * np.pi * t)
    records.write(
        records.Record(t, x, 2e4 * x + 100 * np.sign(np.cos(2 * np.pi * t)), no_input=True), data / "brace.h5"
    )
    tables = client.get("/api/records/cycle-figures", params={"key": "data/brace.h5"}).json()["tables"]
    [every] = [table for table in tables if table["name"] == "cycles"]
    assert all(row[every["columns"].index("equivalent damping")] is not None for row in every["rows"])


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        ({"key": "data/none.h5"}, 404, "none.h5"),
        ({"key": ONE, "device": "spring"}, 400, "device"),
        ({"key": ONE, "least_stiffness": 3}, 422, "least_stiffness"),
        ({"key": [f"data/{k}.h5" for k in range(9)]}, 422, "key"),
    ],
)
def test_a_wrong_request_is_a_sentence(client, options, code, words):
    answer = client.get("/api/records/cycle-figures", params=options)
    assert (answer.status_code, words in answer.text) == (code, True), answer.text
