"""A passive damper (friction, oil, rubber) from its file to the building: nothing of it speaks of volts or amperes."""

import json
import re
import shutil
import subprocess
import zipfile
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.errors import FileError, InputError
from dampyr.export import export
from dampyr.ground_motions import el_centro
from dampyr.identification import accept, fit, score
from dampyr.identification.fits.least_squares import fit_model
from dampyr.identification.model_choice.leaderboard import leaderboard
from dampyr.identification.scoring.validation import cross_validate
from dampyr.models import Constant, Damper, Interpolation
from dampyr.planning import Peak
from dampyr.records import Record, nominal_inputs, read, read_campaign, write
from dampyr.show.descriptions import description_of
from dampyr.show.pages.result_page import write_page
from dampyr.structures import control_law, ensemble, respond, two_storey
from dampyr.studies import raminelli_2020

DAHL = Damper("dahl", {"kx": 1200.0, "kw": 200.0, "rho": 2000.0}, input="none")
SPEAKS = re.compile(
    r"(?i:volt|current|ampere|\bcoil)|\d\s?V\b|\d A\b|(?<!\w)\[[VA]\]|\bin [VA]\b|V or A"
    r"|\b(at|with|over) none|\d none|input_none"
)


def spoken(text: str) -> list[str]:
    """What a text says of volts and amperes, with what stands about it."""
    return [text[max(0, m.start() - 40) : m.end() + 40] for m in SPEAKS.finditer(text)]


def of_page(path: Path) -> str:
    """The words of a page and of its figures."""
    page = re.sub(r"(?s)<(style|script)\b.*?</\1>", " ", path.read_text(encoding="utf-8"))
    comments = " ".join(re.findall(r"(?s)<!--(.*?)-->", page))  # the texts of figures stand in them
    return unescape(re.sub(r"(?s)<[^>]*>", " ", page)) + comments


def sine(amplitude: float = 0.01, frequency: float = 1.0, **about: object) -> Record:
    t = np.arange(0.0, 6.0, 0.005)
    x, v = (
        amplitude * w
        for w in (np.sin(2 * np.pi * frequency * t), 2 * np.pi * frequency * np.cos(2 * np.pi * frequency * t))
    )
    return Record(t, x, DAHL.force(t, x, velocity=v), velocity=v, **({"no_input": True, "name": "sine"} | about))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """The case passive_no_input of the findings: 10 mm at 1 Hz, in mm and N, no column of an input."""
    record = sine()
    rows = np.column_stack((record.time, 1e3 * record.displacement, record.force))
    path = tmp_path / "passive_no_input.csv"
    np.savetxt(path, rows, delimiter=",", header="time [s],displacement [mm],force [N]", comments="", fmt="%.4f")
    return path


def run(*arguments: str | Path) -> str:
    done = CliRunner().invoke(cli, [*map(str, arguments)], catch_exceptions=False)
    assert done.exit_code == 0, done.output + done.stderr
    return done.stdout + done.stderr


def test_the_numbers_of_the_case_are_found_and_its_card_gives_the_force_without_an_input(file: Path, tmp_path: Path):
    result = fit(read(file, no_input=True), "dahl")
    found = result.parameters
    assert [found[f"dahl.{name}"] for name in ("kx", "kw", "rho")] == pytest.approx([1200.0, 200.0, 2000.0], rel=1e-3)
    assert not spoken(str(result) + repr(result) + json.dumps(result.as_dict(), default=str))
    assert "at 0" not in result.levels.settles
    assert result.levels.settles.startswith("repeat one test, such as passive_no_input, in every session")
    card = result.damper.save(tmp_path / "card.toml")
    assert not spoken(card.read_text())
    damper = Damper.load(card)
    assert (damper.input, damper.needs_input, damper.range_words) == ("none", False, "has no input")
    assert not spoken(str(damper) + damper.to_dataframe().to_string())
    record = sine()
    force = damper.force(record.time, record.displacement, velocity=record.velocity)
    assert np.abs(force - record.force).max() < 1e-3 * record.force.max()
    assert damper.at().kx == damper.at(3.0).kx
    assert score(damper, record).l1 < 1e-3


