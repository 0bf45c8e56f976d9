"""Origins are combined, told and read back whole; files of published data are recognised; fitted records, too."""

import json
import os
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.errors import FileError, InputError
from dampyr.ground_motions import el_centro
from dampyr.ground_motions import read as read_motion
from dampyr.hybrid.delayed_hybrid import delayed_result
from dampyr.models import Damper
from dampyr.origin import NOT_STATED, Origin, PublishedData, as_origin, combined
from dampyr.records import datasets, read, write
from dampyr.source_digest import full_version
from dampyr.source_file import SourceFile, source_file
from dampyr.structures import two_storey
from tests.identification.synthetic import sine

DAHL = Damper("dahl", {"dahl.kx": 1200.0, "dahl.kw": 200.0, "dahl.rho": 2000.0})
ONE = Origin(
    "measured",
    sources=(SourceFile("b.csv", "b" * 64),),
    operators=("night shift",),
    specimens=("MR-7",),
    sessions=("mounting 3",),
    dates=("2026-03-02",),
    data_sets=(PublishedData("labcontrol", "10.5281/zenodo.4445334", "MIT"),),
    versions=("0.2.0+0123456789ab",),
)
OTHER = Origin("measured", sources=(SourceFile("a.csv", "a" * 64),), dates=("2026-03-01", "2026-03-05"))


def test_what_is_made_of_several_has_all_of_them_and_this_version() -> None:
    both = combined([ONE, OTHER, ONE])
    assert both.kind == "measured"
    assert [file.name for file in both.sources] == ["a.csv", "b.csv"]
    assert both.dates == ("2026-03-01", "2026-03-02", "2026-03-05")
    assert (both.operators, both.specimens, both.sessions) == (ONE.operators, ONE.specimens, ONE.sessions)
    assert both.versions == ("0.2.0+0123456789ab", full_version())
    assert both.facts() == {
        "origin": "measured",
        "operator": "night shift",
        "specimen": "MR-7",
        "session": "mounting 3",
        "tested": "2026-03-01 to 2026-03-05",
        "data set": "labcontrol (doi:10.5281/zenodo.4445334, MIT)",
        "earlier versions": "dampyr 0.2.0+0123456789ab",
    }
    assert NOT_STATED.facts() == {}
    assert NOT_STATED.in_words() == ""
    assert "files: a.csv (SHA-256 aaaaaaaaaaaa), b.csv (SHA-256 bbbbbbbbbbbb)" in both.in_words()


def test_an_origin_comes_back_from_json_and_from_a_card(tmp_path: Path) -> None:
    assert Origin.from_json(ONE.as_json()) == ONE
    assert json.loads(ONE.as_json())["sources"] == [{"name": "b.csv", "sha256": "b" * 64}]
    assert Origin.from_json("simulated") == as_origin("simulated")
    card = replace(DAHL, origin=ONE).save(tmp_path / "card.toml")
    assert Damper.load(card).origin == ONE
    assert 'origin = "measured"' in card.read_text("utf-8")  # where dampyr 0.3.0 looks for it


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('sources = ["me.csv"]', "'me.csv' is not a SHA-256"),
        ('sources = "me.csv"', "'me.csv' is not a SHA-256"),
        ("operators = [3]", "origin.operators = 3 must be a text"),
        ('colour = ["red"]', "origin.colour is not known; choose from kind, sources"),
        ('data_sets = [{ title = "mine" }]', "origin.data_sets.title is not known; choose from name, doi, licence"),
    ],
)
def test_a_card_with_another_origin_is_refused_in_one_sentence(tmp_path: Path, line: str, words: str) -> None:
    card = DAHL.save(tmp_path / "card.toml")
    card.write_text(f"{card.read_text('utf-8')}\n[origin]\n{line}\n", "utf-8")
    with pytest.raises(FileError, match=words) as refused:
        Damper.load(card)
    assert "dampyr help card" in str(refused.value)


