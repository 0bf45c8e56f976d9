"""Acceptance on the Records page: what its endpoint tells, and what a person sees."""

import re
import shutil

import numpy as np
import pytest

pytest.importorskip("fastapi")
from tests.identification.synthetic import sine

from dampyr import identification, records
from dampyr.models import Constant, Damper
from dampyr.studies import raminelli_2020

VALI, ONE, OTHER = (f"labcontrol/ensaio.{name}.mat" for name in ("vali.1", "A.3", "A.4"))
CARD = Damper("dahl", {"dahl.kx": Constant(900.0, 0.0, 0.0), "dahl.kw": 150.0, "dahl.rho": 3000.0})


@pytest.fixture(scope="module")
def lab_files(tmp_path_factory):
    """A card, a test of a damper like it, and one of a damper that is 20 % stronger."""
    data = tmp_path_factory.mktemp("lab")
    (data / "cards").mkdir()
    CARD.save(data / "cards/mine.toml")
    good = sine(CARD, 0.0, "good")
    records.write(good, data / "good.h5")
    strong = good.replace(note="stronger", name="strong", force=120.0 + 1.2 * (good.force - 120.0))
    records.write(strong, data / "strong.h5")
    records.write(good.replace(note="wrong", name="fast", voltage=3.0), data / "fast.h5")
    return data


@pytest.fixture
def lab(data, lab_files):
    """A data folder with those files."""
    shutil.copytree(lab_files, data, dirs_exist_ok=True)
    return data


def judged(client, *keys, **options):
    return client.get("/api/records/acceptance", params={"key": keys, **options})


def test_the_endpoint_tells_what_the_function_finds(client, campaign_folder):
    got = judged(client, VALI, reference="raminelli_2020", tolerance=0.04).json()
    record = records.read_campaign(campaign_folder, role="validation")[0]
    own = identification.accept(record, raminelli_2020.damper(), tolerance=0.04).results[0]
    (one,) = got["records"]
    assert (one["name"], one["verdict"], one["count"]) == ("ensaio.vali.1", own.verdict, len(own.points))
    assert one["outside_count"] == len(own.outside) > 0
    assert (one["run"], one["cut"], one["judged_cycles"]) == (own.run, own.cut, own.judged_cycles)
    assert one["wrong_rejection"] == pytest.approx(own.wrong_rejection)
    assert [each["cycles"] for each in one["levels"]] == [own.cut]
    assert one["outside"][0]["deviation"] == pytest.approx(own.outside[0].deviation)
    assert [p["quantity"] for p in one["points"]] == ["extension", "compression", "energy"]
    assert one["points"][2]["measured"] == pytest.approx([p.measured for p in own.points if p.quantity == "energy"])
    assert [row["quantity"] for row in got["bands"]] == ["extension", "compression"]
    assert {(row["input"], row["input_value"]) for row in got["bands"]} == {(record.input, record.input_value)}
    low, high = got["bands"][1]["low"], got["bands"][1]["high"]
    assert np.all(np.array(low) < high)


def test_cards_and_records_are_references(client, lab):
    results = judged(client, "data/good.h5", "data/strong.h5", reference="cards/mine.toml").json()["records"]
    assert [one["verdict"] for one in results] == ["passed", "failed"]
    wide = judged(client, "data/strong.h5", reference="cards/mine.toml", force_slack=12, energy_slack=0.4).json()[
        "records"
    ]
    assert wide[0]["verdict"] == "passed"
    each = judged(client, "data/good.h5", "data/strong.h5", reference=["data/good.h5", "data/strong.h5"]).json()
    assert [one["verdict"] for one in each["records"]] == ["failed", "failed"]
    assert [one["worst"]["deviation"] for one in each["records"]] == pytest.approx([1 / 1.2 - 1, 0.2], abs=0.05)
    alone = judged(client, "data/good.h5", reference="data/good.h5").json()["records"][0]
    assert (alone["verdict"], alone["reason"]) == ("not judged", "the reference is this record itself")
    beyond = judged(client, "data/fast.h5", reference="cards/mine.toml").json()["records"][0]
    assert "voltage 3 V is outside the calibrated range" in beyond["reason"]


def test_a_card_may_be_extrapolated_and_records_relevelled(client, lab):
    beyond = judged(client, "data/fast.h5", reference="cards/mine.toml", allow_extrapolation="true").json()["records"][
        0
    ]
    assert beyond["judged"] == beyond["count"] > 0
    got = judged(client, "data/strong.h5", reference="cards/mine.toml", relevel=2).json()
    (once,), (again,) = got["records"], got["relevelled"]
    assert (once["verdict"], once["level"]) == ("failed", 1.0)
    assert (again["verdict"], again["level"]) == ("passed", pytest.approx(1.2, abs=0.01))
    assert [each["level"] for each in got["data"]["relevelled"]] == [again["level"]]
    assert judged(client, "data/strong.h5", reference="cards/mine.toml").json()["relevelled"] == []