def test_a_file_without_a_column_of_the_input_is_no_passive_damper_until_that_is_said(file: Path):
    """A forgotten voltage of a magnetorheological damper must not become a damper without an input."""
    record = read(file)
    assert (record.input, record.no_input) == (None, False)
    for call in (lambda: fit(record, "dahl"), lambda: leaderboard([record])):
        with pytest.raises(
            InputError, match=r"its voltage is not known.*\(friction, oil, rubber\) is read with no_input=True"
        ):
            call()
    done = CliRunner().invoke(cli, ["identify", str(file), "--model", "dahl"])
    assert done.exit_code != 0
    assert "damper without an input (friction, oil, rubber) is declared with --no-input" in " ".join(
        done.stderr.split()
    )


@pytest.mark.parametrize("suffix", ["csv", "h5", "mat", "nc", "parquet"])
def test_a_record_without_an_input_comes_back_as_it_was_written(suffix: str, tmp_path: Path):
    path = write(sine(), tmp_path / f"record.{suffix}")
    back = read(path)
    assert (back.input, back.no_input, back.input_value) == ("none", True, None)
    assert np.allclose(back.force, sine().force)
    with pytest.raises(InputError, match="voltage = 1 V was given, but the file says that the damper has no input"):
        read(path, voltage=1.0)
    assert not spoken(str(back) + back.to_dataframe().to_string())


def test_a_folder_says_it_once_and_a_measured_zero_gives_way(tmp_path: Path):
    """A passive damper on a rig that records the voltage of a coil that nobody connected."""
    for name in ("a", "b"):
        noise = 0.002 * np.random.default_rng(1).standard_normal(1200)
        write(sine(no_input=False, voltage=noise, name=name), tmp_path / f"{name}.csv")
    (tmp_path / "reading.toml").write_text("no_input = true\n")
    records = read_campaign(tmp_path)
    assert {record.input for record in records} == {"none"}
    assert "no input as stated" in records[0].history
    write(sine(no_input=False, voltage=2.0, name="c"), tmp_path / "c.h5")
    with pytest.raises(FileError, match=r"no_input was given, but the file's voltage has 2 to 2 V"):
        read_campaign(tmp_path)


def test_records_with_and_without_an_input_are_not_taken_together():
    mixed = [sine(), sine(no_input=False, voltage=1.0, name="other")]
    with pytest.raises(
        InputError, match="other has a voltage and sine none as its input; take records of one kind together"
    ):
        nominal_inputs(mixed)
    with pytest.raises(InputError, match="take records of one kind together"):
        fit(mixed, "dahl")
    with pytest.raises(InputError, match="they are of two dampers, so fit them separately"):
        fit_model("dahl", mixed)
    with pytest.raises(InputError, match="voltage is given, and no_input says that the damper has none"):
        sine(voltage=1.0)
    with pytest.raises(InputError, match="no_input are both given"):
        read("x.csv", voltage=1.0, no_input=True)


def test_a_damper_without_an_input_takes_none_and_follows_none():
    record = sine()
    with pytest.raises(InputError, match="this damper has no input, and voltage= is given; leave it out"):
        DAHL.force(record.time, record.displacement, voltage=0.0)
    with pytest.raises(InputError, match=r"this damper has no input, and voltage= is given"):
        score(DAHL, sine(no_input=False, voltage=1.0))
    with pytest.raises(InputError, match=r"dahl\.kw follows an input and the damper's input is 'none'"):
        Damper("dahl", {"kx": 1.0, "kw": Interpolation((0.0, 1.0), (1.0, 2.0)), "rho": 1.0}, input="none")
    with pytest.raises(InputError, match=r"follows an input and the damper's input is 'none'"):
        Damper("dahl", {"kx": 1.0, "kw": Constant(1.0, 0.0, 1.0), "rho": 1.0}, input="none")
    with pytest.raises(InputError, match="lag is the lag of an input"):
        Damper("dahl + lag", {"kx": 1.0, "kw": 1.0, "rho": 1.0, "tau": 0.1}, input="none")
    with pytest.raises(InputError, match="there is no input, so nothing can be drawn over it"):
        DAHL.plot.laws()


