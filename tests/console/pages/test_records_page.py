"""The Records page in a browser: what comes in, what is left out, what is changed."""

import numpy as np
import pytest

pytest.importorskip("fastapi")

from dampyr import records

ROWS = [(k / 100, 8 * np.sin(k / 12), 300 * np.cos(k / 12) + 20) for k in range(600)]
BARE = "".join(f"{t},{x:.5f},{f:.4f}\n" for t, x, f in ROWS)


def made(name, **more):
    t, x, f = np.array(ROWS).T
    return records.Record(t, 1e-3 * x, f, voltage=1.0, name=name, **more)


def test_several_files_without_names_are_uploaded_with_the_columns_chosen_once(address, new_page, data, tmp_path):
    for name in ("one.csv", "two, second.csv"):
        (tmp_path / name).write_text(BARE)
    page = new_page(f"{address}#/records?source=data")
    page.get_by_text("Upload records").click()
    page.get_by_label("File", exact=True).set_input_files([tmp_path / "one.csv", tmp_path / "two, second.csv"])
    for k, channel in enumerate(("time", "displacement", "force")):
        page.get_by_label(f"Channel of column {k}").select_option(channel)
    assert page.get_by_label("Unit of column 1").input_value() == "mm"
    page.get_by_label("Factor of column 2").fill("2 kN")  # as of counts, in the place of a unit
    page.get_by_label("Unit of column 2").fill("")
    page.get_by_label("Offset of column 2").fill("-100 N")
    page.get_by_label("Voltage, V").fill("0,5")
    page.get_by_role("button", name="Upload").click()
    page.get_by_text("Uploaded 2 records.").wait_for()
    page.get_by_label("Show two_ second").wait_for()
    read = records.read(data / "uploads" / "one.h5")
    assert read.voltage == 0.5
    assert read.force == pytest.approx(2e3 * np.array(ROWS)[:, 2] - 100.0, abs=0.2)


def test_the_chosen_columns_are_drawn_before_they_are_uploaded(address, new_page, tmp_path):
    lines = [f"{t:.2f};{x:.4f};{f:.3f};1,98".replace(".", ",") for t, x, f in ROWS]
    (tmp_path / "Versuch.csv").write_text("\n".join(["Zeit in s;Weg in mm;Kraft in N;Spannung in V", *lines]))
    page = new_page(f"{address}#/records?source=data")
    page.get_by_text("Upload records").click()
    page.get_by_label("File", exact=True).set_input_files(tmp_path / "Versuch.csv")
    page.get_by_role("img", name="Kraft over Weg in the file, before it is uploaded").wait_for()
    assert page.get_by_label("Channel of Spannung").input_value() == "voltage"
    assert page.get_by_label("Channel of Weg").evaluate("box => box.clientWidth") > 120  # displacement is read whole
    page.get_by_text("every row of 600").wait_for()
    page.get_by_role("button", name="Save", exact=True).wait_for()
    page.get_by_label("Channel of Weg").select_option("")
    page.get_by_role("img", name="Weg over Zeit in the file, before it is uploaded").wait_for(state="detached")
    page.get_by_role("img", name="Kraft over Zeit in the file, before it is uploaded").wait_for()
    page.evaluate("location.assign('#/building')")
    page.get_by_label("Inputs").fill("0,5")
    page.get_by_role("button", name="Simulate").click()
    page.get_by_text(
        "Inputs: 0,5 can be one number or two; write 0.5 or 0,5; for the one number, 0; 5 for two"
    ).wait_for()
    page.get_by_label("Inputs").fill("0,5;")
    page.get_by_label("Inputs").blur()


def test_a_line_of_names_that_is_said_shows_the_columns_anew(address, new_page, tmp_path):
    (tmp_path / "two.csv").write_text("one,two,three\nt [s],x [mm],f [N]\n" + BARE)
    page = new_page(f"{address}#/records?source=data")
    page.get_by_text("Upload records").click()
    page.get_by_label("File", exact=True).set_input_files([tmp_path / "two.csv"])
    page.get_by_label("Channel of x", exact=True).wait_for()
    page.get_by_label("Header").fill("1")
    page.get_by_label("Header").blur()
    page.get_by_label("Channel of two").wait_for()