def test_a_records_origin_is_that_of_its_fields_whatever_was_given() -> None:
    record = sine(DAHL, 1.0, "one", 0.005, 1.0)
    named = record.replace(note="named", specimen="MR-7", origin=replace(ONE, operators=("nobody",)))
    assert named.origin == Origin("measured", specimens=("MR-7",))
    assert named.replace(note="renamed", specimen="MR-8").origin.specimens == ("MR-8",)
    with pytest.raises(InputError, match="origin = 'real' is not known; choose from measured"):
        record.replace(note="", origin="real")


def test_a_file_of_a_published_data_set_is_recognised_under_any_name(campaign_folder: Path, tmp_path: Path) -> None:
    copy = tmp_path / "mine.mat"
    shutil.copy(campaign_folder / "ensaio1.1.mat", copy)
    record = read(copy, voltage=0.0, units={"displacement": "mm", "velocity": "mm/s", "force": "N"})
    [data_set] = record.origin.data_sets
    assert (data_set.name, data_set.doi) == ("labcontrol", datasets.data_set("labcontrol").doi)
    assert data_set.licence.startswith("MIT")
    again = read(write(record, tmp_path / "again.h5"))  # another file, the same data
    assert again.origin.data_sets == (data_set,)
    assert again.origin.sources == (source_file(tmp_path / "again.h5"),)


def test_the_day_of_a_record_is_that_of_its_first_time_stamp(tmp_path: Path) -> None:
    t = np.arange(0.0, 3.0, 0.01)
    lines = [f"2026/3/1 10:00:{at:06.3f},{np.sin(6 * at):.6f},{np.cos(6 * at):.6f}" for at in t]
    path = tmp_path / "stamped.csv"
    path.write_text("\n".join(["time,displacement [mm],force [N]", *lines]), "utf-8")
    assert read(path, voltage=0.0).origin.dates == ("2026-03-01",)


@pytest.mark.parametrize("reader", [read, read_motion])
def test_a_file_whose_name_no_card_can_hold_is_refused_in_one_sentence(
    tmp_path: Path, reader: Callable[..., Any]
) -> None:
    path = tmp_path / os.fsdecode(b"prueba\xf1.csv")
    path.write_text("t [s],a [m/s2]\n0,0\n1,1\n")
    with pytest.raises(FileError, match="not in UTF-8; rename it"):
        reader(path)


@pytest.mark.prove
def test_a_hybrid_test_without_a_rig_is_virtual_and_has_the_origin_of_its_card() -> None:
    result = delayed_result(two_storey(), el_centro().scaled(0.1), replace(DAHL, origin=ONE), 0.001)
    assert result.origin == replace(combined([ONE]), kind="virtual")
    assert result.as_dict()["origin"]["specimens"] == ["MR-7"]


def test_a_fitted_record_is_known_by_its_file_and_not_by_its_name(tmp_path: Path) -> None:
    for folder in ("here", "there"):
        (tmp_path / folder).mkdir()
    for k in range(3):
        write(sine(DAHL, 1.0, f"test{k}", 0.005, 1.0 + 0.2 * k, noise=1.0, seed=k), tmp_path / f"here/test{k}.h5")
    write(sine(DAHL, 1.0, "test0", 0.004, 1.7, noise=1.0, seed=9), tmp_path / "there/test0.h5")
    write(sine(DAHL, 1.0, "new", 0.004, 1.3, noise=1.0, seed=8), tmp_path / "there/new.h5")
    shutil.copy(tmp_path / "here/test1.h5", tmp_path / "there/copy.h5")
    card = tmp_path / "card.toml"
    run = CliRunner().invoke
    assert run(cli, ["identify", str(tmp_path / "here"), "--model", "dahl", "--save", str(card)]).exit_code == 0
    validate = ["validate", str(card), *map(str, sorted((tmp_path / "there").glob("*.h5")))]
    scores = json.loads(run(cli, [*validate, "--json"]).stdout)["scores"]
    assert {name: score["fitted_on"] for name, score in scores.items()} == {"test1": True, "new": False, "test0": None}
    printed = run(cli, validate).stdout
    rows = [line.split() for line in printed.splitlines() if line.strip()]
    column = {row[0]: row[2] for row in reversed(rows) if row[0] in scores}  # the first table's
    assert column == {"test1": "yes", "new": "no", "test0": "unknown"}