def test_in_a_building_it_stands_by_itself_and_beside_one_with_an_input():
    building, motion = two_storey(), el_centro()
    alone = respond(building, motion, {1: DAHL})
    cases = respond(building, motion, {1: DAHL}, voltage=[None])
    assert list(cases.cases) == ["no damper", "with damper"]
    assert np.array_equal(cases["with damper"].peak_drift, alone.peak_drift)
    assert not spoken(str(cases) + str(alone) + json.dumps(cases.as_dict(), default=str))
    assert not {"input", "mean_input", "damper_input_unit"} & {*alone.to_xarray().variables}
    for inputs in ({"voltage": 1.0}, {"voltage": [1.0]}, {"current": 0.1}, {"voltage": {1: 1.0}}):
        with pytest.raises(InputError, match="is given, but the damper has no input; leave it out"):
            respond(building, motion, {1: DAHL}, **inputs)
    law = control_law("on_off", low=0.0, high=1.0)
    with pytest.raises(InputError, match="a control law sets the input of a damper, and this one has none"):
        respond(building, motion, {1: DAHL}, voltage=law)
    beside = {1: DAHL, 2: raminelli_2020.damper()}
    with pytest.raises(InputError, match="an input is given for storey 1, whose damper has none"):
        respond(building, motion, beside, voltage={1: 0.0, 2: 1.98})
    both = respond(building, motion, beside, voltage=1.98)
    assert both.inputs == (None, 1.98)
    assert list(respond(building, motion, beside, voltage=[1.98]).cases) == ["no damper", "1.98 V"]


def test_an_ensemble_has_one_case_of_it_and_refuses_an_input():
    building, motion = two_storey(), el_centro()
    result = ensemble(building, motion, [None, DAHL], scales=[0.5, 1.0])
    assert result.dataset.sizes["input"] == 1
    assert not spoken(str(result) + result.to_dataframe().to_string())
    assert "with damper" in str(result.to_dataframe())
    with pytest.raises(InputError, match=r"voltage= is given, but the dampers have no input"):
        ensemble(building, motion, DAHL, voltage=[1.0])
    with pytest.raises(InputError, match="a control law sets the input of a damper, and these have none"):
        ensemble(building, motion, DAHL, voltage=control_law("on_off", low=0.0, high=1.0))
    with pytest.raises(InputError, match="some of the dampers have an input and others none"):
        ensemble(building, motion, [DAHL, raminelli_2020.damper()], voltage=1.0)


def test_what_is_exported_takes_the_motion_alone(tmp_path: Path):
    for kind in ("c", "opensees", "matlab"):
        for path in export(DAHL, kind, tmp_path / kind):
            assert not spoken(path.read_text()), path
    header = (tmp_path / "c" / "damper.h").read_text()
    assert "double damper_step(damper_state *d, double t, double x, double v);" in header
    assert "def define(ops, tag):" in (tmp_path / "opensees" / "damper.py").read_text()
    assert "f = damper(t, x, v) is the force" in (tmp_path / "matlab" / "damper.m").read_text()
    with pytest.raises(InputError, match="the damper has no input, and inputs are given"):
        export(DAHL, "opensees", tmp_path / "more", inputs=[1.0])


@pytest.mark.prove
@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler is installed")
@pytest.mark.parametrize("fmi", [2, 3])
def test_the_unit_has_no_variable_of_an_input_and_the_c_code_gives_the_force(fmi: int, tmp_path: Path):
    export(DAHL, "c", tmp_path / "c")
    assert subprocess.run(["make", "-C", str(tmp_path / "c"), "test"], capture_output=True, check=False).returncode == 0
    (unit,) = export(DAHL, "fmu", tmp_path, fmi=fmi)
    with zipfile.ZipFile(unit) as archive:
        texts = {
            name: archive.read(name).decode() for name in archive.namelist() if name.endswith((".xml", ".c", ".h"))
        }
    assert not [said for text in texts.values() for said in spoken(text)]
    description = texts["modelDescription.xml"]
    assert re.findall(r'name="(\w+)" valueReference="(\d+)" causality="input"', description) == [
        ("displacement", "0"),
        ("velocity", "1"),
    ]
    fmpy = pytest.importorskip("fmpy")
    assert not pytest.importorskip("fmpy.validation").validate_fmu(str(unit))
    record = sine()
    signals = np.rec.fromarrays(
        [record.time, record.displacement, record.velocity], names=["time", "displacement", "velocity"]
    )
    told = fmpy.simulate_fmu(
        str(unit), input=signals, output=["force", "dahl.kw"], step_size=0.005, output_interval=0.005, stop_time=2.0
    )
    count = len(told["force"])  # a master that reads before it sets is a step late
    assert np.allclose(told["force"][1:], record.force[: count - 1], rtol=0, atol=1e-6 * record.force.max())
    assert set(told["dahl.kw"]) == {200.0}


