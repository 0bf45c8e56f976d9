"""What dampyr identify prints of errors, and what it refuses before it fits."""

import importlib
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from tests.identification.parameter_uncertainty.test_uncertainty import records
from tests.identification.tangent_campaign import without_velocity

from dampyr import identification
from dampyr.cli import cli
from dampyr.identification import Fit
from dampyr.models import Damper
from dampyr.records import Record, write
from dampyr.show.pages import result_page


def run(*words: str | Path) -> Result:
    return CliRunner().invoke(cli, ["identify", *map(str, words)], catch_exceptions=False)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three records at 0 V and one at 2 V."""
    place = tmp_path_factory.mktemp("few")
    for record in (*records(0.0, 3), *records(2.0, 1)):
        write(record, place / f"{record.name}.h5")
    return place


@pytest.fixture(scope="module")
def fits() -> dict[tuple[object, ...], Fit]:
    """The fits that were computed."""
    return {}


@pytest.fixture
def fitted_once(fits: dict[tuple[object, ...], Fit], monkeypatch: pytest.MonkeyPatch) -> None:
    """A fit of the same records by the same model with the same options is computed once; what is printed is tested."""
    fit = identification.fit

    def once(records: list[Record], model: str, options: object, *more: Any) -> Fit:
        key = (*(record.name for record in records), model, repr(options), repr(more))
        if key not in fits:
            fits[key] = fit(records, model, options, *more)
        return fits[key]

    monkeypatch.setattr(identification, "fit", once)


@pytest.mark.prove
@pytest.mark.usefixtures("fitted_once")
def test_the_table_says_where_there_is_no_interval(folder: Path) -> None:
    done = run(folder, "--model", "dahl", "--details")
    assert done.exit_code == 0, done.output
    rows = [line.split("  ") for line in done.stdout.splitlines() if line.strip().startswith("dahl.kw")]
    values, _, errors = [[cell.strip() for cell in row if cell.strip()] for row in rows]
    assert re.fullmatch(r"[\d.]+ ± [\d.]+", values[2])
    assert re.fullmatch(r"[\d.]+ \(no interval\)", values[3])
    assert re.fullmatch(r"[\d.e-]+ \([\d.e-]+\)", errors[2])
    assert errors[3].endswith(", within these records only")
    assert "Between-record variance is not estimated from 1 record" in done.stdout
    # that sessions are not known, and how to settle it, is said once
    assert done.stdout.count("to settle it, repeat") == 1
    assert "voltage and session" not in done.stdout


@pytest.mark.usefixtures("fitted_once")
def test_the_answer_is_one_screen_and_details_are_asked_for(folder: Path) -> None:
    short, whole = run(folder, "--model", "dahl").stdout, run(folder, "--model", "dahl", "--details").stdout
    assert len(short.splitlines()) <= 24  # of a terminal
    short, whole = " ".join(short.split()), " ".join(whole.split())
    assert short.count("parameter ") == 1
    assert re.search(r"misfit [\d.]+ % of the force \(L1 ratio\)", short)
    more = re.search(r"(\d+) more findings and (\d+) more tables: add --details\.", short)
    assert more is not None
    for said in ("Standard errors", "Goodness of fit", "What these records do not separate"):
        assert said not in short
        assert said in whole
    findings = json.loads(run(folder, "--model", "dahl", "--json").stdout)["findings"]
    assert sum(finding["words"][1:] in short for finding in findings) == len(findings) - int(more[1]) == 1
    assert all(finding["words"][1:] in whole for finding in findings)


@pytest.mark.usefixtures("fitted_once")
def test_files_are_written_before_anything_is_printed(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def closed(*_: object, **__: object) -> None:
        raise BrokenPipeError

    monkeypatch.setattr(importlib.import_module("dampyr.cli._output"), "print_table", closed)
    monkeypatch.setattr(result_page, "write_page", lambda fit, path: path.write_text(str(fit.problem.composition)))
    card, page = tmp_path / "card.toml", tmp_path / "page.html"
    words = ["identify", str(folder), "--model", "dahl", "--save", str(card), "--report", str(page)]
    CliRunner().invoke(cli, words)
    assert Damper.load(card).all_laws
    assert page.read_text() == "dahl"


@pytest.mark.prove  # the page has a figure of each record
@pytest.mark.usefixtures("fitted_once")
def test_the_card_and_the_page_are_there_when_only_the_first_lines_are_read(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As in ``dampyr identify ... | head``: the pipe is closed, and the command ends while it prints."""

    def closed(*_: object, **__: object) -> None:
        raise BrokenPipeError

    monkeypatch.setattr(importlib.import_module("dampyr.cli._output"), "print_table", closed)
    card, page = tmp_path / "card.toml", tmp_path / "page.html"
    words = ["identify", str(folder), "--model", "dahl", "--save", str(card), "--report", str(page)]
    CliRunner().invoke(cli, words)
    assert Damper.load(card).all_laws
    assert page.read_text("utf-8").rstrip().endswith("</html>")