def test_an_upload_is_described_anew_renamed_and_deleted_after_a_question(address, new_page, data):
    (data / "uploads").mkdir()
    records.write(made("a"), data / "uploads" / "a.h5")
    page = new_page(f"{address}#/records?source=data&open=data/uploads/a.h5&tab=about")
    page.get_by_text("Change what is said of it").click()
    page.get_by_label("Operator").fill("Jo")
    page.get_by_label("Voltage at the coil, V").fill("1,98")
    page.get_by_label("Role").last.select_option("validation")
    page.get_by_role("button", name="Save the changes").click()
    page.get_by_text("The record is written anew").wait_for()
    assert records.read(data / "uploads" / "a.h5").role == "validation"
    page.locator("tr", has=page.get_by_label("Show a", exact=True)).get_by_text("validation").wait_for()
    assert records.read(data / "uploads" / "a.h5").voltage == 1.98
    page.get_by_text("Change what is said of it").click()
    page.get_by_role("button", name="Rename").click()
    page.get_by_label("New name").fill("b")
    page.get_by_role("dialog").get_by_role("button", name="Rename").click()
    page.get_by_text("Renamed b.").wait_for()
    page.get_by_text("Change what is said of it").click()
    page.get_by_role("button", name="Delete the record").click()
    page.get_by_role("dialog").get_by_role("button", name="Cancel").click()
    assert (data / "uploads" / "b.h5").is_file()
    page.get_by_role("button", name="Delete the record").click()
    page.get_by_role("dialog").get_by_role("button", name="Delete").click()
    page.get_by_text("The record is deleted.").wait_for()
    assert list((data / "uploads").iterdir()) == []


def test_interrupted_records_are_marked_and_left_out_until_they_are_wanted(address, new_page, data):
    (data / "runs" / "day").mkdir(parents=True)
    for name, attempt, more in (("a", "1", {"complete": "no"}), ("a-2", "2", {})):
        records.write(made("a", provenance={"test": "a", "try": attempt, **more}), data / "runs" / "day" / f"{name}.h5")
    page = new_page(f"{address}#/records?source=data")
    page.get_by_text("1 of 2 records; up to 6 are overlaid; 1 interrupted or repeated not shown").wait_for()
    page.get_by_label("Interrupted and repeated ones too").check()
    page.get_by_text("2 of 2 records").wait_for()
    assert page.locator("tr", has_text="interrupted").count() == 1
    page.evaluate("location.assign('#/identify')")
    page.get_by_label("Source").select_option("data")
    page.get_by_label("Choose a-2").wait_for()
    page.get_by_role("button", name="All shown").click()
    page.get_by_text("1 chosen").wait_for()
    page.get_by_label("interrupted and repeated ones").check()
    page.get_by_role("button", name="All shown").click()
    page.get_by_text("2 chosen").wait_for()


def test_the_figures_of_cycles_follow_the_form(address, new_page, data):
    records.write(made("a"), data / "a.h5")
    page = new_page(f"{address}#/records?source=data&open=data/a.h5&tab=cycles")
    page.get_by_text("Every full cycle.", exact=True).wait_for()
    assert page.get_by_role("columnheader", name="energy J").count() > 0
    page.get_by_label("Unit system").select_option("in-lb")
    page.get_by_role("columnheader", name="energy in lbf").first.wait_for()
    assert "unit_system=in-lb" in page.evaluate("location.hash")
    page.get_by_label("Speeds, mm/s").fill("fast")
    page.get_by_label("Speeds, mm/s").blur()
    page.get_by_role("alert").or_(page.get_by_role("status")).filter(has_text="fast").first.wait_for()