@pytest.fixture
def six() -> list[Record]:
    rng = np.random.default_rng(1)
    records = []
    for k, (amplitude, frequency) in enumerate(
        [(0.01, 1), (0.01, 0.5), (0.005, 2), (0.015, 1), (0.015, 0.5), (0.005, 1)]
    ):
        record = sine(amplitude, frequency, name=f"t{k}", measurement_session="a" if k < 3 else "b")
        level = 1.0 + 0.02 * rng.standard_normal()
        records.append(record.replace(note="made", force=level * record.force + rng.normal(0.0, 1.0, record.n)))
    return records


def test_left_out_records_sessions_and_acceptance_speak_of_records_alone(six: list[Record]):
    result = fit(six, "dahl")
    assert "estimated from 2 sessions that were repeated" in result.levels.words
    validation = cross_validate(six, "dahl", "record")
    assert (validation.inputs, validation.unit) == ({}, "")
    with pytest.raises(InputError, match="leaving an input out needs three or more"):
        cross_validate(six, "dahl", "input")
    accepted = accept(six, result.damper)
    assert accepted.verdict == "passed"
    for shown in (result, validation, accepted, result.residuals, result.damper):
        assert not [table for table in description_of(shown).tables if "input" in table().columns]
    told = [str(o) + json.dumps(o.as_dict(), default=str) for o in (result, validation, accepted)]
    told += [o.to_dataframe().to_string() for o in (result, validation, accepted, result.residuals)]
    assert not [said for text in told for said in spoken(text)]


@pytest.mark.prove
def test_a_choice_of_models_says_no_volts(six: list[Record], tmp_path: Path):
    result = fit(six, models=("dahl", "bingham"), add_ons=("lag",))
    board = result.leaderboard
    assert board.winner.model == "dahl"
    assert board.left_out[0].startswith("lag was not tried: there is no input")
    page = tmp_path / "page.html"
    write_page(result, page)
    told = str(board) + str(board.winner) + of_page(page)
    assert not spoken(told)
    assert "unseen input" not in told


@pytest.mark.prove
def test_from_the_file_to_the_building_by_the_command_line(file: Path, tmp_path: Path):
    """Terminal, JSON, pages, card: the whole chain, and no word of volts."""
    card, said = tmp_path / "card.toml", ""
    pages = [tmp_path / f"{name}.html" for name in ("fit", "validate", "accept", "simulate", "ensemble")]
    say_so = (file, "--no-input")
    said += run("records", *say_so) + run("records", *say_so, "--json")
    said += run("identify", *say_so, "--model", "dahl", "--save", card, "--report", pages[0], "--details")
    said += run("identify", *say_so, "--model", "dahl", "--json") + card.read_text()
    said += run("validate", card, *say_so, "--report", pages[1]) + run("validate", card, *say_so, "--json")
    said += run("accept", card, *say_so, "--report", pages[2]) + run("accept", card, *say_so, "--json")
    said += run("simulate", card, "--report", pages[3], "--details") + run("simulate", card, "--json")
    few = ("--synthetic", "2", "--scale", "0.5,1", "--without-damper", "--limit", "12mm")
    said += run("ensemble", card, *few, "--report", pages[4]) + run("ensemble", card, *few, "--json")
    said += run("plan", "--card", card, "--tests", "2", "--out", tmp_path / "campaign.toml")
    said += (tmp_path / "campaign.toml").read_text()
    said += run("plan", "--card", card, "--tests", "1", "--goal", "peak", "--json")
    assert not spoken(said + "".join(map(of_page, pages)))
    for option in (("--voltage", "1"), ("--control", "on_off")):
        done = CliRunner().invoke(cli, ["simulate", str(card), *option])
        assert done.exit_code != 0
        assert f"this damper has no input, and {option[0]} is given; leave it out" in done.stderr


def test_a_peak_of_a_building_is_planned_for_without_a_voltage():
    peak = Peak(two_storey(), el_centro(), None)
    assert peak.words == "the largest drift"
    peak.check(DAHL)
    with pytest.raises(InputError, match="has no input"):
        Peak(two_storey(), el_centro(), 1.0).check(DAHL)
    with pytest.raises(InputError, match="needs the damper's voltage"):
        peak.check(raminelli_2020.damper())


def test_cards_and_records_of_dampers_with_an_input_are_as_before():
    damper = Damper("dahl", {"kx": 900.0, "kw": 250.0, "rho": 9000.0})
    assert (damper.input, damper.has_input, damper.needs_input) == ("V", True, False)
    record = sine(no_input=False)
    assert (record.input, sine(no_input=False, current=0.1).input) == (None, "A")