@pytest.mark.usefixtures("fitted_once")
def test_a_card_that_cannot_be_written_is_an_error_below_the_result(folder: Path, tmp_path: Path) -> None:
    done = CliRunner().invoke(cli, ["identify", str(folder), "--model", "dahl", "--save", str(tmp_path)])
    assert done.exit_code == 2
    assert "The search converged" in done.stdout


@pytest.mark.usefixtures("fitted_once")
def test_json_has_null_and_the_reason_where_there_is_no_interval(folder: Path) -> None:
    output = json.loads(run(folder, "--model", "dahl", "--json").stdout)
    assert output["clusters"] == "record and cycle"
    assert output["intervals_95"]["dahl.kw @ 2 V"] is None
    low, high = output["intervals_95"]["dahl.kw @ 0 V"]
    assert low < output["parameters"]["dahl.kw @ 0 V"] < high
    assert output["within_records_only"] == {
        f"dahl.{name} @ 2 V": "between-record variance is not estimated from 1 record" for name in ("kx", "kw", "rho")
    }


@pytest.mark.prove
def test_of_every_record_by_itself_json_labels_the_errors(folder: Path) -> None:
    for output in json.loads(run(folder, "--model", "dahl", "--each", "--json").stdout):
        assert set(output["within_records_only"]) == set(output["parameters"])
        assert set(output["intervals_95"].values()) == {None}


@pytest.fixture(scope="module")
def different_speeds(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Files without a velocity, of 0.1 to 5 Hz."""
    place = tmp_path_factory.mktemp("speeds")
    for record in without_velocity():
        write(record, place / f"{record.name}.csv")
    return place


@pytest.mark.prove
@pytest.mark.parametrize("options", [[], ["--bandwidth", "20"]])
def test_a_folder_without_velocity_is_ranked_although_speeds_differ(
    different_speeds: Path, options: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {0})  # in this process
    done = run(different_speeds, "--try", "dahl", *options)
    assert done.exit_code == 0, done.output
    assert f"The velocity is derived with {'20' if options else '40'} Hz" in done.stdout


def test_a_search_that_is_cut_shows_what_it_has_and_writes_no_card(
    different_speeds: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {0})  # in this process
    card, words = tmp_path / "card.toml", (different_speeds, "--try", "dahl", "--seconds", "1e-9", "--bandwidth", "20")
    done = run(*words, "--save", card)
    assert done.exit_code == 2
    assert "Which model predicts best; the search was cut" in done.stdout
    assert re.search(
        r"dampyr: the search was cut after 1e-09 s, 0 of 5 trials done.* no model is chosen: .*name", done.stderr
    )
    assert not card.exists()
    board = json.loads(run(*words, "--json").stdout)["leaderboard"]
    assert board["chosen"] is None
    assert board["cut"].startswith("the search was cut after")


@pytest.mark.parametrize("options", [[], ["--model", "dahl"], ["--model", "dahl", "--each"]])
def test_a_bandwidth_that_a_record_does_not_carry_is_one_sentence(different_speeds: Path, options: list[str]) -> None:
    done = run(different_speeds, *options, "--bandwidth", "60")
    assert done.exit_code == 2
    assert done.stderr == (
        "dampyr: 0V-0.1Hz: a bandwidth of 60 Hz is not allowed, as its samples 0.005 s apart carry at most 50 Hz; lower it to "
        "50 Hz or less\n"
    )


def test_the_goodness_of_fit_is_listed_by_rising_input() -> None:
    from dampyr.identification import Score
    from dampyr.identification.scoring.scoring_window import Window
    from dampyr.records import Record
    from dampyr.show.identification.score_groups import scores_by_input

    t = np.linspace(0.0, 1.0, 50)
    inputs = (10.0, 1.0, None, 0.25, 1.0)
    records = [Record(t, t, t, current=u, name=f"{k}") for k, u in enumerate(inputs)]
    score = Score(0.1, 0.1, 0.99, 0.1, 0.0, 0.0, 0.0, Window(0, 49, 0.0, 1.0), 1.1, 0.05)
    table = scores_by_input(records, {r.name: score for r in records}, "by input")
    assert [row[:2] for row in table.rows] == [[0.25, 1], [1.0, 2], [10.0, 1], [None, 1]]
    assert all(row[2:] == [pytest.approx(10.0), pytest.approx(10.0), pytest.approx(5.0)] for row in table.rows)
    assert table.units[0] == "A"