@pytest.mark.prove
def test_many_points_are_thinned_and_none_outside_is_lost(client, data):
    t = np.arange(0.0, 1500.0, 0.05)
    x, v = 0.01 * np.sin(2 * np.pi * t), 0.02 * np.pi * np.cos(2 * np.pi * t)
    weak = np.where(np.abs(t - 700.0) < 1.5, 0.5, 1.0)
    records.write(records.Record(t, x, 900.0 * v, voltage=0.0, name="new"), data / "new.h5")
    records.write(records.Record(t, x, 900.0 * v * weak, voltage=0.0, name="long"), data / "long.h5")
    (one,) = judged(client, "data/long.h5", reference="data/new.h5", quantities="extension").json()["records"]
    (points,) = one["points"]
    assert one["count"] > 1400
    assert len(points["speed"]) < 1000
    assert points["inside"].count(False) == one["outside_count"] == 4  # half of the window of the first and the last


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        ({"reference": "nothing_2020"}, 400, "nothing_2020"),
        ({"reference": "cards/none.toml"}, 404, "no such file"),
        ({"reference": "cards/../good.h5"}, 400, "not a valid file name"),
        ({"reference": "data/none.h5"}, 404, "no such file"),
        ({}, 422, "reference"),
        ({"reference": "cards/mine.toml", "tolerance": 15}, 422, "tolerance"),
        ({"reference": "cards/mine.toml", "tolerance": "nan"}, 422, "tolerance"),
        ({"reference": "cards/mine.toml", "tolerance": 0}, 400, "has no width"),
        ({"reference": "cards/mine.toml", "quantities": "rebound"}, 400, "quantities = 'rebound' is not known"),
        ({"reference": "cards/mine.toml", "force_slack": -1}, 422, "force_slack"),
        ({"reference": "cards/mine.toml", "relevel": -1}, 422, "relevel"),
        ({"reference": "cards/mine.toml", "offset": "inf"}, 422, "offset"),
    ],
)
def test_what_is_wrong_is_a_sentence(client, lab, options, code, words):
    answer = judged(client, "data/good.h5", **options)
    assert (answer.status_code, words in answer.json()["detail"]) == (code, True), answer.text
    assert str(lab) not in answer.text


def test_the_page_is_given_as_a_file(client, lab):
    query = {"key": "data/strong.h5", "reference": "cards/mine.toml"}
    page = client.get("/api/records/acceptance/page", params=query)
    assert page.headers["content-disposition"] == 'attachment; filename="acceptance.html"'
    assert "Judged by mine" in page.text
    assert "✗ failed" in page.text


def test_a_person_judges_records_and_the_address_keeps_it(data, lab, address, new_page, accessible):
    page = new_page(f"{address}#/records?source=data&open=data/good.h5&open=data/strong.h5&tab=acceptance")
    page.get_by_text("Choose a reference").wait_for()
    page.get_by_label("Reference", exact=True).select_option("cards/mine.toml")
    page.get_by_role("status").filter(has_text="1 passed, 1 failed.").wait_for()
    page.get_by_role(
        "img", name=re.compile("Forces at peak velocity in extension of good, strong in the band")
    ).wait_for()
    page.get_by_role("heading", name="Points outside").wait_for()
    accessible(page)
    page.get_by_label("Tolerance, %").fill("21")
    page.keyboard.press("Tab")
    page.get_by_role("status").filter(has_text="2 passed.").wait_for()
    assert page.get_by_role("heading", name="Points outside").count() == 0
    page.get_by_label("energy", exact=True).uncheck()
    page.wait_for_url(re.compile("quantities=extension&quantities=compression$"))
    page.reload()
    page.get_by_role("status").filter(has_text="2 passed.").wait_for()
    assert page.get_by_label("Tolerance, %").input_value() == "21"
    assert not page.get_by_label("energy", exact=True).is_checked()
    page.get_by_label("Reference", exact=True).select_option("others")
    page.get_by_role("status").filter(has_text="2 passed.").wait_for()
    with page.expect_download() as given:
        page.get_by_role("link", name="Save the page").click()
    assert "Judged by" in given.value.path().read_text("utf-8")


def test_what_is_not_judged_says_why_in_the_dark_on_a_phone(lab, address, new_page, accessible):
    query = "source=data&open=data/fast.h5&tab=acceptance&reference=cards/mine.toml"
    page = new_page(f"{address}#/records?{query}", color_scheme="dark", viewport={"width": 390, "height": 800})
    page.get_by_role("status").filter(has_text="1 not judged.").wait_for()
    page.get_by_text("voltage 3 V is outside the calibrated range 0 to 0 V").wait_for()
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    accessible(page)


def test_a_wrong_number_is_told_in_a_sentence(lab, address, client, chromium):
    """The browser itself complains of an answer 422, so this page is watched by nobody."""
    page = chromium.new_page()
    page.goto(
        f"{address}#/records?source=data&open=data/good.h5&tab=acceptance&reference=cards/mine.toml&force_slack=much"
    )
    page.get_by_text("force_slack: 'much' is not a quantity").wait_for()
    page.close()