def test_records_are_told_apart_grouped_searched_and_overlaid_from_their_begins(address, new_page, data, accessible):
    for run, specimen, operator, day, rest in (
        ("monday", "no 1", "Ana", "01", 0.0),
        ("tuesday", "no 2", "Jo", "02", 40.0),
    ):
        (data / "runs" / run).mkdir(parents=True)
        for name in ("01-sine", "02-sine"):
            stated = {"operator": operator, "started": f"2026-03-{day}T0{name[1]}:30:00", "date": f"2026-03-{day}"}
            record = made(name, specimen=specimen, provenance=stated)
            records.write(record.replace(note="later", time=record.time + rest), data / "runs" / run / f"{name}.h5")
    page = new_page(f"{address}#/records?source=data", viewport={"width": 1440, "height": 700})
    heads = page.locator("tr.group")
    heads.nth(1).wait_for()
    assert heads.all_inner_texts() == [
        "runs/monday 2 records · no 1 · Ana · 2026-03-01", "runs/tuesday 2 records · no 2 · Jo · 2026-03-02"
    ]  # fmt: skip
    page.get_by_role("button", name="date").click()
    page.get_by_role("button", name="date").click()  # the latest first, and its group
    assert heads.first.inner_text().startswith("runs/tuesday")
    dates = page.locator("tbody tr:not(.group) td:nth-child(3)").all_inner_texts()
    assert [" ".join(date.split()) for date in dates] == [
        f"2026-03-0{day} 0{hour}:30" for day in (2, 1) for hour in (2, 1)
    ]
    page.get_by_label("Group by").select_option("")
    assert heads.count() == 0
    names = page.locator("tbody td:nth-child(2)").all_inner_texts()
    assert [" ".join(name.split()) for name in names][::2] == [
        "01-sine runs/monday · no 1 · Ana",
        "01-sine runs/tuesday · no 2 · Jo",
    ]
    for search, count in (("jo", 2), ("2026-03-01 02-sine", 1), ("monday ana", 2), ("nobody", 0)):
        page.get_by_label("Filter").fill(search)
        page.get_by_text(f"{count} of 4 records").wait_for()
    page.get_by_label("Filter").fill("")
    box = page.locator(".table").first  # all columns are seen at this width
    assert box.evaluate("box => box.scrollWidth <= box.clientWidth")
    for row in page.get_by_label("Show 01-sine").all():
        row.check()
    page.get_by_role("img", name="Force over time of 01-sine (monday), 01-sine (tuesday)").wait_for()
    page.get_by_role("button", name="Save", exact=True).first.wait_for()
    plots = "Bokeh.documents.filter((one) => one.roots().length).at(-1).roots()"
    range_of = f"() => {plots}.map((one) => [one.x_range.start, one.x_range.end])[0]"
    start, end = page.evaluate(range_of)
    assert -1.0 < start <= 0.0 < 5.0 < end < 6.0
    accessible(page)
    page.get_by_label("Time from").select_option("rig")
    page.wait_for_function(f"() => ({range_of})()?.[1] > 45")
    assert "clock=rig" in page.url
    page.set_viewport_size({"width": 390, "height": 800})
    page.locator(".table.wider").first.wait_for()  # and where they are not, an edge is shaded
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_a_whole_run_is_chosen_by_one_box(address, new_page, data):
    for run in ("monday", "tuesday"):
        (data / "runs" / run).mkdir(parents=True)
        for name in ("01-sine", "02-sine"):
            records.write(made(name), data / "runs" / run / f"{name}.h5")
    page = new_page(f"{address}#/identify")
    page.get_by_label("Choose all of runs/tuesday").check()
    page.get_by_text("2 chosen").wait_for()
    page.get_by_label("Choose 01-sine").nth(1).uncheck()
    assert page.get_by_label("Choose all of runs/tuesday").evaluate("box => box.indeterminate && !box.checked")
    assert page.get_by_label("Source").input_value() == "data"


def test_an_address_with_a_view_that_is_none_shows_the_first(address, new_page, data):
    records.write(made("a"), data / "a.h5")
    page = new_page(f"{address}#/records?source=data&open=data/a.h5&tab=constructor")
    page.get_by_role("tab", name="Time", selected=True).wait_for()


def test_ones_own_records_come_first_where_there_are_any(address, new_page, data):
    page = new_page(f"{address}#/records")
    page.get_by_label("Source", exact=True).wait_for()
    assert page.get_by_label("Source", exact=True).input_value() != "data"
    (data / "uploads").mkdir()
    records.write(made("a"), data / "uploads" / "a.h5")
    page.reload()
    page.goto(f"{address}#/bench")
    page.goto(f"{address}#/records")
    page.get_by_label("Show a", exact=True).wait_for()
    assert page.get_by_label("Source", exact=True).input_value() == "data"
